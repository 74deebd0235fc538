//! Flow in a rotating drum: slip at the shell, the flowing layer, torque, mixing.

use super::bed_surface::{BedSurface, BedSurfaces};
use super::catalogue::{Group, VELOCITIES, WALL_CONTACTS, define};
use super::drum::Drum;
use super::frames::Frames;
use super::line::Line;
use super::measurement::{Measurement, Readings};
use super::mixing::{MIXING_CELL, lacey_index};
use super::setting::Setting;
use super::view::View;
use crate::statistics::{mean, standard_error};
use makadam::snapshot::{Partner, Snapshot};
use makadam_frames::plan::{Observable, lasting_number};
use nalgebra::Vector3;

pub(super) const GROUP: Group = Group {
    observable: Observable::DrumFlow,
    name: "drum-flow",
    read,
    definitions: &[
        define(
            ["shell_layer_speed_ratio", "ω_s/Ω", ""],
            "angular speed of the grains at the shell over the drum's; 1 where they turn with it",
        )
        .needs(VELOCITIES),
        define(
            ["wall_torque", "T", "N m"],
            "torque of the walls that turn with the shell on the grains about the axis, positive in the sense of \
             rotation",
        )
        .needs(WALL_CONTACTS),
        define(
            ["flowing_layer_thickness", "h_f", "diameter"],
            "depth below the middle of the surface at which the velocity along the surface changes sign",
        )
        .of_span()
        .needs(VELOCITIES),
        define(["surface_speed", "v_s", "m/s"], "velocity down the slope in the uppermost half diameter there")
            .of_span()
            .needs(VELOCITIES),
        define(
            ["lacey_mixing_index", "M", ""],
            "(s₀² − s²)/(s₀² − s_r²) of grains marked by the side of the drum on which they were at the first \
             measured frame; needs at least two frames",
        )
        .source("Lacey, J. Appl. Chem. 4, 257 (1954)")
        .of_span(),
    ],
};

/// Largest distance of the centres of grains in the shell layer from the shell, in radii.
const SHELL_LAYER: f64 = 1.1;

/// Half arc of the shell, about the middle of the bed, for measurements of the layer, degrees.
const HALF_ARC: f64 = 30.0;

/// Half width of the strip across the surface for the velocity profile, diameters.
const HALF_STRIP: f64 = 2.0;

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    let Some(drum) = &view.setting.drum else {
        return Ok(());
    };
    if drum.sense() == 0.0 {
        return Err(format!("the drum does not turn at {} s", view.frame.time));
    }
    if let Some(ratio) = speed_ratio(view, drum) {
        readings.add("shell_layer_speed_ratio", ratio);
    }
    let turning = (view.frame.contacts.iter())
        .filter(|contact| matches!(contact.second, Partner::Wall(wall) if drum.walls.contains(&wall)));
    let torque: f64 = turning
        .map(|contact| (Vector3::from(contact.point) - drum.centre).cross(&contact.force_on_partner()).dot(&drum.axis))
        .sum();
    if !view.frame.contacts.is_empty() {
        readings.add("wall_torque", -torque * drum.sense());
    }
    Ok(())
}

/// Returns the angular speed of the grains at the shell about the axis, over the drum's. The grains have centres within 1.1 radii of the shell,
/// within 30 degrees of the bed's middle, and at least two diameters from the ends.
fn speed_ratio(view: &View<'_>, drum: &Drum) -> Option<f64> {
    let grains = &view.frame.particles;
    let middle = grains.iter().map(|grain| Vector3::from(grain.position)).sum::<Vector3<f64>>() / grains.len() as f64;
    let [across, up] = drum.section(&middle);
    let ends = 2.0 * view.setting.diameter;
    let mut ratios = Vec::new();
    for grain in grains {
        let place = Vector3::from(grain.position);
        let [x, y] = drum.section(&place);
        // Most grains lie far inside the shell: rounding does not exclude one of the layer.
        if (x * x + y * y).sqrt() < drum.radius - 1.001 * SHELL_LAYER * grain.radius {
            continue;
        }
        let distance = x.hypot(y);
        let beside = (x * across + y * up) / (distance * across.hypot(up));
        if drum.radius - distance <= SHELL_LAYER * grain.radius
            && beside >= HALF_ARC.to_radians().cos()
            && drum.distance_to_ends(&place) >= ends
        {
            let tangent = drum.axis.cross(&(place - drum.centre));
            ratios.push(Vector3::from(grain.velocity).dot(&tangent) / (distance * distance * drum.rate));
        }
    }
    (!ratios.is_empty()).then(|| mean(&ratios))
}

