//! Runs of one code over several seeds, run in parallel, measured at their end.

use super::{CodeRuns, CodeSummary, Harvest, Timing};
use crate::codes::{Code, CodeError, Job, Purpose};
use crate::study::{Key, RunCache, RunError};
use makadam::checkpoint::checksum;
use makadam_frames::output::{file_stem, run_folder};
use makadam_frames::plan::{MeasuredScene, physics_hash};
use makadam_frames::provenance::{machine, utc};
use makadam_frames::recording::Recording;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Receives the completed fraction of a run, 0 to 1.
pub type Share = Box<dyn Fn(f64) + Send + Sync>;

/// Opens a progress display for a run of this name.
pub type Announce<'a> = &'a (dyn Fn(&str) -> Share + Sync);

/// Seed of the run for pictures and curves over time; of the others the numbers alone are stored.
const PICTURED_SEED: u64 = 1;

/// Runs of a code on a scene.
#[derive(Clone)]
pub struct Runs<'a> {
    /// Scene as written in its file.
    pub scene: &'a MeasuredScene,
    /// File of the scene.
    pub scene_file: &'a Path,
    /// Purpose of the runs.
    pub purpose: Purpose,
    /// Seeds of the initial positions.
    pub seeds: Vec<u64>,
    /// Time step of explicit codes over the Rayleigh step.
    pub rayleigh_fraction: f64,
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Wall time after which a run is stopped.
    pub time_limit: Duration,
    /// Folder of raw recordings. A recording of this scene and the installed version is reused; a new run is stored.
    /// Without a folder no recording is stored.
    pub recordings: Option<PathBuf>,
    /// Opens progress displays.
    pub announce: Announce<'a>,
}

/// Time step of the live runs of a qualification over the Rayleigh step: the longest with which LIGGGHTS stays within the bounds of
/// the trade-off in every scene.
pub const LIVE_FRACTION: f64 = 0.2;

impl<'a> Runs<'a> {
    /// Returns one seed for measuring. Scenes, effects and settings of a qualification all use this request, so that no run is repeated.
    pub fn of_one_seed(
        scene: &'a MeasuredScene,
        scene_file: &'a Path,
        seed: u64,
        time_limit: Duration,
        announce: Announce<'a>,
    ) -> Runs<'a> {
        let (purpose, rayleigh_fraction, stiffness_factor) = (Purpose::Measuring, LIVE_FRACTION, 1.0);
        let (seeds, recordings) = (vec![seed], None);
        Runs {
            scene,
            scene_file,
            purpose,
            seeds,
            rayleigh_fraction,
            stiffness_factor,
            time_limit,
            recordings,
            announce,
        }
    }

    /// Returns the same runs of other seeds.
    pub fn of_seeds(&self, seeds: &[u64]) -> Runs<'a> {
        Runs { seeds: seeds.to_vec(), ..self.clone() }
    }
}

/// Ended runs.
pub struct Simulated {
    /// Successful runs, measured.
    pub harvests: Vec<Harvest>,
    /// Failed runs: seed and reason.
    pub failures: Vec<(u64, CodeError)>,
}

