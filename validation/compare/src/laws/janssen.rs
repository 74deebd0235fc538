//! Weight of grains in a tube: the part that the floor carries.
//!
//! Grains fill a tube on a floor. In the experiments a slowly sinking piston mobilises friction at the wall, here a slowly rising
//! wall does. The floor then carries the apparent mass `M_a = M_s (1 - exp(-M/M_s))` of the filled mass `M`. This mass
//! saturates at `M_s = rho_b pi R^3 / (2 K mu_w)`, with the bulk density, the tube's radius, the ratio `K` of horizontal to
//! vertical stress and the friction at the wall.

use super::campaign::values;
use super::results::least;
use super::{Case, DIAMETER, Law, Mean, Run, RunError, SPREAD, Values, figure, grains_of};
use crate::sketch::{DENSITY, GRAVITY, Sketch};
use crate::study::Finding;
use makadam::scene::{Motion, Region, Shape};
use makadam::snapshot::{Partner, Snapshot};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{CodeStyle, Marker};
use makadam_view::draw::plot::{Axis, Key, Plot};
use std::f64::consts::PI;

/// Friction of the grains with each other and with the floor.
const FRICTION: f64 = 0.5;
/// Friction of the tube: below that of the grains, so that slip occurs at the wall and not next to it.
const WALL_FRICTION: f64 = 0.3;
/// Friction of a bed of grains of that friction: `tan` of 20.9 degrees, of glass beads (Jop, Forterre & Pouliquen 2006).
const INTERNAL_FRICTION: f64 = 0.38;
/// Speed of the wall, m/s: one diameter per second.
const SPEED: f64 = 0.01;
/// Rise of the wall before forces are measured, in diameters: a constant, and a term per tube diameter of filling. The weight compresses
/// a poured bed, and the rise stretches it by that length before friction at the wall is mobilised down to the floor.
const MOBILISING: [f64; 2] = [0.3, 0.3];
/// Rise of the wall while forces are measured, in diameters.
const MEASURED: f64 = 0.5;
/// Time between two measured frames, s.
const INTERVAL: f64 = 0.01;
/// Time step, s, and sweeps per step: with 10, a filling of four diameters lay a twentieth of the saturated mass below the curve.
const SOLVE: (f64, u32) = (5e-4, 40);
/// Solid fraction for the number of grains.
const SOLID: f64 = 0.58;
/// Indices of the tube and of the floor in the scene.
const TUBE: u32 = 0;
const FLOOR: u32 = 1;
/// Tolerated deviation of an apparent mass, over the saturated one.
const TOLERANCE: f64 = 0.05;

/// Law of the silo's wall.
pub(super) const LAW: Law = Law {
    name: "janssen",
    statement: "the floor of a tube bears M_a = M_s (1 - exp(-M/M_s)) of a mass M, with M_s = rho_b pi R^3 / (2 K mu_w)",
    source: "Janssen, Z. Ver. Dtsch. Ing. 39, 1045 (1895); measured as by Vanel & Clement, Eur. Phys. J. B 11, 525 (1999), with a \
                 moving wall as Landry & Grest, Phys. Rev. E 69, 031303 (2004)",
    cases,
    measure,
    judge,
    figures,
};

/// Apparent mass at a mass, both over the saturated one.
fn law(mass: f64) -> f64 {
    1.0 - (-mass).exp()
}

fn cases(quick: bool) -> Vec<Case> {
    match quick {
        true => [0.5, 1.0, 2.0, 4.0].map(|filling| case(10.0, filling, 1.0)).into(),
        false => {
            let mut cases: Vec<Case> = [0.5, 1.0, 2.0, 3.0, 4.0, 6.0].map(|filling| case(12.0, filling, 1.0)).into();
            cases.push(case(12.0, 2.0, 0.5));
            cases
        }
    }
}

