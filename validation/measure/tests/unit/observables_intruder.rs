//! Unit tests of `src/observables/intruder.rs`.

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
    let mut scene = MeasuredScene::parse(text).unwrap();
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
    let measured = |scene: &MeasuredScene| {
        let Ok(measured) = measure_frames(scene, &shown[..]);
        measured.unwrap().measurements.into_iter().map(|one| (one.observable, one.value)).collect::<Vec<_>>()
    };
    let values = [("intruder_height", 0.035), ("largest_intruder_depth", -0.02), ("intruder_speed", 3.0)];
    assert_eq!(measured(&scene), values.map(|(name, value)| (name.to_string(), value)));
    let heights = over_time(&Properties::new(&scene), &frames);
    assert_eq!(heights, [(0.0, 0.05), (0.05, 0.02)]);
    scene.grain.clear();
    assert_eq!(measured(&scene), []);
}
