//! Collapse of a column: how far it runs out.
//!
//! A tube full of grains on a rough plane is lifted off. The run-out over the first radius, `(r - r0)/r0`, depends on the
//! aspect ratio `a = h0/r0` alone: 1.24 a up to a = 1.7 and 1.6 sqrt(a) beyond.
//!
//! That is so where the column is hundreds of grains wide, as in the experiments. Each aspect ratio is run at several radii, the
//! widest one is judged, and a line through the ratios to the law over `d/r0` tells what is left of the deviation at `d/r0 = 0`.

use super::case::values;
use super::fit::line;
use super::{Case, Law, LawError, Mean, Run, Values, reported};
use crate::observables::close_pairs;
use crate::report::figure::Figure;
use crate::report::names::{CodeStyle, Marker};
use crate::report::plot::{Axis, Key, Plot};
use crate::stability::{Finding, GRAVITY, Sketch};
use makadam::scene::{Motion, Population, RadiusDistribution, Region, Shape, Wall};
use makadam::snapshot::{Particle, Snapshot};
use std::f64::consts::PI;

/// Mean diameter of the grains, m.
const DIAMETER: f64 = 0.01;
/// Half width of the radii's distribution over their mean, so that the grains form no crystal.
const SPREAD: f64 = 0.1;
/// Friction of the grains: sand's and glass's.
const FRICTION: f64 = 0.5;
/// Rolling friction of the grains: spheres that roll freely run out farther than the grains of the experiments.
const ROLLING_FRICTION: f64 = 0.1;
/// Friction and rolling friction of the plane: a base with grains glued to it holds single grains up to slopes of about 25
/// degrees, half the normal force.
const BASE: [f64; 2] = [1.0, 0.5];
/// Speed of the tube over `sqrt(g h0)`.
const LIFT: f64 = 5.0;
/// Time step, s, and sweeps a step.
const SOLVE: (f64, u32) = (5e-4, 10);
/// Solid fraction by which grains are counted out.
const SOLID: f64 = 0.6;
/// Coverage at which the deposit ends: half the plane under grains. Deposits thinner than that are scattered grains, which the
/// experiments leave out.
const EDGE: f64 = 0.5;
/// Grains that move slower than this in the mean, over `sqrt(g d)`, are at rest.
const REST: f64 = 0.01;
/// Longest time until rest, over `sqrt(h0/g)`.
const PATIENCE: f64 = 12.0;
/// Tolerated deviation from the law.
const TOLERANCE: f64 = 0.1;

/// The law of the run-out.
pub(super) struct Collapse;

/// Run-out over the first radius at an aspect ratio (Lube et al. 2004, equations 3.1 and 3.2).
fn law(aspect: f64) -> f64 {
    if aspect < 1.7 { 1.24 * aspect } else { 1.6 * aspect.sqrt() }
}

