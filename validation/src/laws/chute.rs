//! A layer that flows down a rough chute without end: Bagnold's velocity profile, and the friction law mu(I).
//!
//! In a steady, uniform flow the stresses at a depth D are those of the weight above it, `P = rho phi g D cos(angle)` and
//! `tau = P tan(angle)`, so the friction `mu = tau/P` is the same everywhere, and so is the inertial number
//! `I = (dv/dz) d sqrt(rho/P)` if friction depends on it alone. Then `dv/dz` goes as `sqrt(D)` and the velocity as
//! `v = v_s - A D^(3/2)`: Bagnold's profile. Depth counts the solid above a place, so that it needs no surface.

use super::case::values;
use super::fit::{least, line};
use super::{Case, Law, LawError, Mean, Run, Values, reported};
use crate::report::figure::Figure;
use crate::report::names::{CodeStyle, Marker};
use crate::report::plot::{Axis, Key, Plot};
use crate::stability::{Finding, GRAVITY, Sketch};
use makadam::scene::{Axis as Periodic, Motion, Population, RadiusDistribution, Region, Shape, Wall};
use makadam::snapshot::{Partner, Snapshot};
use std::f64::consts::PI;

/// Mean diameter of the grains, m.
const DIAMETER: f64 = 0.01;
/// Half width of the radii's distribution over their mean, so that the layer forms no crystal.
const SPREAD: f64 = 0.1;
/// Friction and restitution of grains and bed: those of Silbert et al. (2001).
const FRICTION: f64 = 0.5;
const RESTITUTION: f64 = 0.88;
/// Young's modulus, Pa: a ten thousandth of it is more than the pressure at the bed.
const MODULUS: f64 = 1e8;
/// Periods along the chute and across it, in diameters.
const PERIOD: [f64; 2] = [12.0, 8.0];
/// Rows of the spheres that the bed is made of, along and across: about 1.2 diameters apart.
const ROWS: [usize; 2] = [10, 7];
/// How far they are shifted from their lattice at most, along, across and upwards, in diameters: an even bed would let layers slide.
const SHIFT: [f64; 3] = [0.12, 0.12, 0.2];
/// Depth of the layer, in diameters at a solid fraction of 0.57.
const DEPTH: f64 = 18.0;
/// Time step, s, and sweeps a step; one case is repeated with twice the step, to see what that changes.
const SOLVE: (f64, u32) = (2.5e-4, 10);
/// Time at which measuring begins and ends, s. Flows of this depth still gain a twentieth of their energy after 10 s.
const MEASURED: [f64; 2] = [20.0, 28.0];
/// Time between frames, s.
const INTERVAL: f64 = 0.02;
/// Height of a bin of the profile, in diameters.
const BIN: f64 = 0.5;
/// The profile is fitted where the bed and the surface are at least so far away, in diameters.
const MARGIN: f64 = 3.0;
/// Tolerated deviations of the exponent and of the friction.
const TOLERANCE: (f64, f64) = (0.1, 0.02);

/// The laws of flow down a chute.
pub(super) struct Chute;

/// Friction at an inertial number of spheres with a friction of 0.5, sheared evenly (Chialvo, Sun & Sundaresan 2012, the inertial
/// part of their model).
fn friction(inertial: f64) -> f64 {
    0.382 + 0.37 / ((0.32 / inertial).powf(1.5) + 1.0)
}

/// The same of glass beads in experiments (Jop, Forterre & Pouliquen 2006: the tangents of 20.9 and 32.76 degrees, and 0.279). They are
/// no perfect spheres, and their friction is another one.
fn friction_of_beads(inertial: f64) -> f64 {
    let [least, most] = [20.9_f64, 32.76].map(|angle| angle.to_radians().tan());
    least + (most - least) / (0.279 / inertial + 1.0)
}

