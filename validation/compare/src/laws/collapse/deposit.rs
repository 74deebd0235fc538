//! Edge of the deposit of a collapse, by several definitions.

use super::super::DIAMETER;
use super::column::Part;
use crate::sketch::GRAVITY;
use makadam::snapshot::{Particle, Snapshot};
use makadam_frames::neighbours::close_pairs;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::setting::{Properties, Setting};
use makadam_measure::observables::static_angle;
use makadam_measure::observables::static_angle::HeapFields;
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

/// Distance from a plane of symmetry below which grains do not count for the edge, m: a smooth plane orders nearby grains in layers.
const MARGIN: f64 = 2.0 * DIAMETER;
/// Sectors of a whole deposit over which the outermost grains are averaged.
const SECTORS: usize = 36;

/// Solid volume, m3.
pub(super) fn solid_volume(frame: &Snapshot) -> f64 {
    frame.particles.iter().map(volume).sum()
}

fn volume(grain: &Particle) -> f64 {
    4.0 / 3.0 * PI * grain.radius.powi(3)
}

/// Height of the centre of mass above the plane, m: half the height of a column of even density.
pub(super) fn centre_of_mass(frame: &Snapshot) -> f64 {
    frame.particles.iter().map(|grain| volume(grain) * grain.position[2]).sum::<f64>() / solid_volume(frame)
}

/// Root mean square speed over `sqrt(g d)`.
pub(super) fn speed(frame: &Snapshot) -> f64 {
    let square = |grain: &Particle| grain.velocity.iter().map(|x| x * x).sum::<f64>();
    let mean = frame.particles.iter().map(square).sum::<f64>() / frame.particles.len() as f64;
    (mean / (GRAVITY * DIAMETER)).sqrt()
}

fn distance(grain: &Particle) -> f64 {
    grain.position[0].hypot(grain.position[1])
}

/// Returns true if a grain counts for the edge.
fn counts(grain: &Particle, part: Part) -> bool {
    part == Part::Whole || grain.position[0].min(grain.position[1]) > MARGIN
}

/// Area (m2) within a distance from the axis (m) in which grains count.
fn area(distance: f64, part: Part) -> f64 {
    let square = distance * distance;
    match part {
        Part::Whole => PI * square,
        // The integral of s (pi/2 - 2 asin(m/s)) ds from sqrt(2) m, where both planes are a margin m away.
        Part::Quarter if distance > SQRT_2 * MARGIN => {
            let side = (square - MARGIN * MARGIN).sqrt();
            square * (0.5 * FRAC_PI_2 - (MARGIN / distance).asin()) - MARGIN * side + MARGIN * MARGIN
        }
        Part::Quarter => 0.0,
    }
}

/// Cross-sections of the grains of each ring about the axis, one diameter wide, over the ring's area; zero where a ring has no
/// area.
pub(super) fn coverage(grains: &[Particle], part: Part) -> Vec<f64> {
    let rings = grains.iter().map(|grain| distance(grain) / DIAMETER).fold(0.0, f64::max) as usize + 2;
    let mut covered = vec![0.0; rings];
    for grain in grains.iter().filter(|grain| counts(grain, part)) {
        covered[(distance(grain) / DIAMETER) as usize] += PI * grain.radius * grain.radius;
    }
    let within = |ring: usize| area(ring as f64 * DIAMETER, part);
    let over = |(ring, covered): (usize, &f64)| match within(ring + 1) - within(ring) {
        area if area > 0.0 => covered / area,
        _ => 0.0,
    };
    covered.iter().enumerate().map(over).collect()
}

/// Outermost distance from the axis (m) at which the coverage reaches a level; linear between the middles of rings.
pub(super) fn edge(coverage: &[f64], level: f64) -> f64 {
    let middle = |ring: usize| (ring as f64 + 0.5) * DIAMETER;
    match coverage.iter().rposition(|&covered| covered >= level) {
        Some(ring) => {
            let next = coverage.get(ring + 1).copied().unwrap_or(0.0);
            middle(ring) + DIAMETER * (coverage[ring] - level) / (coverage[ring] - next)
        }
        None => f64::NAN,
    }
}

/// Distance from the axis (m) of the outermost grain connected to the deposit over gaps of up to a tenth of a
/// diameter, the mean over sectors of ten degrees.
pub(super) fn connected(grains: &[Particle], part: Part) -> f64 {
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
    let mut outermost = [0.0f64; SECTORS];
    for (number, grain) in grains.iter().enumerate() {
        if find(&mut root, number) == deposit && counts(grain, part) {
            let turn = grain.position[1].atan2(grain.position[0]) / (2.0 * PI) + 0.5;
            let sector = &mut outermost[((turn * SECTORS as f64) as usize).min(SECTORS - 1)];
            *sector = sector.max(distance(grain) + grain.radius);
        }
    }
    outermost.iter().sum::<f64>() / (part.share() * SECTORS as f64)
}

/// Distance from the axis (m) within which a fraction of the solid volume lies.
pub(super) fn holding(frame: &Snapshot, share: f64) -> f64 {
    let mut grains: Vec<&Particle> = frame.particles.iter().collect();
    grains.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let mut left = share * solid_volume(frame);
    let last = grains.iter().find(|grain| {
        left -= volume(grain);
        left <= 0.0
    });
    last.map_or(f64::NAN, |grain| distance(grain))
}

/// Inclination of a heap's flank ([`static_angle`]), degrees; NaN where there is none.
pub(super) fn angle_of_repose(scene: &MeasuredScene, frame: &Snapshot) -> f64 {
    let properties = Properties::new(scene);
    let setting = Setting::new(&properties, frame);
    let Ok(fields) = HeapFields::new(&setting, &[frame][..]);
    let found = fields.ok().and_then(|fields| static_angle::measure(&setting, &fields).ok()).unwrap_or_default();
    found.first().map_or(f64::NAN, |angle| angle.value)
}

/// Height of the topmost grain within two diameters of the axis, m.
pub(super) fn height_at_axis(grains: &[Particle]) -> f64 {
    let near = grains.iter().filter(|grain| distance(grain) < 2.0 * DIAMETER);
    near.map(|grain| grain.position[2] + grain.radius).fold(f64::NAN, f64::max)
}

#[cfg(test)]
#[path = "../../../tests/unit/laws_collapse_deposit.rs"]
mod tests;
