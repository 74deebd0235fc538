//! The baseline: tests that are missing, new or of another verdict.

use crate::support::sample;
use makadam_compare::compare::{CodeRuns, Comparison, MeasuredRun, Source, Timing, comparison};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::Measurement;
use makadam_measure::statistics::Outcome;
use makadam_qualification::report::{Changes, Qualification, StudyOutcome, Test, tests, write};
use std::path::Path;

/// A drum in which every test agrees, and a study.
fn sound() -> Qualification {
    let mut drum = sample::drum(false);
    for row in &mut drum.rows {
        row.outcome = row.margin.and(Some(Outcome::Agree));
    }
    let studies = vec![sample::study(StudyOutcome::Passed)];
    Qualification { studies, ..sample::qualification(vec![drum]) }
}

fn changes(now: &Qualification) -> Changes {
    Changes::between(&tests(&sound()), &tests(now))
}

#[test]
fn written_tests_are_a_baseline() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tests.json");
    write(&sound(), folder.path()).unwrap();
    let read = Test::read(&file, "full").unwrap();
    assert_eq!(read, tests(&sound()));
    assert_eq!(read.len(), sound().verdict().tests());
    assert_eq!(Changes::between(&read, &tests(&sound())), Changes::default());
    let refused = Test::read(&file, "quick").unwrap_err();
    assert!(refused.contains("no tests of the tier quick, only of full"), "{refused}");
    let refused = Test::read(&folder.path().join("report.json"), "full").unwrap_err();
    assert!(refused.contains("give validation/baseline.json, or tests.json"), "{refused}");
}

#[test]
fn missing_and_new_tests_are_listed() {
    let mut now = sound();
    let gone = now.comparisons[0].rows.iter().position(|row| row.margin.is_some()).unwrap();
    now.comparisons[0].rows[gone].observable = "packing_factor".into();
    now.studies[0].tests[0].name = "stack-11".into();
    let changes = changes(&now);
    assert_eq!(changes.missing, ["drum: dynamic_angle_of_repose against LIGGGHTS", "stability: stack-10"]);
    assert_eq!(changes.new, ["drum: packing_factor against LIGGGHTS", "stability: stack-11"]);
    assert!(!changes.pass());
}

#[test]
fn weaker_tests_are_missing() {
    let reason = |change: &dyn Fn(&mut Comparison)| {
        let mut now = sound();
        change(&mut now.comparisons[0]);
        let changes = changes(&now);
        assert!(!changes.pass());
        changes.missing[0].clone()
    };
    let wider = reason(&|drum| drum.rows.iter_mut().for_each(|row| row.margin = row.margin.map(|margin| 2.0 * margin)));
    assert!(wider.ends_with("(margin 3, baseline 1.5)"), "{wider}");
    for place in [0, 1] {
        let fewer = reason(&|drum| _ = drum.codes[place].seeds.pop());
        assert!(fewer.contains("runs, baseline 5 and 5)"), "{fewer}");
    }
    let other = reason(&|drum| drum.scene.duration += 1.0);
    assert!(other.ends_with("(another scene than that of the baseline)"), "{other}");
}

#[test]
fn changed_verdicts_are_listed() {
    let with = |outcome: Outcome, of_study: StudyOutcome| {
        let mut now = sound();
        now.comparisons[0].rows[0].outcome = Some(outcome);
        now.studies[0].tests[0].outcome = of_study;
        now
    };
    let worse = with(Outcome::Undecided, StudyOutcome::KnownException);
    let lines = [
        "drum: dynamic_angle_of_repose against LIGGGHTS: undecided, baseline agree",
        "stability: stack-10: known exception, baseline passed",
    ];
    assert_eq!(changes(&worse).worse, lines);
    assert!(!changes(&worse).pass());
    let back = Changes::between(&tests(&worse), &tests(&sound()));
    assert!(back.pass() && back.better.len() == 2 && back.worse.is_empty(), "{back:?}");
    // A baseline without a verdict asks for the test alone.
    let unknown: Vec<Test> = tests(&worse).into_iter().map(|test| Test { verdict: None, ..test }).collect();
    assert_eq!(Changes::between(&unknown, &tests(&sound())), Changes::default());
}

/// A code with these packing fractions, all runs but the last `moving` at rest.
fn code(name: &str, values: &[f64], moving: usize) -> CodeRuns {
    let run = |(place, &value): (usize, &f64)| {
        let energy = if place + moving >= values.len() { 1.0 } else { 0.0 };
        let measured = |observable: &str, value: f64| Measurement {
            observable: observable.into(),
            unit: String::new(),
            value,
            standard_error: None,
            frames: 1,
        };
        MeasuredRun {
            code: name.into(),
            version: "1".into(),
            contact_law: String::new(),
            seed: place as u64 + 1,
            time_step: 1e-3,
            rayleigh_fraction: None,
            wall_seconds: 3.0,
            core_seconds: None,
            simulated_seconds: 1.5,
            processor: String::new(),
            date: String::new(),
            scene_hash: String::new(),
            measurements: vec![measured("packing_fraction", value), measured("kinetic_energy", energy)],
        }
    };
    CodeRuns {
        code: name.into(),
        source: Source::Live,
        timing: Timing::SideBySide,
        provenance: String::new(),
        runs: values.iter().enumerate().map(run).collect(),
        failed: Vec::new(),
        discarded: None,
        forces: None,
        series: Vec::new(),
        final_state: None,
    }
}

#[test]
fn runs_excluded_by_the_rule_of_rest_count_as_made() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let mut scene = MeasuredScene::load(&file).unwrap();
    scene.compare.truncate(1);
    scene.measure.seeds = Some(6);
    scene.measure.rest_energy.expect("the packing has a rule of rest");
    let values = [0.585, 0.586, 0.587, 0.586, 0.585, 0.586];
    let made = |moving: usize, runs: usize| {
        let codes = [code("Makadam", &values[..runs], moving), code("YADE", &values, 0)];
        let mut compared = comparison(&scene, &codes, Vec::new());
        compared.scene.measure.seeds = Some(6);
        sample::qualification(vec![compared])
    };
    let baseline = tests(&made(0, 6));
    let excluded = made(1, 6);
    assert_eq!(excluded.comparisons[0].rows[0].seeds, 5, "one run is left out");
    assert_eq!(excluded.verdict().agree, 1, "{}", excluded.verdict().sentence);
    assert_eq!(Changes::between(&baseline, &tests(&excluded)), Changes::default());
    // A run that was not made is missing.
    assert!(Changes::between(&baseline, &tests(&made(0, 5))).missing[0].contains("5 and 6 runs, baseline 6 and 6"));
}