impl Law for Collapse {
    fn name(&self) -> &'static str {
        "collapse"
    }

    fn statement(&self) -> &'static str {
        "a column of radius r0 and height h0 = a r0 runs out to r with (r - r0)/r0 = 1.24 a for a < 1.7, 1.6 sqrt(a) beyond"
    }

    fn source(&self) -> &'static str {
        "Lube, Huppert, Sparks & Hallworth, J. Fluid Mech. 508, 175 (2004); Lajeunesse, Mangeney-Castelnau & Vilotte, Phys. Fluids \
         16, 2371 (2004)"
    }

    fn cases(&self, quick: bool) -> Vec<Case> {
        match quick {
            true => [(0.5, 8.0), (2.0, 8.0)].map(|(aspect, radius)| case(radius, aspect)).into(),
            false => {
                let sizes = [(0.5, 20.0), (1.0, 20.0), (2.0, 12.0), (4.0, 12.0)];
                let series = sizes.into_iter().flat_map(|(aspect, widest)| {
                    let radii = [8.0, 12.0, 20.0].into_iter().filter(move |radius| *radius <= widest);
                    radii.map(move |radius| case(radius, aspect))
                });
                series.collect()
            }
        }
    }

    fn measure(&self, case: &Case, run: &mut Run<'_>) -> Result<Values, LawError> {
        let radius = case.of("radius");
        run.to(case.of("release"))?;
        let column = run.frame();
        let height = 2.0 * centre_of_mass(&column);
        let (fall, last) = ((height / GRAVITY).sqrt(), case.scene.duration);
        while run.time() < last - 1e-9 {
            run.to((run.time() + 0.1 * fall).min(last))?;
            if run.time() > case.of("release") + 2.0 * fall && speed(&run.frame()) < REST {
                break;
            }
        }
        let deposit = run.frame();
        let coverage = coverage(&deposit.particles);
        let run_out = |edge: f64| (edge - radius) / radius;
        Ok(values([
            ("height", height),
            ("aspect", height / radius),
            ("solid_fraction", solid_volume(&column) / (PI * radius * radius * height)),
            ("speed_at_release", speed(&column)),
            ("speed_at_end", speed(&deposit)),
            ("collapse_time", (run.time() - case.of("release")) / fall),
            ("run_out", run_out(edge(&coverage, EDGE))),
            ("run_out_coverage_25", run_out(edge(&coverage, 0.25))),
            ("run_out_coverage_100", run_out(edge(&coverage, 1.0))),
            ("run_out_connected", run_out(connected(&deposit.particles))),
            ("run_out_95_percent", run_out(holding(&deposit, 0.95))),
            ("run_out_99_percent", run_out(holding(&deposit, 0.99))),
            ("deposit_height", height_at_axis(&deposit.particles)),
        ]))
    }

    fn judge(&self, means: &[Mean]) -> Vec<Finding> {
        let aspects = nominal_aspects(means);
        let mut findings = Vec::new();
        for series in aspects.iter().map(|&aspect| series(means, aspect)) {
            let Some(widest) = series.last() else { continue };
            let what = format!("run-out over the law's, {}", words(widest));
            findings.push(Finding::near(what, "", ratio(widest, "run_out"), 1.0, TOLERANCE));
        }
        for series in aspects.iter().map(|&aspect| series(means, aspect)).filter(|series| series.len() > 1) {
            for narrower in &series[..series.len() - 1] {
                findings.push(reported(format!("the same, {}", words(narrower)), "", ratio(narrower, "run_out")));
            }
            let points: Vec<[f64; 2]> =
                series.iter().map(|mean| [DIAMETER / mean.of_value("radius"), ratio(mean, "run_out")]).collect();
            let aspect = series[0].of_value("nominal_aspect");
            findings.push(reported(format!("the same at d/r0 = 0, by a line, a near {aspect}"), "", line(&points).1));
        }
        for series in aspects.iter().map(|&aspect| series(means, aspect)) {
            let Some(widest) = series.last() else { continue };
            for (name, definition) in ALTERNATIVES {
                let what = format!("the same by another edge, {}, {definition}", words(widest));
                findings.push(reported(what, "", ratio(widest, name)));
            }
        }
        findings
    }

    fn figures(&self, means: &[Mean]) -> Vec<Figure> {
        let aspects: Vec<f64> = means.iter().map(|mean| mean.of_value("aspect")).collect();
        let least = 0.8 * aspects.iter().copied().fold(f64::INFINITY, f64::min);
        let most = 1.25 * aspects.iter().copied().fold(0.0, f64::max);
        let own = CodeStyle { class: "code-makadam", marker: Marker::Circle };
        let other = CodeStyle { class: "code-other", marker: Marker::Diamond };
        let keys = [
            Key::Line("curve neutral", "law"),
            Key::Points(own, "half covered (open: narrower)"),
            Key::Points(other, "other edges"),
        ];
        let (x, y) = (Axis::fine("aspect ratio a = h0/r0", least, most), Axis::fine("run-out (r − r0)/r0", 0.3, 8.0));
        let mut plot = Plot::with_legend(x, y, &keys);
        let marks = 60;
        let along = (0..=marks).map(|mark| 0.1 * 200f64.powf(f64::from(mark) / f64::from(marks)));
        plot.curve("curve neutral", along.map(|aspect| [aspect, law(aspect)]));
        for mean in means {
            plot.open_marker(own, mean.of_value("aspect"), mean.of_value("run_out"), 3.4);
        }
        for series in nominal_aspects(means).into_iter().map(|aspect| series(means, aspect)) {
            let Some(widest) = series.last() else { continue };
            let aspect = widest.of_value("aspect");
            for (name, _) in ALTERNATIVES {
                plot.open_marker(other, aspect, widest.of_value(name), 2.6);
            }
            plot.marker(own, aspect, widest.of_value("run_out"), 4.2);
        }
        let title = "Run-out of collapsing columns";
        let caption = format!("{title}: measured, and the law of Lube et al. (2004).");
        vec![Figure { name: "run-out".into(), svg: plot.finish(title), caption }]
    }
}

/// Other definitions of the deposit's edge, reported beside the one that is judged.
const ALTERNATIVES: [(&str, &str); 5] = [
    ("run_out_coverage_25", "a quarter covered"),
    ("run_out_coverage_100", "fully covered"),
    ("run_out_connected", "grains that touch the deposit"),
    ("run_out_95_percent", "95% of the solid volume"),
    ("run_out_99_percent", "99% of the solid volume"),
];

/// Aspect ratios that were asked for, each once, in their order.
fn nominal_aspects(means: &[Mean]) -> Vec<f64> {
    let mut aspects: Vec<f64> = means.iter().map(|mean| mean.of_value("nominal_aspect")).collect();
    aspects.dedup();
    aspects
}

