use super::*;
use crate::observables::Measurement;
use makadam::snapshot::Particle;

fn sample() -> (Scene, Reference) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let scene = Scene::load(&file).unwrap();
    let run = |code: &str, seed, factor| MeasuredRun {
        code: code.into(),
        version: "1.0, Debian".into(),
        seed,
        time_step: 1.23456e-5,
        rayleigh_fraction: Some(0.1),
        stiffness_factor: factor,
        wall_seconds: 12.5,
        simulated_seconds: 1.5,
        processor: "a processor".into(),
        date: "2026-01-02T03:04:05Z".into(),
        measurements: vec![Measurement {
            observable: "packing_fraction".into(),
            unit: String::new(),
            value: 0.58 + seed as f64 / 7.0,
            standard_error: None,
            frames: 1,
        }],
    };
    let mut reference = Reference::default();
    for code in ["LIGGGHTS", "YADE"] {
        let particle =
            Particle { id: 0, position: [0.1, 0.2, 0.3], radius: 0.005, velocity: [1e-9, 0.0, -0.25], spin: [0.0; 3] };
        let runs = |factor| CodeRuns {
            code: code.into(),
            source: Source::Live,
            provenance: String::new(),
            runs: vec![run(code, 1, factor), run(code, 2, factor)],
            stiff_runs: Vec::new(),
            forces: Some(ForceDistribution {
                code: code.into(),
                force: vec![0.125, 0.375],
                density: vec![0.5, 0.25],
                samples: 77,
            }),
            series: vec![Series {
                code: code.into(),
                seed: 1,
                observable: "angle".into(),
                time: vec![0.0, 0.5],
                value: vec![30.0, 31.5],
            }],
            final_state: Some(FinalState { code: code.into(), seed: 1, time: 1.5, particles: vec![particle] }),
        };
        reference.replace(runs(1.0), 1.0, physics_hash(&scene));
        reference.replace(runs(10.0), 10.0, physics_hash(&scene));
    }
    (scene, reference)
}

#[test]
fn what_is_written_is_read_back() {
    let (scene, reference) = sample();
    let folder = tempfile::tempdir().unwrap();
    reference.save(&scene, folder.path()).unwrap();
    let read = Reference::load(folder.path()).unwrap().unwrap();
    assert_eq!(read, reference);
    assert_eq!(read.codes(), ["LIGGGHTS", "YADE"]);
    assert_eq!(read.seeds(), 2);
    assert_eq!(read.code("YADE").unwrap().stiff_runs.len(), 2);
    assert_eq!(read.is_current("YADE", &scene), Some(true));
}

#[test]
fn a_changed_scene_is_noticed_and_changed_margins_are_not() {
    let (mut scene, reference) = sample();
    scene.compare.clear();
    scene.solver.step *= 0.5;
    assert_eq!(reference.is_current("YADE", &scene), Some(true));
    scene.gravity[0] = 0.1;
    assert_eq!(reference.is_current("YADE", &scene), Some(false));
}

#[test]
fn recording_again_replaces() {
    let (scene, mut reference) = sample();
    let again = reference.code("YADE").unwrap();
    let runs = reference.runs.len();
    reference.replace(again, 1.0, physics_hash(&scene));
    assert_eq!(reference.runs.len(), runs);
    assert_eq!(reference.final_states.len(), 2);
}

#[test]
fn a_bad_line_is_named() {
    let (scene, reference) = sample();
    let folder = tempfile::tempdir().unwrap();
    reference.save(&scene, folder.path()).unwrap();
    let file = folder.path().join("measurements.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let spoil = |from: &str, to: &str| {
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        Reference::load(folder.path()).unwrap_err().to_string()
    };
    let message = spoil("0.722857142857", "many");
    assert!(message.contains("measurements.csv:2:"), "{message}");
    let message = spoil(",packing_fraction,,", ",packing_fraction,");
    assert!(message.contains("measurements.csv:2:"), "{message}");
    let message = spoil("LIGGGHTS,\"1.0, Debian\",2", "LIGGGHTS,\"1.0, Debian\",9");
    assert!(message.contains("measurements.csv:3:") && message.contains("runs.csv"), "{message}");
    std::fs::remove_file(&file).unwrap();
    let message = Reference::load(folder.path()).unwrap_err().to_string();
    assert!(message.contains("measurements.csv: cannot be read"), "{message}");
}

#[test]
fn nothing_recorded_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(Reference::load(folder.path()).unwrap(), None);
    assert_eq!(Reference::folder(Path::new("a/scene.toml")), Path::new("a/reference"));
    assert_eq!(Reference::folder(Path::new("a/smoke.toml")), Path::new("a/smoke-reference"));
}
