//! Single contacts at their limits: friction, seams, curved walls, gaps that close, walls that stop.

use crate::sketch::{GRAVITY, RADIUS, Sketch, hertz_force, hertz_overlap, mass};
use crate::stability::Case;
use crate::study::Finding;
use makadam::scene::{Motion, NormalLaw, Shape};
use std::f64::consts::TAU;

pub(super) fn cases() -> Vec<Case> {
    vec![
        incline("friction-0", 30.0, 0.0),
        incline("friction-1e6", 60.0, 1e6),
        pyramid(),
        seam("seam-of-triangles", -0.4, &[Shape::Box { min: [-0.4; 3], max: [0.4; 3], open: vec!["+z".into()] }]),
        seam("seam-of-discs", 0.0, &[disc(-0.15), disc(0.15)]),
        around_a_cylinder("cylinder-rolling", 10.0, 7.0 / 5.0),
        around_a_cylinder("cylinder-sliding", 0.0, 1.0),
        wedge(),
        impossible_gap(NormalLaw::Hertz),
        impossible_gap(NormalLaw::Rigid),
        wall_that_stops(),
    ]
}

fn incline(name: &str, degrees: f64, friction: f64) -> Case {
    let (sine, cosine) = f64::to_radians(degrees).sin_cos();
    let height = RADIUS - hertz_overlap(mass(RADIUS) * GRAVITY * cosine, [1e7; 2], RADIUS);
    let scene = Sketch::new(name, 0.3)
        .gravity([GRAVITY * sine, 0.0, -GRAVITY * cosine])
        .friction(friction)
        .floor()
        .grain(RADIUS, [-0.4, 0.0, height])
        .scene();
    let (share, target, right) = match friction == 0.0 {
        true => (1.0, 0.0, format!("a smooth ball slides down {degrees} degrees without spin")),
        false => (5.0 / 7.0, 1.0, format!("a ball of friction 1e6 rolls down {degrees} degrees without slip")),
    };
    Case::new("friction", scene, right, "acceleration g sin(theta), times 5/7 for a rolling ball", move |evidence| {
        let grain = evidence.grain(0);
        let rolling = RADIUS * grain.spin[1] / grain.velocity[0];
        vec![
            Finding::near("speed over that of the law", grain.velocity[0] / (share * GRAVITY * sine * 0.3), 1.0, 0.01),
            Finding::near("surface speed over speed", rolling, target, 0.01),
        ]
    })
}

fn pyramid() -> Case {
    let side = 2.0 * RADIUS;
    let from_axis = side / 3.0_f64.sqrt();
    let top = RADIUS + (side * side - from_axis * from_axis).sqrt();
    let mut sketch = Sketch::new("friction-1e6-pyramid", 0.5).friction(1e6).floor();
    for corner in 0..3 {
        let (sine, cosine) = (TAU * f64::from(corner) / 3.0).sin_cos();
        sketch = sketch.grain(RADIUS, [from_axis * cosine, from_axis * sine, RADIUS]);
    }
    let right = "a pyramid of friction 1e6 stands";
    let source = "it stands above a friction of 0.318 between grains and 0.079 on the ground";
    Case::new("friction", sketch.grain(RADIUS, [0.0, 0.0, top]).scene(), right, source, move |evidence| {
        vec![
            Finding::at_most("top sunk over the radius", (top - evidence.grain(3).position[2]) / RADIUS, 0.01),
            Finding::near("force on walls over weight", evidence.carried(0.1), 1.0, 0.01),
        ]
    })
}

fn disc(x: f64) -> Shape {
    Shape::Disc { centre: [x, 0.0, 0.0], normal: [0.0, 0.0, 1.0], radius: 0.2, hole: 0.0 }
}

fn seam(name: &str, level: f64, faces: &[Shape]) -> Case {
    const SPEED: f64 = 0.5;
    let height = level + RADIUS - hertz_overlap(mass(RADIUS) * GRAVITY, [1e7; 2], RADIUS);
    let spin = [0.0, SPEED / RADIUS, 0.0];
    let sketch = Sketch::new(name, 0.5)
        .domain([-0.5; 3], [0.5; 3])
        .interval(0.0025)
        // Off the middle, so that the grain does not cross the seam at a corner.
        .moving_grain(RADIUS, [-0.125, 0.013, height], [SPEED, 0.0, 0.0], spin);
    let scene = faces.iter().fold(sketch, |sketch, face| sketch.wall(face.clone())).scene();
    let right = "a ball that rolls over a seam between two faces of one height keeps its speed and its height";
    Case::new("seams and curved walls", scene, right, "rolling without slip on a plane does no work", move |evidence| {
        let grain = evidence.grain(0);
        let heights = evidence.frames().iter().map(|frame| (frame.particles[0].position[2] - height).abs());
        vec![
            Finding::near("speed over that at the start", grain.velocity[0] / SPEED, 1.0, 0.01),
            Finding::at_most("largest change of height over the radius", heights.fold(0.0, f64::max) / RADIUS, 0.01),
            Finding::at_most("speed aside over that along", grain.velocity[1].abs() / SPEED, 0.01),
        ]
    })
}

