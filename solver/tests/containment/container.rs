//! Closed containers: which walls they are made of, how they move, and what is inside.

use nalgebra::{Rotation3, Unit, Vector3};
use std::fmt::Write;

type Vector = Vector3<f64>;

/// Walls around the grains, about the origin and the z axis of their own frame; m.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// A box whose axes are those of the world.
    Box { half: Vector },
    /// Six planes, turned anyhow.
    Planes { half: Vector },
    /// Six discs that meet along the edges of a box, turned anyhow.
    Discs { half: Vector },
    /// A shell with a disc at each end.
    Drum { radius: f64, half: f64 },
    /// A shell between two planes.
    Tube { radius: f64, half: f64 },
    /// A shell with a disc at one end and at the other a ring whose hole a disc closes.
    Plugged { radius: f64, half: f64, hole: f64 },
    /// The space between two shells, with a ring at each end.
    Annulus { inner: f64, radius: f64, half: f64 },
    /// A drum with a sphere in its middle.
    Obstacle { radius: f64, half: f64, ball: f64 },
    /// A drum whose upper end is a plane that a force drives down or up.
    Piston { radius: f64, half: f64, force: f64, mass: f64 },
    /// A cone with a disc at its wide end and at the other a disc or its tip.
    Funnel { radii: [f64; 2], half: f64 },
    /// A shell without ends along x, which repeats itself.
    Pipe { radius: f64, half: f64 },
}

/// Common motion of all walls.
#[derive(Clone, Copy, Debug)]
pub enum Motion {
    Fixed,
    Translating { velocity: Vector },
    Rotating { point: Vector, axis: Vector, rate: f64 },
    Vibrating { amplitude: Vector, frequency: f64 },
}

/// A closed container.
#[derive(Clone, Copy, Debug)]
pub struct Container {
    pub shape: Shape,
    /// From its own frame to the world's at the start.
    pub turned: Rotation3<f64>,
    pub motion: Motion,
}

/// Length of a shell that no piston leaves, m.
const LONG: f64 = 8.0;

/// Largest effect of rounding on a place, over the size of the container.
const ROUNDING: f64 = 1e-7;

impl Container {
    /// A place in the container's own frame, given one in the world at a time (s).
    fn inwards(&self, place: Vector, time: f64) -> Vector {
        let start = match self.motion {
            Motion::Fixed => place,
            Motion::Translating { velocity } => place - velocity * time,
            Motion::Rotating { point, axis, rate } => {
                point + Rotation3::from_axis_angle(&Unit::new_normalize(axis), -rate * time) * (place - point)
            }
            Motion::Vibrating { amplitude, frequency } => {
                place - amplitude * (std::f64::consts::TAU * frequency * time).sin()
            }
        };
        self.turned.inverse() * start
    }

    /// Returns true if a centre is inside at a time (s), the driven wall displaced by so much (m).
    pub fn holds(&self, centre: Vector, time: f64, displacement: f64) -> bool {
        let place = self.inwards(centre, time);
        let across = place.xy().norm();
        let within =
            |radius: f64, half: f64| across <= radius * (1.0 + ROUNDING) && place.z.abs() <= half * (1.0 + ROUNDING);
        match self.shape {
            Shape::Box { half } | Shape::Planes { half } | Shape::Discs { half } => {
                (0..3).all(|axis| place[axis].abs() <= half[axis] * (1.0 + ROUNDING))
            }
            Shape::Drum { radius, half } | Shape::Tube { radius, half } | Shape::Plugged { radius, half, .. } => {
                within(radius, half)
            }
            Shape::Annulus { inner, radius, half } => within(radius, half) && across >= inner * (1.0 - ROUNDING),
            Shape::Obstacle { radius, half, ball } => within(radius, half) && place.norm() >= ball * (1.0 - ROUNDING),
            Shape::Piston { radius, half, .. } => {
                let top = half + displacement;
                across <= radius * (1.0 + ROUNDING)
                    && place.z >= -half * (1.0 + ROUNDING)
                    && place.z <= top + half * ROUNDING
            }
            Shape::Funnel { radii: [low, high], half } => {
                within(low + (high - low) * 0.5 * (place.z / half + 1.0) + ROUNDING * half, half)
            }
            Shape::Pipe { radius, .. } => across <= radius * (1.0 + ROUNDING),
        }
    }

    /// Distance from a place in its own frame to the nearest wall, m.
    pub fn room(&self, place: Vector) -> f64 {
        let across = place.xy().norm();
        match self.shape {
            Shape::Box { half } | Shape::Planes { half } | Shape::Discs { half } => {
                (0..3).map(|axis| half[axis] - place[axis].abs()).fold(f64::INFINITY, f64::min)
            }
            Shape::Drum { radius, half }
            | Shape::Tube { radius, half }
            | Shape::Plugged { radius, half, .. }
            | Shape::Piston { radius, half, .. }
            | Shape::Pipe { radius, half } => (radius - across).min(half - place.z.abs()),
            Shape::Annulus { inner, radius, half } => (radius - across).min(across - inner).min(half - place.z.abs()),
            Shape::Obstacle { radius, half, ball } => {
                (radius - across).min(place.norm() - ball).min(half - place.z.abs())
            }
            Shape::Funnel { radii: [low, high], half } => {
                let lean = 2.0 * half / (2.0 * half).hypot(high - low);
                let radius = low + (high - low) * 0.5 * (place.z / half + 1.0);
                ((radius - across) * lean).min(half - place.z.abs())
            }
        }
    }

