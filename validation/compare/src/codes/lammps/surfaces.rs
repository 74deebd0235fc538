//! Walls as LAMMPS has them: regions, each with one smooth surface, that variables move.
//!
//! ```text
//! plane      plane, endless                                       one side
//! box        a plane a closed face, endless                       one side
//! cylinder   cylinder, both ends open: a thin shell with rims     two sides
//! disc       cylinder from outside, too short to be seen          two sides
//! ```
//!
//! `fix wall/gran/region` tells of one contact a grain, so that a box is not a `block`: its six surfaces would share that one. Cylinders
//! lie along x, y or z; others are turned about their base by a variable that stays as it is.

use crate::codes::plan::{MotionPhase, Plan};
use makadam::scene::{Grain, Motion, Shape, Wall};
use makadam_frames::plan::Scene;
use nalgebra::{Unit, Vector3};

/// Thickness of a disc over the smallest radius: a centre that lies within it would feel nothing.
const THICKNESS: f64 = 1e-7;

/// Sine of the angle to an axis of coordinates below which a cylinder lies along it.
const ALONG: f64 = 1e-9;

/// One smooth surface of a wall.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    /// Its wall, by its place in the scene.
    pub wall: usize,
    /// Style of the region, and its numbers.
    region: String,
    /// Rotation of the region, if it has one.
    tilt: Option<Tilt>,
}

#[derive(Clone, Debug, PartialEq)]
struct Tilt {
    /// By the right-hand rule, rad.
    angle: f64,
    point: Vector3<f64>,
    axis: Vector3<f64>,
}

/// The surfaces of all walls, in their order; an error says what LAMMPS cannot do.
pub(super) fn surfaces(walls: &[Wall], grains: &[Grain]) -> Result<Vec<Surface>, String> {
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let mut all = Vec::new();
    for (index, wall) in walls.iter().enumerate() {
        let regions = regions(&wall.shape, THICKNESS * smallest)?;
        if regions.iter().any(|(_, tilt)| tilt.is_some()) && matches!(wall.motion, Motion::Rotating { .. }) {
            return Err(format!(
                "its cylinders and discs turn only if they lie along x, y or z; wall '{}' does not",
                wall.name
            ));
        }
        all.extend(regions.into_iter().map(|(region, tilt)| Surface { wall: index, region, tilt }));
    }
    Ok(all)
}

fn regions(shape: &Shape, thickness: f64) -> Result<Vec<(String, Option<Tilt>)>, String> {
    Ok(match shape {
        Shape::Plane { point, normal } => vec![(plane(*point, *normal), None)],
        Shape::Box { min, max, open } => {
            let faces = (0..3).flat_map(|axis| [(axis, "-", 1.0, min), (axis, "+", -1.0, max)]);
            faces
                .filter(|(axis, sign, ..)| {
                    !open.iter().any(|face| *face == format!("{sign}{}", ["x", "y", "z"][*axis]))
                })
                .map(|(axis, _, inwards, corner)| {
                    let mut normal = [0.0; 3];
                    normal[axis] = inwards;
                    (plane(*corner, normal), None)
                })
                .collect()
        }
        Shape::Cylinder { base, axis, radius, length } => {
            let (axis, base) = (Vector3::from(*axis).normalize(), Vector3::from(*base));
            let (numbers, tilt) = cylinder(base, axis, *radius, [0.0, *length]);
            vec![(format!("{numbers} open 1 open 2"), tilt)]
        }
        Shape::Disc { hole, .. } if *hole > 0.0 => return Err("it has no region like a disc with a hole".into()),
        Shape::Disc { centre, normal, radius, .. } => {
            let (normal, centre) = (Vector3::from(*normal).normalize(), Vector3::from(*centre));
            let (numbers, tilt) = cylinder(centre, normal, *radius, [-thickness, 0.0]);
            vec![(format!("{numbers} side out"), tilt)]
        }
        Shape::Spheres { .. } => return Err("a wall is made of spheres".into()),
    })
}

