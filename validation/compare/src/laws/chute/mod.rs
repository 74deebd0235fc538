//! Layer that flows down a rough, endless chute: Bagnold's velocity profile, and the friction law mu(I).
//!
//! In a steady, uniform flow the stresses at a depth D are those of the weight above it, `P = rho phi g D cos(angle)` and
//! `tau = P tan(angle)`. So the friction `mu = tau/P` is the same everywhere. So is the inertial number
//! `I = (dv/dz) d sqrt(rho/P)` if friction depends on it alone. Then `dv/dz` goes as `sqrt(D)` and the velocity as
//! `v = v_s - A D^(3/2)`: Bagnold's profile. Depth is the amount of solid above a point, so that it needs no surface.
//!
//! Two pressures are in use. On a chute `P` is the normal stress on planes along it, as above. For evenly sheared spheres,
//! Chialvo, Sun & Sundaresan use the mean of the three normal stresses. The two differ, since the stress across the chute is less
//! than the other two. So friction and inertial number are measured with either, and tested with that of the law.

mod nonlocal;
mod profile;

use self::profile::Profile;
use super::campaign::values;
use super::{Case, DIAMETER, Law, Mean, Run, RunError, SPREAD, Values, figure, grains_of};
use crate::sketch::{GRAVITY, Sketch};
use crate::study::Finding;
use makadam::scene::{Axis as Periodic, Motion, Region, Shape};
use makadam::snapshot::{Partner, Snapshot};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{CodeStyle, Marker};
use makadam_view::draw::plot::{Axis, Key, Plot};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Friction and restitution of grains and bed: those of Silbert et al. (2001).
const FRICTION: f64 = 0.5;
const RESTITUTION: f64 = 0.88;
/// Young's modulus, Pa: a ten thousandth of the modulus exceeds the pressure at the bed.
const MODULUS: f64 = 1e8;
/// Periods along the chute and across it, in diameters.
const PERIOD: [f64; 2] = [12.0, 8.0];
/// Time step, s, and sweeps per step. Twice the step lets the lower half of a fast layer shear too readily, and the more so at higher
/// shear rates, which bends the profile. The steepest case is repeated with twice the step, and reported.
const SOLVE: (f64, u32) = (1.25e-4, 10);
/// Time between frames, s.
const INTERVAL: f64 = 0.02;
/// Exponent of the depth in Bagnold's profile.
const BAGNOLD: f64 = 1.5;
/// Tolerated deviations of the exponent and of the friction.
const TOLERANCE: (f64, f64) = (0.1, 0.02);

/// Amount of grains, and times of measurement.
#[derive(Clone, Copy)]
struct Layer {
    /// Depth, in diameters at a solid fraction of 0.57.
    depth: f64,
    /// Start and end of measurement, s: a deep layer accelerates for a long time.
    measured: [f64; 2],
}

/// Depth of the layers of Silbert et al.: near the depth at which flow stops on a slope, a layer has a straighter profile.
const DEEP: Layer = Layer { depth: 40.0, measured: [60.0, 70.0] };
const SHALLOW: Layer = Layer { depth: 18.0, measured: [20.0, 28.0] };

/// Laws of flow down a chute.
pub(super) const LAW: Law = Law {
    name: "chute",
    statement: "a layer of spheres on a rough chute flows at v = v_s - A D^(3/2) with the depth D, and its friction is \
                 mu(I) = 0.382 + 0.37 / ((0.32/I)^1.5 + 1)",
    source: "Bagnold, Proc. R. Soc. A 225, 49 (1954); Silbert et al., Phys. Rev. E 64, 051302 (2001); Chialvo, Sun & Sundaresan, Phys. Rev. \
                 E 85, 021305 (2012); of beads: Jop, Forterre & Pouliquen, Nature 441, 727 (2006); near the slope at which a layer stops: Kamrin & \
                 Henann, Soft Matter 11, 179 (2015)",
    cases,
    measure,
    judge,
    figures,
};

/// Friction at an inertial number of evenly sheared spheres with a friction of 0.5 (Chialvo, Sun & Sundaresan 2012, the inertial
/// part of their model).
fn friction(inertial: f64) -> f64 {
    0.382 + 0.37 / ((0.32 / inertial).powf(1.5) + 1.0)
}

/// Angles (degrees) whose tangents are the least and the largest friction of glass beads (Jop, Forterre & Pouliquen 2006).
const BEADS: [f64; 2] = [20.9, 32.76];
/// Inertial number of glass beads at the mean of both.
const INERTIAL_OF_BEADS: f64 = 0.279;

/// Friction of glass beads in experiments. The beads are not perfect spheres.
fn friction_of_beads(inertial: f64) -> f64 {
    let [least, most] = BEADS.map(|angle| angle.to_radians().tan());
    least + (most - least) / (INERTIAL_OF_BEADS / inertial + 1.0)
}

