//! Discharge: the mass that passes through the hole of a disc, such as the floor of a silo, and its rate.
//!
//! Grains have passed whose centres lie on the side of the disc that its normal points away from. The rate is the mean of the rates from
//! frame to frame; its standard error is over blocks of time.

use super::frames::Frames;
use super::measurement::{Measurement, Quantity};
use super::setting::Setting;
use crate::statistics::block_average;
use makadam::scene::{Motion, Shape};
use makadam::snapshot::Snapshot;
use nalgebra::Vector3;

const RATE: Quantity = Quantity::mean("mass_flow_rate", "kg/s");
const MASS: Quantity = Quantity::largest("discharged_mass", "kg");

/// A plane with a hole: a point of it and its unit normal towards the grains that have not passed.
struct Outlet {
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

impl Outlet {
    /// The scene's first disc with a hole that does not move; absent where there is none.
    fn find(setting: &Setting<'_>) -> Option<Outlet> {
        setting.scene.wall.iter().find_map(|wall| match (&wall.shape, &wall.motion) {
            (Shape::Disc { centre, normal, hole, .. }, Motion::Fixed) if *hole > 0.0 => {
                Some(Outlet { point: Vector3::from(*centre), normal: Vector3::from(*normal).normalize() })
            }
            _ => None,
        })
    }

    /// Mass beyond it, kg.
    fn passed(&self, setting: &Setting<'_>, frame: &Snapshot) -> f64 {
        let beyond = |place: [f64; 3]| (Vector3::from(place) - self.point).dot(&self.normal) < 0.0;
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
    let rates: Vec<f64> = passed.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).collect();
    let mut measurements = Vec::new();
    if !rates.is_empty() {
        let average = block_average(&rates);
        measurements.push(RATE.measured(average.mean, average.standard_error, passed.len()));
    }
    if let Some([_, mass]) = passed.last() {
        measurements.push(MASS.measured(*mass, None, passed.len()));
    }
    Ok(measurements)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Scene;
    use makadam::snapshot::Particle;

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
