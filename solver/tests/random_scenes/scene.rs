//! Small scenes drawn at random: a cluster of grains that nearly touch, drawn together or apart, in one of several containers.

use makadam::Simulation;
use makadam::scene::Scene;
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::fmt::Write;

type Vector = Vector3<f64>;

/// Mass density of every grain, kg/m3.
pub const DENSITY: f64 = 2500.0;

/// Gap that two neighbours start with, over the sum of their radii.
const GAP: f64 = 2e-3;

/// Distance from the cluster to its container over the cluster's extent.
const ROOM: f64 = 1.02;

/// A grain at the start; SI units.
#[derive(Clone, Copy, Debug)]
pub struct Grain {
    pub radius: f64,
    pub position: Vector,
    pub velocity: Vector,
    pub spin: Vector,
}

/// Container of the grains; m and rad/s.
#[derive(Clone, Copy, Debug)]
pub enum Container {
    None,
    Box {
        half: f64,
    },
    Plane {
        normal: Vector,
        distance: f64,
    },
    /// About the z axis; turning where the rate is not zero.
    Cylinder {
        radius: f64,
        rate: f64,
    },
}

impl Container {
    /// Returns the same container without motion.
    pub fn at_rest(self) -> Container {
        match self {
            Container::Cylinder { radius, .. } => Container::Cylinder { radius, rate: 0.0 },
            other => other,
        }
    }
}

/// A scene.
#[derive(Clone, Debug)]
pub struct Drawn {
    pub grains: Vec<Grain>,
    pub container: Container,
    pub gravity: Vector,
    /// Pa; rigid contacts where it is absent.
    pub youngs_modulus: Option<f64>,
    pub friction: f64,
    pub restitution: f64,
    /// s
    pub step: f64,
}

/// Stopping rule of the solves of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solves {
    /// Ten sweeps with the default over-relaxation.
    Usual,
    /// To rounding.
    Converged,
}

fn direction() -> impl Strategy<Value = Vector> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64]
        .prop_map(Vector::from)
        .prop_filter_map("a direction", |vector| vector.try_normalize(0.1))
}

pub fn components() -> impl Strategy<Value = Vector> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64].prop_map(Vector::from)
}

/// Properties of a single grain: size from 0 to 1, the way in which it comes to the cluster, its velocity and its spin as
/// shares of the largest.
type GrainDraw = (f64, Vector, Vector, Vector);

fn grain() -> impl Strategy<Value = GrainDraw> {
    (0.0..1.0, direction(), components(), components())
}

/// Scenes of up to so many grains, in a container, under gravity.
pub fn scenes(most: usize) -> impl Strategy<Value = Drawn> {
    let kind = (0..5_u8, direction(), -20.0..20.0);
    let gravity = prop_oneof![Just(Vector::zeros()), direction().prop_map(|down| down * 9.81)];
    let law = prop_oneof![Just(None), (6.0..11.0_f64).prop_map(|exponent| Some(10.0_f64.powf(exponent)))];
    let coefficient = |most: f64| prop_oneof![1 => Just(0.0), 1 => Just(most), 4 => 0.0..most];
    let step = (1e-5_f64.ln()..5e-3_f64.ln()).prop_map(f64::exp);
    (prop::collection::vec(grain(), 1..=most), kind, gravity, law, coefficient(2.0), coefficient(1.0), step, -1.0..1.0)
        .prop_map(|(grains, kind, gravity, youngs_modulus, friction, restitution, step, rush)| {
            let grains = cluster(&grains, step, rush);
            let extent = grains.iter().map(|grain| grain.position.norm() + grain.radius).fold(0.0, f64::max);
            let container = match kind {
                (0, ..) => Container::None,
                (1, ..) => Container::Box { half: ROOM * extent },
                (2, normal, _) => Container::Plane { normal, distance: ROOM * extent },
                (3, ..) => Container::Cylinder { radius: ROOM * extent, rate: 0.0 },
                (_, _, rate) => Container::Cylinder { radius: ROOM * extent, rate },
            };
            Drawn { grains, container, gravity, youngs_modulus, friction, restitution, step }
        })
}

/// Grains of radii from 2 mm to 10 mm that come one after the other along a ray to the centre, up to those that are there.
///
/// They then cross a gap in about ten steps to the power of `rush`, at 2 m/s or less.
fn cluster(draws: &[GrainDraw], step: f64, rush: f64) -> Vec<Grain> {
    let mut grains: Vec<Grain> = Vec::new();
    for (size, way, velocity, spin) in draws {
        let radius = 0.002 * 5.0_f64.powf(*size);
        let far = grains.iter().filter_map(|there| {
            // Furthest point of the ray at which the two just do not touch.
            let reach = (radius + there.radius) * (1.0 + GAP);
            let along = way.dot(&there.position);
            let square = along * along - there.position.norm_squared() + reach * reach;
            (square > 0.0).then(|| along + square.sqrt())
        });
        let position = way * far.fold(0.0, f64::max);
        let speed = (10.0_f64.powf(rush) * GAP * 0.01 / step).min(2.0);
        let spin = spin * speed / radius;
        // Inwards on the whole, each in its own way.
        grains.push(Grain { radius, position, velocity: (velocity - way * 0.5) * speed, spin });
    }
    grains
}