fn cases(quick: bool) -> Vec<Case> {
    match quick {
        true => vec![case(23.0, SHALLOW, 4.0)],
        false => [(22.0, 1.0), (23.0, 1.0), (24.0, 1.0), (25.0, 1.0), (25.0, 2.0)]
            .map(|(angle, coarseness)| case(angle, DEEP, coarseness))
            .into(),
    }
}

fn measure(case: &Case, run: &mut Run<'_>) -> Result<Values, RunError> {
    let (angle, [from, until]) = (case.of("angle").to_radians(), [case.of("from"), case.of("until")]);
    run.to(from)?;
    let (mut profile, mut bed, mut halves) = (Profile::default(), [0.0; 3], [0.0; 2]);
    run.sample(until, INTERVAL, |frame| {
        profile.add(frame);
        let force = force_on_walls(frame);
        (0..3).for_each(|axis| bed[axis] += force[axis]);
        halves[usize::from(frame.time > 0.5 * (from + until))] += kinetic(frame);
    })?;
    let fit = profile.fit();
    let inertial = 1.5 * fit.bagnold * DIAMETER / (fit.solid_fraction * GRAVITY * angle.cos()).sqrt();
    let (normal, pressure) = (fit.stress.normal, fit.stress.pressure());
    let inertial_of_pressure = inertial * (normal / pressure).sqrt();
    Ok(values([
        ("solid_fraction", fit.solid_fraction),
        ("depth_in_diameters", fit.depth / DIAMETER),
        ("surface_speed", fit.surface_speed),
        ("exponent", fit.exponent),
        ("inertial_number", inertial),
        ("friction", -bed[0] / bed[2]),
        ("friction_of_beads", friction_of_beads(inertial)),
        ("inertial_number_of_pressure", inertial_of_pressure),
        ("friction_of_pressure", fit.stress.shear / pressure),
        ("published_friction", friction(inertial_of_pressure)),
        ("shear_over_normal_stress", fit.stress.shear / normal),
        ("along_over_normal_stress", fit.stress.along / normal),
        ("across_over_normal_stress", fit.stress.across / normal),
        ("kinetic_energy_later_over_earlier", halves[1] / halves[0]),
    ]))
}

fn judge(means: &[Mean]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let words = |mean: &Mean| match (mean.of_value("angle"), mean.of_value("coarseness")) {
        (angle, 1.0) => format!("{angle} degrees"),
        (angle, times) => format!("{angle} degrees, {times} times the step"),
    };
    for mean in means {
        let (at, judged) = (words(mean), !repeats(mean, means));
        let mut judge = |what: String, value: f64, published: f64, tolerance: f64, judged: bool| {
            findings.push(match judged {
                true => Finding::near(what, value, published, tolerance),
                false => Finding::reported(what, value),
            });
        };
        let nonlocal = nonlocal::exponent(mean.of_value("angle"), mean.of_value("depth_in_diameters"));
        // Near the slope at which a layer stops, the theory leaves the range of Bagnold's law.
        let in_range = (nonlocal - BAGNOLD).abs() <= TOLERANCE.0;
        let range = if in_range { "" } else { ", outside the range of Bagnold's law" };
        let exponent = mean.of_value("exponent");
        let what = format!("exponent of the velocity profile at {at}{range}");
        judge(what, exponent, BAGNOLD, TOLERANCE.0, judged && in_range);
        let what = format!("exponent less that of the nonlocal theory at {at}");
        judge(what, exponent - nonlocal, 0.0, TOLERANCE.0, judged);
        let beyond = mean.of_value("friction_of_pressure") - mean.of_value("published_friction");
        let inertial = mean.of_value("inertial_number_of_pressure");
        let what = format!("friction less the published one at {at}, I = {inertial:.3}");
        judge(what, beyond, 0.0, TOLERANCE.1, judged);
    }
    findings
}

fn figures(means: &[Mean]) -> Vec<Figure> {
    let own = CodeStyle { class: "code-makadam", marker: Marker::Circle };
    let planes = CodeStyle { class: "code-other", marker: Marker::Square };
    let keys = [
        Key::Line("curve neutral", "spheres, simulated"),
        Key::Points(own, "Makadam, by the mean of the stresses"),
        Key::Line("code-other curve thin", "glass beads, measured"),
        Key::Points(planes, "Makadam, by the stress on planes along the chute"),
    ];
    let (x, y) = (Axis::fine("inertial number I", 0.005, 0.4), Axis::fine("friction µ", 0.36, 0.56));
    let mut plot = Plot::with_legend(x, y, &keys);
    let along = || (0..=60).map(|mark| 0.005 * 80f64.powf(f64::from(mark) / 60.0));
    plot.curve("curve neutral", along().map(|inertial| [inertial, friction(inertial)]));
    plot.curve("code-other curve thin", along().map(|inertial| [inertial, friction_of_beads(inertial)]));
    for mean in means.iter().filter(|mean| !repeats(mean, means)) {
        plot.marker(planes, mean.of_value("inertial_number"), mean.of_value("friction"), 3.6);
        plot.marker(own, mean.of_value("inertial_number_of_pressure"), mean.of_value("friction_of_pressure"), 4.2);
    }
    vec![figure(
        "friction",
        plot,
        "Friction of a flowing layer",
        "measured on a chute, and the laws of Chialvo et al. (2012) and of Jop et al. (2006).",
    )]
}

