//! Failures of commands: messages and exit codes.

use makadam::SettingError;
use makadam::scene::SceneFileError;
use makadam_compare::codes::CodeError;
use makadam_compare::compare::RecordError;
use makadam_compare::prepared::StartError;
use makadam_compare::scenes::SceneError;
use makadam_compare::study::{DocumentError, RunError};
use makadam_frames::execution::MeasureError;
use makadam_frames::export::ExportError;
use makadam_frames::import::ImportError;
use makadam_frames::output::{LockError, WriteError};
use makadam_frames::recording::RecordingError;
use makadam_frames::run_frames::RunFolderError;
use makadam_qualification::qualify::QualifyError;
use makadam_studies::parameter_study::ParameterError;
use makadam_studies::problem::{ProblemFileError, SiconosError};
use makadam_view::pictures::PictureError;
use makadam_view::viewer::ViewerError;

/// Exit code of a result outside its tolerance, or undecided.
pub const OUTSIDE_TOLERANCE: u8 = 4;

/// Failure of a command, with its message.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Failure during execution.
    #[error("{0}")]
    Running(String),
    /// Invalid command line.
    #[error("{0}")]
    Usage(String),
    /// Invalid scene, problem or frame file.
    #[error("{0}")]
    Input(String),
    /// Missing reference code, or missing records of one.
    #[error("{0}")]
    MissingCode(String),
    /// Closed standard output, without a report.
    #[error("standard output was closed")]
    ClosedOutput,
}

impl Failure {
    /// Returns the exit code.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Running(_) | Failure::ClosedOutput => 1,
            Failure::Usage(_) => 2,
            Failure::Input(_) => 3,
            Failure::MissingCode(_) => 5,
        }
    }

    /// Returns the failure of an interrupted command, with its remaining results.
    pub(super) fn interrupted(results: &str) -> Failure {
        Failure::Running(format!("interrupted; results so far: {results}"))
    }

    fn with_message(self, message: String) -> Failure {
        match self {
            Failure::Running(_) => Failure::Running(message),
            Failure::Usage(_) => Failure::Usage(message),
            Failure::Input(_) => Failure::Input(message),
            Failure::MissingCode(_) => Failure::MissingCode(message),
            Failure::ClosedOutput => Failure::ClosedOutput,
        }
    }
}

/// Converts errors of the library by their variants; all others are failures during execution.
macro_rules! failures {
    ($($error:ident { $($variant:pat => $failure:expr,)* })*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Failure {
                #[allow(unreachable_patterns)]
                match error {
                    $($variant => $failure,)*
                    other => Failure::Running(other.to_string()),
                }
            }
        })*
    };
}

failures! {
    WriteError {}
    RecordingError {}
    DocumentError {}
    ImportError { error => Failure::Input(error.to_string()), }
    ProblemFileError { error => Failure::Input(error.to_string()), }
    SceneError {
        // A valid scene, which runs on a machine with more memory.
        SceneError::File(error @ SceneFileError::Memory { .. }) => Failure::Running(error.to_string()),
        SceneError::Change(error) => Failure::Usage(SceneError::Change(error).to_string()),
        error => Failure::Input(error.to_string()),
    }
    SettingError {
        error @ SettingError::NoInstructionSet { .. } => {
            Failure::Usage(format!("{error}; leave --isa out, or give one that this processor has"))
        },
        error @ SettingError::NoThreads { .. } => Failure::Running(format!("{error}; give fewer with --threads")),
        error => Failure::Usage(error.to_string()),
    }
    StartError {
        StartError::Scene(error) => error.into(),
        StartError::Execution(error) => error.into(),
        StartError::Interrupted => Failure::interrupted("none, the flowing state was not finished"),
    }
    MeasureError {
        MeasureError::Execution(error) => error.into(),
        MeasureError::Interrupted => Failure::interrupted("none, the measurement was not finished"),
    }
    CodeError {
        CodeError::Scene(error) => error.into(),
        CodeError::Interrupted { .. } => Failure::interrupted("not stored"),
        error @ CodeError::Missing { .. } => Failure::MissingCode(error.to_string()),
    }
    LockError { error @ LockError::Taken { .. } => Failure::Usage(error.to_string()), }
    SiconosError { error @ SiconosError::Missing(_) => Failure::MissingCode(error.to_string()), }
    RunFolderError {
        error @ RunFolderError::Damaged { .. } => Failure::Running(error.to_string()),
        error => Failure::Usage(error.to_string()),
    }
    ViewerError { ViewerError::Frames(error) => error.into(), }
    PictureError { error @ PictureError::Format { .. } => Failure::Usage(error.to_string()), }
    ExportError {
        ExportError::Frames(error) => error.into(),
        ExportError::Interrupted => Failure::interrupted("nothing: the file was not finished"),
    }
    ParameterError {
        ParameterError::Usage(problem) => Failure::Usage(problem),
        ParameterError::Scene { error, values } => {
            let message = format!("{values}: {error}");
            Failure::from(*error).with_message(message)
        },
        ParameterError::Run(error) => error.into(),
    }
    RunError {
        RunError::Scene(error) => error.into(),
        RunError::Code(error) => error.into(),
        RunError::Interrupted => Failure::interrupted("stored run by run; the same command continues from there"),
    }
    RecordError {
        RecordError::Code(CodeError::Interrupted { .. }) => {
            Failure::interrupted("stored run by run; run the command again for the others")
        },
        RecordError::Code(error) => error.into(),
    }
    QualifyError {
        error @ QualifyError::NothingToCompare(_) => Failure::Usage(error.to_string()),
        error @ QualifyError::NotRecorded { .. } => Failure::MissingCode(error.to_string()),
        QualifyError::Run(error) => error.into(),
    }
}
