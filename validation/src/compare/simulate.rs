//! Runs of one code over several seeds, side by side, measured as they end.

use super::{CodeSummary, Harvest, Source, Timing};
use crate::output::{file_stem, run_folder};
use crate::peers::{Code, CodeError, Job, Purpose};
use crate::plan::{Scene, physics_hash};
use crate::provenance::utc;
use crate::recording::{Recording, RecordingError};
use makadam::checkpoint::checksum;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Told the share of a run that is done, 0 to 1.
pub type Share = Box<dyn Fn(f64) + Send + Sync>;

/// Opens a progress display for a run of this name.
pub type Announce<'a> = &'a (dyn Fn(&str) -> Share + Sync);

/// What is asked of a code.
#[derive(Clone)]
pub struct Runs<'a> {
    /// The scene as its file says it.
    pub scene: &'a Scene,
    /// Its file.
    pub scene_file: &'a Path,
    /// What the runs are for.
    pub purpose: Purpose,
    /// Seeds of the initial positions.
    pub seeds: Vec<u64>,
    /// Time step of explicit codes over the Rayleigh step.
    pub rayleigh_fraction: f64,
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Wall time after which a run is stopped.
    pub time_limit: Duration,
    /// Folder of raw recordings: what is there of this scene and the installed version is not run again, what is run is kept.
    /// Without a folder nothing is kept.
    pub recordings: Option<PathBuf>,
    /// Opens progress displays.
    pub announce: Announce<'a>,
}

/// Time step of the live runs of a qualification over the Rayleigh step: the longest with which LIGGGHTS keeps the bounds of
/// the trade-off in every scene.
pub(crate) const LIVE_FRACTION: f64 = 0.2;

impl<'a> Runs<'a> {
    /// One seed for measuring. Scenes, effects and settings of a qualification all ask for a run in this way, so that none is made twice.
    pub fn of_one_seed(
        scene: &'a Scene,
        scene_file: &'a Path,
        seed: u64,
        time_limit: Duration,
        announce: Announce<'a>,
    ) -> Runs<'a> {
        Runs {
            scene,
            scene_file,
            purpose: Purpose::Measuring,
            seeds: vec![seed],
            rayleigh_fraction: LIVE_FRACTION,
            stiffness_factor: 1.0,
            time_limit,
            recordings: None,
            announce,
        }
    }
}

/// A code that was timed on one seed and measured.
pub struct Timed {
    /// How long it took.
    pub summary: CodeSummary,
    /// What was measured.
    pub harvest: Harvest,
}

/// What came of the runs.
pub struct Simulated {
    /// The runs that ended well, measured.
    pub harvests: Vec<Harvest>,
    /// The others: seed and reason.
    pub failures: Vec<(u64, CodeError)>,
}

