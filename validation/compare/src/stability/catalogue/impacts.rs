//! Impacts: too fast for the step, with and without restitution, and one scene at steps from a microsecond to a tenth of a
//! second.

use crate::sketch::{GRAVITY, RADIUS, Sketch};
use crate::stability::{Case, Evidence};
use crate::study::Finding;
use makadam::scene::{Motion, NormalLaw, Shape};
use makadam::snapshot::Snapshot;

const NEWTON: &str = "Newton's law of impact";

/// Time step of the impacts that are too fast for it, s.
const STEP: f64 = 5e-4;

/// Speed of a hundred diameters per step, m/s.
const FAST: f64 = 100.0 * 2.0 * RADIUS / STEP;

/// Restitution of walls that are hit fast.
const RESTITUTION: f64 = 0.5;

pub(super) fn cases() -> Vec<Case> {
    let mut cases =
        vec![plane("fast-plane", RESTITUTION, NormalLaw::Hertz), plane("fast-inelastic", 0.0, NormalLaw::Hertz)];
    cases.extend([plane("fast-rigid", RESTITUTION, NormalLaw::Rigid), corner(), disc(), shell(), moving_wall()]);
    cases.push(time_step(1e-6).long());
    cases.extend([1e-5, 1e-4, 1e-3, 1e-2, 1e-1].map(time_step));
    cases.extend([no_restitution(), full_restitution(), bouncing_to_rest(), inelastic_collapse()]);
    cases
}

/// Returns a space in which grains may fly for twenty steps.
fn fast(name: &str) -> Sketch {
    Sketch::new(name, 20.0 * STEP)
        .gravity([0.0; 3])
        .modulus(1e12)
        .friction(0.0)
        .restitution(RESTITUTION)
        .domain([-30.0; 3], [30.0; 3])
        .step(STEP)
        .interval(STEP)
}

