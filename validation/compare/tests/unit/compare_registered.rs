//! Unit tests of `src/compare/registered.rs`.

use super::*;
use crate::compare::rows::tests::{code, packing_fraction};
use crate::compare::{CodeRuns, comparison};
use makadam_measure::observables::Measurement;
use makadam_measure::statistics::Outcome;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use statrs::distribution::{ContinuousCDF, Normal};

fn first_outcome(scene: &Scene, codes: &[CodeRuns]) -> Outcome {
    comparison(scene, codes, Vec::new()).rows[0].outcome.unwrap()
}

#[test]
fn agreement_counts_for_registered_seeds_alone() {
    let values = [0.585, 0.586, 0.587, 0.586];
    let codes = [code("Makadam", &values), code("YADE", &values)];
    assert_eq!(first_outcome(&packing_fraction(4), &codes), Outcome::Agree);
    let said = |scene: &Scene, codes: &[CodeRuns]| {
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
