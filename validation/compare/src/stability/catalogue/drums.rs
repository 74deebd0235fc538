//! Drums from creeping to centrifuging, stopped and reversed, and the grain that leaves the shell.

use crate::sketch::{GRAVITY, RADIUS, Sketch, turning};
use crate::stability::{Case, Evidence};
use crate::study::Finding;
use makadam::scene::{Motion, Region, Shape};
use makadam::snapshot::{Particle, Snapshot};

/// Radius of the drums, m: ten grains across.
const WIDE: f64 = 10.0 * RADIUS;

/// Length of the drums, m.
const LONG: f64 = 8.0 * RADIUS;

const COUNT: usize = 120;

const CONTAINED: &str = "a drum is closed; friction of 0.5 holds a bed at 5 to 60 degrees";

pub(super) fn cases() -> Vec<Case> {
    vec![
        rolling(1e-5, 30.0),
        rolling(1e-3, 10.0),
        rolling(1e-1, 5.0),
        critical(),
        centrifuging(),
        creeping_long().long(),
        lone_grain(1.1),
        lone_grain(0.9),
        lone_grain(0.5),
        stopped(),
        reversed(),
    ]
}

/// Angular velocity at a Froude number `omega^2 R/g`, rad/s.
fn rate(froude: f64) -> f64 {
    (froude * GRAVITY / WIDE).sqrt()
}

/// Returns a drum about the y axis, one third full of grains, with end caps.
fn drum(name: String, duration: f64, motion: Motion) -> Sketch {
    let (base, axis) = ([0.0, -0.5 * LONG, 0.0], [0.0, 1.0, 0.0]);
    let cap = |side: f64| Shape::Disc {
        centre: [0.0, 0.5 * side * LONG, 0.0],
        normal: [0.0, -side, 0.0],
        radius: WIDE,
        hole: 0.0,
    };
    Sketch::new(name, duration)
        .domain([-0.06; 3], [0.06; 3])
        .sweeps(20)
        .moving_wall(Shape::Cylinder { base, axis, radius: WIDE, length: LONG }, motion.clone())
        .moving_wall(cap(-1.0), motion.clone())
        .moving_wall(cap(1.0), motion)
        .population(COUNT, RADIUS, Region::Cylinder { base, axis, radius: WIDE, length: LONG })
}

