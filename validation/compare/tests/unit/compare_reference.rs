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
    assert!(
        message.contains("measurements.csv: cannot be read") && message.contains("--record --restart"),
        "{message}"
    );
}

#[test]
fn nothing_recorded_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(Reference::load(folder.path()).unwrap(), None);
    assert_eq!(Reference::folder(Path::new("a/scene.toml")), Path::new("a/reference"));
    assert_eq!(Reference::folder(Path::new("a/smoke.toml")), Path::new("a/smoke-reference"));
}

/// Lists what is missing where a piece of what is wanted is changed; two seeds are recorded, three are wanted.
fn missing(change: impl Fn(&mut Wanted<'_>)) -> Missing {
    let (scene, reference) = sample();
    let hash = physics_hash(&scene);
    let mut wanted = Wanted {
        code: "YADE",
        version: Some("1.0, Debian"),
        contact_law: "a law",
        scene_hash: &hash,
        rayleigh_fraction: 0.1,
        seeds: &[1, 2, 3],
    };
    change(&mut wanted);
    reference.missing(&wanted)
}

#[test]
fn only_seeds_that_are_not_recorded_are_missing() {
    let third = Missing { seeds: vec![3], replaces: None };
    assert_eq!(missing(|_| ()), third);
    assert_eq!(missing(|wanted| wanted.version = None), third, "a code that is not installed keeps its runs");
    assert!(missing(|wanted| wanted.seeds = &[1]).seeds.is_empty());
}

#[test]
fn a_code_without_runs_misses_all_seeds() {
    let all = Missing { seeds: vec![1, 2, 3], replaces: None };
    assert_eq!(missing(|wanted| wanted.code = "another"), all);
}

#[test]
fn runs_made_otherwise_are_all_replaced_and_the_reason_is_said() {
    let replaced = |missing: Missing, reason: &str| {
        assert_eq!(missing.seeds, [1, 2, 3]);
        let said = missing.replaces.unwrap();
        assert!(said.contains(reason), "{said}");
    };
    replaced(missing(|wanted| wanted.scene_hash = "another"), "scene has changed");
    replaced(missing(|wanted| wanted.version = Some("2.0")), "version 1.0, Debian, not 2.0");
    replaced(missing(|wanted| wanted.contact_law = "another"), "contact law 'a law', not 'another'");
    replaced(missing(|wanted| wanted.rayleigh_fraction = 0.2), "10% of the Rayleigh step, and 20%");
}

/// The recorded runs of YADE with other seeds, for adding to a reference or for starting one.
fn with_seeds(seeds: [u64; 2]) -> (Reference, CodeRuns, String) {
    let (scene, reference) = sample();
    let mut code = reference.code("YADE").unwrap();
    for (run, seed) in code.runs.iter_mut().zip(seeds) {
        run.seed = seed;
    }
    code.series.iter_mut().for_each(|series| series.seed = seeds[0]);
    code.final_state.as_mut().unwrap().seed = seeds[0];
    (reference, code, physics_hash(&scene))
}

fn seeds(reference: &Reference) -> Vec<u64> {
    reference.of("YADE").map(|run| run.seed).collect()
}

#[test]
fn new_seeds_stand_beside_the_recorded_ones() {
    let (mut reference, code, hash) = with_seeds([3, 4]);
    let before = reference.clone();
    reference.add(code, &hash).unwrap();
    assert_eq!(seeds(&reference), [1, 2, 3, 4]);
    assert!(reference.of("YADE").all(|run| run.scene_hash == hash));
    let forces = |reference: &Reference, code: &str| reference.code(code).unwrap().forces.unwrap();
    assert_eq!(forces(&reference, "YADE").samples, 2 * forces(&before, "YADE").samples);
    assert_eq!(forces(&reference, "LIGGGHTS"), forces(&before, "LIGGGHTS"));
    // The first seed is still the one that was recorded.
    assert_eq!((&reference.series, &reference.final_states), (&before.series, &before.final_states));
}

#[test]
fn a_new_first_seed_brings_its_series_and_its_final_state() {
    let (mut reference, code, hash) = with_seeds([3, 4]);
    reference.replace(code, &hash);
    let (_, code, _) = with_seeds([1, 2]);
    reference.add(code, &hash).unwrap();
    let code = reference.code("YADE").unwrap();
    assert_eq!(seeds(&reference), [1, 2, 3, 4]);
    assert_eq!((code.series[0].seed, code.final_state.unwrap().seed), (1, 1));
}

#[test]
fn what_does_not_go_together_is_refused_and_changes_nothing() {
    let (reference, code, hash) = with_seeds([3, 4]);
    let refused = |code: CodeRuns, hash: &str| {
        let mut changed = reference.clone();
        let error = changed.add(code, hash).unwrap_err();
        assert_eq!(changed, reference);
        error
    };
    let mut version = code.clone();
    version.runs[1].version = "2.0".into();
    assert!(refused(version, &hash).contains("YADE, seed 4"));
    assert!(refused(code.clone(), "another").contains("YADE, seed 3"));
    let mut seed = code.clone();
    seed.runs[0].seed = 2;
    assert!(refused(seed, &hash).contains("YADE, seed 2"));
    let mut bins = code;
    bins.forces.as_mut().unwrap().force[0] = 0.5;
    assert!(refused(bins, &hash).contains("forces of YADE"));
}

#[test]
fn replacing_leaves_the_order_alone() {
    let (mut reference, _, hash) = with_seeds([1, 2]);
    let before = reference.clone();
    for code in ["LIGGGHTS", "YADE", "LIGGGHTS"] {
        reference.replace(before.code(code).unwrap(), &hash);
    }
    assert_eq!(reference, before);
}
