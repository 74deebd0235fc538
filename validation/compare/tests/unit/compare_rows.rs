//! Unit tests of `src/compare/rows.rs`.

use super::*;
use crate::compare::{CodeRuns, Source, Timing, comparison};
use makadam_measure::observables::Measurement;
use makadam_measure::statistics::Outcome;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use statrs::distribution::{ContinuousCDF, Normal};
use std::path::Path;

/// The packing with the margin of its packing fraction that these tests count by, any run at rest, and so many seeds registered.
fn packing(seeds: u64) -> MeasuredScene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reference-scenes/packing/scene.toml");
    let mut scene = MeasuredScene::load(&file).unwrap();
    scene.compare[0].margin = Some(0.006);
    (scene.measure.seeds, scene.measure.rest_energy) = (Some(seeds), None);
    scene
}

/// Runs of a code with these packing fractions.
pub fn code(name: &str, values: &[f64]) -> CodeRuns {
    let run = |(index, &value): (usize, &f64)| MeasuredRun {
        code: name.into(),
        version: "1".into(),
        contact_law: String::new(),
        seed: index as u64 + 1,
        time_step: 1e-3,
        rayleigh_fraction: None,
        wall_seconds: 3.0,
        core_seconds: None,
        simulated_seconds: 1.5,
        processor: String::new(),
        date: String::new(),
        scene_hash: String::new(),
        measurements: vec![Measurement {
            observable: "packing_fraction".into(),
            unit: String::new(),
            value,
            standard_error: None,
            frames: 1,
        }],
    };
    let runs = values.iter().enumerate().map(run).collect();
    CodeRuns {
        code: name.into(),
        source: Source::Live,
        timing: Timing::SideBySide,
        provenance: String::new(),
        runs,
        failed: Vec::new(),
        discarded: None,
        forces: None,
        series: Vec::new(),
        final_state: None,
    }
}

#[test]
fn three_codes_give_three_pairs_and_the_last_code_alone() {
    let codes = [
        code("Makadam", &[0.585, 0.586, 0.587, 0.586]),
        code("YADE", &[0.584, 0.586, 0.586, 0.585]),
        code("LIGGGHTS", &[0.605, 0.606, 0.607, 0.606]),
    ];
    let comparison = comparison(&packing_fraction(4), &codes, Vec::new());
    let pairs: Vec<_> =
        comparison.rows.iter().map(|row| (row.code.as_str(), row.reference_code.as_deref(), row.outcome)).collect();
    assert_eq!(
        pairs,
        [
            ("Makadam", Some("YADE"), Some(Outcome::Undecided)),
            ("Makadam", Some("LIGGGHTS"), Some(Outcome::Disagree)),
            ("YADE", Some("LIGGGHTS"), Some(Outcome::Disagree)),
            ("LIGGGHTS", None, None),
        ]
    );
    assert_eq!(comparison.codes[0].wall_seconds_per_simulated_second, 2.0);
    assert!((comparison.rows[1].difference.unwrap() + 0.02).abs() < 1e-12);
}

#[test]
fn where_references_are_at_odds_agreement_with_one_proves_nothing() {
    let makadam = code("Makadam", &[0.585, 0.586, 0.587, 0.586]);
    let between = |yade: f64, liggghts: f64| {
        let near = |middle: f64| [middle - 0.0002, middle, middle + 0.0002, middle];
        let codes = [makadam.clone(), code("YADE", &near(yade)), code("LIGGGHTS", &near(liggghts))];
        let rows = comparison(&packing_fraction(4), &codes, Vec::new()).rows;
        [rows[0].outcome, rows[1].outcome].map(Option::unwrap)
    };
    // The margin is 0.006.
    assert_eq!(between(0.5840, 0.5880), [Outcome::Agree; 2]);
    assert_eq!(between(0.5825, 0.5895), [Outcome::Undecided; 2]);
    assert_eq!(between(0.5860, 0.6060), [Outcome::Undecided, Outcome::Disagree]);
}

#[test]
fn one_seed_is_undecided() {
    let codes = [code("Makadam", &[0.585]), code("YADE", &[0.585])];
    let comparison = comparison(&packing(2), &codes, Vec::new());
    assert_eq!(comparison.rows[0].outcome, Some(Outcome::Undecided));
}

/// The packing, compared by its packing fraction alone.
pub fn packing_fraction(seeds: u64) -> MeasuredScene {
    let mut scene = packing(seeds);
    scene.compare.truncate(1);
    scene
}

/// Outcomes where the seeds of the first code are those that are registered.
fn outcomes(codes: &[CodeRuns]) -> Vec<(String, Option<String>, Option<Outcome>, String)> {
    let seeds = codes[0].runs.len() + codes[0].failed.len();
    let rows = comparison(&packing_fraction(seeds as u64), codes, Vec::new()).rows.into_iter();
    rows.map(|row| (row.code, row.reference_code, row.outcome, row.missing.unwrap_or_default())).collect()
}

