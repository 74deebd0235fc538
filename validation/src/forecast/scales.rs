//! Characteristic numbers of a scene: of its bed, of its moving walls, of its contacts.

use super::Scale;
use makadam::scene::{Grain, Motion, NormalLaw, Shape};
use makadam_frames::plan::MeasuredScene;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Solid fraction of a bed, for its depth and pressure.
const FRACTION: f64 = 0.6;

/// All grains as a level bed on the base of the domain or of a narrower container.
pub(super) struct Bed {
    /// Mass, kg.
    pub mass: f64,
    /// Mean radius, m.
    radius: f64,
    /// Mean density, kg/m3.
    density: f64,
    /// Depth, m.
    depth: f64,
    /// Magnitude of gravity at the start, m/s2.
    gravity: f64,
}

impl Bed {
    pub fn of(scene: &MeasuredScene, grains: &[Grain]) -> Bed {
        let volume_of = |grain: &Grain| 4.0 / 3.0 * PI * grain.radius.powi(3);
        let volume: f64 = grains.iter().map(volume_of).sum();
        let mass: f64 = grains.iter().map(|grain| scene.material[&grain.material].density * volume_of(grain)).sum();
        let radius = grains.iter().map(|grain| grain.radius).sum::<f64>() / grains.len().max(1) as f64;
        let gravity = Vector3::from(scene.gravity);
        let ground = ground(scene, &gravity);
        let depth = (volume / FRACTION / ground).max(2.0 * radius);
        Bed { mass, radius, density: if volume > 0.0 { mass / volume } else { 0.0 }, depth, gravity: gravity.norm() }
    }

    /// Returns the defined numbers of the scene.
    pub fn scales(&self, scene: &MeasuredScene, grains: &[Grain]) -> Vec<Scale> {
        if grains.is_empty() {
            return Vec::new();
        }
        let mut scales = Vec::new();
        let mut add = |name, value: f64, unit, formula: String| {
            if value.is_finite() {
                scales.push(Scale { name, value, unit, formula });
            }
        };
        let rayleigh = scene.rayleigh_step(grains);
        add(
            "Rayleigh step",
            rayleigh,
            "s",
            "π r √(ρ/G) / (0.1631 ν + 0.8766), smallest; explicit codes take 10 to 20% of it".into(),
        );
        add("step over Rayleigh step", scene.solver.step / rayleigh, "", "solver.step over the above".into());
        if self.gravity > 0.0 {
            let fall = self.gravity * scene.solver.step.powi(2) / self.radius;
            add(
                "fall per step",
                fall,
                "radius",
                "g h²/r: a packing fraction deviates by at most 0.14 (1 + μ) times its root".into(),
            );
            add("expected overlap", self.overlap(scene), "radius", "static, under half the bed".into());
        }
        if let Some((speed, radius)) = fastest(scene) {
            if radius > 0.0 && self.gravity > 0.0 {
                let froude = speed * speed / (radius * self.gravity);
                add(
                    "Froude number",
                    froude,
                    "",
                    "Ω² R/g of the turning walls; rolling below 0.1, cataracting from 0.1, centrifuging from 1".into(),
                );
            }
            if self.gravity > 0.0 {
                let pressure = self.density * FRACTION * self.gravity * 0.5 * self.depth;
                let inertial = speed / self.depth * 2.0 * self.radius / (pressure / self.density).sqrt();
                add("inertial number", inertial, "", "γ d/√(P/ρ) with γ the speed of the walls over the depth of the bed, P under half of it: an order of magnitude".into());
            }
        }
        for wall in &scene.wall {
            if let (Motion::Vibrating { amplitude, frequency, .. }, true) = (&wall.motion, self.gravity > 0.0) {
                let acceleration = Vector3::from(*amplitude).norm() * (2.0 * PI * frequency).powi(2);
                add("vibration", acceleration / self.gravity, "g", format!("A (2π f)²/g of {}", wall.name));
            }
        }
        scales
    }

