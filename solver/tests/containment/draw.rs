//! Containers and their grains, drawn from a number.

use super::container::{Container, Motion, Shape};
use makadam::scene::Scene;
use nalgebra::{Rotation3, Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use std::fmt::Write;

type Vector = Vector3<f64>;

/// Time step, s.
const STEP: f64 = 5e-4;

/// Mean radius of the grains, m.
const RADIUS: f64 = 0.004;

/// A container with grains.
pub struct Drawn {
    pub container: Container,
    grains: Vec<Grain>,
    /// Diameters a step.
    pace: f64,
    solver: &'static str,
    gravity: f64,
    friction: f64,
    restitution: f64,
}

struct Grain {
    radius: f64,
    position: Vector,
    velocity: Vector,
    spin: Vector,
}

struct Dice(ChaCha8Rng);

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: u64) -> u64 {
        self.0.next_u64() % count
    }

    /// Uniform in the logarithm.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn components(&mut self) -> Vector {
        Vector::from_fn(|_, _| self.between(-1.0, 1.0))
    }

    fn direction(&mut self) -> Vector {
        loop {
            let vector = self.components();
            if (0.1..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }

    /// One of these, a share of the time the first.
    fn coefficient(&mut self, most: f64) -> f64 {
        match self.below(4) {
            0 => 0.0,
            1 => most,
            _ => self.between(0.0, most),
        }
    }
}

fn shape(dice: &mut Dice) -> Shape {
    let size = |dice: &mut Dice| RADIUS * dice.scale(4.0, 24.0);
    let half = Vector::new(size(dice), size(dice), size(dice));
    let (radius, length) = (half.x, half.z);
    match dice.below(10) {
        0 => Shape::Box { half },
        1 => Shape::Planes { half },
        2 => Shape::Discs { half },
        3 => Shape::Drum { radius, half: length },
        4 => Shape::Tube { radius, half: length },
        5 => Shape::Plugged { radius, half: length, hole: radius * dice.between(0.1, 0.9) },
        6 => Shape::Annulus { inner: radius, radius: radius + size(dice), half: length },
        7 => {
            Shape::Obstacle { radius, half: length, ball: (radius.min(length) - 1.5 * RADIUS) * dice.between(0.2, 0.5) }
        }
        8 => Shape::Piston { radius, half: length, force: dice.between(-1.0, 0.2), mass: dice.scale(1e-3, 1.0) },
        _ => Shape::Pipe { radius, half: 0.1 },
    }
}

fn funnel(dice: &mut Dice) -> Shape {
    let size = |dice: &mut Dice| RADIUS * dice.scale(4.0, 24.0);
    let (radius, half) = (size(dice), size(dice));
    let low = radius * if dice.below(2) == 0 { 0.0 } else { dice.between(0.05, 1.0) };
    Shape::Funnel { radii: [low, radius], half }
}

fn motion(dice: &mut Dice, shape: &Shape) -> Motion {
    let speed = 2.0 * RADIUS / STEP * dice.scale(0.01, 0.5);
    match (dice.below(5), shape) {
        (_, Shape::Piston { .. } | Shape::Pipe { .. }) | (0 | 1, _) => Motion::Fixed,
        (2, _) => Motion::Translating { velocity: dice.direction() * speed },
        (3, _) => {
            let point = dice.components() * 0.05;
            Motion::Rotating { point, axis: dice.direction(), rate: dice.between(-1.0, 1.0) * 60.0 }
        }
        _ => {
            let frequency = dice.scale(5.0, 100.0);
            Motion::Vibrating { amplitude: dice.direction() * (dice.scale(0.1, 4.0) * RADIUS), frequency }
        }
    }
}

impl Drawn {
    /// The container of a number.
    pub fn number(number: u64) -> Drawn {
        Drawn::of(number, shape)
    }

    /// The funnel of a number.
    pub fn funnel(number: u64) -> Drawn {
        Drawn::of(number, funnel)
    }

    fn of(number: u64, shape: fn(&mut Dice) -> Shape) -> Drawn {
        let mut dice = Dice(ChaCha8Rng::seed_from_u64(number));
        let shape = shape(&mut dice);
        let turned = match shape {
            Shape::Box { .. } => Rotation3::identity(),
            // Its axis lies along x, which repeats itself.
            Shape::Pipe { .. } => Rotation3::from_axis_angle(&Vector::y_axis(), std::f64::consts::FRAC_PI_2),
            Shape::Obstacle { .. }
            | Shape::Piston { .. }
            | Shape::Planes { .. }
            | Shape::Discs { .. }
            | Shape::Drum { .. }
            | Shape::Tube { .. }
            | Shape::Plugged { .. }
            | Shape::Annulus { .. }
            | Shape::Funnel { .. } => {
                Rotation3::from_axis_angle(&Unit::new_normalize(dice.direction()), dice.between(0.0, 6.0))
            }
        };
        let container = Container { shape, turned, motion: motion(&mut dice, &shape) };
        let count = match dice.below(3) {
            0 => 1,
            1 => 2 + dice.below(20),
            _ => 20 + dice.below(281),
        };
        let pace = dice.scale(0.1, 10.0);
        let mut grains = Vec::new();
        for _ in 0..count {
            grains.extend(grain(&mut dice, &container, pace, &grains));
        }
        let solver = match dice.below(4) {
            0 => "normal_law = { kind = 'rigid' }",
            1 => "stop = { kind = 'residual', tolerance = 1e-6, max_sweeps = 200 }",
            2 => "precision = 'single'",
            _ => "",
        };
        let solver = if matches!(shape, Shape::Piston { .. }) { "" } else { solver };
        Drawn {
            container,
            grains,
            pace,
            solver,
            gravity: dice.coefficient(20.0),
            friction: dice.coefficient(1.0),
            restitution: dice.coefficient(1.0),
        }
    }

    /// Returns true if its solves are in single precision.
    pub fn is_single(&self) -> bool {
        self.solver.contains("single")
    }

    /// In a few words.
    pub fn summary(&self) -> String {
        format!(
            "{} grains at {:.2} diameters a step, {:?}, {}",
            self.grains.len(),
            self.pace,
            self.container,
            self.solver
        )
    }

    /// The scene as a file says it.
    pub fn text(&self) -> String {
        let vector = |v: &Vector| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
        let periodic = matches!(self.container.shape, Shape::Pipe { .. });
        let (x, repeats) = if periodic { (0.1, ", periodic = ['x']") } else { (3.0, "") };
        let mut text = format!(
            "name = 'container'\ndescription = 'drawn at random'\nduration = 1.0\ngravity = [0.0, 0.0, {:?}]\n\
             largest_start_overlap = 2.0\n\
             domain = {{ min = [-{x:?}, -3.0, -3.0], max = [{x:?}, 3.0, 3.0]{repeats} }}\n\
             [material.stone]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = {:?}\n\
             restitution = {:?}\n[solver]\nstep = {STEP:?}\n{}\n{}",
            -self.gravity,
            self.friction,
            self.restitution,
            self.solver,
            self.container.text()
        );
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
    pub fn scene(&self) -> Scene {
        let text = self.text();
        Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }
}

/// A grain that has room where it starts; absent where none was found.
fn grain(dice: &mut Dice, container: &Container, pace: f64, others: &[Grain]) -> Option<Grain> {
    let radius = RADIUS * dice.between(0.6, 1.4);
    let extent = container.extent();
    let overlaps = |place: &Vector| {
        let deep = |other: &Grain| (container.turned * place - other.position).norm() < 0.6 * (radius + other.radius);
        others.iter().any(deep)
    };
    let place = (0..50)
        .map(|_| dice.components().component_mul(&extent))
        .find(|place| container.room(*place) > radius && !overlaps(place))?;
    let speed = pace * 2.0 * RADIUS / STEP * dice.between(0.3, 1.0);
    let (velocity, spin) = (dice.direction() * speed, dice.components() * (0.1 * speed / radius));
    Some(Grain { radius, position: container.turned * place, velocity, spin })
}