#[test]
fn an_expectation_that_nobody_measured_is_a_row_that_says_so() {
    let codes = [code("Makadam", &[0.585, 0.586]), code("YADE", &[0.585, 0.586])];
    let comparison = comparison(&packing(2), &codes, Vec::new());
    let of = |name: &str| comparison.rows.iter().find(|row| row.observable == name && row.code == "Makadam").unwrap();
    for name in ["coordination_number", "share_below_mean", "gini", "wall_force_over_weight"] {
        let row = of(name);
        assert_eq!((row.outcome, row.mean, row.seeds), (Some(Outcome::NotMeasured), None, 0), "{name}");
        assert_eq!(row.missing.as_deref(), Some("Makadam has no value; YADE has no value"));
    }
    assert_eq!(of("packing_fraction").missing, None);
}

#[test]
fn a_seed_without_a_value_is_no_smaller_ensemble() {
    let mut short = code("Makadam", &[0.585, 0.586, 0.585]);
    short.runs[1].measurements.clear();
    let whole = code("YADE", &[0.585, 0.586, 0.585]);
    let said = "Makadam has a value in 2 of 3 seeds".to_string();
    let not = Some(Outcome::NotMeasured);
    let rows = outcomes(&[short.clone(), whole.clone()]);
    assert_eq!(rows[0], ("Makadam".into(), Some("YADE".into()), not, said.clone()));
    assert_eq!(rows[1], ("YADE".into(), None, None, String::new()));
    // A reference code as well as the judged code, and the judged code by itself.
    short.code = "LIGGGHTS".into();
    let rows = outcomes(&[code("Makadam", &[0.585, 0.586]), whole, short.clone()]);
    let words: Vec<&str> = rows.iter().map(|row| row.3.as_str()).collect();
    let said = "LIGGGHTS has a value in 2 of 3 seeds";
    assert_eq!(words, ["", said, said, said]);
    assert_eq!(rows[0].2, Some(Outcome::Agree), "what is whole is judged");
    assert_eq!(outcomes(&[short])[0].2, not);
}

#[test]
fn a_seed_that_failed_is_a_missing_value() {
    let short = CodeRuns { failed: vec![3], ..code("Makadam", &[0.585, 0.586]) };
    let rows = outcomes(&[short, code("YADE", &[0.585, 0.586, 0.585])]);
    assert_eq!((rows[0].2, rows[0].3.as_str()), (Some(Outcome::NotMeasured), "Makadam has a value in 2 of 3 seeds"));
    let none = CodeRuns { failed: vec![1, 2], ..code("Makadam", &[]) };
    assert_eq!(outcomes(&[none, code("YADE", &[0.585, 0.586])])[0].3, "Makadam has no value");
}

#[test]
fn runs_that_do_not_count_are_held_against_nothing() {
    let other = CodeRuns { discarded: Some("of another scene".into()), ..code("YADE", &[0.584, 0.586, 0.586]) };
    let rows = outcomes(&[code("Makadam", &[0.585, 0.586]), other.clone()]);
    assert_eq!((rows[0].2, rows[0].3.as_str()), (Some(Outcome::NotMeasured), "of another scene"));
    let checks = live_checks(&packing(2), &code("YADE", &[0.585]).runs[0], &other, 0.99);
    assert!(checks.iter().all(|check| check.inside().is_none()));
}

#[test]
fn a_code_without_runs_is_said() {
    let codes = [code("Makadam", &[0.585, 0.586]), code("YADE", &[])];
    let rows = outcomes(&codes);
    assert_eq!(rows[0].2, Some(Outcome::NotMeasured));
    assert_eq!(rows[0].3, "YADE has no runs");
    assert_eq!(comparison(&packing(2), &codes, Vec::new()).codes.len(), 1);
}

#[test]
fn a_live_run_is_held_against_the_recorded_spread() {
    let recorded = code("YADE", &[0.584, 0.586, 0.586, 0.585]);
    // Inside the interval of 99%, and outside that of 90%.
    let inside = live_checks(&packing(2), &code("YADE", &[0.59]).runs[0], &recorded, 0.99);
    assert_eq!(inside[0].inside(), Some(true));
    assert_eq!(inside.len(), 5, "one a margin");
    assert!(inside[1..].iter().all(|check| check.inside().is_none()), "none of these was measured");
    let outside = live_checks(&packing(2), &code("YADE", &[0.62]).runs[0], &recorded, 0.99);
    assert_eq!(outside[0].inside(), Some(false));
}

fn first_outcome(scene: &MeasuredScene, codes: &[CodeRuns]) -> Outcome {
    comparison(scene, codes, Vec::new()).rows[0].outcome.unwrap()
}