fn plane([x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> String {
    format!("plane {x:.17e} {y:.17e} {z:.17e} {u:.17e} {v:.17e} {w:.17e}")
}

/// A cylinder between two places along its axis, from its base.
fn cylinder(base: Vector3<f64>, axis: Vector3<f64>, radius: f64, ends: [f64; 2]) -> (String, Option<Tilt>) {
    let along = axis.iamax();
    let straight = (1.0 - axis[along] * axis[along]).max(0.0).sqrt() < ALONG;
    let (along, tilt) = if straight { (along, None) } else { (2, Some(Tilt::from_z(base, axis))) };
    let forwards = !straight || axis[along] > 0.0;
    let [low, high] = if forwards { ends } else { [-ends[1], -ends[0]] }.map(|end| base[along] + end);
    // The centre's two coordinates are given in the order of x, y, z.
    let [first, second] = [[1, 2], [0, 2], [0, 1]][along].map(|other| base[other]);
    let name = ["x", "y", "z"][along];
    (format!("cylinder {name} {first:.17e} {second:.17e} {radius:.17e} {low:.17e} {high:.17e}"), tilt)
}

impl Tilt {
    /// Rotation of z to a direction.
    fn from_z(point: Vector3<f64>, direction: Vector3<f64>) -> Tilt {
        let axis = Unit::try_new(Vector3::z().cross(&direction), 0.0).unwrap_or(Vector3::x_axis());
        Tilt { angle: Vector3::z().angle(&direction), point, axis: axis.into_inner() }
    }
}

/// Lines of a deck: the variables that state the poses of the walls, and the regions of the surfaces.
pub(super) fn lines(scene: &Scene, surfaces: &[Surface], plan: &Plan) -> Vec<String> {
    let walls = scene.wall.iter().enumerate();
    let mut lines: Vec<String> = walls.flat_map(|(number, wall)| variables(number, &wall.motion, plan)).collect();
    for (number, surface) in surfaces.iter().enumerate() {
        if let Some(tilt) = &surface.tilt {
            lines.push(format!("variable tilt{number} equal {:.17e}", tilt.angle));
        }
        lines.push(region(number, surface, &scene.wall[surface.wall].motion, plan));
    }
    lines
}

/// Variables that state the pose of a wall; none where it is at rest.
fn variables(wall: usize, motion: &Motion, plan: &Plan) -> Vec<String> {
    let phases = plan.phases(motion);
    if phases.is_empty() {
        return Vec::new();
    }
    let time = format!("{:.17e}*({})", plan.time_step, steps_in(&phases));
    let along = |size: &[f64; 3], of_time: &str| {
        let axes = ["x", "y", "z"].iter().zip(size);
        axes.map(|(axis, size)| format!("variable {axis}{wall} equal ({size:.17e})*{of_time}")).collect()
    };
    match motion {
        Motion::Fixed | Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => Vec::new(),
        Motion::Translating { velocity, .. } => along(velocity, &time),
        Motion::Rotating { rate, .. } => vec![format!("variable turn{wall} equal ({rate:.17e})*{time}")],
        Motion::Vibrating { amplitude, frequency, .. } => {
            let rate = std::f64::consts::TAU * frequency;
            along(amplitude, &format!("sin({rate:.17e}*{time})"))
        }
    }
}

/// Steps for which a wall has moved, less those backwards, as a formula of LAMMPS.
fn steps_in(phases: &[MotionPhase]) -> String {
    let of = |MotionPhase { first, last, direction }: &MotionPhase| {
        let whole = last - first;
        format!("({direction})*((step>{first})*(step<={last})*(step-{first})+(step>{last})*{whole})")
    };
    phases.iter().map(of).collect::<Vec<_>>().join("+")
}

fn region(number: usize, surface: &Surface, motion: &Motion, plan: &Plan) -> String {
    let Surface { wall, region, tilt } = surface;
    let moves = !plan.phases(motion).is_empty();
    let rotate = |variable: String, [x, y, z]: [f64; 3], [a, b, c]: [f64; 3]| {
        format!(" rotate v_{variable} {x:.17e} {y:.17e} {z:.17e} {a:.17e} {b:.17e} {c:.17e}")
    };
    let shifts = matches!(motion, Motion::Translating { .. } | Motion::Vibrating { .. }) && moves;
    let shift = if shifts { format!(" move v_x{wall} v_y{wall} v_z{wall}") } else { String::new() };
    let turn = match (tilt, motion) {
        (Some(tilt), _) => rotate(format!("tilt{number}"), tilt.point.into(), tilt.axis.into()),
        (None, Motion::Rotating { point, axis, .. }) if moves => {
            rotate(format!("turn{wall}"), *point, Vector3::from(*axis).normalize().into())
        }
        (None, _) => String::new(),
    };
    format!("region surface{number} {region} units box{shift}{turn}")
}
