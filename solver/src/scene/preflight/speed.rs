//! Checks of stated speeds against the step and `restitution_threshold`: initial velocities and prescribed motions of walls.

use super::Beforehand;
use crate::laws::compliance::{NormalContact, NormalScheme, damping_ratio, effective_radius};
use crate::scene::document::DocumentPath;
use crate::scene::error::{Fault, rounded_down, short};
use crate::scene::populate::origin;
use crate::scene::{Grain, Motion, NormalLaw, Scene, Shape, Wall};
use crate::surface::furthest_corner;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Largest displacement of a wall per step, over the smallest radius: a driven grain does not pass another grain.
const DIAMETER: f64 = 2.0;
/// Smallest impact speed, over g h, with a resolved bounce.
const VISIBLE: f64 = 5.0;

/// Reports motion above a diameter per step, and impacts that are all below the restitution threshold.
pub(super) fn faults(scene: &Scene, grains: &[Grain], beforehand: Option<Beforehand>) -> Vec<Fault> {
    let mut faults = walls(scene, grains);
    faults.extend(passing_grains(scene, grains, beforehand));
    faults.extend(below_threshold(scene, grains));
    faults
}

/// Returns the longest step (s) in which no wall moves by more than the smallest diameter.
pub(in crate::scene) fn longest_step_of_walls(scene: &Scene, grains: &[Grain]) -> f64 {
    let smallest = smallest_radius(grains);
    let steps = driving(scene, grains).map(|(_, speed)| DIAMETER * smallest / speed);
    steps.fold(f64::INFINITY, f64::min)
}

fn walls(scene: &Scene, grains: &[Grain]) -> Vec<Fault> {
    let (smallest, step) = (smallest_radius(grains), scene.solver.step);
    let too_fast = driving(scene, grains).filter(|(_, speed)| speed * step > DIAMETER * smallest);
    let fault = |(index, speed): (usize, f64)| {
        let at = DocumentPath::default().key("wall").index(index).key("motion");
        let problem = format!(
            "wall '{}' moves at up to {} m/s, {} of the smallest radius in a step of {} s: the step does not resolve which grains it \
             drives into others",
            scene.wall[index].name,
            short((speed * 100.0).round() / 100.0),
            short((speed * step / smallest * 10.0).round() / 10.0),
            short(step),
        );
        let longest = rounded_down(DIAMETER * smallest / speed, 1);
        at.fault(problem, &format!("lower solver.step to {longest:e} s, or slow the wall down"))
    };
    too_fast.map(fault).collect()
}

/// Reports the first pair of grains that move by more than the sum of their radii in a step.
fn passing_grains(scene: &Scene, grains: &[Grain], beforehand: Option<Beforehand>) -> Option<Fault> {
    let (step, key) = beforehand.map_or((scene.solver.step, "solver.step"), |prepare| (prepare.step, "prepare.step"));
    let velocities: Vec<Vector3<f64>> = grains.iter().map(velocity).collect();
    let mean = velocities.iter().sum::<Vector3<f64>>() / grains.len().max(1) as f64;
    let smallest = smallest_radius(grains);
    let passes = |first: usize, second: usize| {
        (velocities[first] - velocities[second]).norm() * step > grains[first].radius + grains[second].radius
    };
    // At least one of two such grains moves at half the relative speed against the mean.
    let mut fast = (0..grains.len()).filter(|&grain| (velocities[grain] - mean).norm() * step > smallest);
    let (first, second) = fast.find_map(|one| {
        let other = (0..grains.len()).find(|&other| passes(one, other))?;
        Some((one.min(other), one.max(other)))
    })?;
    let path = (velocities[first] - velocities[second]).norm() * step;
    let touch = grains[first].radius + grains[second].radius;
    let problem = format!(
        "grains {first} and {second} move by {} m against each other in a step of {} s, more than the sum of their radii, {} m: the step \
         does not resolve which grains meet",
        short(path),
        short(step),
        short(touch)
    );
    let remedy = format!("lower {key} to {:e} s, or the velocities", rounded_down(step * touch / path, 1));
    Some(Fault::new(origin(scene, first), problem, remedy))
}