#[test]
fn agreement_counts_for_registered_seeds_alone() {
    let values = [0.585, 0.586, 0.587, 0.586];
    let codes = [code("Makadam", &values), code("YADE", &values)];
    assert_eq!(first_outcome(&packing_fraction(4), &codes), Outcome::Agree);
    let said = |scene: &MeasuredScene, codes: &[CodeRuns]| {
        assert_eq!(first_outcome(scene, codes), Outcome::Exploratory);
        comparison(scene, codes, Vec::new()).unregistered().unwrap()
    };
    assert_eq!(said(&packing_fraction(5), &codes), "packing registers 5 seeds (measure.seeds), and 4 seeds were run");
    let mut scene = packing_fraction(4);
    scene.measure.seeds = None;
    let words = said(&scene, &codes);
    assert!(words.starts_with("packing registers no seeds, and 4 seeds were run; give measure.seeds"), "{words}");
    // As many, chosen from more.
    let mut chosen = codes.clone();
    chosen[0].runs[3].seed = 7;
    let words = said(&packing_fraction(4), &chosen);
    assert!(words.contains("registers seeds 1 to 4"), "{words}");
    // Disagreement needs no registration.
    let other = [code("Makadam", &values), code("YADE", &values.map(|value| value + 0.02))];
    assert_eq!(first_outcome(&packing_fraction(5), &other), Outcome::Disagree);
}

#[test]
fn further_seeds_are_named_for_exploration_alone() {
    let codes = [code("Makadam", &[0.580, 0.590, 0.586]), code("YADE", &[0.581, 0.589, 0.586])];
    let needed = |registered| {
        let row = comparison(&packing_fraction(registered), &codes, Vec::new()).rows.swap_remove(0);
        assert_eq!(row.outcome, Some(Outcome::Undecided));
        row.seeds_needed
    };
    assert_eq!(needed(3), None);
    assert!(needed(8).is_some_and(|seeds| seeds > 3));
}

/// Codes whose means differ by the margin: who looks again and again finds them equal in 8% of cases where the test errs in 2.5%.
#[test]
fn looking_again_does_not_raise_the_error() {
    const LOOKS: [usize; 6] = [8, 12, 16, 24, 32, 48];
    const TRIALS: u32 = 2000;
    let mut random = ChaCha8Rng::seed_from_u64(53);
    let normal = Normal::standard();
    let mut draw = || normal.inverse_cdf((random.next_u32() as f64 + 0.5) / 4_294_967_296.0);
    // 97.5% on each side, as for three codes.
    let third = code("LIGGGHTS", &[0.586, 0.587, 0.586, 0.587]);
    let (mut naive, mut registered) = (0, 0);
    for _ in 0..TRIALS {
        let [own, other]: [Vec<f64>; 2] =
            [0.586 + 0.006, 0.586].map(|mean| (0..48).map(|_| mean + 0.003 * draw()).collect());
        let outcome = |look: usize| {
            let codes = [code("Makadam", &own[..look]), code("YADE", &other[..look]), third.clone()];
            first_outcome(&packing_fraction(48), &codes)
        };
        let found: Vec<Outcome> = LOOKS.into_iter().map(outcome).collect();
        naive += u32::from(found.iter().any(|outcome| matches!(outcome, Outcome::Agree | Outcome::Exploratory)));
        registered += u32::from(found.contains(&Outcome::Agree));
    }
    let share = |count: u32| f64::from(count) / f64::from(TRIALS);
    assert!(share(naive) > 0.06, "{}", share(naive));
    // Three standard errors of the share above 2.5%.
    assert!(share(registered) < 0.036, "{}", share(registered));
}

/// Adds a kinetic energy to each run.
fn with_energies(code: CodeRuns, energies: &[f64]) -> CodeRuns {
    let mut code = code;
    for (run, energy) in code.runs.iter_mut().zip(energies) {
        let observable = "kinetic_energy".into();
        run.measurements.push(Measurement { observable, value: *energy, ..run.measurements[0].clone() });
    }
    code
}

#[test]
fn runs_that_move_are_left_out() {
    let mut scene = packing_fraction(6);
    // Of 2,000 grains.
    scene.measure.rest_energy = Some(5e-9);
    let own = with_energies(code("Makadam", &[0.585, 0.586, 0.587, 0.586, 0.585, 0.586]), &[0.0; 6]);
    let values = [0.700, 0.586, 0.587, 0.586, 0.585, 0.586];
    let energies = |moving: usize| [2e-5, if moving > 1 { 2e-5 } else { 1e-6 }, 0.0, 0.0, 0.0, 0.0];
    let compared = |moving| {
        comparison(&scene, &[own.clone(), with_energies(code("YADE", &values), &energies(moving))], Vec::new())
    };
    let one = compared(1);
    assert_eq!(one.rows[0].outcome, Some(Outcome::Agree));
    assert_eq!(one.rows[1].seeds, 5);
    let words = "YADE: 1 of 6 runs are not at rest at their end and are left out (measure.rest_energy): seeds 1";
    assert_eq!(one.notes, [words]);
    let two = compared(2);
    assert_eq!(two.rows[0].outcome, Some(Outcome::NotMeasured));
    let missing = two.rows[0].missing.as_deref();
    assert_eq!(missing, Some("2 of 6 runs of YADE are not known to be at rest (measure.rest_energy)"));
    // A code that does not tell its energies.
    let untold = comparison(&scene, &[own.clone(), code("YADE", &values)], Vec::new());
    assert_eq!(untold.rows[0].outcome, Some(Outcome::NotMeasured));
}