/// Angle by which the centre of mass is turned from the lowest point, in the sense of the drum, degrees.
fn lean(evidence: &Evidence<'_>, frame: &Snapshot) -> f64 {
    let [x, z] = [0, 2].map(|axis| evidence.centre_of_mass(frame, axis));
    (-x).atan2(-z).to_degrees()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// Grains with centres outside the shell or beyond an end cap.
fn escaped(evidence: &Evidence<'_>) -> Finding {
    let outside = evidence.last().particles.iter().filter(|grain| {
        let [x, y, z] = grain.position;
        x.hypot(z) > WIDE || y.abs() > 0.5 * LONG
    });
    Finding::at_most("grains outside the drum", outside.count() as f64, 0.0)
}

fn rolling(froude: f64, duration: f64) -> Case {
    let scene = drum(format!("drum-froude-{froude:.0e}"), duration, turning(rate(froude), None, None)).scene();
    let right = format!("a drum at a Froude number of {froude:.0e} carries its bed up and loses no grain");
    Case::new("drums", scene, right, CONTAINED, move |evidence| rolling_findings(evidence, froude))
}

fn rolling_findings(evidence: &Evidence<'_>, froude: f64) -> Vec<Finding> {
    let ending = evidence.ending(0.3);
    let leaning = mean(ending.iter().map(|frame| lean(evidence, frame)));
    // A grain that falls through the drum reaches the speed of a free fall over its diameter.
    let fastest = rate(froude) * WIDE + (2.0 * GRAVITY * 2.0 * WIDE).sqrt();
    vec![
        Finding::between("lean of the bed", leaning, 5.0, 60.0).in_unit("degrees"),
        escaped(evidence),
        Finding::at_most("largest overlap over the radius", evidence.largest_overlap(0.5), 0.1),
        Finding::at_most("largest speed over that of free fall", evidence.fastest_ever() / fastest, 1.0),
    ]
}

fn creeping_long() -> Case {
    let froude = 1e-5;
    let scene = drum("drum-creeping-long".into(), 100.0, turning(rate(froude), None, None)).interval(1.0).scene();
    let right = "a creeping drum turns by 250 degrees, carries its bed up and loses no grain";
    Case::new("drums", scene, right, CONTAINED, move |evidence| rolling_findings(evidence, froude))
}

fn critical() -> Case {
    let scene = drum("drum-froude-1".into(), 5.0, turning(rate(1.0), None, None)).scene();
    let right = "a drum at a Froude number of 1 throws its grains about and loses none";
    let source = "a drum is closed; no grain outruns shell and free fall";
    Case::new("drums", scene, right, source, |evidence| rolling_findings(evidence, 1.0)[1..].to_vec())
}

fn centrifuging() -> Case {
    let froude = 2.0;
    // Smooth or rolling grains slip or roll back on the rising side, whatever their normal force on the shell.
    let scene = drum("drum-froude-2".into(), 5.0, turning(rate(froude), None, None))
        .friction(2.0)
        // YADE has no other ratio of both.
        .materials(|material| material.rolling_friction = 2.0)
        .change_material("wall", |wall| wall.rolling_friction = 1.5)
        .interval(0.05)
        .scene();
    let right = "a drum at a Froude number of 2 takes grains that neither slip nor roll round with it";
    let source =
        "friction of 2 holds on all the way round where omega^2 r >= g sqrt(1 + 1/4): from 0.56 of the radius on";
    Case::new("drums", scene, right, source, move |evidence| {
        let ending = evidence.ending(0.2);
        let grains = || ending.iter().flat_map(|frame| &frame.particles);
        let turned = mean(grains().map(|grain| {
            let ([x, _, z], [u, _, w]) = (grain.position, grain.velocity);
            (z * u - x * w) / (x * x + z * z) / rate(froude)
        }));
        // A grain that was thrown inwards may fly for some turns before it joins the others.
        let is_far = |grain: &Particle| grain.position[0].hypot(grain.position[2]) > 0.5 * WIDE;
        let held = mean(grains().map(|grain| f64::from(u8::from(is_far(grain)))));
        vec![
            Finding::near("angular velocity of the grains over the drum's", turned, 1.0, 0.05),
            Finding::at_least("share of the grains beyond half the drum's radius", held, 0.95),
            escaped(evidence),
        ]
    })
}

fn lone_grain(froude: f64) -> Case {
    let arm = WIDE - RADIUS;
    let rate = (froude * GRAVITY / arm).sqrt();
    let stays = froude > 1.0;
    // A grain that leaves the shell flies on a parabola that reaches the shell again after this time.
    let flight = 2.0 * ((1.0 - froude).max(0.0) * arm / GRAVITY).sqrt();
    let (duration, right, source) = match stays {
        true => (
            1.0,
            "a grain carried over the top of a drum at omega^2 (R - r) = 1.1 g stays on the shell".to_string(),
            "the shell bears m (v^2/(R - r) - g) at the top, and more elsewhere",
        ),
        false => (
            flight,
            format!("a grain carried over the top of a drum at omega^2 (R - r) = {froude} g lets go and flies"),
            "the parabola's least distance from the axis: (R - r) sqrt(1 - (1 - Fr)^2)",
        ),
    };
    let scene = Sketch::new(format!("drum-lone-grain-{froude}"), duration)
        .domain([-0.06; 3], [0.06; 3])
        .friction(10.0)
        .step(1e-5)
        .interval(duration / 100.0)
        .moving_wall(
            Shape::Cylinder { base: [0.0, -0.05, 0.0], axis: [0.0, 1.0, 0.0], radius: WIDE, length: 0.1 },
            turning(rate, None, None),
        )
        .moving_grain(RADIUS, [0.0, 0.0, arm], [rate * arm, 0.0, 0.0], [0.0, rate, 0.0])
        .scene();
    Case::new("drums", scene, right, source, move |evidence| {
        let gap = |frame: &Snapshot| {
            let [x, _, z] = frame.particles[0].position;
            arm - x.hypot(z)
        };
        let widest = evidence.frames().iter().map(gap).fold(f64::NEG_INFINITY, f64::max);
        let flown = arm * (1.0 - (1.0 - (1.0 - froude).powi(2)).sqrt());
        match stays {
            true => vec![Finding::at_most("widest gap over the radius", widest / RADIUS, 0.01)],
            false => vec![Finding::near("widest gap over that of the flight", widest / flown, 1.0, 0.05)],
        }
    })
}

fn stopped() -> Case {
    let scene = drum("drum-stopped".into(), 6.0, turning(1.0, Some(4.0), None)).scene();
    let right = "a drum that stops leaves its bed leaning, at rest";
    Case::new("drums", scene, right, CONTAINED, |evidence| {
        let leaning = lean(evidence, evidence.last());
        vec![
            Finding::at_most("largest speed at the end", evidence.fastest(), 0.01).in_unit("m/s"),
            Finding::between("lean of the bed", leaning, 5.0, 60.0).in_unit("degrees"),
            escaped(evidence),
        ]
    })
}

fn reversed() -> Case {
    let scene = drum("drum-reversed".into(), 10.0, turning(1.0, None, Some(5.0))).interval(0.1).scene();
    let right = "a drum that is reversed leans its bed as far to the other side";
    Case::new("drums", scene, right, "mirror symmetry", |evidence| {
        let over = |from: f64, to: f64| {
            let frames = evidence.frames().iter().filter(|frame| frame.time > from && frame.time < to);
            mean(frames.map(|frame| lean(evidence, frame)))
        };
        let (forth, back) = (over(2.0, 4.95), over(7.0, 10.01));
        vec![
            Finding::between("lean of the bed before", forth, 5.0, 60.0).in_unit("degrees"),
            Finding::near("lean after over lean before", back / forth, -1.0, 0.2),
            escaped(evidence),
        ]
    })
}
