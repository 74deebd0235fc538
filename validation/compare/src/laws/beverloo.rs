//! Outflow from a silo: mass flow of grains through a round hole in its flat floor.
//!
//! The mass flow does not depend on the filling, and goes as `W = C rho_b sqrt(g) (D - k d)^(5/2)` with the hole's diameter `D`.
//! Grains fall freely from an arch of the hole's width, and their centres stay at a distance from its rim.

use super::campaign::values;
use super::results::line;
use super::{Case, DIAMETER, Law, Mean, Run, RunError, SPREAD, Values, figure, grains_of};
use crate::sketch::{DENSITY, GRAVITY, Sketch};
use crate::study::Finding;
use makadam::scene::{Motion, Reaction, Region, Shape};
use makadam::snapshot::{Particle, Snapshot};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{CodeStyle, Marker};
use makadam_view::draw::plot::{Axis, Key, Plot};
use std::f64::consts::PI;

/// Friction of the grains and of all walls.
const FRICTION: f64 = 0.5;
/// Least diameter of the silo: over the hole's, and over the grains'. In narrower silos the wall affects the flow.
const SILO: [f64; 2] = [2.5, 20.0];
/// Filling at the start, and the minimum while the flow is measured, over the silo's diameter.
const FILLING: [f64; 2] = [1.6, 1.2];
/// Time from the opening until the flow is steady, and longest time of measurement, s.
const TIMES: [f64; 2] = [0.3, 1.2];
/// Time between two measured frames, s.
const INTERVAL: f64 = 0.02;
/// Depth of the plane below the floor on which grains land, in grain diameters.
const DEPTH: f64 = 60.0;
/// Speed at which the lid of the hole falls away, m/s: ahead of the grains, which reach 3.4 m/s.
const LID: f64 = 6.0;
/// Time step, s, and sweeps per step. With twice the step the flow of small holes is a twentieth too low, and the exponent is 2.6.
const SOLVE: (f64, u32) = (5e-4, 10);
/// Solid fraction for the number of grains.
const SOLID: f64 = 0.58;
/// Published values of C, k and the exponent; the tolerated deviation of the exponent.
const C: f64 = 0.58;
const K: f64 = 1.4;
const EXPONENT: f64 = 2.5;
const TOLERANCE: f64 = 0.1;

/// Law of the silo's outflow.
pub(super) const LAW: Law = Law {
    name: "beverloo",
    statement: "a hole of diameter D in the floor of a silo lets pass W = C rho_b sqrt(g) (D - k d)^2.5, with C = 0.58 and k = 1.4",
    source: "Beverloo, Leniger & van de Velde, Chem. Eng. Sci. 15, 260 (1961); Nedderman, Statics and Kinematics of Granular \
                 Materials (1992), chapter 10",
    cases,
    measure,
    judge,
    figures,
};

/// Flow over `rho_b sqrt(g) d^(5/2)` through a hole of the given number of grain diameters.
fn law(hole: f64) -> f64 {
    C * (hole - K).max(0.0).powf(EXPONENT)
}

fn cases(quick: bool) -> Vec<Case> {
    match quick {
        // Narrower than the law requires: 14 grain diameters.
        true => [4.5, 5.5].map(|hole| case(hole, 14.0)).into(),
        false => [6.0, 8.0, 10.0, 12.0].map(|hole| case(hole, SILO[1])).into(),
    }
}