/// Returns true if a case has a longer step than another one of the same slope.
fn repeats(mean: &Mean, means: &[Mean]) -> bool {
    let mut same = means.iter().filter(|other| other.of_value("angle") == mean.of_value("angle"));
    same.any(|other| other.of_value("coarseness") < mean.of_value("coarseness"))
}

/// Returns a layer on a bed of spheres, inclined by an angle (degrees), with a multiple of the usual time step.
fn case(angle: f64, layer: Layer, coarseness: f64) -> Case {
    let [length, width] = PERIOD.map(|diameters| diameters * DIAMETER);
    let (radius, turn) = (0.5 * DIAMETER, angle.to_radians());
    let room = (10.0 + 2.3 * layer.depth) * DIAMETER;
    let count = grains_of(0.57 * length * width * layer.depth * DIAMETER);
    let name = if coarseness == 1.0 { format!("chute-{angle}") } else { format!("chute-{angle}-coarse") };
    let [from, until] = layer.measured;
    let scene = Sketch::new(name, until)
        .gravity([GRAVITY * turn.sin(), 0.0, -GRAVITY * turn.cos()])
        .domain([0.0, 0.0, -2.0 * DIAMETER], [length, width, room])
        .step(coarseness * SOLVE.0)
        .sweeps(SOLVE.1)
        .interval(INTERVAL)
        .modulus(MODULUS)
        .friction(FRICTION)
        .restitution(RESTITUTION)
        .wall(Shape::Spheres { centres: bed(), radius })
        // This plane stops grains that fall through a gap in the bed.
        .named_wall(
            "beneath",
            "wall",
            Shape::Plane { point: [0.0, 0.0, -1.5 * DIAMETER], normal: [0.0, 0.0, 1.0] },
            Motion::Fixed,
        )
        .with(|scene| scene.description = format!("A layer on a rough chute without end, inclined by {angle} degrees."))
        .polydisperse(
            count,
            [radius, SPREAD],
            Region::Box { min: [0.0, 0.0, DIAMETER], max: [length, width, room] },
            0.1,
        )
        .with(|scene| scene.domain.periodic = vec![Periodic::X, Periodic::Y]);
    let given =
        [("angle", angle), ("depth", layer.depth), ("coarseness", coarseness), ("from", from), ("until", until)];
    Case::new(scene.scene(), given)
}

/// Rows of the spheres of the bed, along and across: about 1.2 diameters apart.
const ROWS: [usize; 2] = [10, 7];
/// Largest shifts from their lattice along, across and upwards, in diameters: an even bed would let layers slide.
const SHIFT: [f64; 3] = [0.12, 0.12, 0.2];

/// Centres of the bed's spheres, m: a lattice with pseudorandom, reproducible shifts.
fn bed() -> Vec<[f64; 3]> {
    let mut state = 1_u64;
    let mut shift = |most: f64| {
        // Knuth's linear congruential generator, its upper bits.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        most * (2.0 * (state >> 11) as f64 / (1_u64 << 53) as f64 - 1.0)
    };
    let mut centres = Vec::new();
    for row in 0..ROWS[1] {
        for column in 0..ROWS[0] {
            let at = |number: usize, axis: usize| (number as f64 + 0.5) * PERIOD[axis] / ROWS[axis] as f64;
            let place = [at(column, 0), at(row, 1), -0.5];
            centres.push(std::array::from_fn(|axis| DIAMETER * (place[axis] + shift(SHIFT[axis]))));
        }
    }
    centres
}

/// Force on all walls, N.
fn force_on_walls(frame: &Snapshot) -> [f64; 3] {
    let on_walls = frame.contacts.iter().filter(|contact| matches!(contact.second, Partner::Wall(_)));
    on_walls.map(|contact| contact.force_on_partner()).sum::<Vector3<f64>>().into()
}

/// Translational kinetic energy over the density, m5/s2.
fn kinetic(frame: &Snapshot) -> f64 {
    let of = |radius: f64, velocity: [f64; 3]| radius.powi(3) * velocity.iter().map(|v| v * v).sum::<f64>();
    2.0 / 3.0 * PI * frame.particles.iter().map(|grain| of(grain.radius, grain.velocity)).sum::<f64>()
}

#[cfg(test)]
#[path = "../../../tests/unit/laws_chute.rs"]
mod tests;
