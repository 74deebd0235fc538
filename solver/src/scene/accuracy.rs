//! Accuracy requests instead of a time step and a number of sweeps, and the default step.
//!
//! The error of a long step h comes from contacts that the step does not resolve. It grows with h over the time scale t of a contact; in
//! beds of stiff grains, whose contacts no step resolves, with h over the time in which a grain falls by its radius:
//!
//! ```text
//! deviation of a packing fraction     <=  0.0035 h/t        and    <=  0.14 (1 + mu) h sqrt(g/r)
//! deviation of friction mobilisation  <=  0.0165 h/t
//! deviation of an angle               <=  0.75 h/t degrees
//! t = 1/sqrt(k S)                     of the smallest grains, of radius r; S = 1/m_a + 1/m_b
//! k = 5/4 k_H sqrt(d)                 of Hertz's law at the overlap d = (f/k_H)^(2/3) under the load f of half the bed
//! mu                                  largest friction of a contact, at most 1
//! ```
//!
//! The slopes are the largest measured ones, those of packing fractions and angles with two standard errors, because a bound is requested
//! (`validation/docs/accuracy.md`). The number of sweeps is not fixed: a solve continues until its residual is small.

use super::error::rounded_down;
use super::populate::placed;
use super::preflight::{fall_speed, longest_step, longest_step_of_walls};
use super::types::earth_gravity;
use super::{Grain, NormalLaw, Reaction, Scene, Stop, sphere_volume};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Tolerated deviations from the converged solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Accuracy {
    /// Tolerance of an angle of repose, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Tolerance of a packing fraction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub packing_fraction: Option<f64>,
    /// Tolerance of the friction mobilisation, the mean of the tangential force over Coulomb's bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_mobilisation: Option<f64>,
    /// Tolerance of an overlap, over the mean radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap: Option<f64>,
    /// Tolerance of an angle and a packing fraction, relative to 30 degrees and 0.6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative: Option<f64>,
}

/// Deviation of a packing fraction over h/t.
const PACKING_FRACTION_SLOPE: f64 = 0.0035;
/// Deviation of a packing fraction over `(1 + mu) h sqrt(g/r)`.
const FALL_SLOPE: f64 = 0.14;
/// Largest `g h^2 / r` of the measurements; the law is not extrapolated.
const LARGEST_FALL: f64 = 8e-3;
/// Deviation of the friction mobilisation over h/t.
const MOBILISATION_SLOPE: f64 = 0.0165;
/// Deviation of a drum's angle of repose over h/t, degrees.
const ANGLE_SLOPE: f64 = 0.75;
/// Largest h/t of the measurements.
const LARGEST_PERIODS: f64 = 8.0;
/// Largest residual of a solve, in units of g h, without an effect on angles of repose.
const LARGEST_RESIDUAL: f64 = 0.1;
/// Residual, in units of g h, over the tolerated deviations of a packing fraction and of the friction mobilisation.
const RESIDUALS: [f64; 2] = [10.0, 2.0];
/// Largest number of sweeps per solve.
const MOST_SWEEPS: u32 = 400;
/// Solid fraction of a bed, for the estimate of its depth.
const BED_FRACTION: f64 = 0.6;

/// `g h^2 / r` of a default step: 0.50 ms for a radius of 5 mm under the gravity of the Earth.
const DEFAULT_FALL: f64 = 5e-4;
/// Path of the fastest grain at the start in a default step, over the radius: that of `reference-scenes/cooling-gas`.
const DEFAULT_PATH: f64 = 0.1;
/// Radius of grains that come later to a scene without any, m.
const DEFAULT_RADIUS: f64 = 5e-3;

