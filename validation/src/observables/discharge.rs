//! Discharge: the mass that passes through the hole of a disc, such as the floor of a silo, and its rate.
//!
//! Grains have passed whose centres lie below the disc, wherever it has moved to; without gravity across it, on the side that its normal
//! points away from. The rate is what has passed between the first frame and the last one, over the time between them; its standard error
//! is over blocks of time.

use super::frames::Frames;
use super::measurement::{Measurement, Quantity};
use super::setting::Setting;
use crate::statistics::{block_count, standard_error};
use makadam::scene::Shape;
use makadam::snapshot::Snapshot;
use makadam::wall::PlacedWalls;
use nalgebra::Vector3;

const RATE: Quantity = Quantity::mean("mass_flow_rate", "kg/s");
const MASS: Quantity = Quantity::largest("discharged_mass", "kg");

/// Share of gravity across a disc from which on it has a side below it.
const ACROSS: f64 = 1e-6;

/// A plane with a hole: a point of it and its unit normal towards the grains that have not passed, as the scene places it.
struct Outlet {
    wall: usize,
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

impl Outlet {
    /// The scene's first disc with a hole; absent where there is none.
    fn find(setting: &Setting<'_>) -> Option<Outlet> {
        setting.scene.wall.iter().enumerate().find_map(|(wall, known)| match &known.shape {
            Shape::Disc { centre, normal, hole, .. } if *hole > 0.0 => {
                let normal = Vector3::from(*normal).normalize();
                let up = setting.up.map_or(0.0, |up| up.dot(&normal));
                let normal = if up < -ACROSS { -normal } else { normal };
                Some(Outlet { wall, point: Vector3::from(*centre), normal })
            }
            _ => None,
        })
    }

    /// Mass beyond it, kg.
    fn passed(&self, setting: &Setting<'_>, frame: &Snapshot) -> f64 {
        let scene = setting.scene;
        let walls = PlacedWalls::at(&scene.wall, &scene.domain, frame.time, &frame.driven_walls);
        let point = walls.point_of(self.wall, &self.point);
        let normal = walls.point_of(self.wall, &(self.point + self.normal)) - point;
        let beyond = |place: [f64; 3]| (Vector3::from(place) - point).dot(&normal) < 0.0;
        let grains = frame.particles.iter().filter(|grain| beyond(grain.position));
        grains.map(|grain| setting.mass(grain)).sum()
    }
}

/// Measures mass and rate; nothing where no disc has a hole, and no rate of a single frame.
///
/// # Errors
/// Where a frame cannot be shown.
pub fn measure<F: Frames + ?Sized>(setting: &Setting<'_>, frames: &F) -> Result<Vec<Measurement>, F::Error> {
    let Some(outlet) = Outlet::find(setting) else { return Ok(Vec::new()) };
    let mut passed: Vec<[f64; 2]> = Vec::new();
    frames.each(&mut |frame| passed.push([frame.time, outlet.passed(setting, frame)]))?;
    let mut measurements = Vec::new();
    if let Some(rate) = rate(&passed) {
        measurements.push(RATE.measured(rate, error_of_rate(&passed), passed.len()));
    }
    if let Some([_, mass]) = passed.last() {
        measurements.push(MASS.measured(*mass, None, passed.len()));
    }
    Ok(measurements)
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
            let setting = Setting::new(scene, frame);
            let Ok(measured) = measure(&setting, &[frame][..]);
            measured[0].value
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
        let setting = Setting::new(&scene, &frames[0]);
        let Ok(measured) = measure(&setting, &shown[..]);
        let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
        approx::assert_relative_eq!(measured[0].value, 30.0 * mass, max_relative = 1e-12);
        assert!(measured[0].standard_error.unwrap() < 1e-9 * measured[0].value);
        approx::assert_relative_eq!(measured[1].value, 36.0 * mass, max_relative = 1e-12);
        let Ok(single) = measure(&setting, &shown[..1]);
        assert_eq!(single.iter().map(|one| one.observable.as_str()).collect::<Vec<_>>(), ["discharged_mass"]);
        let drum = Scene::parse(include_str!("../../templates/drum.toml")).unwrap();
        let Ok(none) = measure(&Setting::new(&drum, &frames[0]), &shown[..]);
        assert!(none.is_empty());
    }
}
