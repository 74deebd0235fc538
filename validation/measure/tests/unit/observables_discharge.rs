//! Unit tests of `src/observables/discharge.rs`.

use super::*;
use makadam::snapshot::Particle;
use makadam_frames::plan::MeasuredScene;

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
    let text = include_str!("../../../templates/silo.toml");
    let grain = |height: f64| Particle {
        id: 0,
        position: [0.0, 0.0, height],
        radius: 0.005,
        velocity: [0.0; 3],
        spin: [0.0; 3],
    };
    let at = |time: f64, height: f64| Snapshot { time, particles: vec![grain(height)], ..Snapshot::default() };
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    let found = |scene: &MeasuredScene, frame: &Snapshot| {
        let Ok(measured) = measure(&Properties::new(scene), &[frame][..]);
        measured.unwrap()[0].value
    };
    let mut scene = MeasuredScene::parse(text).unwrap();
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
    let text = include_str!("../../../templates/silo.toml");
    let scene = MeasuredScene::parse(text).unwrap();
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
    let drum = MeasuredScene::parse(include_str!("../../../templates/drum.toml")).unwrap();
    assert_eq!(measure(&Properties::new(&drum), &shown[..]), Ok(Ok(Vec::new())));
}

/// Frames a second apart of grains through the disc of a silo, each with the numbers and heights (m) of its grains.
fn deleted(frames: &[&[(u32, f64)]]) -> Result<Vec<Measurement>, String> {
    let scene = MeasuredScene::parse(include_str!("../../../templates/silo.toml")).unwrap();
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

#[test]
fn what_falls_over_the_outer_edge_has_not_passed() {
    let text = include_str!("../../../templates/silo.toml");
    let mut scene = MeasuredScene::parse(text).unwrap();
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    // The hole has a radius of 40 mm, the disc of 80 mm.
    let frame = |(number, places): (usize, &Vec<[f64; 2]>)| Snapshot {
        time: 0.01 * number as f64,
        particles: (0..)
            .zip(places)
            .map(|(id, &[x, z])| Particle {
                id,
                position: [x, 0.0, z],
                radius: 0.005,
                velocity: [0.0; 3],
                spin: [0.0; 3],
            })
            .collect(),
        ..Snapshot::default()
    };
    let measured = |scene: &MeasuredScene, places: &[Vec<[f64; 2]>]| {
        let frames: Vec<Snapshot> = places.iter().enumerate().map(frame).collect();
        let Ok(found) = measure(&Properties::new(scene), &frames.iter().collect::<Vec<_>>()[..]);
        found.map(|found| found.iter().find(|one| one.observable == "discharged_mass").unwrap().value)
    };
    // One through the hole, which then lies far off; one over the edge; one that jumps back onto the disc and falls over the edge.
    let near = [
        vec![[0.03, 0.003], [0.078, 0.005], [0.079, 0.005]],
        vec![[0.032, -0.005], [0.084, -0.004], [0.081, -0.002]],
        vec![[0.1, -0.1], [0.1, -0.1], [0.079, 0.004]],
        vec![[0.2, -0.2], [0.2, -0.2], [0.084, -0.003]],
    ];
    let far = [vec![[0.07, 0.1]], vec![[0.15, -0.195]]];
    assert_eq!(measured(&scene, &near), Ok(3.0 * mass), "a shell stands on the disc");
    assert_eq!(measured(&scene, &far), Ok(mass));
    scene.wall.retain(|wall| wall.name != "shell");
    assert_eq!(measured(&scene, &near), Ok(mass));
    assert!(measured(&scene, &far).unwrap_err().contains("frames are too far apart to tell"));
    // Inside the outer edge before and after there is but one way.
    assert_eq!(measured(&scene, &[vec![[0.07, 0.1]], vec![[0.02, -0.195]]]), Ok(mass));
}