impl Scene {
    /// Returns the step (s) of a scene without `solver.step`, rounded down to two digits, from 1e-9 to 0.1 s:
    /// `min(sqrt(5e-4 r/g), 0.1 r/v)` with
    ///
    /// - r: smallest mean radius of a population or a source, or radius of a listed grain; 5 mm in a scene without grains
    /// - g: largest gravity, also of the stages, or that of the Earth in a scene without gravity
    /// - v: largest speed of a listed grain or a source, or `agitation` of a population
    ///
    /// Similar scenes of other sizes have the same motion with this step. Speeds of walls and falls do not enter: the preflight checks
    /// report those that the step does not resolve.
    pub fn default_step(&self) -> f64 {
        let speed = |velocity| Vector3::from(velocity).norm();
        let listed = self.listed().map(|grain| (grain.radius, speed(grain.velocity)));
        let groups = self.population.iter().filter(|group| group.count > 0);
        let placed = groups.map(|group| (group.radius.mean(), group.agitation));
        let come = self.insert.iter().map(|source| (source.radius.mean(), speed(source.velocity)));
        let (radius, fastest) = listed
            .chain(placed)
            .chain(come)
            .fold((f64::INFINITY, 0.0), |(radius, fastest), (own, fast)| (own.min(radius), fast.max(fastest)));
        let radius = if radius > 0.0 && radius.is_finite() { radius } else { DEFAULT_RADIUS };
        let of_stages = self.stage.iter().filter_map(|stage| stage.gravity.map(speed));
        let largest = of_stages.fold(self.largest_gravity(), f64::max);
        let gravity = if largest > 0.0 { largest } else { speed(earth_gravity()) };
        let step = (DEFAULT_FALL * radius / gravity).sqrt().min(DEFAULT_PATH * radius / fastest).clamp(1e-9, 0.1);
        // Rounding of a quotient must not cost a digit.
        rounded_down(step * (1.0 + 1e-9), 2)
    }
}

/// Smallest number of grains of a bed: solves of smaller beds converge within a step.
const SMALLEST_BED: usize = 64;
/// Overlap of grains that fall on a bed over their displacement per step, for grains of one size.
const PENETRATION_SLOPE: f64 = 0.75;
/// Overlap over the displacement per step and the ratio of radii, for grains of several sizes.
const PENETRATION_PER_RATIO: f64 = 0.1;
/// Fraction of the tolerated overlap for the step; the remainder is for the elasticity of the grains.
const PENETRATION_FRACTION: f64 = 2.0 / 3.0;

/// Bed of equal grains on the bottom of the domain, with the number of grains of the scene.
struct Bed {
    /// Mean radius, m.
    radius: f64,
    /// Radius of the smallest grains, m.
    smallest: f64,
    /// Mass, kg.
    mass: f64,
    /// Depth, m.
    depth: f64,
    /// Gravity, m/s2.
    gravity: f64,
}

impl Accuracy {
    /// Returns true if no tolerance is requested.
    pub fn is_empty(&self) -> bool {
        *self == Accuracy::default()
    }

    /// Returns the step (s) and the stop of the solves that keep a scene within the accuracy by the law above.
    pub(super) fn settings(&self, scene: &Scene) -> (f64, Stop) {
        let bed = Bed::of(scene);
        let target = |own: Option<f64>, relative_to: f64| {
            own.unwrap_or(f64::INFINITY).min(self.relative.map_or(f64::INFINITY, |relative| relative * relative_to))
        };
        let (angle, packing_fraction) = (target(self.angle, 30.0), target(self.packing_fraction, 0.6));
        let [mobilisation, overlap] =
            [self.friction_mobilisation, self.overlap].map(|own| own.unwrap_or(f64::INFINITY));
        let friction = scene.possible_contacts().map(|contact| contact.friction).fold(0.0, f64::max).min(1.0);
        let (time, fall) = (bed.contact_time(scene), (bed.smallest / bed.gravity.max(1e-3)).sqrt());
        let by_contact = (mobilisation / MOBILISATION_SLOPE).min(angle / ANGLE_SLOPE).min(LARGEST_PERIODS) * time;
        // The smaller of two bounds holds.
        let by_fraction = (time / PACKING_FRACTION_SLOPE).max(fall / FALL_SLOPE / (1.0 + friction)) * packing_fraction;
        let step = by_contact.min(by_fraction).min(LARGEST_FALL.sqrt() * fall);
        // For every tolerance, walls move as prescribed, impacts stay below the overlap limit of the watchdog, and the run has at least one step.
        let step = step.min(longest_step(scene)).min(bed.longest_step(scene));
        let step = if scene.duration > 0.0 { step.min(scene.duration) } else { step };
        // A grain that moves at the residual velocity sinks by h times that velocity; the error accumulates over the layers of the bed.
        let layers = (bed.depth / (2.0 * bed.radius)).max(1.0);
        let sinking = bed.gravity.max(1e-300) * step * step * layers / bed.radius;
        let residual = LARGEST_RESIDUAL.min(RESIDUALS[0] * packing_fraction).min(RESIDUALS[1] * mobilisation);
        let tolerance = residual.min(overlap / sinking).max(1e-9);
        (step, Stop::Residual { tolerance, max_sweeps: MOST_SWEEPS })
    }
}

