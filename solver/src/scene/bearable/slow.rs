//! Impacts so slow that none of them has its restitution.

use super::bed::{Bed, Fall};
use crate::scene::document_path::DocumentPath;
use crate::scene::error::{Fault, short};
use crate::scene::{Grain, Motion, Scene};

/// Speeds of impact, over what gravity gives in a step, from which on a bounce would be seen.
const SEEN: f64 = 5.0;

/// Reports a scene in which no grain meets what is at rest as fast as `restitution_threshold`, though the step would show its bounce.
///
/// Speeds are those of free fall from the start. Where walls move or gravity changes they are not known, and nothing is reported.
pub(super) fn fault(scene: &Scene, grains: &[Grain], bed: &Bed) -> Option<Fault> {
    let (threshold, largest_gravity) = (scene.slowest_impact(), scene.gravity_field().largest());
    let unknown = scene.wall.iter().any(|wall| wall.motion != Motion::Fixed);
    if unknown || !scene.gravity_changes.is_empty() || scene.material.values().all(|one| one.restitution == 0.0) {
        return None;
    }
    let speed = |index: usize| {
        let square: f64 = grains[index].velocity.iter().map(|v| v * v).sum();
        match bed.falls[index] {
            Fall::Down(fall) | Fall::Out(fall) => Some((square + 2.0 * bed.gravity * fall.max(0.0)).sqrt()),
            Fall::Unknown if largest_gravity == 0.0 => Some(square.sqrt()),
            Fall::Unknown => None,
        }
    };
    let fastest = (0..grains.len()).map(speed).try_fold(0.0_f64, |largest, own| Some(largest.max(own?)))?;
    let is_seen = fastest > SEEN * largest_gravity * scene.solver.step;
    let rounded = |speed: f64, digits: usize| short(format!("{speed:.digits$e}").parse().unwrap_or(speed));
    (fastest > 0.0 && is_seen && fastest < threshold).then(|| {
        let problem = format!(
            "no grain meets what is at rest faster than {} m/s, and impacts slower than {} m/s that the step does not resolve are \
             contacts at rest: they do not leave at their restitution",
            rounded(fastest, 2),
            rounded(threshold, 2),
        );
        let remedy = format!("set it below {} m/s", rounded(0.5 * fastest, 0));
        DocumentPath::default().key("solver").key("restitution_threshold").fault(problem, &remedy)
    })
}