/// Returns a case of a fast grain, in which all codes have one time step.
fn impact(
    sketch: Sketch,
    right: impl Into<String>,
    judge: impl Fn(&Evidence<'_>) -> Vec<Finding> + Send + Sync + 'static,
) -> Case {
    Case::new("fast impacts", sketch.scene(), right, NEWTON, judge).at_one_step()
}

fn plane(name: &str, restitution: f64, law: NormalLaw) -> Case {
    let sketch = fast(name).restitution(restitution).with(|scene| scene.solver.normal_law = law).floor().moving_grain(
        RADIUS,
        [0.0, 0.0, 50.5 * 2.0 * RADIUS],
        [0.0, 0.0, -FAST],
        [0.0; 3],
    );
    let right =
        format!("a grain at 100 diameters a step does not pass a plane and leaves at {restitution} of its speed");
    impact(sketch, right, move |evidence| rebound(evidence, [0.0, 0.0, 1.0], restitution))
}

/// Speed along a direction after the impact, and the side of the face on which the grain is.
fn rebound(evidence: &Evidence<'_>, away: [f64; 3], restitution: f64) -> Vec<Finding> {
    let along = |vector: [f64; 3]| vector.iter().zip(away).map(|(a, b)| a * b).sum::<f64>();
    let grain = evidence.grain(0);
    vec![
        Finding::near("speed away from the wall over that before", along(grain.velocity) / FAST, restitution, 0.02),
        Finding::at_least("centre in front of the wall, over the radius", along(grain.position) / RADIUS, 0.99),
    ]
}

fn corner() -> Case {
    let part = FAST / 3.0_f64.sqrt();
    let sketch = fast("fast-corner").open_box([-5.0, -5.0, 0.0], [5.0, 5.0, 10.0]).moving_grain(
        RADIUS,
        [-4.9, -4.9, 0.1],
        [-part; 3],
        [0.0; 3],
    );
    let right = "a grain at 100 diameters a step does not leave a box by its corner";
    impact(sketch, right, move |evidence| {
        let [x, y, z] = evidence.grain(0).position;
        let inside = (x + 5.0).min(5.0 - x).min(y + 5.0).min(5.0 - y).min(z) / RADIUS;
        let slowest = evidence.grain(0).velocity.iter().fold(f64::INFINITY, |least, v| least.min(v.abs())) / part;
        vec![
            Finding::at_least("centre inside the box, over the radius", inside, 0.99),
            Finding::near("least component of the speed over that before", slowest, RESTITUTION, 0.02),
        ]
    })
}

fn disc() -> Case {
    let sketch = fast("fast-disc")
        .wall(Shape::Disc { centre: [0.0; 3], normal: [0.0, 0.0, 1.0], radius: 0.2, hole: 0.0 })
        .moving_grain(RADIUS, [0.01, 0.02, 50.5 * 2.0 * RADIUS], [0.0, 0.0, -FAST], [0.0; 3]);
    let right = "a grain at 100 diameters a step does not pass a disc";
    impact(sketch, right, |evidence| rebound(evidence, [0.0, 0.0, 1.0], RESTITUTION))
}

fn shell() -> Case {
    const WIDE: f64 = 0.6;
    let scene = fast("fast-cylinder")
        .wall(Shape::Cylinder { base: [0.0, -0.5, 0.0], axis: [0.0, 1.0, 0.0], radius: WIDE, length: 1.0 })
        .moving_grain(RADIUS, [0.0, 0.0, 0.1], [0.0, 0.0, -FAST], [0.0; 3])
        .scene();
    let right = "a grain at 100 diameters a step does not pass the shell of a cylinder";
    Case::new("fast impacts", scene, right, "the shell is closed; impacts take energy, none give any", |evidence| {
        let furthest = evidence.frames().iter().map(|frame| {
            let [x, _, z] = frame.particles[0].position;
            x.hypot(z)
        });
        let last = evidence.grain(0).position;
        vec![
            Finding::at_most("distance from the axis at the end over the shell's", last[0].hypot(last[2]) / WIDE, 1.0),
            Finding::at_most(
                "largest distance from the axis, steps",
                furthest.fold(0.0, f64::max) / (FAST * STEP),
                1.2,
            ),
            Finding::at_most("largest speed over that before", evidence.fastest_ever() / FAST, 1.001),
        ]
    })
    .at_one_step()
}

fn moving_wall() -> Case {
    let motion = Motion::Translating { velocity: [0.0, 0.0, FAST], start: 0.0, stop: Some(2.0 * STEP) };
    let sketch = fast("fast-wall")
        .moving_wall(Shape::Plane { point: [0.0, 0.0, -1.0], normal: [0.0, 0.0, 1.0] }, motion)
        .grain(RADIUS, [0.0, 0.0, 0.5]);
    let right = "a plane at 100 diameters a step does not pass a grain, which leaves at 1.5 of its speed";
    impact(sketch, right, |evidence| {
        let grain = evidence.grain(0);
        vec![
            Finding::near("speed over the wall's", grain.velocity[2] / FAST, 1.0 + RESTITUTION, 0.02),
            Finding::at_least("centre in front of the wall, over the radius", (grain.position[2] - 1.0) / RADIUS, 0.99),
        ]
    })
}

fn time_step(step: f64) -> Case {
    let fall = 2.0 * RADIUS;
    let mut sketch = Sketch::new(format!("step-{step:.0e}"), 1.0)
        .step(step)
        .interval(0.1)
        .open_box([-0.03, -0.03, 0.0], [0.03, 0.03, 0.5]);
    for place in 0..8 {
        let at = |bit: i32| f64::from(place >> bit & 1);
        // Slightly off the axis, so that the upper ones roll off.
        let aside = 0.1 * RADIUS * at(2);
        let [x, y] = [0, 1].map(|bit| 2.2 * RADIUS * (at(bit) - 0.5) + aside);
        sketch = sketch.grain(RADIUS, [x, y, RADIUS + fall + 2.2 * RADIUS * at(2)]);
    }
    let drop = fall + 2.2 * RADIUS;
    let fastest = (2.0 * GRAVITY * drop).sqrt() + GRAVITY * step;
    let right = format!("at a step of {step:.0e} s grains fall into a box, gain no energy and come to rest");
    let source = "conservation of energy; the box is closed below; balance of forces";
    Case::new("time steps", sketch.scene(), right, source, move |evidence| {
        // No elastic energy is stored at the start, so kinetic and potential energy alone never exceed their initial sum.
        let energy = |frame: &Snapshot| evidence.mechanical(frame) - evidence.elastic(frame);
        let start = energy(&evidence.frames()[0]);
        let highest = evidence.frames().iter().map(energy).fold(f64::NEG_INFINITY, f64::max);
        let inside = evidence.last().particles.iter().map(|grain| {
            let [x, y, z] = grain.position;
            (0.03 - x.abs()).min(0.03 - y.abs()).min(z) / RADIUS
        });
        vec![
            Finding::at_least("least depth inside the box, radii", inside.fold(f64::INFINITY, f64::min), 0.9),
            Finding::at_most("largest energy over that at the start", highest / start, 1.01),
            Finding::at_most("largest speed over that of free fall", evidence.fastest_ever() / fastest, 1.01),
            Finding::near("force on walls over weight", evidence.carried(0.3), 1.0, 0.05),
            Finding::at_most("largest overlap at the end over the radius", evidence.largest_overlap(0.0), 0.05),
        ]
    })
    .at_one_step()
}

fn no_restitution() -> Case {
    let scene = Sketch::new("restitution-0", 0.5).restitution(0.0).floor().grain(RADIUS, [0.0, 0.0, 0.1]).scene();
    let right = "a ball of restitution 0 does not bounce";
    Case::new("restitution", scene, right, NEWTON, |evidence| {
        let hit = (2.0 * (0.1 - RADIUS) / GRAVITY).sqrt();
        let after = evidence.frames().iter().filter(|frame| frame.time > hit + 0.01);
        let highest = after.map(|frame| frame.particles[0].position[2]).fold(0.0, f64::max);
        vec![Finding::near("highest place after the impact over the radius", highest / RADIUS, 1.0, 0.01)]
    })
}

fn full_restitution() -> Case {
    let drop = 0.1 - RADIUS;
    let scene = Sketch::new("restitution-1", 3.0)
        .restitution(1.0)
        .interval(0.005)
        .floor()
        .grain(RADIUS, [0.0, 0.0, 0.1])
        .scene();
    let right = "a ball of restitution 1 keeps its energy over ten bounces";
    Case::new("restitution", scene, right, "conservation of energy", move |evidence| {
        let start = mass_height(evidence, 0);
        let ratios = (0..evidence.frames().len()).map(|frame| (mass_height(evidence, frame) - start) / drop);
        let (low, high) = ratios.fold((0.0_f64, 0.0_f64), |(low, high), ratio| (low.min(ratio), high.max(ratio)));
        vec![
            Finding::at_most("largest gain of energy over the drop's", high, 0.05),
            Finding::at_least("largest loss of energy over the drop's", low, -0.05),
        ]
    })
}

/// Mechanical energy of a frame of one grain as a height, m.
fn mass_height(evidence: &Evidence<'_>, frame: usize) -> f64 {
    evidence.mechanical(&evidence.frames()[frame]) / (evidence.mass(0) * GRAVITY)
}

fn bouncing_to_rest() -> Case {
    let fall = (2.0 * (0.1 - RADIUS) / GRAVITY).sqrt();
    let end = fall * (1.0 + 0.5) / (1.0 - 0.5);
    let scene = Sketch::new("bouncing-to-rest", 1.2 * end).floor().grain(RADIUS, [0.0, 0.0, 0.1]).scene();
    let right = "the bounces of a ball of restitution 0.5 end after three times the first fall";
    Case::new("restitution", scene, right, "geometric series of the bounces' durations", |evidence| {
        let height = evidence.grain(0).position[2] / RADIUS;
        vec![
            Finding::near("height over the radius at 1.2 times that", height, 1.0, 0.01),
            Finding::at_most("speed at 1.2 times that", evidence.fastest(), 0.01).in_unit("m/s"),
        ]
    })
}

fn inelastic_collapse() -> Case {
    const COUNT: usize = 20;
    let mut sketch = Sketch::new("inelastic-collapse", 0.5).gravity([0.0; 3]).restitution(0.3).moving_grain(
        RADIUS,
        [-0.2, 0.0, 0.4],
        [1.0, 0.0, 0.0],
        [0.0; 3],
    );
    for place in 1..COUNT {
        sketch = sketch.grain(RADIUS, [-0.2 + 2.02 * RADIUS * place as f64, 0.0, 0.4]);
    }
    let source = "McNamara & Young 1992: beyond a number of grains impacts become infinitely many; momentum is kept";
    let right = "20 grains of restitution 0.3 gather, keep their momentum and do not pass through each other";
    Case::new("restitution", sketch.scene(), right, source, |evidence| {
        let (first, last) = (&evidence.frames()[0], evidence.last());
        let kinetic: Vec<f64> = evidence.frames().iter().map(|frame| evidence.kinetic(frame)).collect();
        let rise = kinetic.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max) / kinetic[0];
        let order = last.particles.windows(2).map(|pair| pair[1].position[0] - pair[0].position[0]);
        let momentum = evidence.momentum(last).x / evidence.momentum(first).x;
        vec![
            Finding::near("momentum over that at the start", momentum, 1.0, 1e-6),
            Finding::between(
                "kinetic energy over that at the start",
                kinetic[kinetic.len() - 1] / kinetic[0],
                1.0 / COUNT as f64,
                1.0,
            ),
            Finding::at_most("largest rise of kinetic energy, share", rise, 0.01),
            Finding::at_least(
                "least distance of neighbours, diameters",
                order.fold(f64::INFINITY, f64::min) / (2.0 * RADIUS),
                0.98,
            ),
        ]
    })
}
