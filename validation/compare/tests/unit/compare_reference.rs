use super::*;
use makadam::snapshot::Particle;
use makadam_frames::plan::physics_hash;
use makadam_measure::observables::Measurement;

pub(super) fn sample() -> (MeasuredScene, Reference) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reference-scenes/packing/scene.toml");
    let scene = MeasuredScene::load(&file).unwrap();
    let run = |code: &str, seed| MeasuredRun {
        code: code.into(),
        version: "1.0, Debian".into(),
        contact_law: "a law".into(),
        seed,
        time_step: 1.23456e-5,
        rayleigh_fraction: Some(0.1),
        wall_seconds: 12.5,
        core_seconds: None,
        simulated_seconds: 1.5,
        processor: "a processor".into(),
        date: "2026-01-02T03:04:05Z".into(),
        scene_hash: String::new(),
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
        let runs = CodeRuns {
            code: code.into(),
            source: Source::Live,
            timing: crate::compare::Timing::SideBySide,
            provenance: String::new(),
            runs: vec![run(code, 1), run(code, 2)],
            failed: Vec::new(),
            discarded: None,
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
        reference.replace(runs, &physics_hash(&scene));
    }
    (scene, reference)
}

#[test]
fn what_is_written_is_read_back() {
    let (scene, reference) = sample();
    let folder = tempfile::tempdir().unwrap();
    reference.save(folder.path()).unwrap();
    let read = Reference::load(folder.path()).unwrap().unwrap();
    assert_eq!(read, reference);
    assert_eq!(read.codes(), ["LIGGGHTS", "YADE"]);
    assert_eq!(read.seeds(), 2);
    assert_eq!(read.is_current("YADE", &scene), Some(true));
}

#[test]
fn a_changed_scene_is_noticed_and_changed_margins_are_not() {
    let (mut scene, reference) = sample();
    scene.compare.clear();
    scene.solver.step *= 0.5;
    scene.output = Some(makadam_frames::plan::Output::default());
    assert_eq!(reference.is_current("YADE", &scene), Some(true));
    scene.gravity[0] = 0.1;
    assert_eq!(reference.is_current("YADE", &scene), Some(false));
}

#[test]
fn runs_under_another_law_of_contacts_are_noticed() {
    let (scene, reference) = sample();
    assert_eq!(reference.is_current("Makadam", &scene), None);
    assert!(reference.out_of_date("LIGGGHTS", "a law", &scene).is_empty());
    let reasons = reference.out_of_date("YADE", "another law", &scene);
    assert_eq!(reasons.len(), 1, "{reasons:?}");
    assert!(reasons[0].contains("2 of 2 recorded runs of YADE were made under the contact law 'a law'"), "{reasons:?}");
}

#[test]
fn what_does_not_count_is_not_there_and_seeds_that_are_wanting_have_failed() {
    let (mut scene, mut reference) = sample();
    reference.runs.iter_mut().filter(|run| run.code == "YADE" && run.seed == 2).for_each(|run| run.seed = 4);
    assert_eq!(reference.code_on("YADE", &scene).unwrap().failed, [2, 3]);
    assert_eq!(reference.code_on("LIGGGHTS", &scene).unwrap().failed, [0; 0]);
    scene.gravity[0] = 0.1;
    let other = reference.code_on("LIGGGHTS", &scene).unwrap();
    assert!(other.discarded.is_some_and(|why| why.contains("another scene")));
    assert!(other.runs.is_empty() && other.series.is_empty() && other.forces.is_none() && other.final_state.is_none());
}

/// Numbers are written as they were read, so that recording one code leaves the lines of another alone.
#[test]
fn recorded_references_are_written_as_they_were_read() {
    for name in ["packing", "drum", "drum-caps", "heap"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../reference-scenes/{name}/scene.toml"));
        let (recorded, copy) = (Reference::folder(&file), tempfile::tempdir().unwrap());
        let reference = Reference::load(&recorded).unwrap().unwrap();
        reference.save(copy.path()).unwrap();
        for entry in std::fs::read_dir(&recorded).unwrap() {
            let path = entry.unwrap().path();
            let written = copy.path().join(path.file_name().unwrap());
            assert!(std::fs::read(&path).unwrap() == std::fs::read(&written).unwrap(), "{}", path.display());
        }
    }
}

#[test]
fn provenance_lists_days_and_processors() {
    let (_, mut reference) = sample();
    let last = reference.runs.iter_mut().rfind(|run| run.code == "YADE").unwrap();
    (last.processor, last.date) = ("another".into(), "2026-02-03T00:00:00Z".into());
    let provenance = reference.code("YADE").unwrap().provenance;
    assert!(provenance.contains("recorded 2026-01-02 to 2026-02-03 on a processor, another"), "{provenance}");
}

#[test]
fn a_bad_line_is_named() {
    let (_, reference) = sample();
    let folder = tempfile::tempdir().unwrap();
    reference.save(folder.path()).unwrap();
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
    assert!(message.contains("measurements.csv: cannot be read") && message.contains("--record"), "{message}");
}

#[test]
fn nothing_recorded_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(Reference::load(folder.path()).unwrap(), None);
    assert_eq!(Reference::folder(Path::new("a/scene.toml")), Path::new("a/reference"));
    assert_eq!(Reference::folder(Path::new("a/smoke.toml")), Path::new("a/smoke-reference"));
}

#[test]
fn replacing_leaves_the_order_alone() {
    let (scene, mut reference) = sample();
    let hash = physics_hash(&scene);
    let before = reference.clone();
    for code in ["LIGGGHTS", "YADE", "LIGGGHTS"] {
        reference.replace(before.code(code).unwrap(), &hash);
    }
    assert_eq!(reference, before);
}
