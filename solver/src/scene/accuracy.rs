//! Accuracy requests instead of a time step and a number of sweeps.
//!
//! The error of a long step appears where grains settle: in a step, grains fall and overlap by lengths of the order of `g h^2`. A
//! packing fraction deviates from its converged value in proportion to this length over a radius, for all stiffnesses from 10 MPa
//! to 50 GPa (`makadam tradeoff packing`). The model of a drum's angle is an error in proportion to the elasticity of contacts
//! that a step does not resolve. Both slopes are the largest measured values, not means, because a bound is requested:
//!
//! ```text
//! deviation of a packing fraction  ~  g h^2 / r
//! deviation of an angle            ~  x = h sqrt(k S)            S = 1/m_a + 1/m_b
//! k = 5/4 k_H sqrt(d)              of Hertz's law at the overlap d = (f/k_H)^(2/3) under the load f of half the bed
//! ```
//!
//! The number of sweeps is not fixed: a solve continues until its residual is small, in proportion to the overlap tolerance.

use super::populate::placed;
use super::preflight::{fall_speed, longest_step, longest_step_of_walls};
use super::{Grain, NormalLaw, Reaction, Scene, Stop, sphere_volume};
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
    /// Tolerance of an overlap, over the mean radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap: Option<f64>,
    /// Tolerance of all of these, relative to an angle of 30 degrees, a packing fraction of 0.6 and an overlap of a
    /// hundredth of the radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative: Option<f64>,
}

/// Largest measured deviation of a packing fraction over `g h^2 / r`: 1.35 ± 0.2 at friction 1; the mean over
/// stiffnesses is 0.7 at friction 0.5.
const PACKING_FRACTION_SLOPE: f64 = 1.5;
/// Smallest and largest `g h^2 / r` of those measurements; the law is not extrapolated.
const FALLS_MEASURED: [f64; 2] = [1e-4, 8e-3];
/// Largest measured deviation of a drum's angle of repose over x, degrees: grains with radii that spread by 20%.
const ANGLE_SLOPE: f64 = 0.45;
/// Largest residual of a solve, in units of g h, without an effect on angles of repose.
const LARGEST_RESIDUAL: f64 = 0.1;
/// Residual, in units of g h, over the tolerated deviation of a packing fraction. At friction 1 and a tolerance of 0.005, the
/// error of a packing is 0.003 with this value and 0.004 with twice the value (`scripts/check-accuracy`, sixteen seeds).
const PACKING_FRACTION_RESIDUAL: f64 = 10.0;
/// Smallest and largest x of the measurements of angles.
const MEASURED: [f64; 2] = [0.4, 8.0];
/// Largest number of sweeps per solve.
const MOST_SWEEPS: u32 = 400;
/// Solid fraction of a bed, for the estimate of its depth.
const BED_FRACTION: f64 = 0.6;

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
    /// Radius, m.
    radius: f64,
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
        let relative = self.relative.unwrap_or(f64::INFINITY);
        let angle = self.angle.unwrap_or(f64::INFINITY).min(30.0 * relative);
        let packing_fraction = self.packing_fraction.unwrap_or(f64::INFINITY).min(0.6 * relative);
        let overlap = self.overlap.unwrap_or(f64::INFINITY).min(0.01 * relative);
        let by_angle = (angle / ANGLE_SLOPE).clamp(MEASURED[0], MEASURED[1]) * bed.contact_time(scene);
        let fall = (packing_fraction / PACKING_FRACTION_SLOPE).clamp(FALLS_MEASURED[0], FALLS_MEASURED[1]);
        let by_fraction = (fall * bed.radius / bed.gravity.max(1e-3)).sqrt();
        let step = match (angle.is_finite(), packing_fraction.is_finite()) {
            (true, false) => by_angle,
            (false, true) => by_fraction,
            _ => by_angle.min(by_fraction),
        };
        // For every tolerance, walls move as prescribed, impacts stay below the overlap limit of the watchdog, and the run has at least one step.
        let step = step.min(longest_step(scene)).min(bed.longest_step(scene));
        let step = if scene.duration > 0.0 { step.min(scene.duration) } else { step };
        // A grain that moves at the residual velocity sinks by h times that velocity; the error accumulates over the layers of the bed.
        let layers = (bed.depth / (2.0 * bed.radius)).max(1.0);
        let sinking = bed.gravity.max(1e-300) * step * step * layers / bed.radius;
        let residual = LARGEST_RESIDUAL.min(PACKING_FRACTION_RESIDUAL * packing_fraction);
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
        Bed { radius, mass: (mass / count).max(1e-300), depth, gravity }
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

    /// Returns the time scale (s) of a contact of the stiffest material in the bed, `1/sqrt(k S)`.
    fn contact_time(&self, scene: &Scene) -> f64 {
        let inverse_mass = 2.0 / self.mass;
        let effective_radius = self.radius / 2.0;
        let hertz = scene.material.values().map(|material| {
            let modulus = material.youngs_modulus / (2.0 * (1.0 - material.poisson_ratio * material.poisson_ratio));
            4.0 / 3.0 * modulus * effective_radius.sqrt()
        });
        let hertz = hertz.fold(0.0, f64::max);
        let stiffness = match scene.solver.normal_law {
            NormalLaw::Linear { stiffness } => stiffness,
            // Rigid grains are resolved with the stiffness of their material.
            NormalLaw::Hertz | NormalLaw::Rigid => {
                let weight = self.mass * self.gravity.max(1e-3);
                let load = (0.5 * self.depth / (2.0 * self.radius)).max(1.0) * weight;
                1.25 * hertz * (load / hertz).cbrt()
            }
        };
        1.0 / (stiffness * inverse_mass).sqrt()
    }
}
