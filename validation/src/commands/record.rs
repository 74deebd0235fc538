//! `makadam compare --record`: what is missing in a scene's recorded references is measured or run, and taken in.

use super::arguments::CompareArguments;
use super::compare::{FEW_SEEDS, codes};
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, can_record};
use crate::compare::{CodeRuns, Missing, Reference, Runs, Simulated, Wanted, physics_hash};
use crate::peers::{Code, CodeError};
use crate::plan::Scene;
use crate::prepared::cache_folder;
use crate::statistics::Ensemble;
use rayon::prelude::*;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Records what is missing of the peers that are asked for.
pub(super) fn record(
    arguments: &CompareArguments,
    scene: &Scene,
    file: &Path,
    console: &Console,
) -> Result<ExitCode, Failure> {
    let peers = codes(&arguments.codes).into_iter().filter(|code| code.name() != "Makadam").collect();
    record_codes(peers, arguments, scene, file, console)
}

/// Records what is missing of some codes. What ended well is taken in even if other seeds failed.
fn record_codes(
    peers: Vec<Box<dyn Code>>,
    arguments: &CompareArguments,
    scene: &Scene,
    file: &Path,
    console: &Console,
) -> Result<ExitCode, Failure> {
    can_record(file)?;
    let folder = Reference::folder(file);
    let mut reference = Reference::load(&folder)?.unwrap_or_default();
    let seeds: Vec<u64> = (1..=arguments.seeds.unwrap_or_else(|| reference.seeds().max(FEW_SEEDS))).collect();
    let (factor, hash) = (arguments.stiffness_factor, physics_hash(scene));
    let announce = announce(console);
    let recordings = match &arguments.recordings {
        Some(folder) => folder.clone(),
        None => cache_folder()?.join("recordings"),
    };
    let runs_of = |missing: &Missing| Runs {
        scene,
        scene_file: file,
        seeds: missing.seeds.clone(),
        rayleigh_fraction: arguments.rayleigh_fraction,
        stiffness_factor: factor,
        time_limit: Duration::from_secs_f64(arguments.time_limit),
        recordings: Some(recordings.clone()),
        announce: &announce,
    };
    // Said before the hours that the runs may take, so that a fraction mistyped is noticed in time.
    let plans: Vec<(Box<dyn Code>, Missing)> = peers
        .into_iter()
        .map(|code| {
            let missing = plan(code.as_ref(), arguments, &reference, &hash, &seeds);
            say(code.name(), &missing, reference.at(code.name(), factor).count(), &seeds, console);
            (code, missing)
        })
        .collect();
    let simulated: Vec<_> = plans.par_iter().map(|(code, missing)| runs_of(missing).simulate(code.as_ref())).collect();
    let (mut failure, mut changed, mut whole) = (None, false, true);
    for ((code, missing), simulated) in plans.iter().zip(simulated) {
        let code = code.name();
        let (new, failed) = split(code, simulated, console);
        let complete = failed.is_none();
        failure = failure.or(failed);
        match take_in(&mut reference, new, missing, complete, factor, &hash) {
            Ok(taken) => changed |= taken,
            Err(problem) => {
                console.warn(&format!("{code}: its references stay as they were: {problem}"));
                failure = failure.or(Some(Failure::Running(problem)));
            }
        }
        whole &= show(&reference, code, factor, scene, console)?;
    }
    // Nothing new leaves the files alone, down to their dates.
    if changed {
        reference.save(scene, &folder)?;
    }
    let state = if changed { "" } else { " (unchanged)" };
    console.result(&format!("references: {}{state}", folder.display()))?;
    match (failure, whole) {
        (Some(failure), _) => Err(failure),
        (None, true) => Ok(ExitCode::SUCCESS),
        (None, false) => Ok(ExitCode::from(OUTSIDE_TOLERANCE)),
    }
}

/// What has to be measured or run of a code.
fn plan(code: &dyn Code, arguments: &CompareArguments, reference: &Reference, hash: &str, seeds: &[u64]) -> Missing {
    if arguments.again {
        let recorded = reference.at(code.name(), arguments.stiffness_factor).next();
        return Missing { seeds: seeds.to_vec(), replaces: recorded.map(|_| "--again asks for it".into()) };
    }
    reference.missing(&Wanted {
        code: code.name(),
        version: code.version().as_deref(),
        scene_hash: hash,
        rayleigh_fraction: arguments.rayleigh_fraction,
        stiffness_factor: arguments.stiffness_factor,
        seeds,
    })
}

/// Says what will be kept and what will be replaced.
fn say(code: &str, missing: &Missing, recorded: usize, seeds: &[u64], console: &Console) {
    match &missing.replaces {
        Some(reason) => console.warn(&format!(
            "{code}: all {recorded} recorded runs will be replaced by seeds 1 to {}, not mixed with them: {reason}",
            seeds.len()
        )),
        None => console.note(&format!(
            "{code}: {} of {} seeds are recorded already, {} to measure or run",
            seeds.len() - missing.seeds.len(),
            seeds.len(),
            missing.seeds.len()
        )),
    }
}

