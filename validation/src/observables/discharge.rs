//! Discharge: the mass that passes through the hole of a disc, such as the floor of a silo, and its rate.
//!
//! Grains have passed whose centres lie below the disc, wherever it has moved to; without gravity across it, on the side that its normal
//! points away from. Grains are told apart by their lasting numbers: one that passed and was deleted later has passed. A grain that is
//! gone and had not passed in the frame before leaves open how much passed, and nothing is measured. The rate is what has passed between
//! the first frame and the last one, over the time between them; its standard error is over blocks of time.

use super::frames::Frames;
use super::measurement::{Measurement, Quantity};
use super::setting::{Properties, Setting};
use super::walls::PlacedWalls;
use crate::plan::{Scene, lasting_number};
use crate::statistics::{block_count, standard_error};
use makadam::scene::Shape;
use makadam::snapshot::Snapshot;
use nalgebra::Vector3;
use std::collections::HashMap;

const RATE: Quantity = Quantity::mean("mass_flow_rate", "kg/s");
const MASS: Quantity = Quantity::largest("discharged_mass", "kg");

/// Share of gravity across a disc from which on it has a side below it.
const ACROSS: f64 = 1e-6;

/// A plane with a hole: a point of it and its unit normal, as the scene places it.
struct Outlet {
    wall: usize,
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

/// The outlet in a frame: a point, and the unit normal towards the grains that have not passed.
struct PlacedOutlet {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    /// True if that is the side that the scene's normal points to.
    as_placed: bool,
}

impl Outlet {
    /// The scene's first disc with a hole; absent where there is none.
    fn find(scene: &Scene) -> Option<Outlet> {
        scene.wall.iter().enumerate().find_map(|(wall, known)| match &known.shape {
            Shape::Disc { centre, normal, hole, .. } if *hole > 0.0 => {
                Some(Outlet { wall, point: Vector3::from(*centre), normal: Vector3::from(*normal).normalize() })
            }
            _ => None,
        })
    }