/// Measures the flow over all frames; the drum turns in one sense in all of them.
pub fn measure_flow<F: Frames + ?Sized>(
    setting: &Setting<'_>,
    drum: &Drum,
    bed: &BedSurfaces,
    frames: &F,
) -> Result<Vec<Measurement>, F::Error> {
    let profile = |surface: &Option<BedSurface>| Some(Profile::new(setting, drum, surface.as_ref()?.line));
    let mut whole = profile(&bed.whole);
    let mut parts: Vec<Option<Profile<'_>>> = bed.parts.iter().map(profile).collect();
    let mut number = 0;
    frames.visit_grains(0..frames.count(), &mut |frame| {
        let block = bed.blocks.iter().position(|block| block.contains(&number));
        number += 1;
        whole.iter_mut().chain(block.and_then(|block| parts[block].as_mut())).for_each(|profile| profile.add(frame));
    })?;
    let mut measurements = Vec::new();
    if let Some((thickness, speed)) = whole.and_then(|profile| profile.flowing_layer()) {
        let parts: Vec<(f64, f64)> = parts.iter().flatten().filter_map(Profile::flowing_layer).collect();
        let error = |pick: fn(&(f64, f64)) -> f64| standard_error(&parts.iter().map(pick).collect::<Vec<_>>());
        measurements.push(Measurement::of("flowing_layer_thickness", thickness, error(|part| part.0), number));
        measurements.push(Measurement::of("surface_speed", speed, error(|part| part.1), number));
    }
    Ok(measurements)
}

/// Measures the mixing in the last frame of the grains on either side of their median across the drum in the first frame;
/// `None` for a single frame.
pub fn measure_mixing<F: Frames + ?Sized>(
    setting: &Setting<'_>,
    drum: &Drum,
    frames: &F,
) -> Result<Option<Measurement>, F::Error> {
    let count = frames.count();
    if count < 2 {
        return Ok(None);
    }
    // Identities and positions across the drum in the first frame, in the order of identities.
    let mut across: Vec<(u64, f64)> = Vec::new();
    frames.visit_grains(0..1, &mut |first| {
        let places = first.particles.iter();
        across =
            places.map(|grain| (lasting_number(first, grain.id), drum.section(&grain.position.into())[0])).collect();
    })?;
    across.sort_unstable_by_key(|(grain, _)| *grain);
    let mut sorted: Vec<f64> = across.iter().map(|(_, place)| *place).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let Some(&median) = sorted.get(sorted.len() / 2) else { return Ok(None) };
    let mut index = None;
    frames.visit_grains(count - 1..count, &mut |last| {
        let places = last.particles.iter().map(|grain| {
            let point = Vector3::from(grain.position);
            let [x, y] = drum.section(&point);
            let known = across.binary_search_by_key(&lasting_number(last, grain.id), |(grain, _)| *grain);
            let is_marked = known.is_ok_and(|place| across[place].1 < median);
            ([x, y, (point - drum.centre).dot(&drum.axis)], is_marked)
        });
        index = lacey_index(places, MIXING_CELL * setting.diameter);
    })?;
    Ok(index.map(|index| Measurement::of("lacey_mixing_index", index, None, count)))
}

/// Velocity down the slope against depth below a surface, in bins of half a mean diameter.
struct Profile<'a> {
    setting: &'a Setting<'a>,
    drum: &'a Drum,
    line: Line,
    sums: Vec<f64>,
    counts: Vec<usize>,
}

impl<'a> Profile<'a> {
    fn new(setting: &'a Setting<'a>, drum: &'a Drum, line: Line) -> Self {
        let bins = (drum.radius / (0.5 * setting.diameter)).ceil() as usize;
        Self { setting, drum, line, sums: vec![0.0; bins], counts: vec![0; bins] }
    }

    fn bin(&self) -> f64 {
        0.5 * self.setting.diameter
    }

    fn add(&mut self, frame: &Snapshot) {
        let (line, drum, bin) = (self.line, self.drum, self.bin());
        let middle = line.foot([0.0; 2]);
        let downhill = -(drum.across * line.direction[0] + drum.up * line.direction[1]);
        for grain in &frame.particles {
            let place = drum.section(&grain.position.into());
            let along = line.along(place) - line.along(middle);
            let depth = -line.above(place);
            if along.abs() < HALF_STRIP * self.setting.diameter && depth > -bin {
                let index = (depth.max(0.0) / bin) as usize;
                if index < self.sums.len() {
                    self.sums[index] += Vector3::from(grain.velocity).dot(&downhill);
                    self.counts[index] += 1;
                }
            }
        }
    }

    /// Returns the thickness of the flowing layer (diameters) and the speed at the surface (m/s).
    fn flowing_layer(&self) -> Option<(f64, f64)> {
        let profile: Vec<(f64, f64)> = (0..self.sums.len())
            .filter(|&index| self.counts[index] > 0)
            .map(|index| ((index as f64 + 0.5) * self.bin(), self.sums[index] / self.counts[index] as f64))
            .collect();
        let turn = profile.windows(2).find(|pair| pair[0].1 > 0.0 && pair[1].1 <= 0.0)?;
        let [(shallow, fast), (deep, slow)] = [turn[0], turn[1]];
        let depth = shallow + (deep - shallow) * fast / (fast - slow);
        Some((depth / self.setting.diameter, profile[0].1))
    }
}