fn measure(case: &Case, run: &mut Run<'_>) -> Result<Values, RunError> {
    let [radius, start, from, speed] = ["radius", "start", "measured_from", "speed_share"].map(|name| case.of(name));
    run.to(start)?;
    let poured = run.frame();
    let solid: f64 = poured.particles.iter().map(|grain| 4.0 / 3.0 * PI * grain.radius.powi(3)).sum();
    let mass = solid * DENSITY;
    let height = poured.particles.iter().map(|grain| 2.0 * grain.radius.powi(3) * grain.position[2]).sum::<f64>()
        / poured.particles.iter().map(|grain| grain.radius.powi(3)).sum::<f64>();
    let before = Loads::of(&poured);
    run.to(from)?;
    let mut loads = Vec::new();
    run.sample(case.scene.duration, INTERVAL / speed, |frame| loads.push(Loads::of(frame)))?;
    let mean = |of: fn(&Loads) -> f64| loads.iter().map(of).sum::<f64>() / loads.len() as f64;
    let floor = mean(|loads| loads.floor);
    let square = loads.iter().map(|loads| (loads.floor - floor).powi(2)).sum::<f64>() / loads.len() as f64;
    let middle = loads.len() / 2;
    let half = |loads: &[Loads]| loads.iter().map(|loads| loads.floor).sum::<f64>() / loads.len() as f64;
    Ok(values([
        ("mass", mass),
        ("height", height),
        ("bulk_density", mass / (PI * radius * radius * height)),
        ("apparent_mass", floor / GRAVITY),
        ("apparent_mass_fluctuation", square.sqrt() / GRAVITY),
        ("apparent_mass_drift", (half(&loads[middle..]) - half(&loads[..middle])) / GRAVITY),
        ("apparent_mass_before", before.floor / GRAVITY),
        ("balance", (floor + mean(|loads| loads.tube)) / (mass * GRAVITY)),
        ("mobilisation", mean(|loads| loads.tube) / (WALL_FRICTION * mean(|loads| loads.pressed))),
    ]))
}

fn judge(means: &[Mean]) -> Vec<Finding> {
    let saturated = saturated(means);
    let deviations = fitted(means).map(|mean| {
        let [mass, apparent] = ["mass", "apparent_mass"].map(|name| mean.of_value(name) / saturated);
        apparent - law(mass)
    });
    // A value that is not a number counts as the largest; `max` would skip it.
    let larger = |a: f64, b: f64| if a >= b.abs() || a.is_nan() { a } else { b.abs() };
    let largest = deviations.fold(0.0, larger);
    let densest = fitted(means).last();
    let density = densest.map_or(f64::NAN, |mean| mean.of_value("bulk_density"));
    let radius = densest.map_or(f64::NAN, |mean| mean.of_value("radius"));
    let ratio = density * PI * radius.powi(3) / (2.0 * WALL_FRICTION * saturated);
    let [active, passive] = rankine(INTERNAL_FRICTION);
    vec![
        Finding::at_most("largest deviation from Janssen's curve over M_s", largest, TOLERANCE),
        Finding::between("K, between Rankine's limits", ratio, active, passive),
        Finding::reported("saturated mass M_s", saturated).in_unit("kg"),
    ]
}

fn figures(means: &[Mean]) -> Vec<Figure> {
    let saturated = saturated(means);
    let scaled = |mean: &Mean, name: &str| mean.of_value(name) / saturated;
    let most = means.iter().map(|mean| scaled(mean, "mass")).fold(1.0, f64::max) * 1.05;
    let own = CodeStyle { class: "code-makadam", marker: Marker::Circle };
    let before = CodeStyle { class: "code-other", marker: Marker::Diamond };
    let keys = [Key::Line("curve neutral", "law"), Key::Points(own, "wall rising"), Key::Points(before, "as poured")];
    let x = Axis::linear("filled mass M/Ms", 0.0, most);
    let mut plot = Plot::with_legend(x, Axis::linear("apparent mass Ma/Ms", 0.0, 1.6), &keys);
    let marks = 80;
    let along = (0..=marks).map(|mark| most * f64::from(mark) / f64::from(marks));
    plot.curve("curve neutral", along.map(|mass| [mass, law(mass)]));
    plot.curve("ideal", [[0.0, 0.0], [1.6, 1.6]].into_iter());
    for mean in means {
        let mass = scaled(mean, "mass");
        plot.open_marker(before, mass, scaled(mean, "apparent_mass_before"), 3.0);
        plot.marker(own, mass, scaled(mean, "apparent_mass"), 4.2);
    }
    vec![figure(
        "apparent-mass",
        plot,
        "Mass that the floor of a tube bears",
        "measured, and Janssen's law with the one fitted mass; straight: all of the weight.",
    )]
}