    /// Where it stands in a frame.
    fn at(&self, setting: &Setting<'_>, frame: &Snapshot) -> PlacedOutlet {
        let walls = PlacedWalls::at(setting.scene(), frame);
        let point = walls.point_of(self.wall, &self.point);
        let normal = walls.point_of(self.wall, &(self.point + self.normal)) - point;
        let as_placed = setting.up.map_or(0.0, |up| up.dot(&normal)) >= -ACROSS;
        PlacedOutlet { point, normal: if as_placed { normal } else { -normal }, as_placed }
    }
}

impl PlacedOutlet {
    fn is_beyond(&self, place: [f64; 3]) -> bool {
        (Vector3::from(place) - self.point).dot(&self.normal) < 0.0
    }
}

/// State of a grain in the frames so far.
struct Known {
    /// Mass, kg.
    mass: f64,
    /// Number of the last frame that has it, and whether it lay beyond the outlet there.
    last: usize,
    passed: bool,
}

/// Measures mass and rate; nothing where no disc has a hole, and no rate of a single frame. The inner error says why neither is known.
///
/// # Errors
/// Where a frame cannot be shown.
pub fn measure<F: Frames + ?Sized>(
    properties: &Properties<'_>,
    frames: &F,
) -> Result<Result<Vec<Measurement>, String>, F::Error> {
    let Some(outlet) = Outlet::find(properties.scene) else { return Ok(Ok(Vec::new())) };
    let mut grains: HashMap<u64, Known> = HashMap::new();
    let mut passed: Vec<[f64; 2]> = Vec::new();
    let mut side = None;
    let mut refused = None;
    frames.each(&mut |frame| {
        let setting = Setting::new(properties, frame);
        let (outlet, number) = (outlet.at(&setting, frame), passed.len());
        if *side.get_or_insert(outlet.as_placed) != outlet.as_placed {
            refused.get_or_insert_with(|| format!("gravity turns to the other side of the disc by {} s", frame.time));
        }
        for grain in &frame.particles {
            let known =
                Known { mass: setting.mass(frame, grain), last: number, passed: outlet.is_beyond(grain.position) };
            grains.insert(lasting_number(frame, grain.id), known);
        }
        // In the order of their numbers, so that a sum has the same bits in every run.
        let mut beyond: Vec<(u64, f64)> = Vec::new();
        for (&grain, known) in &grains {
            match known.passed {
                true => beyond.push((grain, known.mass)),
                false if known.last < number => {
                    refused.get_or_insert_with(|| {
                        let time = frame.time;
                        format!("grain {grain} is gone by {time} s, and had not passed the disc in the frame before")
                    });
                }
                false => {}
            }
        }
        beyond.sort_unstable_by_key(|(grain, _)| *grain);
        passed.push([frame.time, beyond.iter().map(|(_, mass)| mass).sum()]);
    })?;
    if let Some(why) = refused {
        return Ok(Err(why));
    }
    let mut measurements = Vec::new();
    if let Some(rate) = rate(&passed) {
        measurements.push(RATE.measured(rate, error_of_rate(&passed), passed.len()));
    }
    if let Some([_, mass]) = passed.last() {
        measurements.push(MASS.measured(*mass, None, passed.len()));
    }
    Ok(Ok(measurements))
}

/// Mass over time between the first and the last of these, kg/s; the frames between may come at any times.
fn rate(passed: &[[f64; 2]]) -> Option<f64> {
    let ([start, before], [end, after]) = (passed.first()?, passed.last()?);
    (end > start).then(|| (after - before) / (end - start))
}

/// Standard error of the rate over blocks that follow each other, kg/s.
fn error_of_rate(passed: &[[f64; 2]]) -> Option<f64> {
    let gaps = passed.len().saturating_sub(1);
    let blocks = block_count(gaps)?;
    let part = |block: usize| &passed[block * gaps / blocks..=(block + 1) * gaps / blocks];
    let rates: Option<Vec<f64>> = (0..blocks).map(|block| rate(part(block))).collect();
    standard_error(&rates?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Scene;
    use makadam::snapshot::Particle;

    #[test]
    fn frames_at_unequal_times_have_the_rate_of_all_that_passed() {
        // A steady flow of 2 kg/s, and a last frame that comes at once, with a grain of 0.1 kg on its way.
        let mut passed: Vec<[f64; 2]> = (0..11).map(|n| [0.1 * f64::from(n), 0.2 * f64::from(n)]).collect();
        passed.push([1.001, 2.0]);
        approx::assert_relative_eq!(rate(&passed).unwrap(), 2.0 / 1.001, max_relative = 1e-12);
        assert!(error_of_rate(&passed).unwrap() < 0.02);
        assert_eq!(rate(&passed[..1]), None);
        assert_eq!(error_of_rate(&passed[..5]), None);
    }

    #[test]
    fn what_lies_below_has_passed_however_the_disc_is_written_and_wherever_it_moves() {
        let text = include_str!("../../templates/silo.toml");
        let grain = |height: f64| Particle {
            id: 0,
            position: [0.0, 0.0, height],
            radius: 0.005,
            velocity: [0.0; 3],
            spin: [0.0; 3],
        };
        let at = |time: f64, height: f64| Snapshot { time, particles: vec![grain(height)], ..Snapshot::default() };
        let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
        let found = |scene: &Scene, frame: &Snapshot| {
            let Ok(measured) = measure(&Properties::new(scene), &[frame][..]);
            measured.unwrap()[0].value
        };
        let mut scene = Scene::parse(text).unwrap();
        let place =
            scene.wall.iter().position(|wall| matches!(wall.shape, Shape::Disc { hole, .. } if hole > 0.0)).unwrap();
        if let Shape::Disc { normal, .. } = &mut scene.wall[place].shape {
            *normal = normal.map(|component| -component);
        }
        assert_eq!((found(&scene, &at(0.0, 0.05)), found(&scene, &at(0.0, -0.05))), (0.0, mass));
        scene.wall[place].motion = makadam::Motion::Translating { velocity: [0.0, 0.0, 1.0], start: 0.0, stop: None };
        assert_eq!((found(&scene, &at(0.0, 0.05)), found(&scene, &at(1.0, 0.05))), (0.0, mass));
    }

    #[test]
    fn the_rate_is_that_at_which_grains_pass() {
        let text = include_str!("../../templates/silo.toml");
        let scene = Scene::parse(text).unwrap();
        let grain = |id: u32, height: f64| Particle {
            id,
            position: [0.0, 0.0, height],
            radius: 0.005,
            velocity: [0.0; 3],
            spin: [0.0; 3],
        };
        // Three grains a frame fall through, one frame each 0.1 s.
        let frame = |number: u32| Snapshot {
            time: 0.1 * f64::from(number),
            particles: (0..60).map(|id| grain(id, if id < 3 * number { -0.05 } else { 0.05 })).collect(),
            ..Snapshot::default()
        };
        let frames: Vec<Snapshot> = (0..13).map(frame).collect();
        let shown: Vec<&Snapshot> = frames.iter().collect();
        let properties = Properties::new(&scene);
        let Ok(Ok(measured)) = measure(&properties, &shown[..]) else { panic!("it is measured") };
        let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
        approx::assert_relative_eq!(measured[0].value, 30.0 * mass, max_relative = 1e-12);
        assert!(measured[0].standard_error.unwrap() < 1e-9 * measured[0].value);
        approx::assert_relative_eq!(measured[1].value, 36.0 * mass, max_relative = 1e-12);
        let Ok(Ok(single)) = measure(&properties, &shown[..1]) else { panic!("it is measured") };
        assert_eq!(single.iter().map(|one| one.observable.as_str()).collect::<Vec<_>>(), ["discharged_mass"]);
        let drum = Scene::parse(include_str!("../../templates/drum.toml")).unwrap();
        assert_eq!(measure(&Properties::new(&drum), &shown[..]), Ok(Ok(Vec::new())));
    }

    /// Frames a second apart of grains through the disc of a silo, each with the numbers and heights (m) of its grains.
    fn deleted(frames: &[&[(u32, f64)]]) -> Result<Vec<Measurement>, String> {
        let scene = Scene::parse(include_str!("../../templates/silo.toml")).unwrap();
        let grain = |&(id, height): &(u32, f64)| Particle {
            id,
            position: [0.0, 0.0, height],
            radius: 0.005,
            velocity: [0.0; 3],
            spin: [0.0; 3],
        };
        let frame = |(number, grains): (usize, &&[(u32, f64)])| Snapshot {
            time: number as f64,
            particles: grains.iter().map(grain).collect(),
            ..Snapshot::default()
        };
        let frames: Vec<Snapshot> = frames.iter().enumerate().map(frame).collect();
        let Ok(measured) = measure(&Properties::new(&scene), &frames.iter().collect::<Vec<_>>()[..]);
        measured
    }

    #[test]
    fn deleted_grains_stay_discharged() {
        let before: &[(u32, f64)] = &[(0, 0.05), (1, 0.07), (2, 0.09), (3, 0.11)];
        let half = &[(0, -0.05), (1, -0.03), (2, 0.03), (3, 0.05)];
        let measured = deleted(&[before, half, &[(2, -0.05), (3, -0.03)]]).unwrap();
        let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
        approx::assert_relative_eq!(measured[0].value, 2.0 * mass, max_relative = 1e-12);
        approx::assert_relative_eq!(measured[1].value, 4.0 * mass, max_relative = 1e-12);
        // One that was above the disc may have passed before it was deleted, or not.
        let refused = deleted(&[before, half, &[(3, -0.03)]]).unwrap_err();
        assert!(refused.contains("grain 2 is gone by 2 s"), "{refused}");
    }
}