/// Reports a scene with no impact at `restitution_threshold` or faster on bodies at rest, although the step would resolve the bounce.
///
/// The bound is the speed after a fall from the start through the whole domain. The bound is unknown if walls move or gravity changes.
fn below_threshold(scene: &Scene, grains: &[Grain]) -> Option<Fault> {
    let moves = |index: usize| scene.course(index) != Motion::Fixed;
    let unknown = (0..scene.wall.len()).any(moves) || !scene.gravity_changes.is_empty();
    if unknown || scene.material.values().all(|material| material.restitution == 0.0) {
        return None;
    }
    let fastest = grains.iter().map(|grain| fall_speed(scene, grain)).fold(0.0, f64::max);
    let (threshold, gravity) = (scene.slowest_impact(), Vector3::from(scene.gravity).norm());
    let is_visible = fastest > VISIBLE * gravity * scene.solver.step;
    let rounded = |speed: f64, digits: usize| short(format!("{speed:.digits$e}").parse().unwrap_or(speed));
    (fastest > 0.0 && is_visible && fastest < threshold).then(|| {
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

/// Returns an upper bound of the speed (m/s) of a grain after a fall through the domain.
pub(in crate::scene) fn fall_speed(scene: &Scene, grain: &Grain) -> f64 {
    let period = scene.domain.period();
    // Energy per mass that a fall to the lowest corner of the domain adds.
    let energy = (0..3).filter(|&axis| scene.gravity[axis] != 0.0).map(|axis| {
        let corner = if scene.gravity[axis] < 0.0 { scene.domain.min } else { scene.domain.max };
        let energy = scene.gravity[axis] * (corner[axis] - grain.position[axis]);
        if period.is_periodic(axis) { f64::INFINITY } else { energy.max(0.0) }
    });
    let start = velocity(grain).norm();
    let by_time = start + Vector3::from(scene.gravity).norm() * scene.duration;
    (start * start + 2.0 * energy.sum::<f64>()).sqrt().min(by_time)
}

fn velocity(grain: &Grain) -> Vector3<f64> {
    Vector3::from(grain.velocity)
}

fn smallest_radius(grains: &[Grain]) -> f64 {
    grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min)
}

/// Returns the indices of the walls that can drive a grain into others, with their largest speed in the domain (m/s).
///
/// The distance of grains from the axis of a rotating plane is unknown.
fn driving<'s>(scene: &'s Scene, grains: &[Grain]) -> impl Iterator<Item = (usize, f64)> + 's {
    let turns = |index: usize| {
        let course = scene.course(index);
        course.parts().iter().any(|motion| matches!(motion, Motion::Rotating { .. } | Motion::Table { .. }))
    };
    let endless = move |index: usize, wall: &Wall| matches!(wall.shape, Shape::Plane { .. }) && turns(index);
    let walls = scene.wall.iter().enumerate().take(if grains.len() < 2 { 0 } else { usize::MAX });
    let moving = walls.filter(move |(index, wall)| !endless(*index, wall));
    moving.map(|(index, wall)| {
        (index, scene.course(index).parts().iter().map(|motion| fastest(scene, wall, motion)).sum())
    })
}

/// Returns the largest speed (m/s) of the points of a wall in the domain by one of its motions within the simulated time.
fn fastest(scene: &Scene, wall: &Wall, motion: &Motion) -> f64 {
    let began = |start: f64| start < scene.duration;
    match *motion {
        Motion::Translating { velocity, start, .. } if began(start) => Vector3::from(velocity).norm(),
        Motion::Vibrating { amplitude, frequency, start, .. } if began(start) => {
            TAU * frequency * Vector3::from(amplitude).norm()
        }
        Motion::Rotating { point, axis, rate, start, .. } if began(start) => {
            let axis = Vector3::from(axis).normalize();
            let arm = |of: Vector3<f64>| (of - Vector3::from(point)).cross(&axis).norm();
            rate.abs() * wall.shape.furthest(arm).min(furthest_corner(&scene.domain.min, &scene.domain.max, arm))
        }
        Motion::Table { ref content, point, start, .. } if began(start) => {
            let arm = |of: Vector3<f64>| (of - Vector3::from(point)).norm();
            let arm = wall.shape.furthest(arm).min(furthest_corner(&scene.domain.min, &scene.domain.max, arm));
            content.speeds().map(|[along, turn]| along + turn * arm).fold(0.0, f64::max)
        }
        _ => 0.0,
    }
}

