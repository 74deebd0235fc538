//! Gauges: grains that pass surfaces in space, counted in each step.
//!
//! The side of a centre follows from its position alone, with the same bits at the end of a step and at the start of the next.
//! So forward and backward passages of a grain alternate, and none is missed or counted twice. Along periodic axes, the image of the
//! centre nearest to the centre of the gauge counts. The momentum of a passage is that of the step.

use crate::Simulation;
use crate::lanes::{plus, times};
use crate::laws::period::Period;
use crate::scene::{Scene, Shape};
use crate::schedule::{Each, Phase, Team};
use crate::world::{chunk, chunks};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Relative tolerance of a path across the end of a period.
const ROUNDING: f64 = 1e-9;
/// Displacement of all passages, m: above rounding, and along no common edge. So a passage on an edge that two gauges share is of one.
const ASIDE: [f64; 3] = [1e-12, 0.7e-12, 0.4e-12];

/// Grains that have passed a gauge in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Passages {
    /// Number of passages.
    pub grains: u64,
    /// Mass, kg.
    pub mass: f64,
    /// Momentum, kg m/s.
    pub momentum: [f64; 3],
}

/// Gauges of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gauges {
    surfaces: Vec<Surface>,
    /// Passages forward and backward of each gauge.
    pub passed: Vec<[Passages; 2]>,
    /// Passages of the step by chunk of grains: index of the gauge, slot of the grain, direction.
    met: Vec<Vec<(usize, usize, usize)>>,
}

#[derive(Clone, Debug)]
struct Surface {
    shape: Shape,
    centre: Vector3<f64>,
    normal: Vector3<f64>,
}

impl Surface {
    /// Returns the direction, 0 forward or 1 backward, in which a centre passes between two points (m).
    fn passage(&self, period: &Period, from: &Vector3<f64>, to: &Vector3<f64>) -> Option<usize> {
        let (start, end) = (period.arm(&self.centre, from), period.arm(&self.centre, to));
        let (before, after) = (self.normal.dot(&start), self.normal.dot(&end));
        if (before < 0.0) == (after < 0.0) {
            return None;
        }
        let path = to - from;
        // Half a period away the nearest image changes.
        let longest = (0..3).map(|axis| period.length(axis)).fold(0.0, f64::max);
        if self.normal.dot(&(end - start - path)).abs() > ROUNDING * longest && period.any() {
            return None;
        }
        let at = start + path * (before / (before - after));
        let at = period.arm(&Vector3::zeros(), &(at + Vector3::from(ASIDE)));
        let inside = match &self.shape {
            Shape::Disc { radius, .. } => at.norm() <= *radius,
            Shape::Rectangle { edges, .. } => {
                let [first, second] = edges.map(Vector3::from);
                let area = first.cross(&second).norm();
                let (along, across) = (at.cross(&second), first.cross(&at));
                [along, across].iter().all(|part| self.normal.dot(part).abs() <= area * 0.5)
            }
            _ => false,
        };
        inside.then_some(usize::from(after < 0.0))
    }
}

impl Gauges {
    /// Creates the gauges of a scene, without passages.
    pub fn of(scene: &Scene) -> Gauges {
        let surface = |gauge: &crate::scene::Gauge| {
            let [centre, normal] = gauge.place().unwrap_or_default();
            Surface { shape: gauge.shape.clone(), centre, normal }
        };
        let passed = vec![Default::default(); scene.gauge.len()];
        Gauges { surfaces: scene.gauge.iter().map(surface).collect(), passed, met: Vec::new() }
    }

    /// Takes over the passages of a checkpoint.
    ///
    /// # Errors
    /// Message if they are of other gauges, or impossible.
    pub fn continue_from(&mut self, passed: &[[Passages; 2]]) -> Result<(), String> {
        let sound =
            |one: &Passages| one.grains < 1 << 53 && one.momentum.iter().chain([&one.mass]).all(|x| x.is_finite());
        if passed.len() != self.passed.len() || !passed.iter().flatten().all(sound) {
            return Err("has other gauges than the scene".into());
        }
        self.passed = passed.to_vec();
        Ok(())
    }
}

impl Simulation {
    /// Returns the passages forward and backward of each gauge of the scene since the start.
    pub fn gauges(&self) -> &[[Passages; 2]] {
        &self.gauges.passed
    }

    /// Counts the passages of the step, before the grains move.
    pub(super) fn note_passages(&mut self, team: &Team) {
        let Simulation { world, settings, gauges: Gauges { surfaces, passed, met }, .. } = self;
        if surfaces.is_empty() {
            return;
        }
        let grains = world.grains();
        met.resize_with(chunks(grains), Vec::new);
        team.each_with(Phase::Integrate, chunks(grains), Each::of(met), |number, met| {
            met.clear();
            for place in chunk(number, grains) {
                let from = world.spheres[place].centre;
                let to = from + Vector3::from(world.bodies[place].velocity) * settings.step;
                let found = surfaces.iter().map(|surface| surface.passage(&world.period, &from, &to)).enumerate();
                met.extend(found.filter_map(|(gauge, way)| Some((gauge, place, way?))));
            }
        });
        for &(gauge, place, way) in met.iter().flatten() {
            let (body, sum) = (&world.bodies[place], &mut passed[gauge][way]);
            let mass = 1.0 / body.inverse_mass;
            sum.grains += 1;
            sum.mass += mass;
            sum.momentum = plus(sum.momentum, times(body.velocity, mass));
        }
    }
}
