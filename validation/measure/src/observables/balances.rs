//! Balances of a frame, valid for every code.

use super::catalogue::{ALL_CONTACTS, Group, MOTION, WALL_CONTACTS, define};
use super::measurement::Readings;
use super::view::View;
use makadam::snapshot::{Particle, Partner};
use makadam_frames::plan::Observable;
use nalgebra::Vector3;

pub(super) const GROUP: Group = Group {
    observable: Observable::Balances,
    name: "balances",
    read,
    definitions: &[
        define(
            ["wall_force_over_weight", "F_w/W", ""],
            "force of the grains on all walls along gravity over the weight of the grains, both as gravity is at the \
             time of the frame; 1 in balance",
        )
        .needs(WALL_CONTACTS),
        define(
            ["largest_overlap", "δ_max", "radius"],
            "largest overlap of two grains, across periodic ends too, over the smaller radius",
        )
        .largest(),
        define(["mean_overlap", "⟨δ⟩", "radius"], "mean overlap of pairs that overlap, over the smaller radius"),
        define(
            ["coulomb_excess", "ε_C", ""],
            "largest f_t / (μ f_n) − 1 over contacts with friction, with the static friction μ; at most 0 where \
             Coulomb's law holds",
        )
        .largest()
        .needs(ALL_CONTACTS),
        define(["kinetic_energy", "E_k", "J"], "Σ ½ m v² + ½ (2/5 m r²) ω²").needs(MOTION),
    ],
};

/// Weakest normal force for a ratio, over the mean normal force: a code's output is rounded.
const TOO_WEAK: f64 = 1e-6;

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    let setting = view.setting;
    let grains = &view.frame.particles;
    if let Some(up) = setting.up.filter(|_| !view.frame.contacts.is_empty()) {
        let walls = view.frame.contacts.iter().filter(|contact| matches!(contact.second, Partner::Wall(_)));
        let push: f64 = walls.map(|contact| -contact.force_on_partner().dot(&up)).sum();
        let weight: f64 = grains.iter().map(|grain| setting.mass(view.frame, grain) * setting.gravity).sum();
        readings.add("wall_force_over_weight", push / weight);
    }

    // Without walls: in a code with faceted round walls, the facets cause overlaps of their own.
    let overlaps: Vec<f64> = (view.pairs().iter())
        .filter(|pair| pair.gap < 0.0)
        .map(|pair| -pair.gap / grains[pair.first].radius.min(grains[pair.second].radius))
        .collect();
    readings.add("largest_overlap", overlaps.iter().copied().fold(0.0, f64::max));
    readings
        .add("mean_overlap", overlaps.iter().fold(0.0, |sum, overlap| sum + overlap) / overlaps.len().max(1) as f64);

    let pushing = || view.frame.contacts.iter().filter(|contact| contact.normal_force > 0.0);
    let mean_force = pushing().map(|contact| contact.normal_force).sum::<f64>() / pushing().count().max(1) as f64;
    let excess = pushing()
        .filter(|contact| contact.normal_force > TOO_WEAK * mean_force)
        .filter_map(|contact| Some((setting.coulomb_bounds(view.frame, contact)?[0], contact)))
        .filter(|(bound, _)| *bound > 0.0)
        .map(|(bound, contact)| Vector3::from(contact.tangential_force).norm() / bound - 1.0)
        .fold(f64::NEG_INFINITY, f64::max);
    readings.add("coulomb_excess", excess);

    readings.add("kinetic_energy", grains.iter().map(|grain| kinetic_energy(view, grain)).sum());
    Ok(())
}

/// Returns the kinetic energy of a solid sphere, J.
fn kinetic_energy(view: &View<'_>, grain: &Particle) -> f64 {
    let spin = 0.4 * grain.radius.powi(2) * Vector3::from(grain.spin).norm_squared();
    0.5 * view.setting.mass(view.frame, grain) * (Vector3::from(grain.velocity).norm_squared() + spin)
}