impl Scene {
    /// The largest grains have the lowest stiffness relative to their inertia, and the slowest impacts with restitution last longest.
    pub(super) fn resolved_impact(&self) -> Option<Fault> {
        if self.solver.normal_law == NormalLaw::Rigid {
            return None;
        }
        let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
        for (name, (_, radius)) in self.grain_kinds() {
            let known = largest.entry(name).or_default();
            *known = known.max(radius);
        }
        let grains = || largest.iter().map(|(name, radius)| (*name, Some(*radius)));
        let walls = self.wall.iter().map(|wall| (wall.material.as_str(), None));
        let partners: Vec<(&str, Option<f64>)> = grains().chain(walls).collect();
        let pairs = largest.iter().flat_map(|first| partners.iter().map(move |second| (first, second)));
        pairs.into_iter().find_map(|((first, radius), (second, other))| self.resolved(first, *radius, second, *other))
    }

    /// Returns the approach speed (m/s) above which an unresolved impact has restitution, see
    /// [`SolverSettings::slowest_impact`], for the mean of the radii in the scene.
    ///
    /// [`SolverSettings::slowest_impact`]: crate::scene::SolverSettings::slowest_impact
    pub fn slowest_impact(&self) -> f64 {
        self.solver.slowest_impact(self.mean_radius(), self.largest_gravity())
    }

    /// Returns the fault of impacts between a grain of a radius (m) and another grain or a wall.
    fn resolved(&self, first: &str, radius: f64, second: &str, other: Option<f64>) -> Option<Fault> {
        let pair = self.contact_coefficients(first, second, other.is_none());
        if !pair.restitution_speed.is_finite() {
            return None;
        }
        let settings = &self.solver;
        let scheme = NormalScheme {
            law: settings.normal_law,
            step: settings.step,
            damping_steps: settings.damping_steps,
            restitution_threshold: self.slowest_impact(),
            gravity: Vector3::from(self.gravity).norm(),
        };
        let (one, two) = (&self.material[first], &self.material[second]);
        let softness = |poisson: f64, modulus: f64| (1.0 - poisson * poisson) / modulus;
        let both = softness(one.poisson_ratio, one.youngs_modulus) + softness(two.poisson_ratio, two.youngs_modulus);
        let inverse_mass =
            |density: f64, radius: f64| 0.75 / (std::f64::consts::PI * density * radius * radius * radius);
        // A slower contact is at rest.
        let speed = pair.restitution_speed.max(scheme.restitution_threshold);
        let impact = NormalContact {
            overlap: 0.0,
            velocity: -speed,
            effective_modulus: 1.0 / both,
            effective_radius: other.map_or(radius, |other| effective_radius(radius, other)),
            inverse_mass: inverse_mass(one.density, radius)
                + other.map_or(0.0, |other| inverse_mass(two.density, other)),
            damping_ratio: damping_ratio(pair.restitution),
        };
        let resolved = impact.constraint(&scheme, speed).resolves_impact;
        resolved.then(|| {
            let problem = format!(
                "restitution_speed: the step of {:e} s resolves an impact of '{first}' and '{second}' at {speed} m/s, whose \
                 restitution is that of its damping at any speed",
                settings.step
            );
            let remedy = "use normal_law = { kind = 'rigid' }, a longer step or a higher youngs_modulus";
            Fault::new(self.says_restitution_speed(first, second), problem, remedy)
        })
    }

    /// Returns the path in the scene of the restitution speed of a pair.
    fn says_restitution_speed(&self, first: &str, second: &str) -> DocumentPath {
        let names =
            |rule: &[String; 2]| (rule[0] == first && rule[1] == second) || (rule[0] == second && rule[1] == first);
        let rule = self.pair.iter().position(|rule| rule.restitution_speed.is_some() && names(&rule.between));
        let root = DocumentPath::default();
        let of_material = || {
            let own = self.material[second].restitution_speed.is_some();
            root.key("material").name(if own { second } else { first })
        };
        rule.map_or_else(of_material, |index| root.key("pair").index(index)).key("restitution_speed")
    }
}