/// The runs that ended well; the first failure of the others, all of which are said.
fn split(code: &str, simulated: Simulated, console: &Console) -> (CodeRuns, Option<Failure>) {
    let mut failure = None;
    for (seed, error) in simulated.failures {
        console.warn(&format!("{code}, seed {seed}: {error}"));
        failure = failure.or(Some(match error {
            CodeError::Interrupted { .. } => Failure::Interrupted("kept, run by run: try again for the others".into()),
            other => Failure::from(other),
        }));
    }
    (CodeRuns::live(code, rayon::current_num_threads(), simulated.harvests), failure)
}

/// Puts new runs beside the recorded ones or in their place; whether anything changed, or why the references stay.
fn take_in(
    reference: &mut Reference,
    new: CodeRuns,
    missing: &Missing,
    complete: bool,
    factor: f64,
    hash: &str,
) -> Result<bool, String> {
    if missing.replaces.is_some() && !complete {
        // Half a replacement would cost recorded runs, and the raw recordings keep what was run.
        return Err("some seeds that were to replace them failed; the runs that ended are kept, so try again".into());
    }
    if new.runs.is_empty() {
        return Ok(false);
    }
    match missing.replaces {
        Some(_) => reference.replace(new, factor, hash),
        None => reference.add(new, factor, hash).map_err(|error| error.to_string())?,
    }
    Ok(true)
}

