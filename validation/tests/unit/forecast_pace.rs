//! Unit tests of `src/forecast/pace.rs`.

use super::*;

#[test]
fn work_is_that_of_runs_within_a_factor_of_two() {
    // Contact sweeps of whole runs, as `makadam run --json` counts them.
    let counted = [
        ("cohesive-heap", 223_650_000.0),
        ("cooling-gas", 480_200.0),
        ("drum", 519_680_000.0),
        ("drum-caps", 509_440_000.0),
        ("frictionless-packing", 355_200_000.0),
        ("heap", 229_950_000.0),
        ("heap-rolling", 197_400_000.0),
        ("landslide", 43_584_000.0),
        ("oedometer", 95_200_000.0),
        ("packing", 133_200_000.0),
        ("packing-100", 2_424_000.0),
        ("packing-stiff", 642_000_000.0),
    ];
    let close = counted.iter().filter(|(name, counted)| {
        let file = makadam_compare::scenes::find(name, &[]).unwrap();
        let scene = makadam_compare::scenes::load(&file).unwrap();
        let ratio = Work::of(&scene, scene.seed).contact_sweeps / counted;
        (0.5..2.0).contains(&ratio)
    });
    assert!(close.count() >= counted.len() - 1);
}

#[test]
fn time_grows_with_every_part_of_the_work() {
    let pace = Pace::here();
    assert!(pace.step > 0.0 && pace.sweep > 0.0, "{pace:?}");
    let work = Work { steps: 1e6, contact_sweeps: 1e7, frames: 1e4, grains: 900, given: 0.0 };
    let seconds = pace.seconds(&work);
    for more in [
        Work { steps: 2e6, ..work },
        Work { contact_sweeps: 2e7, ..work },
        Work { frames: 2e4, ..work },
        Work { given: 1.0, ..work },
    ] {
        assert!(pace.seconds(&more) > seconds);
    }
}
