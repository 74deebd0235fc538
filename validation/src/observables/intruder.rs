//! The intruder: the first grain that a scene lists by itself, such as a ball that is shot into a bed.

use super::measurement::{Quantity, Readings};
use super::setting::{Properties, Setting};
use super::view::View;
use crate::plan::{Scene, lasting_number};
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;

/// Name of the height, of which there is a series over time.
pub const HEIGHT_NAME: &str = "intruder_height";

const HEIGHT: Quantity = Quantity::mean(HEIGHT_NAME, "m");
const SPEED: Quantity = Quantity::mean("intruder_speed", "m/s");

/// The grain itself. Listed grains are numbered before all others, so its lasting number is 0.
fn of<'f>(scene: &Scene, frame: &'f Snapshot) -> Option<&'f Particle> {
    scene.grain.first()?;
    frame.particles.iter().find(|grain| lasting_number(frame, grain.id) == 0)
}

/// Its height above the origin, against gravity, m; `None` where there is no gravity, or no such grain in the frame.
fn height(setting: &Setting<'_>, frame: &Snapshot) -> Option<f64> {
    Some(Vector3::from(of(setting.scene(), frame)?.position).dot(&setting.up?))
}

/// Adds `intruder_height` and `intruder_speed`. Nothing is read where the scene lists no grain by itself.
pub fn read(view: &View<'_>, readings: &mut Readings) {
    if let Some(height) = height(view.setting, view.frame) {
        readings.add(HEIGHT, height);
    }
    if let Some(grain) = of(view.setting.scene(), view.frame) {
        readings.add(SPEED, Vector3::from(grain.velocity).norm());
    }
}

/// Its height in each frame: times in s, heights in m.
pub fn over_time(properties: &Properties<'_>, frames: &[Snapshot]) -> Vec<(f64, f64)> {
    let at = |frame: &Snapshot| Some((frame.time, height(&Setting::new(properties, frame), frame)?));
    frames.iter().filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observables::measure_frames;

    #[test]
    fn it_is_the_first_listed_grain_wherever_it_stands_in_the_frame() {
        let text = "name = 'shot'\ndescription = 'x'\nduration = 0.1\ngravity = [0.0, -9.81, 0.0]\n\
            domain = { min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }\n\
            [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
            [[grain]]\nmaterial = 'grain'\nradius = 0.01\nposition = [0, 0.05, 0]\n\
            [[grain]]\nmaterial = 'grain'\nradius = 0.001\nposition = [0, 0, 0]\n\
            [measure]\nfrom = 0.0\nobservables = ['intruder']\n";
        let mut scene = Scene::parse(text).unwrap();
        let grain = |id: u32, height: f64, speed: f64| Particle {
            id,
            position: [0.03, height, -0.02],
            radius: 0.01,
            velocity: [0.0, -speed, 0.0],
            spin: [0.0; 3],
        };
        let at = |time: f64, height: f64, speed: f64| Snapshot {
            time,
            particles: vec![grain(1, -0.04, 0.0), grain(0, height, speed)],
            ..Snapshot::default()
        };
        let frames = [at(0.0, 0.05, 5.0), at(0.05, 0.02, 1.0)];
        let shown: Vec<&Snapshot> = frames.iter().collect();
        let measured = |scene: &Scene| {
            let Ok(measured) = measure_frames(scene, &shown[..]);
            measured.unwrap().measurements.into_iter().map(|one| (one.observable, one.value)).collect::<Vec<_>>()
        };
        assert_eq!(measured(&scene), [("intruder_height".into(), 0.035), ("intruder_speed".into(), 3.0)]);
        let heights = over_time(&Properties::new(&scene), &frames);
        assert_eq!(heights, [(0.0, 0.05), (0.05, 0.02)]);
        scene.grain.clear();
        assert_eq!(measured(&scene), []);
    }
}