impl Bed {
    fn of(scene: &Scene) -> Bed {
        let placed = scene.population.iter().map(|population| {
            (population.count as f64, population.radius.mean(), scene.material[&population.material].density)
        });
        let listed = scene.listed().map(|grain| (1.0, grain.radius, scene.material[&grain.material].density));
        let come = scene
            .insert
            .iter()
            .map(|source| (scene.expected(source), source.radius.mean(), scene.material[&source.material].density));
        let [mut count, mut radius, mut volume, mut mass] = [0.0; 4];
        for (number, own, density) in placed.chain(listed).chain(come) {
            count += number;
            radius += number * own;
            volume += number * sphere_volume(own);
            mass += number * sphere_volume(own) * density;
        }
        let count = f64::max(count, 1.0);
        let size: [f64; 3] = std::array::from_fn(|axis| scene.domain.max[axis] - scene.domain.min[axis]);
        let gravity = match scene.gravity_changes.is_empty() {
            true => scene.gravity.iter().map(|g| g * g).sum::<f64>().sqrt(),
            false => scene.largest_gravity(),
        };
        // The base area is the extent of the domain across gravity.
        let down = (0..3).max_by(|&a, &b| scene.gravity[a].abs().total_cmp(&scene.gravity[b].abs())).unwrap_or(2);
        let ground = size.iter().product::<f64>() / size[down];
        let radius = (radius / count).max(1e-9);
        let depth = (volume / BED_FRACTION / ground).max(2.0 * radius);
        let smallest = scene.grain_kinds().map(|(_, (low, _))| low).fold(radius, f64::min);
        Bed { radius, smallest, mass: (mass / count).max(1e-300), depth, gravity }
    }

    /// Returns the longest step (s) in which no wall drives a grain past another grain and impacts stay within [`Watch::overlap`].
    ///
    /// A bed that falls on itself at a speed v penetrates by c v h while the sweeps have not yet stopped the whole bed
    /// (`docs/scene-checks.md`). The speed v is that after a fall through the domain to the top of the bed.
    ///
    /// [`Watch::overlap`]: super::Watch::overlap
    fn longest_step(&self, scene: &Scene) -> f64 {
        // Failed placement is an error of `placed`, reported elsewhere.
        let Ok(grains) = placed(scene, scene.seed) else { return f64::INFINITY };
        let by_walls = longest_step_of_walls(scene, &grains);
        let is_watched = scene.watch.every > 0 && scene.watch.on_overlap != Reaction::Ignore;
        if !is_watched || grains.len() < SMALLEST_BED {
            return by_walls;
        }
        let radii =
            |start: f64, choose: fn(f64, f64) -> f64| grains.iter().map(|grain| grain.radius).fold(start, choose);
        let [smallest, largest] = [radii(f64::INFINITY, f64::min), radii(0.0, f64::max)];
        let speed = |grain: &Grain| fall_speed(scene, grain);
        let square = grains.iter().map(speed).fold(0.0, f64::max).powi(2) - 2.0 * self.gravity * self.depth;
        let path = PENETRATION_FRACTION * scene.watch.overlap * smallest
            / PENETRATION_SLOPE.max(PENETRATION_PER_RATIO * largest / smallest);
        by_walls.min(path / square.max(0.0).sqrt())
    }

    /// Returns the time scale (s) of a contact of the smallest grains, of the stiffest material, in the bed, `1/sqrt(k S)`.
    fn contact_time(&self, scene: &Scene) -> f64 {
        let mass = self.mass * (self.smallest / self.radius).powi(3);
        let inverse_mass = 2.0 / mass;
        let effective_radius = self.smallest / 2.0;
        let hertz = scene.material.values().map(|material| {
            let modulus = material.youngs_modulus / (2.0 * (1.0 - material.poisson_ratio * material.poisson_ratio));
            4.0 / 3.0 * modulus * effective_radius.sqrt()
        });
        let hertz = hertz.fold(0.0, f64::max);
        let stiffness = match scene.solver.normal_law {
            NormalLaw::Linear { stiffness } => stiffness,
            // Rigid grains are resolved with the stiffness of their material.
            NormalLaw::Hertz | NormalLaw::Rigid => {
                let weight = mass * self.gravity.max(1e-3);
                let load = (0.5 * self.depth / (2.0 * self.smallest)).max(1.0) * weight;
                1.25 * hertz * (load / hertz).cbrt()
            }
        };
        1.0 / (stiffness * inverse_mass).sqrt()
    }
}