impl Law for Chute {
    fn name(&self) -> &'static str {
        "chute"
    }

    fn statement(&self) -> &'static str {
        "a layer of spheres on a rough chute flows at v = v_s - A D^(3/2) with the depth D, and its friction is \
         mu(I) = 0.382 + 0.37 / ((0.32/I)^1.5 + 1)"
    }

    fn source(&self) -> &'static str {
        "Bagnold, Proc. R. Soc. A 225, 49 (1954); Silbert et al., Phys. Rev. E 64, 051302 (2001); Chialvo, Sun & Sundaresan, Phys. Rev. \
         E 85, 021305 (2012); of beads: Jop, Forterre & Pouliquen, Nature 441, 727 (2006)"
    }

    fn cases(&self, quick: bool) -> Vec<Case> {
        match quick {
            true => vec![case(23.0, 2.0)],
            false => [(22.0, 1.0), (23.0, 1.0), (24.0, 1.0), (25.0, 1.0), (23.0, 2.0)].map(|(a, c)| case(a, c)).into(),
        }
    }

    fn measure(&self, case: &Case, run: &mut Run<'_>) -> Result<Values, LawError> {
        let (angle, [from, until]) = (case.of("angle").to_radians(), MEASURED);
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
        Ok(values([
            ("solid_fraction", fit.solid_fraction),
            ("depth_in_diameters", fit.depth / DIAMETER),
            ("surface_speed", fit.surface_speed),
            ("exponent", fit.exponent),
            ("inertial_number", inertial),
            ("friction", -bed[0] / bed[2]),
            ("published_friction", friction(inertial)),
            ("friction_of_beads", friction_of_beads(inertial)),
            ("kinetic_energy_later_over_earlier", halves[1] / halves[0]),
        ]))
    }

    fn judge(&self, means: &[Mean]) -> Vec<Finding> {
        let mut findings = Vec::new();
        let words = |mean: &Mean| match (mean.of_value("angle"), mean.of_value("coarseness")) {
            (angle, 1.0) => format!("{angle} degrees"),
            (angle, times) => format!("{angle} degrees, {times} times the step"),
        };
        for mean in means {
            let inertial = mean.of_value("inertial_number");
            let what = format!("exponent of the velocity profile at {}", words(mean));
            findings.push(Finding::near(what, "", mean.of_value("exponent"), 1.5, TOLERANCE.0));
            let beyond = mean.of_value("friction") - mean.of_value("published_friction");
            let what = format!("friction less the published one at {}, I = {inertial:.3}", words(mean));
            findings.push(Finding::near(what, "", beyond, 0.0, TOLERANCE.1));
        }
        for mean in means {
            let tangent = mean.of_value("angle").to_radians().tan();
            let name = |what: &str| format!("  {what} at {}", words(mean));
            let beyond = mean.of_value("friction") - mean.of_value("friction_of_beads");
            findings.push(reported(name("friction less that of glass beads"), "", beyond));
            findings.push(reported(
                name("force on the bed over what the slope says"),
                "",
                mean.of_value("friction") / tangent,
            ));
            let energy = mean.of_value("kinetic_energy_later_over_earlier");
            findings.push(reported(name("kinetic energy in the second half over the first"), "", energy));
            findings.push(reported(name("solid fraction"), "", mean.of_value("solid_fraction")));
        }
        findings
    }

    fn figures(&self, means: &[Mean]) -> Vec<Figure> {
        let own = CodeStyle { class: "code-makadam", marker: Marker::Circle };
        let keys = [
            Key::Line("curve neutral", "spheres, simulated"),
            Key::Line("code-other curve thin", "glass beads, measured"),
            Key::Points(own, "Makadam"),
        ];
        let (x, y) = (Axis::fine("inertial number I", 0.005, 0.4), Axis::fine("friction µ", 0.36, 0.56));
        let mut plot = Plot::with_legend(x, y, &keys);
        let along = || (0..=60).map(|mark| 0.005 * 80f64.powf(f64::from(mark) / 60.0));
        plot.curve("curve neutral", along().map(|inertial| [inertial, friction(inertial)]));
        plot.curve("code-other curve thin", along().map(|inertial| [inertial, friction_of_beads(inertial)]));
        for mean in means {
            plot.marker(own, mean.of_value("inertial_number"), mean.of_value("friction"), 4.2);
        }
        let title = "Friction of a flowing layer";
        let caption =
            format!("{title}: measured on a chute, and the laws of Chialvo et al. (2012) and of Jop et al. (2006).");
        vec![Figure { name: "friction".into(), svg: plot.finish(title), caption }]
    }
}

