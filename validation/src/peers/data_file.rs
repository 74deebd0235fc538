//! The file of initial grains that LIGGGHTS and LAMMPS read, and the bins that both sort grains into.

use super::Purpose;
use super::mesh::reach;
use super::palette::Palette;
use crate::plan::Scene;
use makadam::scene::{Grain, Reaction};
use std::fmt::Write;

/// Reach of the neighbour list over the smallest radius; a matter of speed alone. The second one is that at which packing, drum and heap are
/// fastest, within 3%.
const SKIN: f64 = 0.25;
const FASTEST_SKIN: f64 = 0.5;

/// Most bins a grain. Both codes clear them all whenever they make their list anew: a single grain in 2 m of air took LIGGGHTS 300 times
/// as long with bins of its own size.
const MOST_BINS: f64 = 100.0;

/// The sides of the simulation box: fixed, and a grain that leaves ends the run; where the scene lets grains escape, the box grows with them.
pub(super) fn boundary(scene: &Scene) -> &'static str {
    match scene.watch.on_escape {
        Reaction::Stop => "f f f",
        Reaction::Warn | Reaction::Ignore => "m m m",
    }
}

/// Grains as atoms of `kinds` types. The simulation box holds whatever walls reach into.
pub(super) fn data(scene: &Scene, grains: &[Grain], palette: &Palette<'_>, kinds: usize) -> String {
    let limits = reach(&scene.domain);
    let mut text = format!("Initial grains\n\n{} atoms\n{kinds} atom types\n", grains.len());
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let (low, high) = (limits.min[axis], limits.max[axis]);
        let margin = 0.05 * (high - low);
        let _ = writeln!(text, "{:e} {:e} {name}lo {name}hi", low - margin, high + margin);
    }
    text += "\nAtoms\n\n";
    for (index, grain) in grains.iter().enumerate() {
        let [x, y, z] = grain.position;
        let kind = palette.index(&grain.material, false) + 1;
        let (diameter, density) = (2.0 * grain.radius, scene.material[&grain.material].density);
        let _ = writeln!(text, "{} {kind} {diameter:e} {density:e} {x:e} {y:e} {z:e}", index + 1);
    }
    text += "\nVelocities\n\n";
    for (index, grain) in grains.iter().enumerate() {
        let ([u, v, w], [p, q, r]) = (grain.velocity, grain.spin);
        let _ = writeln!(text, "{} {u:e} {v:e} {w:e} {p:e} {q:e} {r:e}", index + 1);
    }
    text
}

/// The words of both decks that set up the neighbour list, a line each.
pub(super) fn neighbours(scene: &Scene, grains: &[Grain], purpose: Purpose) -> String {
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let skin = smallest
        * match purpose {
            Purpose::Measuring => SKIN,
            Purpose::Timing => FASTEST_SKIN,
        };
    let bins = wide_bins(scene, grains, skin).map_or(String::new(), |size| format!(" binsize {size:e}"));
    format!("neighbor {skin:e} bin\nneigh_modify delay 0 every 1 check yes{bins}\n")
}

/// Size of bins where those that the codes would take by themselves, half the reach of their list, were too many, m.
fn wide_bins(scene: &Scene, grains: &[Grain], skin: f64) -> Option<f64> {
    let limits = reach(&scene.domain);
    let volume: f64 = (0..3).map(|axis| limits.max[axis] - limits.min[axis]).product();
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    let usual = largest + 0.5 * skin;
    let sparing = (volume / (MOST_BINS * grains.len() as f64)).cbrt();
    (sparing > usual).then_some(sparing)
}

#[cfg(test)]
#[path = "../../tests/unit/peers_data_file.rs"]
mod tests;
