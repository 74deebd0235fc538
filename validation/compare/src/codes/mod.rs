//! Compared codes: one trait, one file per code, and one table of their names.

mod deck;
pub mod driver;
pub mod external;
mod input;
pub mod lammps;
pub mod liggghts;
mod makadam;
mod migflow;
mod process;
pub mod yade;
mod yade_rolling;

use ::makadam::effects::catalogue::Trigger;
use ::makadam::effects::{CATALOGUE, Effect};
use ::makadam::scene::{Grain, Motion, Shape};
use clap::ValueEnum;
pub use external::{DescriptionError, External};
pub use lammps::Lammps;
pub use liggghts::Liggghts;
pub use makadam::{Makadam, starting_grains};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
pub use migflow::Migflow;
pub use process::absent;
use std::path::{Path, PathBuf};
use std::time::Duration;
pub use yade::Yade;

/// Hertz's spring and Mindlin's, both damped for the restitution of the scene: the default law of explicit codes.
pub const HERTZ_MINDLIN: &str = "Hertz-Mindlin, damped";

/// Purpose of a run. Scene and time step do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Measuring: the frames list all contacts, and curved walls are fine meshes where the code has no others.
    #[default]
    Measuring,
    /// Timing: the fastest input of the code with the same physics. Its frames may lack contacts with walls.
    Timing,
}

/// One requested run of a code.
pub struct Job<'a> {
    /// Scene, its stiffness already scaled by `stiffness_factor`.
    pub scene: &'a MeasuredScene,
    /// File of the scene, named in errors.
    pub scene_file: &'a Path,
    /// Purpose.
    pub purpose: Purpose,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Factor applied to every Young's modulus of the scene; recorded.
    pub stiffness_factor: f64,
    /// Time step of explicit codes over the Rayleigh step.
    pub rayleigh_fraction: f64,
    /// Folder for scripts, decks, logs and raw output; not removed after a failure.
    pub work_folder: &'a Path,
    /// Wall time after which the run is stopped.
    pub time_limit: Duration,
    /// Receives the completed fraction of the run, 0 to 1, at intervals.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// Version of a code that does not tell its version.
pub const UNKNOWN_VERSION: &str = "unknown";

/// Code that can simulate a scene.
pub trait Code: Sync {
    /// Name, such as "Makadam" or "YADE".
    fn name(&self) -> &'static str;
    /// Version, [`UNKNOWN_VERSION`], or `None` if the code is not installed.
    fn version(&self) -> Option<String>;
    /// Contact law in the input of the code; empty where the code has a single law. Runs with different laws are never mixed.
    fn contact_law(&self) -> &'static str {
        ""
    }
    /// Difference of the input for timing, as the end of a sentence; `None` where there is none.
    fn timing_input(&self) -> Option<&'static str> {
        None
    }
    /// Seeds of the available runs, where the code is not run; `None` where any seed can be run.
    fn seeds(&self) -> Option<Vec<u64>> {
        None
    }
    /// Writes the input files of the scene into the job's folder, and returns the command that runs the scene there.
    ///
    /// # Errors
    /// [`CodeError`], also where the code needs no files.
    fn write_input(&self, job: &Job<'_>) -> Result<String, CodeError> {
        let _ = job;
        Err(CodeError::Unsupported { code: self.name(), reason: "there are no files to be exported".into() })
    }
    /// Runs the scene on one core and returns its frames.
    ///
    /// # Errors
    /// [`CodeError`]; files of the code stay in the job's folder.
    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError>;
}