fn measure(case: &Case, run: &mut Run<'_>) -> Result<Values, RunError> {
    let (silo, open) = (case.of("silo"), case.of("open"));
    run.to(open)?;
    let (at_rest, filled) = (bulk_density(&run.frame(), silo), filling(&run.frame(), silo));
    run.to(open + TIMES[0])?;
    let (mut flow, mut flowing, mut least) = (Vec::new(), Vec::new(), filled);
    let end = open + TIMES[0] + TIMES[1];
    while least > FILLING[1] && !run.has_reached(end) {
        run.sample((run.time() + INTERVAL).min(end), INTERVAL, |frame| {
            flow.push([frame.time, passed(frame)]);
            flowing.push(bulk_density(frame, silo));
            least = filling(frame, silo);
        })?;
    }
    let (rate, _) = line(&flow);
    let half = |flow: &[[f64; 2]]| line(flow).0;
    let middle = flow.len() / 2;
    let scale = at_rest * GRAVITY.sqrt() * DIAMETER.powf(2.5);
    Ok(values([
        ("flow", rate),
        ("flow_scaled", rate / scale),
        ("flow_second_over_first_half", half(&flow[middle..]) / half(&flow[..middle])),
        ("passed", flow.last().map_or(0.0, |last| last[1]) / grain_mass()),
        ("seconds_measured", run.time() - open - TIMES[0]),
        ("bulk_density", at_rest),
        ("bulk_density_flowing", flowing.iter().sum::<f64>() / flowing.len() as f64),
        ("filling_at_start", filled),
        ("filling_at_end", least),
    ]))
}

fn judge(means: &[Mean]) -> Vec<Finding> {
    let fit = Fit::of(means);
    vec![
        Finding::near("exponent, with k = 1.4", fit.exponent, EXPONENT, TOLERANCE),
        Finding::reported("C, with k = 1.4 and the exponent 2.5 (published: 0.58)", fit.c),
        Finding::reported("k, with the exponent 2.5 (published: 1.4)", fit.free[1]),
        Finding::reported("  C of that fit", fit.free[0]),
    ]
}

fn figures(means: &[Mean]) -> Vec<Figure> {
    let holes: Vec<f64> = means.iter().map(|mean| mean.of_value("hole")).collect();
    let most = 1.1 * holes.iter().copied().fold(2.0, f64::max);
    let flow = |scaled: f64| scaled.powf(1.0 / EXPONENT);
    let own = CodeStyle { class: "code-makadam", marker: Marker::Circle };
    let keys = [Key::Line("curve neutral", "law"), Key::Points(own, "measured")];
    let x = Axis::linear("diameter of the hole D/d", 0.0, most);
    let y = Axis::linear("(W / ρ g^½ d^5/2)^2/5", 0.0, 1.1 * flow(law(most)));
    let mut plot = Plot::with_legend(x, y, &keys);
    plot.curve("curve neutral", [K, most].into_iter().map(|hole| [hole, flow(law(hole))]));
    for mean in means {
        plot.marker(own, mean.of_value("hole"), flow(mean.of_value("flow_scaled")), 4.2);
    }
    vec![figure(
        "outflow",
        plot,
        "Outflow from a silo",
        "measured, and Beverloo's law with C = 0.58 and k = 1.4, a straight line here.",
    )]
}

/// Fits to the flows.
struct Fit {
    /// Exponent of `D - k d` with the published k.
    exponent: f64,
    /// C with the published k and exponent.
    c: f64,
    /// C and k with the published exponent.
    free: [f64; 2],
}

impl Fit {
    fn of(means: &[Mean]) -> Fit {
        let flows: Vec<[f64; 2]> =
            means.iter().map(|mean| ["hole", "flow_scaled"].map(|name| mean.of_value(name))).collect();
        let logarithms: Vec<[f64; 2]> = flows.iter().map(|[hole, flow]| [(hole - K).ln(), flow.ln()]).collect();
        let (exponent, _) = line(&logarithms);
        let offset = logarithms.iter().map(|[x, y]| y - EXPONENT * x).sum::<f64>() / logarithms.len() as f64;
        // W^(2/5) is linear in D: C^(2/5) (D - k d).
        let roots: Vec<[f64; 2]> = flows.iter().map(|[hole, flow]| [*hole, flow.powf(1.0 / EXPONENT)]).collect();
        let (slope, intercept) = line(&roots);
        Fit { exponent, c: offset.exp(), free: [slope.powf(EXPONENT), -intercept / slope] }
    }
}

fn grain_mass() -> f64 {
    DENSITY * (PI / 6.0 * DIAMETER.powi(3) * (1.0 + SPREAD * SPREAD))
}

