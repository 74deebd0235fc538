//! The codes that are compared: one trait, one file a code, and one table of their names.

mod deck;
pub mod external;
mod input;
pub mod lammps;
pub mod liggghts;
mod makadam;
mod process;
pub mod yade;
mod yade_rolling;

use ::makadam::effects::catalogue::Trigger;
use ::makadam::effects::{CATALOGUE, Effect};
use ::makadam::scene::{Grain, Shape};
use clap::ValueEnum;
pub use external::{DescriptionError, External};
pub use lammps::Lammps;
pub use liggghts::Liggghts;
pub use makadam::{Makadam, starting_grains};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
pub use process::absent;
use std::path::{Path, PathBuf};
use std::time::Duration;
pub use yade::Yade;

/// Hertz's spring and Mindlin's, both damped for the restitution of the scene: what explicit codes do where nothing else is said.
pub const HERTZ_MINDLIN: &str = "Hertz-Mindlin, damped";

/// Purpose of a run. Scene and time step are the same either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Measuring: the frames tell of all contacts, and curved walls are fine meshes where the code has no others.
    #[default]
    Measuring,
    /// Timing: the input from which the code is fastest with the same physics. Its frames may lack contacts with walls.
    Timing,
}

/// One run that is asked of a code.
pub struct Job<'a> {
    /// The scene, its stiffness already scaled by `stiffness_factor`.
    pub scene: &'a MeasuredScene,
    /// File that the scene came from, named in errors.
    pub scene_file: &'a Path,
    /// Its purpose.
    pub purpose: Purpose,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Factor that has been applied to every Young's modulus of the scene; recorded.
    pub stiffness_factor: f64,
    /// Time step of explicit codes over the Rayleigh step.
    pub rayleigh_fraction: f64,
    /// Folder for scripts, decks, logs and raw output; kept after a failure.
    pub work_folder: &'a Path,
    /// Wall time after which the run is stopped.
    pub time_limit: Duration,
    /// Told the share of the run that is done, 0 to 1, now and then.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// A code that can simulate a scene.
pub trait Code: Sync {
    /// Its name, such as "Makadam" or "YADE".
    fn name(&self) -> &'static str;
    /// Its version, or `None` if it is not installed.
    fn version(&self) -> Option<String>;
    /// Contact law in the input of the code; empty where the code has a single law. Runs with different laws are never mixed.
    fn contact_law(&self) -> &'static str {
        ""
    }
    /// Difference of the input for timing, as the end of a sentence; `None` where there is none.
    fn timing_input(&self) -> Option<&'static str> {
        None
    }
    /// Seeds of the runs that exist, where the code is not run; `None` where it runs any seed.
    fn seeds(&self) -> Option<Vec<u64>> {
        None
    }
    /// Writes the files from which it runs the scene into the job's folder, and returns the command that runs it there.
    ///
    /// # Errors
    /// [`CodeError`], also where it needs no files.
    fn write_input(&self, job: &Job<'_>) -> Result<String, CodeError> {
        let _ = job;
        Err(CodeError::Unsupported { code: self.name(), reason: "there are no files to be exported".into() })
    }
    /// Runs the scene on one core and returns its frames.
    ///
    /// # Errors
    /// [`CodeError`]; what the code wrote stays in the job's folder.
    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError>;
}