impl Runs<'_> {
    /// Runs the code over the seeds, as many at a time as the thread pool has threads.
    pub fn simulate(&self, code: &dyn Code) -> Simulated {
        let scene = self.scene.with_stiffness_factor(self.stiffness_factor);
        let ended: Vec<_> = self.seeds.par_iter().map(|&seed| (seed, self.one(code, &scene, seed))).collect();
        let mut simulated = Simulated { harvests: Vec::new(), failures: Vec::new() };
        for (seed, result) in ended {
            match result {
                Ok(harvest) => simulated.harvests.push(harvest),
                Err(error) => simulated.failures.push((seed, error)),
            }
        }
        simulated
    }

    /// Runs the code on one seed of `scene`, whose stiffness is already scaled.
    ///
    /// # Errors
    /// [`CodeError`]; what the code wrote is kept then, unless the user asked to stop.
    pub fn one(&self, code: &dyn Code, scene: &Scene, seed: u64) -> Result<Harvest, CodeError> {
        let name = self.file_stem(code, seed);
        let work_folder =
            run_folder(&name).map_err(|error| CodeError::Io { path: error.path, source: error.source })?;
        let job = |progress| Job {
            scene,
            scene_file: self.scene_file,
            purpose: self.purpose,
            seed,
            stiffness_factor: self.stiffness_factor,
            rayleigh_fraction: self.rayleigh_fraction,
            work_folder: &work_folder,
            time_limit: self.time_limit,
            progress,
        };
        let kept = match &self.recordings {
            Some(folder) => Some(folder.join(format!("{name}{}.rec", inputs(code, &job(&|_| {}))?))),
            None => None,
        };
        let mut again = String::new();
        if let Some(file) = kept.as_ref().filter(|file| file.is_file()) {
            let installed = code.version();
            match self.kept(code, seed, file) {
                // Versions do not mix: what another one left behind is run again, unless no code is there to run.
                Ok(recording) if installed.as_ref().is_none_or(|installed| *installed == recording.version) => {
                    let ended = file.metadata().and_then(|data| data.modified()).unwrap_or_else(|_| SystemTime::now());
                    let _ = std::fs::remove_dir_all(&work_folder);
                    return Ok(Harvest::of(scene, &recording, code.contact_law(), utc(ended)));
                }
                Ok(recording) => again = format!(" (again: recorded with {})", recording.version),
                Err(error) if installed.is_none() => return Err(error.into()),
                // It can be made again.
                Err(error) => again = format!(" (again: {error})"),
            }
        }
        if crate::interrupt::requested() {
            let _ = std::fs::remove_dir_all(&work_folder);
            return Err(CodeError::Interrupted { code: code.name() });
        }
        let progress = (self.announce)(&format!("{} {} seed {seed}{again}", scene.name, code.name()));
        let ended = code.simulate(&job(&*progress));
        // What was cut short tells nothing; what failed by itself does.
        if ended.as_ref().is_err_and(CodeError::is_interruption) {
            let _ = std::fs::remove_dir_all(&work_folder);
        }
        let recording = ended?;
        if let Some(file) = &kept {
            recording.save(file)?;
        }
        // The raw output of a run that ended well is in the recording; a folder that stays does no harm.
        let _ = std::fs::remove_dir_all(&work_folder);
        Ok(Harvest::of(scene, &recording, code.contact_law(), utc(SystemTime::now())))
    }

    /// Times the code on one seed of the scene by a run for timing. Where that does not tell all that is measured, a run for measuring
    /// does. `take` makes either, or takes what is kept of it.
    ///
    /// # Errors
    /// That of either run.
    pub fn time<E>(
        &self,
        code: &dyn Code,
        seed: u64,
        take: impl Fn(&Runs<'_>) -> Result<Harvest, E>,
    ) -> Result<Timed, E> {
        let run_for = |purpose: Purpose| take(&Runs { purpose, ..self.clone() });
        let timed = run_for(Purpose::Timing)?;
        let run = &timed.run;
        let input = code.timing_input().map(|words| format!("; its input for timing: {words}")).unwrap_or_default();
        let summary = CodeSummary {
            code: run.code.clone(),
            version: run.version.clone(),
            source: Source::Live,
            seeds: vec![seed],
            time_step: run.known_time_step(),
            rayleigh_fraction: run.rayleigh_fraction,
            wall_seconds_per_simulated_second: run.pace(),
            // Without processor time there is no time that other codes' can be divided by.
            timing: if run.core_seconds.is_some() { Timing::Alone } else { Timing::Measuring },
            processor: run.processor.clone(),
            provenance: format!("processor time of the stepping of one run by this command{input}"),
        };
        let harvest = if timed.lacks.is_empty() { timed } else { run_for(Purpose::Measuring)? };
        Ok(Timed { summary, harvest })
    }

    /// A recording that is kept, if it is the one that its name says.
    fn kept(&self, code: &dyn Code, seed: u64, file: &Path) -> Result<Recording, RecordingError> {
        let recording = Recording::load(file)?;
        let found = (recording.code.as_str(), recording.seed, recording.stiffness_factor);
        if found == (code.name(), seed, self.stiffness_factor) {
            return Ok(recording);
        }
        let problem = format!("is of {} with seed {} at {} times the stiffness", found.0, found.1, found.2);
        Err(RecordingError::Format(file.display().to_string(), problem))
    }

    /// Name of a run; the hash tells the scene from what it was before a change.
    fn file_stem(&self, code: &dyn Code, seed: u64) -> String {
        let purpose = if self.purpose == Purpose::Timing { "-timing" } else { "" };
        format!(
            "{}-{}-s{seed}-f{}-e{}-{}{purpose}",
            file_stem(&self.scene.name),
            file_stem(&code.name().to_lowercase()),
            self.rayleigh_fraction,
            self.stiffness_factor,
            physics_hash(self.scene)
        )
    }
}

/// The end of a recording's name: a hash of the files that the code is given, so that what came of another deck is not taken up; nothing
/// where it is given none.
///
/// # Errors
/// [`CodeError`], if files cannot be written or read back.
fn inputs(code: &dyn Code, job: &Job<'_>) -> Result<String, CodeError> {
    let refused = |path: &Path, source| CodeError::Io { path: path.display().to_string(), source };
    // Nothing that an earlier process of the same number left behind counts.
    let _ = std::fs::remove_dir_all(job.work_folder);
    match code.write_input(job) {
        Ok(_) => {}
        Err(CodeError::Unsupported { .. }) => return Ok(String::new()),
        Err(error) => return Err(error),
    }
    let listed = std::fs::read_dir(job.work_folder).map_err(|source| refused(job.work_folder, source))?;
    let mut files: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
    files.sort();
    let mut all = Vec::new();
    for file in files {
        all.extend(file.file_name().unwrap_or_default().as_encoded_bytes());
        all.extend(std::fs::read(&file).map_err(|source| refused(&file, source))?);
    }
    Ok(format!("-{:016x}", checksum(&all)))
}
