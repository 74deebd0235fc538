//! Unit tests of `src/commands/compare.rs`.

use super::*;
use crate::commands::{Arguments, Command};
use makadam_compare::codes::{CodeError, Job};
use makadam_compare::compare::Reference;
use makadam_frames::recording::Recording;
use std::cell::Cell;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// A code that is done at once, writes down its seeds and fails where it is told to.
struct Fake {
    version: &'static str,
    /// Options of a recorded run.
    deck: &'static str,
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

    fn write_input(&self, job: &Job<'_>) -> Result<String, CodeError> {
        std::fs::create_dir_all(job.work_folder).unwrap();
        std::fs::write(job.work_folder.join("deck.in"), self.deck).unwrap();
        Ok("fake -in deck.in".into())
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
            core_seconds: None,
            simulated_seconds: 0.4,
            frames: Vec::new(),
            lacks: Vec::new(),
            alarms: Vec::new(),
            notes: Vec::new(),
        })
    }
}

/// A folder with the small scene, its references and raw recordings.
struct Desk {
    folder: tempfile::TempDir,
    scene: PathBuf,
    deck: Cell<&'static str>,
}

impl Desk {
    fn new() -> Desk {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("scene.toml");
        let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
        std::fs::copy(smoke, &scene).unwrap();
        Desk { folder, scene, deck: Cell::new("skin 1") }
    }

    /// Records with a fake code; the seeds that it ran, and whether all went well.
    fn record(&self, options: &str, version: &'static str, failing: &[u64]) -> (Vec<u64>, bool) {
        let kept = self.folder.path().join("kept");
        let fixed = ["makadam", "compare", "scene", "--record", "--recordings", kept.to_str().unwrap()];
        let arguments =
            Arguments::read(&fixed.into_iter().chain(options.split_whitespace()).map(Into::into).collect::<Vec<_>>())
                .unwrap();
        let Command::Compare(arguments) = arguments.command else { unreachable!("the words say compare") };
        let ran = Arc::default();
        let fake = Fake { version, deck: self.deck.get(), failing: failing.to_vec(), ran: Arc::clone(&ran) };
        let scene = MeasuredScene::load(&self.scene).unwrap();
        let console = Console::new(true, false);
        let ended = record_codes(vec![Box::new(fake)], &arguments, &scene, &self.scene, &console);
        let mut ran = ran.lock().unwrap().clone();
        ran.sort_unstable();
        (ran, ended.is_ok())
    }

    /// Seeds and versions of the recorded runs.
    fn recorded(&self) -> Vec<(u64, String)> {
        let reference = Reference::load(&Reference::folder(&self.scene)).unwrap().unwrap();
        reference.of("LIGGGHTS").map(|run| (run.seed, run.version.clone())).collect()
    }

    fn seeds(&self) -> Vec<u64> {
        self.recorded().into_iter().map(|(seed, _)| seed).collect()
    }

    fn forget_raw_recordings(&self) {
        std::fs::remove_dir_all(self.folder.path().join("kept")).unwrap();
    }
}

#[test]
fn what_ended_well_is_taken_in_beside_a_failure() {
    let desk = Desk::new();
    assert_eq!(desk.record("--seeds 3", "1", &[2]), (vec![1, 2, 3], false));
    assert_eq!(desk.seeds(), [1, 3]);
    assert_eq!(desk.record("--seeds 4", "1", &[4]), (vec![2, 4], false));
    assert_eq!(desk.seeds(), [1, 2, 3]);
    assert_eq!(desk.record("--seeds 2", "1", &[]), (vec![], false), "fewer runs than are recorded replace none");
    desk.forget_raw_recordings();
    assert_eq!(desk.record("", "1", &[]), (vec![1, 2, 3], true), "as many as are recorded");
    let written = || std::fs::metadata(Reference::folder(&desk.scene).join("runs.csv")).unwrap().modified().unwrap();
    let before = written();
    assert_eq!(desk.record("", "1", &[]), (vec![], true));
    assert_eq!(written(), before, "nothing new leaves the files alone");
}

#[test]
fn raw_recordings_of_the_installed_version_are_not_run_again() {
    let desk = Desk::new();
    desk.record("--seeds 2", "1", &[]);
    std::fs::remove_dir_all(Reference::folder(&desk.scene)).unwrap();
    assert_eq!(desk.record("--seeds 3", "1", &[]), (vec![3], true));
    assert_eq!(desk.record("--seeds 3", "2", &[]), (vec![1, 2, 3], true));
    assert!(desk.recorded().iter().all(|(_, version)| version == "2"));
}

#[test]
fn raw_recordings_of_another_deck_are_not_taken_up() {
    let desk = Desk::new();
    desk.record("--seeds 2", "1", &[]);
    desk.deck.set("skin 2");
    assert_eq!(desk.record("--seeds 2", "1", &[]), (vec![1, 2], true));
    assert_eq!(desk.record("--seeds 2", "1", &[]), (vec![], true));
    desk.deck.set("skin 1");
    assert_eq!(desk.record("--seeds 2", "1", &[]), (vec![], true));
}

#[test]
fn another_time_step_or_scene_replaces_all_runs() {
    let desk = Desk::new();
    desk.record("--seeds 2", "1", &[]);
    assert_eq!(desk.record("--seeds 2 --rayleigh-fraction 0.2", "1", &[]), (vec![1, 2], true));
    assert_eq!(desk.seeds(), [1, 2]);
    // Raw recordings of the scene as it was are still there, and are none of this one.
    let text = std::fs::read_to_string(&desk.scene).unwrap();
    std::fs::write(&desk.scene, text.replacen("duration = 0.4", "duration = 0.5", 1)).unwrap();
    assert_eq!(desk.record("--seeds 3 --rayleigh-fraction 0.2", "1", &[]), (vec![1, 2, 3], true));
}

#[test]
fn a_replacement_that_failed_in_part_costs_nothing() {
    let desk = Desk::new();
    desk.record("--seeds 2", "1", &[]);
    assert_eq!(desk.record("--seeds 2", "2", &[2]), (vec![1, 2], false));
    assert_eq!(desk.recorded(), [(1, "1".into()), (2, "1".into())]);
    assert_eq!(desk.record("--seeds 3", "2", &[]), (vec![2, 3], true), "the run that ended was kept");
    assert!(desk.recorded().iter().all(|(_, version)| version == "2"));
}

#[test]
fn damaged_references_stay() {
    let desk = Desk::new();
    desk.record("--seeds 2", "1", &[]);
    let runs = Reference::folder(&desk.scene).join("runs.csv");
    std::fs::write(&runs, "code\n").unwrap();
    assert_eq!(desk.record("--seeds 2", "1", &[]), (vec![], false));
    assert_eq!(std::fs::read_to_string(runs).unwrap(), "code\n");
}