/// The columns of one aspect ratio, narrow ones first.
fn series(means: &[Mean], aspect: f64) -> Vec<&Mean> {
    means.iter().filter(|mean| mean.of_value("nominal_aspect") == aspect).collect()
}

/// A run-out over the law's.
fn ratio(mean: &Mean, name: &str) -> f64 {
    mean.of_value(name) / law(mean.of_value("aspect"))
}

/// Aspect ratio and radius of a column.
fn words(mean: &Mean) -> String {
    format!("a = {:.2}, r0 = {:.0} d", mean.of_value("aspect"), mean.of_value("radius") / DIAMETER)
}

/// A column of so many diameters in radius.
fn case(radius_in_diameters: f64, aspect: f64) -> Case {
    let radius = radius_in_diameters * DIAMETER;
    let height = aspect * radius;
    let grain = 0.5 * DIAMETER;
    let volume = 4.0 / 3.0 * PI * grain.powi(3) * (1.0 + SPREAD * SPREAD);
    let count = (SOLID * PI * radius * radius * height / volume).round() as usize;
    // The lattice that grains start on is less than half as dense as the column.
    let room = 3.0 * height + 10.0 * DIAMETER;
    let release = 0.4 + 2.5 * (2.0 * height / GRAVITY).sqrt();
    let fall = (height / GRAVITY).sqrt();
    let reach = radius * (1.0 + 2.5 * law(aspect));
    let lift = LIFT * (GRAVITY * height).sqrt();
    let tube = Motion::Translating { velocity: [0.0, 0.0, lift], start: release, stop: None };
    let up = [0.0, 0.0, 1.0];
    let scene = Sketch::new(format!("collapse-{aspect}-r{radius_in_diameters}"), release + PATIENCE * fall)
        .domain([-reach, -reach, -DIAMETER], [reach, reach, room])
        .step(SOLVE.0)
        .sweeps(SOLVE.1)
        .interval(0.05)
        .material("plate", |plate| [plate.friction, plate.rolling_friction] = BASE)
        .moving_wall(
            Shape::Cylinder { base: [0.0, 0.0, -2.0 * DIAMETER], axis: up, radius, length: room + 4.0 * DIAMETER },
            tube,
        )
        .with(|scene| {
            scene.description =
                format!("A column of aspect ratio {aspect} on a rough plane, whose tube is lifted off.");
            // The tube slides off without a pull.
            scene.material.get_mut("wall").expect("a sketch has it").friction = 0.0;
            let grains = scene.material.get_mut("grain").expect("a sketch has it");
            (grains.friction, grains.rolling_friction) = (FRICTION, ROLLING_FRICTION);
            scene.wall.push(Wall {
                name: "plate".into(),
                material: "plate".into(),
                shape: Shape::Plane { point: [0.0; 3], normal: up },
                motion: Motion::Fixed,
            });
            scene.population.push(Population {
                count,
                material: "grain".into(),
                radius: RadiusDistribution::Uniform { mean: grain, spread: SPREAD },
                region: Region::Cylinder { base: [0.0; 3], axis: up, radius, length: room },
                spacing: 1.04,
                agitation: 0.05,
            });
        });
    Case::new(scene.scene(), [("radius", radius), ("nominal_aspect", aspect), ("release", release)])
}

fn solid_volume(frame: &Snapshot) -> f64 {
    frame.particles.iter().map(volume).sum()
}

fn volume(grain: &Particle) -> f64 {
    4.0 / 3.0 * PI * grain.radius.powi(3)
}

/// Height of the centre of mass above the plane, m: half the height of a column of even density.
fn centre_of_mass(frame: &Snapshot) -> f64 {
    frame.particles.iter().map(|grain| volume(grain) * grain.position[2]).sum::<f64>() / solid_volume(frame)
}

/// Root mean square speed over `sqrt(g d)`.
fn speed(frame: &Snapshot) -> f64 {
    let square = |grain: &Particle| grain.velocity.iter().map(|x| x * x).sum::<f64>();
    let mean = frame.particles.iter().map(square).sum::<f64>() / frame.particles.len() as f64;
    (mean / (GRAVITY * DIAMETER)).sqrt()
}

fn distance(grain: &Particle) -> f64 {
    grain.position[0].hypot(grain.position[1])
}

/// Cross-sections of the grains of each ring about the axis, a diameter wide, over the ring's area.
fn coverage(grains: &[Particle]) -> Vec<f64> {
    let rings = grains.iter().map(|grain| distance(grain) / DIAMETER).fold(0.0, f64::max) as usize + 2;
    let mut covered = vec![0.0; rings];
    for grain in grains {
        covered[(distance(grain) / DIAMETER) as usize] += PI * grain.radius * grain.radius;
    }
    let area = |ring: usize| PI * DIAMETER * DIAMETER * (2 * ring + 1) as f64;
    covered.iter().enumerate().map(|(ring, covered)| covered / area(ring)).collect()
}