fn mass(grain: &Particle) -> f64 {
    DENSITY * 4.0 / 3.0 * PI * grain.radius.powi(3)
}

fn distance(grain: &Particle) -> f64 {
    grain.position[0].hypot(grain.position[1])
}

/// Mass below the floor, kg.
fn passed(frame: &Snapshot) -> f64 {
    frame.particles.iter().filter(|grain| grain.position[2] < 0.0).map(mass).sum()
}

/// Mass of the grains over the volume in the bulk (kg/m3): two grain diameters from the wall, at heights from 0.4 to 0.9
/// diameters of the silo.
fn bulk_density(frame: &Snapshot, silo: f64) -> f64 {
    let (radius, low, high) = (0.5 * silo - 2.0 * DIAMETER, 0.4 * silo, 0.9 * silo);
    let inside = |grain: &&Particle| distance(grain) < radius && (low..high).contains(&grain.position[2]);
    frame.particles.iter().filter(inside).map(mass).sum::<f64>() / (PI * radius * radius * (high - low))
}

/// Height of the filling over the silo's diameter: 99% of the grains in the silo lie below it.
fn filling(frame: &Snapshot, silo: f64) -> f64 {
    let inside = frame.particles.iter().map(|grain| grain.position[2]).filter(|&height| height > 0.0);
    let mut heights: Vec<f64> = inside.collect();
    heights.sort_by(f64::total_cmp);
    heights.get(heights.len() * 99 / 100).map_or(0.0, |height| height / silo)
}

/// Returns a silo of at least `least` grain diameters with a hole of `hole` grain diameters.
fn case(hole: f64, least: f64) -> Case {
    let silo = (SILO[0] * hole).max(least) * DIAMETER;
    let (radius, height, grain) = (0.5 * silo, FILLING[0] * silo, 0.5 * DIAMETER);
    let count = grains_of(SOLID * PI * radius * radius * height);
    // The initial lattice of the grains is less than half as dense as the bed.
    let room = 3.0 * height + 10.0 * DIAMETER;
    let open = 0.4 + 2.0 * (2.0 * height / GRAVITY).sqrt();
    let (up, below) = ([0.0, 0.0, 1.0], -DEPTH * DIAMETER);
    let beside = (radius + 2.0 * DIAMETER).max(0.8 * DEPTH * DIAMETER);
    let lid = Motion::Translating { velocity: [0.0, 0.0, -LID], start: open, stop: None };
    let opening = 0.5 * hole * DIAMETER;
    let disc = |radius: f64, hole: f64| Shape::Disc { centre: [0.0; 3], normal: up, radius, hole };
    let scene = Sketch::new(format!("beverloo-{hole}"), open + TIMES[0] + TIMES[1])
        .domain([-beside, -beside, below - DIAMETER], [beside, beside, room])
        .friction(FRICTION)
        .step(SOLVE.0)
        .sweeps(SOLVE.1)
        .interval(0.05)
        .wall(Shape::Cylinder { base: [0.0; 3], axis: up, radius, length: room })
        .with(|scene| {
            scene.description = format!("A silo of {} grain diameters with a hole of {hole}.", silo / DIAMETER)
        })
        // Grains below the floor may roll away.
        .with(|scene| scene.watch.on_escape = Reaction::Ignore)
        .named_wall("floor", "wall", disc(radius + DIAMETER, opening), Motion::Fixed)
        .named_wall("lid", "wall", disc(opening, 0.0), lid)
        .named_wall("ground", "wall", Shape::Plane { point: [0.0, 0.0, below], normal: up }, Motion::Fixed)
        .polydisperse(
            count,
            [grain, SPREAD],
            Region::Cylinder { base: [0.0; 3], axis: up, radius, length: room },
            0.05,
        );
    Case::new(scene.scene(), [("hole", hole), ("silo", silo), ("open", open)])
}

#[cfg(test)]
#[path = "../../tests/unit/laws_beverloo.rs"]
mod tests;