    /// Half of the extent along each axis of its own frame, m.
    pub fn extent(&self) -> Vector {
        match self.shape {
            Shape::Box { half } | Shape::Planes { half } | Shape::Discs { half } => half,
            Shape::Drum { radius, half }
            | Shape::Tube { radius, half }
            | Shape::Plugged { radius, half, .. }
            | Shape::Annulus { radius, half, .. }
            | Shape::Obstacle { radius, half, .. }
            | Shape::Piston { radius, half, .. }
            | Shape::Pipe { radius, half } => Vector::new(radius, radius, half),
            Shape::Funnel { radii: [low, high], half } => Vector::new(low.max(high), low.max(high), half),
        }
    }

    /// True if it goes on beyond the ends of the domain.
    pub fn repeats(&self) -> bool {
        matches!(self.shape, Shape::Pipe { .. })
    }

    /// The walls as a scene says them.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let vector = |v: Vector| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
        let place = |v: Vector| vector(self.turned * v);
        let z = Vector::z();
        let motion = match self.motion {
            Motion::Fixed => String::new(),
            Motion::Translating { velocity } => {
                format!("motion = {{ kind = 'translating', velocity = {} }}\n", vector(velocity))
            }
            Motion::Rotating { point, axis, rate } => format!(
                "motion = {{ kind = 'rotating', point = {}, axis = {}, rate = {rate:?} }}\n",
                vector(point),
                vector(axis)
            ),
            Motion::Vibrating { amplitude, frequency } => format!(
                "motion = {{ kind = 'vibrating', amplitude = {}, frequency = {frequency:?} }}\n",
                vector(amplitude)
            ),
        };
        let mut number = 0;
        let mut wall_that = |shape: String, motion: &str| {
            number += 1;
            let _ =
                write!(text, "[[wall]]\nname = 'wall {number}'\nmaterial = 'stone'\nshape = {{ {shape} }}\n{motion}");
        };
        let mut wall = |shape: String| wall_that(shape, &motion);
        let disc = |centre: Vector, normal: Vector, radius: f64, hole: f64| {
            let hole = if hole > 0.0 { format!(", hole = {hole:?}") } else { String::new() };
            format!("kind = 'disc', centre = {}, normal = {}, radius = {radius:?}{hole}", place(centre), place(normal))
        };
        let plane = |point: Vector, normal: Vector| {
            format!("kind = 'plane', point = {}, normal = {}", place(point), place(normal))
        };
        let shell = |radius: f64, half: f64, length: f64| {
            let (base, axis) = (place(-z * half), place(z));
            format!("kind = 'cylinder', base = {base}, axis = {axis}, radius = {radius:?}, length = {length:?}")
        };
        match self.shape {
            Shape::Box { half } => wall(format!("kind = 'box', min = {}, max = {}", vector(-half), vector(half))),
            Shape::Planes { half } | Shape::Discs { half } => {
                for axis in 0..3 {
                    for side in [-1.0, 1.0] {
                        let (point, normal) = (Vector::ith(axis, side * half[axis]), Vector::ith(axis, -side));
                        match self.shape {
                            Shape::Planes { .. } => wall(plane(point, normal)),
                            _ => wall(disc(point, normal, half.norm() * 1.001, 0.0)),
                        }
                    }
                }
            }
            Shape::Drum { radius, half } => {
                wall(shell(radius, half, 2.0 * half));
                wall(disc(-z * half, z, radius, 0.0));
                wall(disc(z * half, -z, radius, 0.0));
            }
            Shape::Tube { radius, half } => {
                wall(shell(radius, half, 2.0 * half));
                wall(plane(-z * half, z));
                wall(plane(z * half, -z));
            }
            Shape::Plugged { radius, half, hole } => {
                wall(shell(radius, half, 2.0 * half));
                wall(disc(-z * half, z, radius, 0.0));
                wall(disc(z * half, -z, radius, hole));
                wall(disc(z * half, -z, hole, 0.0));
            }
            Shape::Annulus { inner, radius, half } => {
                wall(shell(radius, half, 2.0 * half));
                wall(shell(inner, half, 2.0 * half));
                wall(disc(-z * half, z, radius, inner));
                wall(disc(z * half, -z, radius, inner));
            }
            Shape::Obstacle { radius, half, ball } => {
                wall(shell(radius, half, 2.0 * half));
                wall(disc(-z * half, z, radius, 0.0));
                wall(disc(z * half, -z, radius, 0.0));
                wall(format!("kind = 'spheres', centres = [[0.0, 0.0, 0.0]], radius = {ball:?}"));
            }
            Shape::Piston { radius, half, force, mass } => {
                wall(shell(radius, half, LONG));
                wall(disc(-z * half, z, radius, 0.0));
                let driven = format!(
                    "motion = {{ kind = 'force-driven', axis = {}, force = {force:?}, mass = {mass:?} }}\n",
                    place(z)
                );
                wall_that(plane(z * half, -z), &driven);
            }
            Shape::Funnel { radii: [low, high], half } => {
                let (base, axis, length) = (place(-z * half), place(z), 2.0 * half);
                wall(format!(
                    "kind = 'frustum', base = {base}, axis = {axis}, radii = [{low:?}, {high:?}], length = {length:?}"
                ));
                wall(disc(z * half, -z, high, 0.0));
                if low > 0.0 {
                    wall(disc(-z * half, z, low, 0.0));
                }
            }
            Shape::Pipe { radius, half } => wall(shell(radius, half, 2.0 * half)),
        }
        text
    }
}