/// Error of a code that gave no recording.
#[derive(Debug, thiserror::Error)]
pub enum CodeError {
    /// It is not on this machine.
    #[error("{}, or leave out --live to use the recorded references", absent(code))]
    Missing {
        /// The code.
        code: &'static str,
    },
    /// It cannot express the scene.
    #[error("{code} cannot express this scene: {reason}; change the scene, or leave this code out")]
    Unsupported {
        /// The code.
        code: &'static str,
        /// Missing capability.
        reason: String,
    },
    /// It ended with an error.
    #[error("{code} failed ({status}); its log is {}; its last words: {tail}", log.display())]
    Crashed {
        /// The code.
        code: &'static str,
        /// Exit status or signal.
        status: String,
        /// Log file, kept.
        log: PathBuf,
        /// End of the log.
        tail: String,
    },
    /// It ran past its time limit and was stopped.
    #[error("{code} was stopped after {seconds:.0} s of wall time; its log is {}; raise --time-limit", log.display())]
    TimedOut {
        /// The code.
        code: &'static str,
        /// Limit, s.
        seconds: f64,
        /// Log file, kept.
        log: PathBuf,
    },
    /// It came to a state that makes its numbers invalid.
    #[error("{code} came to a state that makes its numbers invalid: {alarm}")]
    InvalidState {
        /// The code.
        code: &'static str,
        /// Diagnostic.
        alarm: ::makadam::watch::Alarm,
    },
    /// The user asked to stop.
    #[error("{code} was interrupted")]
    Interrupted {
        /// The code.
        code: &'static str,
    },
    /// Its output is not what was expected.
    #[error("{code}: {}: line {line}: {problem}; the run folder is kept for a look", file.display())]
    Output {
        /// The code.
        code: &'static str,
        /// File that was read.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Fault.
        problem: String,
    },
    /// The scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] crate::scenes::SceneError),
    /// The recording cannot be kept or read back.
    #[error(transparent)]
    Recording(#[from] makadam_frames::recording::RecordingError),
    /// It cannot be carried out as asked.
    #[error(transparent)]
    Execution(#[from] ::makadam::SettingError),
    /// The state that the scene starts from cannot be kept.
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

    /// The one of several failures that is told: that the user asked to stop, else the first.
    pub fn foremost(mut failures: Vec<CodeError>) -> Option<CodeError> {
        let place = failures.iter().position(CodeError::is_interruption).unwrap_or(0);
        (place < failures.len()).then(|| failures.swap_remove(place))
    }
}

/// Remedy for a file that the system refused.
fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        std::io::ErrorKind::NotFound => "nothing has written it: see the logs beside it",
        _ => "check that the path is writable and the disk has room",
    }
}

/// Writes files into a folder, which is made.
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

/// Refuses a scene with an effect that is not among those that a code has, as far as grains and walls that are there have it. An effect
/// that a code does not list is refused, so that no input leaves one out.
///
/// # Errors
/// [`CodeError::Unsupported`] with the first effect, in the catalogue's order, and what calls for it.
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
            return Err(CodeError::Unsupported { code, reason: format!("it has no {}: {}", effect.name, call.why) });
        }
    }
    Ok(())
}

/// The grains that a soft reference code starts from, or what it cannot do with the scene; `has` are the effects that it has.
fn supported_start(code: &'static str, has: &[&'static Effect], job: &Job<'_>) -> Result<Vec<Grain>, CodeError> {
    makadam::starting_grains_if(job, |grains| refuse_unsupported(code, has, job.scene, grains))
}

/// Refuses scenes that no soft-sphere code can run.
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
    if grains.is_empty() {
        return refuse("it has no grains");
    }
    if scene.wall.iter().any(|wall| matches!(wall.shape, Shape::Spheres { .. })) {
        return refuse("a wall is made of spheres");
    }
    refuse_effects(code, has, scene, grains)
}

/// A name that this program gives to no code.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no code '{0}': give makadam, yade, liggghts or lammps")]
pub struct UnknownCode(String);

/// A code that this program drives.
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
}

impl CodeName {
    /// The codes that Makadam is held against, live or recorded.
    pub const REFEREES: [CodeName; 2] = [CodeName::Yade, CodeName::Liggghts];

    /// The codes that count where their numbers are on record, and are not asked to run.
    pub const FURTHER_REFEREES: [CodeName; 1] = [CodeName::Lammps];

    /// The code of a name, in capitals or not.
    ///
    /// # Errors
    /// [`UnknownCode`] for a name that this program gives to no code.
    pub fn of(name: &str) -> Result<CodeName, UnknownCode> {
        CodeName::from_str(name, true).map_err(|_| UnknownCode(name.into()))
    }

    /// The code.
    pub fn code(self) -> Box<dyn Code + Send> {
        match self {
            CodeName::Makadam => Box::new(Makadam),
            CodeName::Yade => Box::new(Yade::default()),
            CodeName::Liggghts => Box::new(Liggghts::default()),
            CodeName::Lammps => Box::new(Lammps::default()),
        }
    }
}

/// The codes of these names, each once, Makadam first.
pub fn codes_of(names: &[CodeName]) -> Vec<Box<dyn Code>> {
    let asked = CodeName::value_variants().iter().filter(|name| names.contains(name));
    asked.map(|name| -> Box<dyn Code> { name.code() }).collect()
}

#[cfg(test)]
#[path = "../../tests/unit/codes.rs"]
mod tests;
