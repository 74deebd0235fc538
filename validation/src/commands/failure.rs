//! Why a command failed, and the exit code that says so.

use crate::compare::{KeptError, RecordError, ReferenceError};
use crate::execution::MeasureError;
use crate::import::ImportError;
use crate::output::WriteError;
use crate::parameter_study::ParameterError;
use crate::peers::CodeError;
use crate::prepared::StartError;
use crate::problem::{ProblemFileError, SiconosError};
use crate::qualify::JudgeError;
use crate::recording::RecordingError;
use crate::scenes::SceneError;
use crate::stability::StabilityError;
use crate::study::DocumentError;
use crate::tradeoff::CampaignError;
use makadam::SettingError;
use makadam::scene::SceneFileError;

/// Exit code where a result lies outside its tolerance, or too few seeds leave it undecided.
pub const OUTSIDE_TOLERANCE: u8 = 4;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line makes no sense.
    #[error("{0}")]
    Usage(String),
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file holds no contact problem that could be solved.
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    /// A file holds no frames that could be measured.
    #[error("{0}")]
    Frames(#[from] ImportError),
    /// What is wrong with one combination of values.
    #[error("{0}: {1}")]
    Combination(String, Box<Failure>),
    /// A reference code, or what was recorded of it, is missing.
    #[error("{0}")]
    MissingCode(String),
    /// Something went wrong while running.
    #[error("{0}")]
    Running(String),
    /// The user asked to stop.
    #[error("interrupted; results so far: {0}")]
    Interrupted(String),
    /// The reader of standard output went away: nobody is left to tell.
    #[error("standard output was closed")]
    ClosedOutput,
}

impl Failure {
    /// The exit code.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Running(_) | Failure::Interrupted(_) | Failure::ClosedOutput => 1,
            // The scene is sound, and runs where there is more.
            Failure::Scene(SceneError::File(SceneFileError::Memory { .. })) => 1,
            Failure::Usage(_) | Failure::Scene(SceneError::Change(_)) => 2,
            Failure::Scene(_) | Failure::Problem(_) | Failure::Frames(_) => 3,
            Failure::MissingCode(_) => 5,
            Failure::Combination(_, failure) => failure.exit_code(),
        }
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Failure {
        Failure::Running(error.to_string())
    }
}

impl From<ParameterError> for Failure {
    fn from(error: ParameterError) -> Failure {
        match error {
            ParameterError::Change(_)
            | ParameterError::Key { .. }
            | ParameterError::TooMany(_)
            | ParameterError::Folder(_) => Failure::Usage(error.to_string()),
            ParameterError::Scene { error: scene, values } => Failure::Combination(values, Box::new((*scene).into())),
            ParameterError::Run { error: run, values, seed } => {
                Failure::Combination(format!("{values}, seed {seed}"), Box::new((*run).into()))
            }
            ParameterError::Write(error) => error.into(),
            ParameterError::Interrupted => {
                Failure::Interrupted("stored run by run; the same command continues from there".into())
            }
        }
    }
}

impl From<SiconosError> for Failure {
    fn from(error: SiconosError) -> Failure {
        match error {
            SiconosError::Missing(_) => Failure::MissingCode(error.to_string()),
            SiconosError::Failed(_) => Failure::Running(error.to_string()),
        }
    }
}

impl From<SettingError> for Failure {
    fn from(error: SettingError) -> Failure {
        match error {
            SettingError::NoInstructionSet { .. } => {
                Failure::Usage(format!("{error}; leave --isa out, or give one that this processor has"))
            }
            SettingError::NoThreads { .. } => Failure::Running(format!("{error}; give fewer with --threads")),
            SettingError::Method { .. } | SettingError::SinglePrecision(_) => Failure::Usage(error.to_string()),
        }
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Failure {
        Failure::Running(error.to_string())
    }
}

impl From<StartError> for Failure {
    fn from(error: StartError) -> Failure {
        match error {
            StartError::Scene(error) => Failure::Scene(error),
            StartError::Write(error) => error.into(),
            StartError::Checkpoint(error) => Failure::Running(error.to_string()),
            StartError::Execution(error) => error.into(),
            StartError::Worthless(_) => Failure::Running(error.to_string()),
            StartError::Interrupted => Failure::Interrupted("none, the flowing state was not finished".into()),
        }
    }
}

impl From<MeasureError> for Failure {
    fn from(error: MeasureError) -> Failure {
        match error {
            MeasureError::Execution(error) => error.into(),
            MeasureError::Threads(_) => Failure::Running(error.to_string()),
            MeasureError::Interrupted => Failure::Interrupted("none, the measurement was not finished".into()),
        }
    }
}

impl From<CodeError> for Failure {
    fn from(error: CodeError) -> Failure {
        match error {
            CodeError::Scene(error) => Failure::Scene(error),
            CodeError::Interrupted { .. } => Failure::Interrupted("not stored".into()),
            CodeError::Missing { .. } => Failure::MissingCode(error.to_string()),
            other => Failure::Running(other.to_string()),
        }
    }
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Failure {
        match error {
            RecordError::Code(CodeError::Interrupted { .. }) => {
                Failure::Interrupted("stored run by run; run the command again for the others".into())
            }
            RecordError::Code(error) => error.into(),
            other => Failure::Running(other.to_string()),
        }
    }
}

impl From<JudgeError> for Failure {
    fn from(error: JudgeError) -> Failure {
        match error {
            JudgeError::NothingToCompare { .. } => Failure::Usage(error.to_string()),
            JudgeError::Reference(error) => error.into(),
            JudgeError::NotRecorded { .. } => Failure::MissingCode(error.to_string()),
            JudgeError::Code(error) => error.into(),
        }
    }
}

impl From<StabilityError> for Failure {
    fn from(error: StabilityError) -> Failure {
        match error {
            StabilityError::Scene(error) => Failure::Scene(error),
            StabilityError::Interrupted(kept) => Failure::Interrupted(kept),
            StabilityError::Code(error) => error.into(),
            StabilityError::Write(error) => error.into(),
        }
    }
}

impl From<KeptError> for Failure {
    fn from(error: KeptError) -> Failure {
        match error {
            KeptError::Code(CodeError::Interrupted { .. }) => {
                Failure::Interrupted("stored run by run; the same command continues from there".into())
            }
            KeptError::Code(error) => error.into(),
            KeptError::Worthless(problem) => Failure::Running(problem),
            KeptError::Write(error) => error.into(),
        }
    }
}

impl From<CampaignError> for Failure {
    fn from(error: CampaignError) -> Failure {
        match error {
            CampaignError::Scene(error) => Failure::Scene(error),
            CampaignError::Write(error) => error.into(),
            CampaignError::Code(error) => error.into(),
        }
    }
}

impl From<ReferenceError> for Failure {
    fn from(error: ReferenceError) -> Failure {
        Failure::Running(error.to_string())
    }
}

impl From<DocumentError> for Failure {
    fn from(error: DocumentError) -> Failure {
        Failure::Running(error.to_string())
    }
}