/// A layer on a bed of spheres, inclined by an angle (degrees), simulated with so many times the usual step.
fn case(angle: f64, coarseness: f64) -> Case {
    let [length, width] = PERIOD.map(|diameters| diameters * DIAMETER);
    let (radius, turn) = (0.5 * DIAMETER, angle.to_radians());
    let room = 50.0 * DIAMETER;
    let volume = 4.0 / 3.0 * PI * radius.powi(3) * (1.0 + SPREAD * SPREAD);
    let count = (0.57 * length * width * DEPTH * DIAMETER / volume).round() as usize;
    let name = if coarseness == 1.0 { format!("chute-{angle}") } else { format!("chute-{angle}-coarse") };
    let scene = Sketch::new(name, MEASURED[1])
        .gravity([GRAVITY * turn.sin(), 0.0, -GRAVITY * turn.cos()])
        .domain([0.0, 0.0, -2.0 * DIAMETER], [length, width, room])
        .step(coarseness * SOLVE.0)
        .sweeps(SOLVE.1)
        .interval(INTERVAL)
        .modulus(MODULUS)
        .friction(FRICTION)
        .restitution(RESTITUTION)
        .wall(Shape::Spheres { centres: bed(), radius })
        .with(|scene| {
            scene.description = format!("A layer on a rough chute without end, inclined by {angle} degrees.");
            scene.domain.periodic = vec![Periodic::X, Periodic::Y];
            // What finds a gap in the bed does not fall through it.
            scene.wall.push(Wall {
                name: "beneath".into(),
                material: "wall".into(),
                shape: Shape::Plane { point: [0.0, 0.0, -1.5 * DIAMETER], normal: [0.0, 0.0, 1.0] },
                motion: Motion::Fixed,
            });
            scene.population.push(Population {
                count,
                material: "grain".into(),
                radius: RadiusDistribution::Uniform { mean: radius, spread: SPREAD },
                region: Region::Box { min: [0.0, 0.0, DIAMETER], max: [length, width, room] },
                spacing: 1.04,
                agitation: 0.1,
            });
        });
    Case::new(scene.scene(), [("angle", angle), ("coarseness", coarseness)])
}

/// Centres of the bed's spheres, m: a lattice with shifts that look random and are always the same.
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

/// Solid volume and momentum over height, summed over frames.
#[derive(Default)]
struct Profile {
    volume: Vec<f64>,
    flow: Vec<f64>,
    frames: usize,
}

/// What a profile says.
struct Fit {
    solid_fraction: f64,
    /// Height of the layer at its mean solid fraction, m.
    depth: f64,
    /// v_s, m/s, and A, m^(-1/2)/s, of Bagnold's profile.
    surface_speed: f64,
    bagnold: f64,
    /// The exponent of the depth that fits best.
    exponent: f64,
}

impl Profile {
    fn add(&mut self, frame: &Snapshot) {
        self.frames += 1;
        for grain in &frame.particles {
            let bin = (grain.position[2] / (BIN * DIAMETER)).max(0.0) as usize;
            if self.volume.len() <= bin {
                self.volume.resize(bin + 1, 0.0);
                self.flow.resize(bin + 1, 0.0);
            }
            let volume = 4.0 / 3.0 * PI * grain.radius.powi(3);
            self.volume[bin] += volume;
            self.flow[bin] += volume * grain.velocity[0];
        }
    }

    /// Fits velocities over depths.
    fn fit(&self) -> Fit {
        let room = BIN * DIAMETER * PERIOD[0] * PERIOD[1] * DIAMETER * DIAMETER * self.frames as f64;
        let solid: Vec<f64> = self.volume.iter().map(|volume| volume / room).collect();
        // Solid above the middle of each bin, m.
        let above: Vec<f64> = (0..solid.len())
            .map(|bin| BIN * DIAMETER * (0.5 * solid[bin] + solid[bin + 1..].iter().sum::<f64>()))
            .collect();
        let inside = |bin: &usize| {
            (*bin as f64 + 0.5) * BIN >= MARGIN && above[*bin] >= 0.57 * MARGIN * DIAMETER && self.volume[*bin] > 0.0
        };
        let bins: Vec<usize> = (0..solid.len()).filter(inside).collect();
        let solid_fraction = bins.iter().map(|&bin| solid[bin]).sum::<f64>() / bins.len() as f64;
        let points: Vec<[f64; 2]> =
            bins.iter().map(|&bin| [above[bin] / solid_fraction, self.flow[bin] / self.volume[bin]]).collect();
        let raised =
            |exponent: f64| points.iter().map(|&[depth, speed]| [depth.powf(exponent), speed]).collect::<Vec<_>>();
        let misfit = |exponent: f64| {
            let points = raised(exponent);
            let (slope, start) = line(&points);
            points.iter().map(|[x, y]| (y - start - slope * x).powi(2)).sum::<f64>()
        };
        let (slope, surface_speed) = line(&raised(1.5));
        Fit {
            solid_fraction,
            depth: solid.iter().sum::<f64>() * BIN * DIAMETER / solid_fraction,
            surface_speed,
            bagnold: -slope,
            exponent: least(misfit, 0.3, 4.0),
        }
    }
}