impl Runs<'_> {
    /// Runs the code over the seeds, at most one per thread of the thread pool at a time.
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
    /// [`CodeError`]; the files of the code are not removed, unless the user asked to stop.
    pub fn one(&self, code: &dyn Code, scene: &MeasuredScene, seed: u64) -> Result<Harvest, CodeError> {
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
        if let Some(file) = kept.as_ref().filter(|file| file.is_file()) {
            let (installed, recording) = (code.version(), Recording::load(file));
            // Versions do not mix: a recording of another version, or a damaged one, is repeated, unless no code is there to run.
            let is_right =
                recording.as_ref().is_ok_and(|found| installed.as_ref().is_none_or(|own| *own == found.version));
            if is_right || installed.is_none() {
                let ended = file.metadata().and_then(|data| data.modified()).unwrap_or_else(|_| SystemTime::now());
                let _ = std::fs::remove_dir_all(&work_folder);
                return Ok(Harvest::of(scene, &recording?, code.contact_law(), utc(ended)));
            }
        }
        if makadam_frames::interrupt::requested() {
            let _ = std::fs::remove_dir_all(&work_folder);
            return Err(CodeError::Interrupted { code: code.name() });
        }
        let progress = (self.announce)(&format!("{} {} seed {seed}", scene.name, code.name()));
        let ended = code.simulate(&job(&*progress));
        // The files of an interrupted run are removed; those of a failed run are not.
        if ended.as_ref().is_err_and(CodeError::is_interruption) {
            let _ = std::fs::remove_dir_all(&work_folder);
        }
        let recording = ended?;
        let mut ended = SystemTime::now();
        if let Some(file) = &kept {
            recording.save(file)?;
            // The date of the run is that of its raw recording, as when the recording is read again.
            ended = file.metadata().and_then(|data| data.modified()).unwrap_or(ended);
        }
        // The raw output of a successful run is in the recording; a folder that cannot be removed does no harm.
        let _ = std::fs::remove_dir_all(&work_folder);
        Ok(Harvest::of(scene, &recording, code.contact_law(), utc(ended)))
    }

    /// Returns the run of a seed, from the cache or new. Other runs may have run at the same time.
    ///
    /// # Errors
    /// [`RunError`] if a new run is necessary and fails.
    pub fn take(&self, cache: &RunCache, code: &dyn Code, seed: u64) -> Result<Harvest, RunError> {
        match cache.find(&self.key(code, seed, true))? {
            Some(harvest) => Ok(harvest),
            None => self.take_as(cache, code, seed, false),
        }
    }

    /// Returns the run of a seed, from the cache or new. A run that is `alone` has the machine to itself; its key includes the processor.
    ///
    /// # Errors
    /// [`RunError`] if a new run is necessary and fails.
    pub fn take_as(&self, cache: &RunCache, code: &dyn Code, seed: u64, alone: bool) -> Result<Harvest, RunError> {
        cache.take(&self.key(code, seed, alone), || {
            let harvest = self.one(code, &self.scene.with_stiffness_factor(self.stiffness_factor), seed)?;
            Ok(match seed {
                PICTURED_SEED => harvest,
                _ => Harvest { series: Vec::new(), final_state: None, ..harvest },
            })
        })
    }

    /// Key of a run: scene, settings, the code with its version and contact law; for a run alone on the machine also its processor.
    pub fn key(&self, code: &dyn Code, seed: u64, alone: bool) -> Key {
        let scene = self.scene.with_stiffness_factor(self.stiffness_factor);
        let (mark, machine) = if alone { ("-alone", machine()) } else { ("", String::new()) };
        let name = format!("{}-{}-s{seed}{mark}", file_stem(&scene.name), code.name().to_lowercase());
        // If the inputs for timing and for measuring are equal, one run serves for both.
        let timing = self.purpose == Purpose::Timing && code.timing_input().is_some();
        let settings = [
            format!("{} {}", self.rayleigh_fraction, self.stiffness_factor),
            format!("{} {}, {}", code.name(), code.version().unwrap_or_default(), code.contact_law()),
            machine,
            String::from(if timing { "timing" } else { "" }),
        ];
        Key::of_run(name, &scene, seed, &settings.each_ref().map(String::as_str)).apart()
    }

    /// Times the code on one seed by a run for timing, alone on the machine, unless a time is stored. Where its frames lack content, a run for
    /// measuring supplies the measurements.
    ///
    /// # Errors
    /// Error of either run.
    pub fn time(&self, cache: &RunCache, code: &dyn Code, seed: u64) -> Result<(CodeSummary, Harvest), RunError> {
        let timed = Runs { purpose: Purpose::Timing, ..self.clone() }.take_as(cache, code, seed, true)?;
        let input = code.timing_input().map(|words| format!("; its input for timing: {words}")).unwrap_or_default();
        // Without processor time no ratio to the times of other codes is possible.
        let timing = if timed.run.core_seconds.is_some() { Timing::Alone } else { Timing::Measuring };
        let provenance = format!("processor time of the stepping of one run by this command{input}");
        let runs = CodeRuns { timing, provenance, ..CodeRuns::live(code.name(), 1, vec![timed.clone()]) };
        let summary = runs.summary().expect("it has a run");
        let harvest = if timed.lacks.is_empty() { timed } else { self.take(cache, code, seed)? };
        Ok((summary, harvest))
    }

    /// Returns the name of a run; the hash distinguishes the scene from its earlier versions.
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

/// Returns the end of a recording's name: a hash of the input files of the code, so that a recording of another deck is not reused; empty
/// if there are none.
fn inputs(code: &dyn Code, job: &Job<'_>) -> Result<String, CodeError> {
    let refused = |path: &Path, source| CodeError::Io { path: path.display().to_string(), source };
    // Files of an earlier process with the same number do not count.
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