impl Drawn {
    /// The scene as a file says it.
    pub fn text(&self, solves: Solves) -> String {
        let vector = |v: &Vector| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
        let mut text = format!(
            "name = 'random'\ndescription = 'drawn at random'\nduration = 10.0\ngravity = {}\n\
             largest_start_overlap = 2.0\n\
             domain = {{ min = [-0.5, -0.5, -0.5], max = [0.5, 0.5, 0.5] }}\n\
             [material.stone]\ndensity = {DENSITY:?}\nyoungs_modulus = {:?}\npoisson_ratio = 0.3\nfriction = {:?}\n\
             restitution = {:?}\n[solver]\nstep = {:?}\n",
            vector(&self.gravity),
            self.youngs_modulus.unwrap_or(1e7),
            self.friction,
            self.restitution,
            self.step
        );
        if self.youngs_modulus.is_none() {
            text += "normal_law = { kind = 'rigid' }\n";
        }
        text += match solves {
            Solves::Usual => "stop = { kind = 'sweeps', sweeps = 10 }\n",
            Solves::Converged => {
                "over_relaxation = 1.0\nstop = { kind = 'residual', tolerance = 1e-13, max_sweeps = 20000 }\n"
            }
        };
        let mut wall = |shape: String, motion: String| {
            let _ = writeln!(text, "[[wall]]\nname = 'wall'\nmaterial = 'stone'\nshape = {{ {shape} }}\n{motion}");
        };
        match self.container {
            Container::None => {}
            Container::Box { half: h } => {
                wall(
                    format!("kind = 'box', min = [{:?}, {:?}, {:?}], max = [{h:?}, {h:?}, {h:?}]", -h, -h, -h),
                    "".into(),
                );
            }
            Container::Plane { normal, distance } => {
                let point = vector(&(normal * -distance));
                wall(format!("kind = 'plane', point = {point}, normal = {}", vector(&normal)), "".into());
            }
            Container::Cylinder { radius, rate } => {
                let motion = match rate {
                    0.0 => String::new(),
                    _ => format!(
                        "motion = {{ kind = 'rotating', point = [0, 0, 0], axis = [0, 0, 1], rate = {rate:?} }}"
                    ),
                };
                let shape = "kind = 'cylinder', base = [0, 0, -0.5], axis = [0, 0, 1], length = 1.0";
                wall(format!("{shape}, radius = {radius:?}"), motion);
            }
        }
        for grain in &self.grains {
            let _ = writeln!(
                text,
                "[[grain]]\nmaterial = 'stone'\nradius = {:?}\nposition = {}\nvelocity = {}\nspin = {}",
                grain.radius,
                vector(&grain.position),
                vector(&grain.velocity),
                vector(&grain.spin)
            );
        }
        text
    }

    /// The scene as it is read.
    pub fn scene(&self, solves: Solves) -> Scene {
        let text = self.text(solves);
        Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    /// The scene at its start.
    pub fn start(&self, solves: Solves) -> Simulation {
        let made = Simulation::new(&self.scene(solves), 1);
        made.unwrap_or_else(|error| panic!("{error}\n{}", self.text(solves)))
    }

    /// The scene from the state of a snapshot on; absent where that is no start: a grain has left the domain, or is deep in another.
    pub fn starting_at(&self, snapshot: &Snapshot) -> Option<Drawn> {
        let grain = |particle: &Particle| Grain {
            radius: particle.radius,
            position: particle.position.into(),
            velocity: particle.velocity.into(),
            spin: particle.spin.into(),
        };
        let here = Drawn { grains: snapshot.particles.iter().map(grain).collect(), ..self.clone() };
        Simulation::new(&here.scene(Solves::Usual), 1).is_ok().then_some(here)
    }

    /// Mass of a grain, kg.
    pub fn mass(&self, grain: usize) -> f64 {
        DENSITY * 4.0 / 3.0 * std::f64::consts::PI * self.grains[grain].radius.powi(3)
    }

    /// The scene with every vector mapped by `polar`, and every axial vector by `axial`.
    pub fn mapped(&self, polar: impl Fn(Vector) -> Vector, axial: impl Fn(Vector) -> Vector) -> Drawn {
        let mut image = self.clone();
        for grain in &mut image.grains {
            grain.position = polar(grain.position);
            grain.velocity = polar(grain.velocity);
            grain.spin = axial(grain.spin);
        }
        image.gravity = polar(self.gravity);
        image.container = match self.container {
            Container::Plane { normal, distance } => Container::Plane { normal: polar(normal), distance },
            Container::Cylinder { radius, rate } => Container::Cylinder { radius, rate: axial(Vector::z() * rate).z },
            other => other,
        };
        image
    }
}