/// Force on all walls, N.
fn force_on_walls(frame: &Snapshot) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for contact in frame.contacts.iter().filter(|contact| matches!(contact.second, Partner::Wall(_))) {
        for ((sum, normal), tangential) in sum.iter_mut().zip(contact.normal).zip(contact.tangential_force) {
            *sum += contact.normal_force * normal + tangential;
        }
    }
    sum
}

/// Kinetic energy of translation over the density, m5/s2.
fn kinetic(frame: &Snapshot) -> f64 {
    let of = |radius: f64, velocity: [f64; 3]| radius.powi(3) * velocity.iter().map(|v| v * v).sum::<f64>();
    2.0 / 3.0 * PI * frame.particles.iter().map(|grain| of(grain.radius, grain.velocity)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use makadam::snapshot::Particle;

    #[test]
    fn the_law_has_its_limits() {
        assert_relative_eq!(friction(1e-12), 0.382, max_relative = 1e-9);
        assert_relative_eq!(friction(1e12), 0.752, max_relative = 1e-9);
        assert_relative_eq!(friction_of_beads(1e-12), 20.9_f64.to_radians().tan(), max_relative = 1e-9);
        assert_relative_eq!(friction_of_beads(0.279), 0.5 * (0.38186 + 0.64353), max_relative = 1e-3);
    }

    #[test]
    fn a_profile_of_known_exponent_is_found() {
        for exponent in [1.0, 1.5, 2.2] {
            // Layers of grains a tenth of a diameter apart, 20 diameters deep.
            let layer = |number: usize| {
                let height = (number as f64 + 0.5) * 0.1 * DIAMETER;
                let depth = 20.0 * DIAMETER - height;
                let speed = 2.0 - 3.0 * depth.powf(exponent);
                Particle {
                    id: number as u32,
                    position: [0.0, 0.0, height],
                    radius: 0.02,
                    velocity: [speed, 0.0, 0.0],
                    spin: [0.0; 3],
                }
            };
            let frame = Snapshot { time: 0.0, particles: (0..200).map(layer).collect(), contacts: Vec::new() };
            let mut profile = Profile::default();
            profile.add(&frame);
            let fit = profile.fit();
            assert_relative_eq!(fit.exponent, exponent, max_relative = 5e-3);
            assert_relative_eq!(fit.depth, 20.0 * DIAMETER, max_relative = 1e-9);
            if exponent == 1.5 {
                assert_relative_eq!(fit.bagnold, 3.0, max_relative = 1e-2);
                assert_relative_eq!(fit.surface_speed, 2.0, max_relative = 1e-3);
            }
        }
    }

    #[test]
    fn the_bed_has_no_gap_that_a_grain_falls_through() {
        let centres = bed();
        assert_eq!(centres.len(), ROWS[0] * ROWS[1]);
        // Where the smallest grain comes to rest above each place.
        let (reach, [length, width]) = ((1.0 - 0.5 * SPREAD) * DIAMETER, PERIOD.map(|diameters| diameters * DIAMETER));
        let lap = |distance: f64, period: f64| distance - period * (distance / period).round();
        let rest = |x: f64, y: f64| {
            let heights = centres.iter().map(|centre| {
                let square = lap(x - centre[0], length).powi(2) + lap(y - centre[1], width).powi(2);
                centre[2] + (reach * reach - square).sqrt()
            });
            heights.fold(f64::NEG_INFINITY, f64::max)
        };
        let places =
            (0..200).flat_map(|i| (0..200).map(move |j| (f64::from(i) * length / 200.0, f64::from(j) * width / 200.0)));
        let lowest = places.map(|(x, y)| rest(x, y)).fold(f64::INFINITY, f64::min);
        assert!(lowest > -0.5 * DIAMETER, "a grain sinks to {lowest} m");
    }
}