    /// Returns the overlap of two grains under half the bed, over the mean radius.
    fn overlap(&self, scene: &MeasuredScene) -> f64 {
        let layers = (0.5 * self.depth / (2.0 * self.radius)).max(1.0);
        let load = layers * self.density * 4.0 / 3.0 * PI * self.radius.powi(3) * self.gravity;
        let softest = scene.material.values().map(|material| {
            let modulus = material.youngs_modulus / (2.0 * (1.0 - material.poisson_ratio.powi(2)));
            4.0 / 3.0 * modulus * (self.radius / 2.0).sqrt()
        });
        let stiffness = softest.fold(f64::INFINITY, f64::min);
        match scene.solver.normal_law {
            NormalLaw::Rigid => 0.0,
            NormalLaw::Linear { stiffness } => load / stiffness / self.radius,
            NormalLaw::Hertz => (load / stiffness).powf(2.0 / 3.0) / self.radius,
        }
    }
}

/// Returns the base area of the grains, m2: the narrowest container across gravity, or the domain.
fn ground(scene: &MeasuredScene, gravity: &Vector3<f64>) -> f64 {
    let size: [f64; 3] = std::array::from_fn(|axis| scene.domain.max[axis] - scene.domain.min[axis]);
    let down = gravity.iamax();
    let domain = size.iter().product::<f64>() / size[down];
    let of_wall = scene.wall.iter().filter_map(|wall| match &wall.shape {
        Shape::Box { min, max, .. } => {
            let sides: [f64; 3] = std::array::from_fn(|axis| max[axis] - min[axis]);
            Some(sides.iter().product::<f64>() / sides[down])
        }
        Shape::Cylinder { axis, radius, length, .. } => {
            let upright = Vector3::from(*axis).normalize()[down].abs() > 0.7;
            Some(if upright { PI * radius * radius } else { 2.0 * radius * length })
        }
        _ => None,
    });
    of_wall.fold(domain, f64::min)
}

/// Returns the speed of the fastest wall (m/s), and its radius if it rotates (m; else 0).
fn fastest(scene: &MeasuredScene) -> Option<(f64, f64)> {
    let speeds = scene.wall.iter().filter_map(|wall| match (&wall.motion, &wall.shape) {
        (Motion::Rotating { rate, .. }, Shape::Cylinder { radius, .. }) => Some((rate.abs() * radius, *radius)),
        (Motion::Rotating { point, axis, rate, .. }, shape) => {
            let axis = Vector3::from(*axis).normalize();
            let radius = shape.furthest(|place| (place - Vector3::from(*point)).cross(&axis).norm());
            radius.is_finite().then_some((rate.abs() * radius, radius))
        }
        (Motion::Translating { velocity, .. }, _) => Some((Vector3::from(*velocity).norm(), 0.0)),
        _ => None,
    });
    speeds.filter(|(speed, _)| *speed > 0.0).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Describes the motion of a wall; `None` for a wall at rest.
pub(super) fn motion(motion: &Motion) -> Option<String> {
    Some(match motion {
        Motion::Fixed => return None,
        Motion::Translating { velocity, .. } => format!("moves at {} m/s", Vector3::from(*velocity).norm()),
        Motion::Rotating { rate, .. } => format!("turns at {rate} rad/s ({:.3} rpm)", rate * 30.0 / PI),
        Motion::Vibrating { amplitude, frequency, .. } => {
            format!("vibrates by {} m at {frequency} Hz", Vector3::from(*amplitude).norm())
        }
        Motion::ForceDriven { force, .. } => format!("is pushed by {force} N"),
        Motion::Table { file, .. } => format!("moves by '{file}'"),
        Motion::List(parts) => parts.iter().filter_map(self::motion).collect::<Vec<_>>().join(", "),
        Motion::TorqueDriven { torque, .. } => format!("is turned by {torque} N m"),
    })
}
