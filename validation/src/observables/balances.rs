//! Balances: what must add up whatever the code.

use super::measurement::{Quantity, Readings};
use super::view::View;
use makadam::snapshot::{Particle, Partner};
use nalgebra::Vector3;

const WALL_FORCE: Quantity = Quantity::mean("wall_force_over_weight", "");
const LARGEST_OVERLAP: Quantity = Quantity::largest("largest_overlap", "radius");
const MEAN_OVERLAP: Quantity = Quantity::mean("mean_overlap", "radius");
const COULOMB_EXCESS: Quantity = Quantity::largest("coulomb_excess", "");
const KINETIC_ENERGY: Quantity = Quantity::mean("kinetic_energy", "J");

/// Contacts below this part of the mean normal force are too weak for a ratio: a code's output is rounded.
const TOO_WEAK: f64 = 1e-6;

/// Adds the balances of a frame.
///
/// - `wall_force_over_weight`: the grains' push on all walls along gravity, tangential forces included, over their
///   weight; 1 in balance.
/// - `largest_overlap`, `mean_overlap`: of grain pairs that overlap, across periodic ends too, over the smaller radius. Walls are left out, as
///   a code that makes a round wall of facets has overlaps of its own there.
/// - `coulomb_excess`: largest ft/(mu fn) - 1 over all contacts with friction, by the static coefficient.
/// - `kinetic_energy`: translation and spin of solid spheres.
pub fn read(view: &View<'_>, readings: &mut Readings) {
    let setting = view.setting;
    let grains = &view.frame.particles;
    if let Some(up) = setting.up.filter(|_| !view.frame.contacts.is_empty()) {
        let walls = view.frame.contacts.iter().filter(|contact| matches!(contact.second, Partner::Wall(_)));
        let push: f64 = walls.map(|contact| -contact.force_on_partner().dot(&up)).sum();
        let weight: f64 = grains.iter().map(|grain| setting.mass(view.frame, grain) * setting.gravity).sum();
        readings.add(WALL_FORCE, push / weight);
    }

    let overlaps: Vec<f64> = (view.pairs().iter())
        .filter(|pair| pair.gap < 0.0)
        .map(|pair| -pair.gap / grains[pair.first].radius.min(grains[pair.second].radius))
        .collect();
    readings.add(LARGEST_OVERLAP, overlaps.iter().copied().fold(0.0, f64::max));
    readings.add(MEAN_OVERLAP, overlaps.iter().fold(0.0, |sum, overlap| sum + overlap) / overlaps.len().max(1) as f64);

    let pushing = || view.frame.contacts.iter().filter(|contact| contact.normal_force > 0.0);
    let mean_force = pushing().map(|contact| contact.normal_force).sum::<f64>() / pushing().count().max(1) as f64;
    let excess = pushing()
        .filter(|contact| contact.normal_force > TOO_WEAK * mean_force)
        .filter_map(|contact| Some((setting.coulomb_bounds(view.frame, contact)?[0], contact)))
        .filter(|(bound, _)| *bound > 0.0)
        .map(|(bound, contact)| Vector3::from(contact.tangential_force).norm() / bound - 1.0)
        .fold(f64::NEG_INFINITY, f64::max);
    readings.add(COULOMB_EXCESS, excess);

    readings.add(KINETIC_ENERGY, grains.iter().map(|grain| kinetic_energy(view, grain)).sum());
}

/// Kinetic energy of a solid sphere, J.
fn kinetic_energy(view: &View<'_>, grain: &Particle) -> f64 {
    let spin = 0.4 * grain.radius.powi(2) * Vector3::from(grain.spin).norm_squared();
    0.5 * view.setting.mass(view.frame, grain) * (Vector3::from(grain.velocity).norm_squared() + spin)
}
