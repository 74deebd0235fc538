//! Beds whose numbers are known beforehand, and scenes to measure them with.

use makadam::snapshot::{Particle, Snapshot};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use makadam_measure::observables::Measurement;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::SQRT_2;

/// A small generator, so that synthetic beds are the same in every run.
pub struct Random(pub u64);

impl Random {
    /// Evenly spread from 0 to 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A scene of one grain between some walls, with a `[measure]` of some observables.
pub fn scene(walls: &str, observables: &str, from: &str) -> MeasuredScene {
    let text = format!(
        r#"
name = "synthetic"
description = "a synthetic bed"
duration = 10.0
domain = {{ min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }}
[material.grain]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.5
restitution = 0.3
{walls}
[[population]]
count = 1
material = "grain"
radius = {{ kind = "fixed", value = 0.005 }}
region = {{ kind = "box", min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }}
[measure]
observables = {observables}
{from}
"#
    );
    MeasuredScene::parse(&text).expect("a valid scene")
}

/// Returns the bed in a drum that turns at `rate` (rad/s).
pub fn drum_scene(rate: f64, observables: &str) -> MeasuredScene {
    let walls = format!(
        r#"
[[wall]]
name = "shell"
material = "grain"
shape = {{ kind = "cylinder", base = [0.0, -0.06, 0.0], axis = [0.0, 1.0, 0.0], radius = 0.1, length = 0.12 }}
motion = {{ kind = "rotating", point = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], rate = {rate:?} }}
[[wall]]
name = "front"
material = "grain"
shape = {{ kind = "disc", centre = [0.0, -0.06, 0.0], normal = [0.0, 1.0, 0.0], radius = 0.1 }}
[[wall]]
name = "back"
material = "grain"
shape = {{ kind = "disc", centre = [0.0, 0.06, 0.0], normal = [0.0, -1.0, 0.0], radius = 0.1 }}
"#
    );
    scene(&walls, observables, "from = 0.0")
}

/// A recording of these frames.
pub fn recording(frames: Vec<Snapshot>) -> Recording {
    Recording {
        scene: "synthetic".into(),
        code: "Makadam".into(),
        version: "0".into(),
        seed: 1,
        time_step: 1e-3,
        rayleigh_fraction: None,
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 1.0,
        core_seconds: None,
        simulated_seconds: 1.0,
        frames,
        lacks: Vec::new(),
        alarms: Vec::new(),
        notes: Vec::new(),
    }
}

/// Grains at rest at some places.
pub fn particles(places: impl IntoIterator<Item = Vector3<f64>>, radius: f64) -> Vec<Particle> {
    (places.into_iter().enumerate())
        .map(|(id, place)| Particle {
            id: id as u32,
            position: place.into(),
            radius,
            velocity: [0.0; 3],
            spin: [0.0; 3],
        })
        .collect()
}

/// A frame without contacts.
pub fn frame(time: f64, particles: Vec<Particle>) -> Snapshot {
    Snapshot { time, particles, ..Snapshot::default() }
}

/// The value of an observable that must be there.
pub fn value(measurements: &[Measurement], name: &str) -> f64 {
    measurements.iter().find(|m| m.observable == name).unwrap_or_else(|| panic!("{name} is missing")).value
}

/// Sites of a face-centred cubic lattice of touching spheres, turned, in a cube about the origin.
pub fn fcc(diameter: f64, half: f64, turn: Rotation3<f64>, shift: Vector3<f64>) -> Vec<Vector3<f64>> {
    let edge = diameter * SQRT_2;
    // The cube's corner lies sqrt(3) of its half width away, the lattice is shifted by up to an edge.
    let count = (1.75 * half / edge).ceil() as i64 + 2;
    let place = |site: Vector3<f64>| turn * (site * edge) + shift;
    let along = turn * (Vector3::z() * edge);
    let mut sites = Vec::new();
    for i in -count..=count {
        for j in -count..=count {
            // Of a row of the lattice, the cells that reach into the cube.
            let row = place(Vector3::new(i as f64, j as f64, 0.0));
            let (mut first, mut last) = (-count as f64, count as f64);
            for axis in (0..3).filter(|&axis| along[axis] != 0.0) {
                let ends = [-half - edge, half + edge].map(|end| (end - row[axis]) / along[axis]);
                (first, last) = (first.max(ends[0].min(ends[1])), last.min(ends[0].max(ends[1])));
            }
            for k in first.ceil() as i64..=last.floor() as i64 {
                for basis in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
                    let place = place(Vector3::new(i as f64, j as f64, k as f64) + Vector3::from(basis));
                    if place.amax() <= half {
                        sites.push(place);
                    }
                }
            }
        }
    }
    sites
}

/// A crystal that is turned and shifted anew for each frame: dense, and with no direction of its own over time.
pub fn random_crystal(random: &mut Random, half: f64) -> Vec<Vector3<f64>> {
    let turn = Rotation3::from_euler_angles(6.3 * random.uniform(), 6.3 * random.uniform(), 6.3 * random.uniform());
    let shift = Vector3::from_fn(|_, _| 0.01 * random.uniform());
    fcc(0.0106, half, turn, shift)
}

/// Frames of a drum whose bed is cut by a plane `offset` (m) above the axis and inclined by `degrees` about y.
pub fn tilted_drum(frames: usize, degrees: f64, offset: f64, radius: f64) -> Vec<Snapshot> {
    let mut random = Random(7);
    let (sine, cosine) = degrees.to_radians().sin_cos();
    (0..frames)
        .map(|index| {
            let places = random_crystal(&mut random, 0.12).into_iter().filter(|p| {
                p.x.hypot(p.z) < 0.1 - radius
                    && p.y.abs() < 0.06 - radius
                    && p.z * cosine - p.x * sine < offset - radius
            });
            frame(index as f64 * 0.05, particles(places, radius))
        })
        .collect()
}