/// Outermost distance from the axis (m) at which the coverage is at a level; linear between the middles of rings.
fn edge(coverage: &[f64], level: f64) -> f64 {
    let middle = |ring: usize| (ring as f64 + 0.5) * DIAMETER;
    match coverage.iter().rposition(|&covered| covered >= level) {
        Some(ring) => {
            let next = coverage.get(ring + 1).copied().unwrap_or(0.0);
            middle(ring) + DIAMETER * (coverage[ring] - level) / (coverage[ring] - next)
        }
        None => f64::NAN,
    }
}

/// Distance from the axis (m) of the outermost grain that hangs together with the deposit over gaps of up to a tenth of a
/// diameter, the mean over 36 sectors.
fn connected(grains: &[Particle]) -> f64 {
    let mut root: Vec<usize> = (0..grains.len()).collect();
    fn find(root: &mut [usize], mut grain: usize) -> usize {
        while root[grain] != grain {
            root[grain] = root[root[grain]];
            grain = root[grain];
        }
        grain
    }
    for pair in close_pairs(grains, 0.1 * DIAMETER) {
        let (a, b) = (find(&mut root, pair.first), find(&mut root, pair.second));
        root[a.max(b)] = a.min(b);
    }
    let inner = (0..grains.len()).min_by(|&a, &b| distance(&grains[a]).total_cmp(&distance(&grains[b])));
    let Some(inner) = inner else { return f64::NAN };
    let deposit = find(&mut root, inner);
    let mut outermost = [0.0f64; 36];
    for (number, grain) in grains.iter().enumerate() {
        if find(&mut root, number) == deposit {
            let turn = grain.position[1].atan2(grain.position[0]) / (2.0 * PI) + 0.5;
            let sector = &mut outermost[((turn * 36.0) as usize).min(35)];
            *sector = sector.max(distance(grain) + grain.radius);
        }
    }
    outermost.iter().sum::<f64>() / 36.0
}

/// Distance from the axis (m) that holds a share of the solid volume.
fn holding(frame: &Snapshot, share: f64) -> f64 {
    let mut grains: Vec<&Particle> = frame.particles.iter().collect();
    grains.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let mut left = share * solid_volume(frame);
    let last = grains.iter().find(|grain| {
        left -= volume(grain);
        left <= 0.0
    });
    last.map_or(f64::NAN, |grain| distance(grain))
}

/// Height of the topmost grain within two diameters of the axis, m.
fn height_at_axis(grains: &[Particle]) -> f64 {
    let near = grains.iter().filter(|grain| distance(grain) < 2.0 * DIAMETER);
    near.map(|grain| grain.position[2] + grain.radius).fold(f64::NAN, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_law_has_its_two_branches() {
        assert_relative_eq!(law(1.0), 1.24);
        assert_relative_eq!(law(4.0), 3.2);
    }

    #[test]
    fn a_layer_ends_where_half_of_the_plane_is_covered() {
        let profile = [3.0, 2.0, 1.0, 0.75, 0.25, 0.1];
        assert_relative_eq!(edge(&profile, 0.5), 4.0 * DIAMETER, max_relative = 1e-12);
        assert!(edge(&[0.1, 0.2], 0.5).is_nan());
    }

    #[test]
    fn judged_are_run_outs_and_nothing_else() {
        let judged = |run_out: f64| Collapse.judge(&[mean(0.2, run_out)])[0].holds();
        assert!(judged(1.24 * 1.09) && judged(1.24 * 0.91));
        assert!(!judged(1.24 * 1.11) && !judged(1.24 * 0.89));
    }

    #[test]
    fn the_widest_column_counts_and_the_line_goes_on_to_endless_ones() {
        // 1 - 4 d/r0 of the law.
        let findings = Collapse.judge(&[8.0, 20.0].map(|radius| mean(radius * DIAMETER, 1.24 * (1.0 - 4.0 / radius))));
        let judged: Vec<&Finding> = findings.iter().filter(|finding| finding.low.is_finite()).collect();
        assert_eq!(judged.len(), 1);
        assert_relative_eq!(judged[0].value, 0.8, max_relative = 1e-12);
        let limit = findings.iter().find(|finding| finding.what.contains("d/r0 = 0")).unwrap();
        assert_relative_eq!(limit.value, 1.0, max_relative = 1e-12);
    }

    fn mean(radius: f64, run_out: f64) -> Mean {
        let given = [("aspect", 1.0), ("nominal_aspect", 1.0), ("radius", radius), ("run_out", run_out)];
        Mean { case: format!("collapse-{radius}"), seeds: 1, values: values(given), deviations: Values::new() }
    }
}