/// Error of a code that returned no recording.
#[derive(Debug, thiserror::Error)]
pub enum CodeError {
    /// The code is not on this machine.
    #[error("{}, or leave out --live to use the recorded references", absent(code))]
    Missing {
        /// Code.
        code: &'static str,
    },
    /// The code cannot express the scene.
    #[error("{code} cannot express this scene: {reason}; change the scene, or leave this code out")]
    Unsupported {
        /// Code.
        code: &'static str,
        /// Missing capability.
        reason: String,
    },
    /// The code ended with an error.
    #[error("{code} failed ({status}); its log is {}; its last words: {tail}", log.display())]
    Crashed {
        /// Code.
        code: &'static str,
        /// Exit status or signal.
        status: String,
        /// Log file, not removed.
        log: PathBuf,
        /// End of the log.
        tail: String,
    },
    /// The code exceeded its time limit and was stopped.
    #[error("{code} was stopped after {seconds:.0} s of wall time; its log is {}; raise --time-limit", log.display())]
    TimedOut {
        /// Code.
        code: &'static str,
        /// Limit, s.
        seconds: f64,
        /// Log file, not removed.
        log: PathBuf,
    },
    /// The code reached a state that invalidates its numbers.
    #[error("{code} came to a state that makes its numbers invalid: {alarm}")]
    InvalidState {
        /// Code.
        code: &'static str,
        /// Diagnostic.
        alarm: ::makadam::watch::Alarm,
    },
    /// The user asked to stop.
    #[error("{code} was interrupted")]
    Interrupted {
        /// Code.
        code: &'static str,
    },
    /// The output is invalid.
    #[error("{code}: {}: line {line}: {problem}; the run folder is kept for a look", file.display())]
    Output {
        /// Code.
        code: &'static str,
        /// Output file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Fault.
        problem: String,
    },
    /// The scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] crate::scenes::SceneError),
    /// The recording cannot be stored or read back.
    #[error(transparent)]
    Recording(#[from] makadam_frames::recording::RecordingError),
    /// The run cannot be executed with the requested settings.
    #[error(transparent)]
    Execution(#[from] ::makadam::SettingError),
    /// The initial state of the scene cannot be stored.
    #[error(transparent)]
    State(#[from] ::makadam::checkpoint::CheckpointError),
    /// The system refused.
    #[error("{path}: {source}; {}", remedy(source))]
    Io {
        /// Path of the file or folder.
        path: String,
        /// Error of the system.
        source: std::io::Error,
    },
}

impl CodeError {
    /// Returns true if the user asked to stop.
    pub fn is_interruption(&self) -> bool {
        matches!(self, CodeError::Interrupted { .. })
    }

    /// Returns the failure to report: the interruption by the user, else the first.
    pub fn foremost(mut failures: Vec<CodeError>) -> Option<CodeError> {
        let place = failures.iter().position(CodeError::is_interruption).unwrap_or(0);
        (place < failures.len()).then(|| failures.swap_remove(place))
    }
}

/// Returns the remedy for a file that the system refused.
fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        std::io::ErrorKind::NotFound => "nothing has written it: see the logs beside it",
        _ => "check that the path is writable and the disk has room",
    }
}

/// Creates a folder and writes files into it.
fn write_files(
    folder: &Path,
    files: impl IntoIterator<Item = (impl AsRef<Path>, impl AsRef<[u8]>)>,
) -> Result<(), CodeError> {
    std::fs::create_dir_all(folder).map_err(|source| process::io(folder, source))?;
    for (name, content) in files {
        let path = folder.join(name);
        std::fs::write(&path, content).map_err(|source| process::io(&path, source))?;
    }
    Ok(())
}

/// Refuses a scene with an effect that a code lacks, if present grains and walls have the effect. An effect
/// that a code does not list is refused, so that no input omits one.
///
/// # Errors
/// [`CodeError::Unsupported`] with the first effect, in the catalogue's order, and the setting that enables it.
pub fn refuse_effects(
    code: &'static str,
    has: &[&'static Effect],
    scene: &MeasuredScene,
    grains: &[Grain],
) -> Result<(), CodeError> {
    let palette = input::Palette::new(scene, grains);
    let here = |effect: &Effect| match effect.trigger {
        Trigger::Contacts { acts, .. } => palette.pairs().any(|(_, _, pair)| acts(&pair)),
        Trigger::Scene(_) => true,
    };
    let is_listed = |effect: &Effect| has.iter().any(|one| one.name == effect.name);
    for effect in CATALOGUE.iter().filter(|effect| !is_listed(effect) && here(effect)) {
        if let Ok(call) = effect.called_by(scene) {
            return Err(CodeError::Unsupported {
                code,
                reason: format!("it has no {}: {} ({})", effect.name, call.why, call.place),
            });
        }
    }
    Ok(())
}

/// Returns the initial grains of a reference code, or the unsupported part of the scene; `has` are the effects of the code.
fn supported_start(code: &'static str, has: &[&'static Effect], job: &Job<'_>) -> Result<Vec<Grain>, CodeError> {
    makadam::starting_grains_if(job, |grains| refuse_unsupported(code, has, job.scene, grains))
}

/// Refuses scenes that no reference code can run.
fn refuse_unsupported(
    code: &'static str,
    has: &[&'static Effect],
    scene: &MeasuredScene,
    grains: &[Grain],
) -> Result<(), CodeError> {
    let refuse = |reason: &str| Err(CodeError::Unsupported { code, reason: reason.into() });
    if scene.prepare.is_some() && scene.wall.iter().any(|wall| wall.motion.is_driven()) {
        return refuse("it starts from a prepared state, in which a wall has been driven");
    }
    if !scene.stage.is_empty() {
        return refuse("it has stages");
    }
    for (index, wall) in scene.wall.iter().enumerate() {
        match scene.course(index) {
            Motion::List(_) => return refuse(&format!("wall '{}' has several motions", wall.name)),
            Motion::Table { .. } => return refuse(&format!("wall '{}' moves by a table", wall.name)),
            Motion::ForceDriven { largest_speed: Some(_), .. }
            | Motion::TorqueDriven { largest_speed: Some(_), .. } => {
                return refuse(&format!("wall '{}' is driven at a largest speed", wall.name));
            }
            _ => {}
        }
    }
    if grains.is_empty() && scene.insert.is_empty() {
        return refuse("it has no grains");
    }
    if scene.wall.iter().any(|wall| matches!(wall.shape, Shape::Spheres { .. })) {
        return refuse("a wall is made of spheres");
    }
    refuse_effects(code, has, scene, grains)
}

/// Name without a code in this program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no code '{0}': give makadam, yade, liggghts, lammps or migflow")]
pub struct UnknownCode(String);

/// Code that this program can run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CodeName {
    /// Makadam.
    Makadam,
    /// YADE.
    Yade,
    /// LIGGGHTS.
    Liggghts,
    /// LAMMPS.
    Lammps,
    /// MigFlow.
    Migflow,
}

impl CodeName {
    /// Codes that Makadam is compared with, live or recorded.
    pub const REFEREES: [CodeName; 2] = [CodeName::Yade, CodeName::Liggghts];