fn around_a_cylinder(name: &str, friction: f64, inertia: f64) -> Case {
    const WIDE: f64 = 0.05;
    let swing = 10_f64.to_radians();
    let (sine, cosine) = swing.sin_cos();
    let arm = WIDE - RADIUS;
    let overlap = hertz_overlap(mass(RADIUS) * GRAVITY, [1e7; 2], RADIUS);
    // Finite-amplitude correction: theta^2/16 of the period.
    let period = TAU * (inertia * (arm + overlap) / GRAVITY).sqrt() * (1.0 + swing * swing / 16.0);
    let scene = Sketch::new(name, 3.0 * period)
        .friction(friction)
        .wall(Shape::Cylinder { base: [0.0, -0.05, 0.0], axis: [0.0, 1.0, 0.0], radius: WIDE, length: 0.1 })
        .grain(RADIUS, [(arm + overlap) * sine, 0.0, -(arm + overlap) * cosine])
        .scene();
    let right = match friction > 0.0 {
        true => "a ball that rolls in a cylinder is back where it started after three swings",
        false => "a smooth ball that slides in a cylinder is back where it started after three swings",
    };
    let source = "period 2 pi sqrt(7 (R - r)/(5 g)) of a rolling, 2 pi sqrt((R - r)/g) of a sliding ball";
    Case::new("seams and curved walls", scene, right, source, move |evidence| {
        let [x, y, z] = evidence.grain(0).position;
        let furthest = evidence.frames().iter().map(|frame| {
            let [x, _, z] = frame.particles[0].position;
            (x.hypot(z) - arm - overlap).abs()
        });
        vec![
            Finding::near("angle after three swings over that at the start", x.atan2(-z) / swing, 1.0, 0.05),
            Finding::at_most("way off the cylinder over the radius", furthest.fold(0.0, f64::max) / RADIUS, 0.02),
            Finding::at_most("way along the axis over the radius", y.abs() / RADIUS, 0.01),
        ]
    })
}

/// Returns a grain between two planes that approach each other to less than its diameter.
fn closing(name: &str, gap: f64) -> Sketch {
    const SPEED: f64 = 0.1;
    let stop = (3.0 * RADIUS - gap) / SPEED;
    let motion = Motion::Translating { velocity: [0.0, 0.0, -SPEED], start: 0.0, stop: Some(stop) };
    Sketch::new(name, 0.5)
        .gravity([0.0; 3])
        .floor()
        .moving_wall(Shape::Plane { point: [0.0, 0.0, 3.0 * RADIUS], normal: [0.0, 0.0, -1.0] }, motion)
        .grain(RADIUS, [0.0, 0.0, RADIUS])
}

fn wedge() -> Case {
    let gap = 1.8 * RADIUS;
    let force = hertz_force(RADIUS - 0.5 * gap, [1e7; 2], RADIUS);
    let right = "a grain in a gap of nine tenths of its diameter bears Hertz's force and stays in the middle";
    Case::new(
        "moving walls",
        closing("wedge", gap).scene(),
        right,
        "Hertz's law at an overlap of a tenth of the radius",
        move |evidence| {
            let place = (evidence.grain(0).position[2] - 0.5 * gap) / RADIUS;
            let both = [0, 1].map(|wall| evidence.force_on_wall(wall, 0.1).norm() / force);
            vec![
                Finding::near("force on the fixed wall over Hertz's", both[0], 1.0, 0.02),
                Finding::near("force on the moving wall over Hertz's", both[1], 1.0, 0.02),
                Finding::near("place beside the middle over the radius", place, 0.0, 0.01),
                Finding::at_most("speed at the end", evidence.fastest(), 1e-3).in_unit("m/s"),
            ]
        },
    )
}

fn impossible_gap(law: NormalLaw) -> Case {
    let name = if law == NormalLaw::Rigid { "impossible-gap-rigid" } else { "impossible-gap" };
    let scene = closing(name, 0.0).with(|scene| scene.solver.normal_law = law).scene();
    let right = "a grain between walls that close altogether stays there under a bounded force";
    let (bound, source) = match law {
        NormalLaw::Rigid => (
            mass(RADIUS) * 2.0 * RADIUS / (scene.solver.step * scene.solver.step),
            "no force is right; one that would move the grain by its diameter in a step is the bound",
        ),
        _ => (
            2.0 * hertz_force(RADIUS, [1e7; 2], RADIUS),
            "Hertz's law at an overlap of the radius, and as much again for the approach",
        ),
    };
    Case::new("moving walls", scene, right, source, move |evidence| {
        let forces = evidence.frames().iter().flat_map(|frame| &frame.contacts).map(|contact| contact.normal_force);
        let place = evidence.grain(0).position[2] / RADIUS;
        vec![
            Finding::between("largest force over that bound", forces.fold(0.0, f64::max) / bound, 0.0, 1.0),
            Finding::near("place beside the middle over the radius", place, 0.0, 0.1),
            Finding::at_most("speed at the end", evidence.fastest(), 0.1).in_unit("m/s"),
        ]
    })
}

fn wall_that_stops() -> Case {
    const SPEED: f64 = 1.0;
    let motion = Motion::Translating { velocity: [0.0, 0.0, SPEED], start: 0.0, stop: Some(0.2) };
    let height = RADIUS - hertz_overlap(mass(RADIUS) * GRAVITY, [1e7; 2], RADIUS);
    let scene = Sketch::new("wall-stops-dead", 1.0)
        .interval(0.005)
        .moving_wall(Shape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] }, motion)
        .moving_grain(RADIUS, [0.0, 0.0, height], [0.0, 0.0, SPEED], [0.0; 3])
        .scene();
    let right = "a grain on a floor that rises and stops dead flies on, falls back and comes to rest";
    Case::new("moving walls", scene, right, "a throw of v^2/(2 g)", |evidence| {
        let highest = evidence.frames().iter().map(|frame| frame.particles[0].position[2]).fold(0.0, f64::max);
        let throw = SPEED * SPEED / (2.0 * GRAVITY);
        vec![
            Finding::near("height of the throw over v^2/(2 g)", (highest - 0.2 - RADIUS) / throw, 1.0, 0.02),
            Finding::near(
                "height at the end over the radius",
                (evidence.grain(0).position[2] - 0.2) / RADIUS,
                1.0,
                0.01,
            ),
        ]
    })
}