/// Cases of the curve fit: those at full speed.
fn fitted(means: &[Mean]) -> impl Iterator<Item = &Mean> {
    means.iter().filter(|mean| mean.of_value("speed_share") == 1.0)
}

/// Saturated mass (kg) that brings Janssen's curve nearest to the apparent masses by least squares.
fn saturated(means: &[Mean]) -> f64 {
    let points: Vec<[f64; 2]> =
        fitted(means).map(|mean| ["mass", "apparent_mass"].map(|name| mean.of_value(name))).collect();
    let most = points.iter().map(|point| point[1]).fold(0.0, f64::max);
    let squares =
        |saturated: f64| points.iter().map(|[mass, own]| (own - saturated * law(mass / saturated)).powi(2)).sum();
    least(squares, 0.2 * most, 10.0 * most)
}

/// Smallest and largest ratio of horizontal to vertical stress in a bed of this internal friction: Rankine's active
/// and passive limits, `(1 - sin phi)/(1 + sin phi)` and its inverse.
fn rankine(friction: f64) -> [f64; 2] {
    let sine = friction / (1.0 + friction * friction).sqrt();
    let active = (1.0 - sine) / (1.0 + sine);
    [active, 1.0 / active]
}

/// Loads of the walls in a frame, N.
struct Loads {
    /// Downward force on the floor.
    floor: f64,
    /// Downward force on the tube.
    tube: f64,
    /// Sum of the normal forces on the tube.
    pressed: f64,
}

impl Loads {
    fn of(frame: &Snapshot) -> Loads {
        let mut loads = Loads { floor: 0.0, tube: 0.0, pressed: 0.0 };
        for contact in &frame.contacts {
            let force = contact.force_on_partner();
            match contact.second {
                Partner::Wall(FLOOR) => loads.floor -= force.z,
                Partner::Wall(TUBE) => {
                    loads.tube -= force.z;
                    loads.pressed += contact.normal_force;
                }
                _ => {}
            }
        }
        loads
    }
}

/// Returns a tube of a given number of grain diameters, filled to a height over its own diameter; its wall rises at a fraction of the speed.
fn case(diameters: f64, filling: f64, speed_share: f64) -> Case {
    let radius = 0.5 * diameters * DIAMETER;
    let height = filling * 2.0 * radius;
    let grain = 0.5 * DIAMETER;
    let count = grains_of(SOLID * PI * radius * radius * height);
    // The initial lattice of the grains is less than half as dense as the bed.
    let room = 3.0 * height + 10.0 * DIAMETER;
    let start = 0.4 + 2.5 * (2.0 * height / GRAVITY).sqrt();
    let speed = speed_share * SPEED;
    let from = start + (MOBILISING[0] + MOBILISING[1] * filling) * DIAMETER / speed;
    let up = [0.0, 0.0, 1.0];
    let rising = Motion::Translating { velocity: [0.0, 0.0, speed], start, stop: None };
    let slow = if speed_share == 1.0 { "" } else { "-slow" };
    let beside = radius + DIAMETER;
    let scene = Sketch::new(format!("janssen-{filling}{slow}"), from + MEASURED * DIAMETER / speed)
        .domain([-beside, -beside, -DIAMETER], [beside, beside, room])
        .step(SOLVE.0)
        .sweeps(SOLVE.1)
        .interval(0.05)
        .material("floor", |floor| floor.friction = FRICTION)
        .moving_wall(
            Shape::Cylinder { base: [0.0, 0.0, -2.0 * DIAMETER], axis: up, radius, length: room + 4.0 * DIAMETER },
            rising,
        )
        .with(|scene| scene.description = format!("Grains to {filling} diameters of a tube whose wall rises slowly."))
        .change_material("wall", |wall| wall.friction = WALL_FRICTION)
        .change_material("grain", |grain| grain.friction = FRICTION)
        .named_wall("floor", "floor", Shape::Plane { point: [0.0; 3], normal: up }, Motion::Fixed)
        .polydisperse(
            count,
            [grain, SPREAD],
            Region::Cylinder { base: [0.0; 3], axis: up, radius, length: room },
            0.05,
        );
    let given = [
        ("radius", radius),
        ("filling", filling),
        ("start", start),
        ("measured_from", from),
        ("speed_share", speed_share),
    ];
    Case::new(scene.scene(), given)
}

#[cfg(test)]
#[path = "../../tests/unit/laws_janssen.rs"]
mod tests;