    /// Codes that count where their numbers are recorded, and are not run by default.
    pub const FURTHER_REFEREES: [CodeName; 2] = [CodeName::Lammps, CodeName::Migflow];

    /// Returns the code of a name, in any case of letters.
    ///
    /// # Errors
    /// [`UnknownCode`] for a name without a code in this program.
    pub fn of(name: &str) -> Result<CodeName, UnknownCode> {
        CodeName::from_str(name, true).map_err(|_| UnknownCode(name.into()))
    }

    /// Returns the code.
    pub fn code(self) -> Box<dyn Code + Send> {
        match self {
            CodeName::Makadam => Box::new(Makadam),
            CodeName::Yade => Box::new(Yade::default()),
            CodeName::Liggghts => Box::new(Liggghts::default()),
            CodeName::Lammps => Box::new(Lammps::default()),
            CodeName::Migflow => Box::new(Migflow::default()),
        }
    }
}

/// Returns the codes of these names, each once, Makadam first.
pub fn codes_of(names: &[CodeName]) -> Vec<Box<dyn Code>> {
    let asked = CodeName::value_variants().iter().filter(|name| names.contains(name));
    asked.map(|name| -> Box<dyn Code> { name.code() }).collect()
}

#[cfg(test)]
#[path = "../../tests/unit/codes.rs"]
mod tests;
