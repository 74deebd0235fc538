//! The best accuracy that fits into a time: first the coarsest, which tells what the scene costs, then a finer one in its place.

use crate::plan::Scene;
use makadam::scene::Accuracy;

/// What is run first: the coarsest setting that the law of [`Accuracy`] was measured for.
pub(super) const COARSEST: Accuracy =
    Accuracy { angle: None, packing_fraction: None, overlap: None, relative: Some(LARGEST) };

const LARGEST: f64 = 0.02;
const SMALLEST: f64 = 1e-4;

/// Share of the time left that a finer run may be expected to take: contacts come to rest later with some steps than with others.
const SHARE: f64 = 0.9;

/// The scene with the finest setting that is expected to fit into `left` seconds, given what a run of `coarse` took; absent where
/// there is no time for one that is finer by a tenth. A step costs the same whatever its length: shorter ones need fewer sweeps.
pub(super) fn finer(coarse: &Scene, took: f64, left: f64) -> Option<Scene> {
    let at = |relative: f64| {
        let mut scene = coarse.clone();
        scene.ask(Accuracy { relative: Some(relative), ..Accuracy::default() });
        scene
    };
    let fits = |scene: &Scene| took * coarse.solver.step / scene.solver.step <= SHARE * left;
    let (mut fine, mut large) = (SMALLEST, LARGEST);
    if !fits(&at(large)) {
        return None;
    }
    if !fits(&at(fine)) {
        for _ in 0..40 {
            let middle = (fine * large).sqrt();
            if fits(&at(middle)) {
                large = middle;
            } else {
                fine = middle;
            }
        }
        fine = large;
    }
    Some(at(fine)).filter(|scene| scene.solver.step < 0.9 * coarse.solver.step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn more_time_buys_shorter_steps_until_nothing_finer_was_measured() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
        let mut coarse = Scene::load(&file).unwrap();
        coarse.ask(COARSEST);
        let step = |left: f64| finer(&coarse, 1.0, left).map(|scene| scene.solver.step);
        assert_eq!(step(1.0), None);
        let (short, long) = (step(1.5).unwrap(), step(3.0).unwrap());
        assert!((short / coarse.solver.step - 1.0 / 1.35).abs() < 1e-3, "{short}");
        assert!((long / short - 0.5).abs() < 1e-3, "{long}");
        assert_eq!(step(1e6), step(1e7));
        assert!(step(1e6).unwrap() < long);
    }
}
