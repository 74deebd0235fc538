//! Recorded measurements of known beds: a change in the order of sums over frames may change no digit.

use crate::support::beds::{Random, drum_scene, frame, particles, random_crystal, recording, scene, tilted_drum};
use makadam::checkpoint::checksum;
use makadam::snapshot::{Contact, Partner, Snapshot};
use makadam_frames::neighbours::close_pairs;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::{Measurement, force_distribution, measure};
use nalgebra::Vector3;

/// Every observable.
const ALL: &str = r#"["dynamic-angle-of-repose", "static-angle-of-repose", "packing-fraction", "coordination-number",
    "contact-forces", "drum-flow", "size-mixing", "driven-wall", "balances"]"#;

const BOX: &str = r#"
[[wall]]
name = "box"
material = "grain"
shape = { kind = "box", min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1], open = ["+z"] }
"#;

const HEAP: &str = r#"
[[wall]]
name = "plate"
material = "grain"
shape = { kind = "plane", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
"#;

/// Gives a frame contacts, with forces and velocities from a generator.
fn alive(mut frame: Snapshot, random: &mut Random) -> Snapshot {
    for grain in &mut frame.particles {
        let [x, _, z] = grain.position;
        grain.velocity = [-0.5 * (z + 0.03) + 0.01 * random.uniform(), 0.01 * random.uniform(), 0.5 * x];
        grain.radius *= 0.95 + 0.12 * random.uniform();
    }
    let mut pairs = close_pairs(&frame.particles, 0.002);
    pairs.sort_by_key(|pair| (pair.first, pair.second));
    for pair in pairs {
        let arm =
            Vector3::from(frame.particles[pair.second].position) - Vector3::from(frame.particles[pair.first].position);
        let force = -random.uniform().max(1e-6).ln();
        frame.contacts.push(Contact {
            first: pair.first as u32,
            second: Partner::Grain(pair.second as u32),
            point: (Vector3::from(frame.particles[pair.first].position) + 0.5 * arm).into(),
            normal: arm.normalize().into(),
            normal_force: force,
            tangential_force: [0.4 * force * random.uniform(), 0.0, 0.0],
        });
    }
    for first in 0..20 {
        frame.contacts.push(Contact {
            first,
            second: Partner::Wall(0),
            point: frame.particles[first as usize].position,
            normal: [0.0, 0.0, -1.0],
            normal_force: random.uniform(),
            tangential_force: [0.3 * random.uniform(), 0.0, 0.0],
        });
    }
    frame
}

/// Frames of a drum, a bed in a box and a heap, each with the scene that it is measured by.
fn beds() -> [(&'static str, MeasuredScene, Vec<Snapshot>); 3] {
    let mut random = Random(11);
    let drum = tilted_drum(13, 25.0, 0.01, 0.005).into_iter().map(|frame| alive(frame, &mut random)).collect();
    let mut random = Random(12);
    let packing = (0..9).map(|index| {
        let places: Vec<_> = random_crystal(&mut random, 0.094).into_iter().filter(|p| p.z < 0.05).collect();
        alive(frame(index as f64, particles(places, 0.005)), &mut random)
    });
    let packing = packing.collect();
    let mut random = Random(13);
    let heap = (0..6).map(|index| {
        let mut places: Vec<_> = (random_crystal(&mut random, 0.16).into_iter())
            .filter(|p| p.z > 0.005 && p.z < 0.5 * (0.15 - p.x.hypot(p.y)))
            .collect();
        places.extend((0..20).map(|n| Vector3::new(0.3 + 0.02 * f64::from(n), 0.1, 0.005)));
        alive(frame(index as f64, particles(places, 0.005)), &mut random)
    });
    let heap = heap.collect();
    [
        ("drum", drum_scene(-1.0, ALL), drum),
        ("packing", scene(BOX, ALL, "from = 0.0"), packing),
        ("heap", scene(HEAP, ALL, "from = 0.0"), heap),
    ]
}

/// Measurements to eleven digits, beyond which functions of the system's library differ between machines.
fn digits(measured: &[Measurement]) -> String {
    let error = |one: &Measurement| one.standard_error.map_or(String::new(), |error| format!("{error:.7e}"));
    let line = |one: &Measurement| format!("{} {:.10e} {} {}\n", one.observable, one.value, error(one), one.frames);
    measured.iter().map(line).collect()
}

#[test]
fn measurements_have_the_digits_that_they_had() {
    let expected: [(u64, u64); 3] = [
        (0x21ba_1a7f_53e4_20db, 0x4e1d_a679_5a66_8342),
        (0x36a4_fe1d_e637_4a5d, 0xf3a4_ed2d_097e_5a02),
        (0x2513_1ed4_0672_d565, 0x2455_41a4_0e6e_dac4),
    ];
    let found = beds().map(|(name, scene, frames)| {
        let run = recording(frames);
        let measured = digits(&measure(&scene, &run));
        let forces = force_distribution(&scene, std::slice::from_ref(&run));
        let counts: Vec<u64> =
            forces.density.iter().map(|d| (d * forces.samples as f64 * 0.25).round() as u64).collect();
        println!("{name}\n{measured}{counts:?}");
        (checksum(measured.as_bytes()), checksum(format!("{counts:?}").as_bytes()))
    });
    assert_eq!(found, expected, "{found:#018x?}");
}