/// Prints mean and standard deviation of what is recorded of a code; whether every run has a value of all that is compared.
fn show(reference: &Reference, code: &str, factor: f64, scene: &Scene, console: &Console) -> Result<bool, Failure> {
    let runs = reference.at(code, factor).count();
    let mut whole = true;
    for expectation in &scene.compare {
        let observable = &expectation.observable;
        let values: Vec<f64> = reference.at(code, factor).filter_map(|run| run.value(observable)).collect();
        let lacking = match runs - values.len() {
            0 => String::new(),
            _ => format!("; not measured in {} of {runs}", runs - values.len()),
        };
        whole &= lacking.is_empty() && runs > 0;
        let text = match Ensemble::of(&values) {
            Some(ensemble) => format!(
                "{:.5} +- {:.5} ({} seeds{lacking})",
                ensemble.mean, ensemble.standard_deviation, ensemble.seeds
            ),
            None => format!("not measured in any of {runs} seeds"),
        };
        console.result(&format!("{code:<10} {observable:<28} {text}"))?;
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::arguments::{Arguments, Command};
    use crate::peers::Job;
    use crate::recording::Recording;
    use clap::Parser;
    use std::path::PathBuf;
    use std::sync::{Arc, Mutex};

    /// A code that is done at once, writes down its seeds and fails where it is told to.
    struct Fake {
        version: &'static str,
        failing: Vec<u64>,
        ran: Arc<Mutex<Vec<u64>>>,
    }

    impl Code for Fake {
        fn name(&self) -> &'static str {
            "LIGGGHTS"
        }

        fn version(&self) -> Option<String> {
            Some(self.version.into())
        }

        fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
            self.ran.lock().unwrap().push(job.seed);
            if self.failing.contains(&job.seed) {
                return Err(CodeError::Unsupported { code: "LIGGGHTS", reason: "it was told to fail".into() });
            }
            Ok(Recording {
                scene: job.scene.name.clone(),
                code: "LIGGGHTS".into(),
                version: self.version.into(),
                seed: job.seed,
                time_step: 1e-5,
                rayleigh_fraction: Some(job.rayleigh_fraction),
                stiffness_factor: job.stiffness_factor,
                threads: 1,
                wall_seconds: 1.0,
                simulated_seconds: 0.4,
                frames: Vec::new(),
            })
        }
    }

    /// A folder with the small scene, its references and raw recordings.
    struct Desk {
        folder: tempfile::TempDir,
        scene: PathBuf,
    }

    impl Desk {
        fn new() -> Desk {
            let folder = tempfile::tempdir().unwrap();
            let scene = folder.path().join("scene.toml");
            let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
            std::fs::copy(smoke, &scene).unwrap();
            Desk { folder, scene }
        }

        /// Records with a fake code; the seeds that it ran, and whether all went well.
        fn record(&self, options: &str, version: &'static str, failing: &[u64]) -> (Vec<u64>, bool) {
            let kept = self.folder.path().join("kept");
            let fixed = ["makadam", "compare", "scene", "--record", "--recordings", kept.to_str().unwrap()];
            let arguments = Arguments::parse_from(fixed.into_iter().chain(options.split_whitespace()));
            let Command::Compare(arguments) = arguments.command else { unreachable!("the words say compare") };
            let ran = Arc::default();
            let fake = Fake { version, failing: failing.to_vec(), ran: Arc::clone(&ran) };
            let scene = Scene::load(&self.scene).unwrap();
            let console = Console::new(true, false);
            let ended = record_codes(vec![Box::new(fake)], &arguments, &scene, &self.scene, &console);
            let mut ran = ran.lock().unwrap().clone();
            ran.sort_unstable();
            (ran, ended.is_ok())
        }

        /// Seeds and versions of the recorded runs at a stiffness.
        fn recorded(&self, factor: f64) -> Vec<(u64, String)> {
            let reference = Reference::load(&Reference::folder(&self.scene)).unwrap().unwrap();
            reference.at("LIGGGHTS", factor).map(|run| (run.seed, run.version.clone())).collect()
        }

        fn seeds(&self, factor: f64) -> Vec<u64> {
            self.recorded(factor).into_iter().map(|(seed, _)| seed).collect()
        }

        fn forget_raw_recordings(&self) {
            std::fs::remove_dir_all(self.folder.path().join("kept")).unwrap();
        }
    }

    #[test]
    fn only_missing_seeds_are_run_and_later_seeds_stay() {
        let desk = Desk::new();
        assert_eq!(desk.record("--seeds 2", "1", &[]), (vec![1, 2], true));
        desk.forget_raw_recordings();
        assert_eq!(desk.record("--seeds 4", "1", &[]), (vec![3, 4], true));
        assert_eq!(desk.record("--seeds 1", "1", &[]), (vec![], true));
        assert_eq!(desk.record("", "1", &[]), (vec![], true), "as many as are recorded");
        assert_eq!(desk.seeds(1.0), [1, 2, 3, 4]);
        assert_eq!(desk.record("--seeds 2 --stiffness-factor 10", "1", &[]), (vec![1, 2], true));
        assert_eq!((desk.seeds(1.0), desk.seeds(10.0)), (vec![1, 2, 3, 4], vec![1, 2]));
    }

    #[test]
    fn what_ended_well_is_taken_in_beside_a_failure() {
        let desk = Desk::new();
        assert_eq!(desk.record("--seeds 3", "1", &[2]), (vec![1, 2, 3], false));
        assert_eq!(desk.seeds(1.0), [1, 3]);
        desk.forget_raw_recordings();
        assert_eq!(desk.record("--seeds 4", "1", &[4]), (vec![2, 4], false));
        assert_eq!(desk.seeds(1.0), [1, 2, 3]);
    }

    #[test]
    fn raw_recordings_of_the_installed_version_are_not_run_again() {
        let desk = Desk::new();
        desk.record("--seeds 2", "1", &[]);
        std::fs::remove_dir_all(Reference::folder(&desk.scene)).unwrap();
        assert_eq!(desk.record("--seeds 3", "1", &[]), (vec![3], true));
        assert_eq!(desk.record("--seeds 3", "2", &[]), (vec![1, 2, 3], true));
        assert!(desk.recorded(1.0).iter().all(|(_, version)| version == "2"));
    }

    #[test]
    fn another_time_step_or_scene_replaces_all_runs() {
        let desk = Desk::new();
        desk.record("--seeds 3", "1", &[]);
        assert_eq!(desk.record("--seeds 2 --rayleigh-fraction 0.2", "1", &[]), (vec![1, 2], true));
        assert_eq!(desk.seeds(1.0), [1, 2]);
        // Raw recordings of the scene as it was are still there, and are none of this one.
        let text = std::fs::read_to_string(&desk.scene).unwrap();
        std::fs::write(&desk.scene, text.replacen("duration = 0.4", "duration = 0.5", 1)).unwrap();
        assert_eq!(desk.record("--seeds 3 --rayleigh-fraction 0.2", "1", &[]), (vec![1, 2, 3], true));
    }

    #[test]
    fn a_replacement_that_failed_in_part_costs_nothing() {
        let desk = Desk::new();
        desk.record("--seeds 2", "1", &[]);
        assert_eq!(desk.record("--seeds 3", "2", &[3]), (vec![1, 2, 3], false));
        assert_eq!(desk.recorded(1.0), [(1, "1".into()), (2, "1".into())]);
        assert_eq!(desk.record("--seeds 3", "2", &[]), (vec![3], true), "the runs that ended were kept");
        assert_eq!(desk.seeds(1.0), [1, 2, 3]);
    }

    #[test]
    fn again_replaces_what_is_recorded() {
        let desk = Desk::new();
        desk.record("--seeds 3", "1", &[]);
        assert_eq!(desk.record("--seeds 2 --again", "1", &[]), (vec![], true), "measured from raw recordings");
        assert_eq!(desk.seeds(1.0), [1, 2]);
        desk.forget_raw_recordings();
        assert_eq!(desk.record("--seeds 2 --again", "1", &[]), (vec![1, 2], true));
    }
}
