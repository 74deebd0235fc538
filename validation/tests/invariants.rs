//! Invariants of all observables, on beds drawn at random. `MAKADAM_RANDOM_SCENES` sets the number of beds of each property.

use crate::support::beds::{Random, drum_scene, frame, particles, random_crystal, scene, tilted_drum};
use crate::support::turn::{Turn, turned};
use makadam::scene::{Axis, Domain, GravityChange};
use makadam::snapshot::{Contact, DrivenWall, Partner, Snapshot};
use makadam_frames::neighbours::close_pairs;
use makadam_frames::plan::{MeasuredScene, Observable};
use makadam_measure::observables::catalogue::{definition, definitions};
use makadam_measure::observables::{Measurement, measure_frames};
use nalgebra::Vector3;

/// Every group of observables.
const ALL: [Observable; 11] = [
    Observable::DynamicAngleOfRepose,
    Observable::StaticAngleOfRepose,
    Observable::PackingFraction,
    Observable::CoordinationNumber,
    Observable::ContactForces,
    Observable::Balances,
    Observable::DrumFlow,
    Observable::SizeMixing,
    Observable::DrivenWall,
    Observable::Discharge,
    Observable::Intruder,
];

/// Kinds of beds, each with a number that its bed must have.
const KINDS: [(&str, &str); 6] = [
    ("box", "packing_fraction"),
    ("drum", "dynamic_angle_of_repose"),
    ("heap", "static_angle_of_repose"),
    ("periodic", "coordination_number"),
    ("lid", "packing_fraction"),
    ("silo", "mass_flow_rate"),
];

const BOX: &str = "[[wall]]\nname = 'box'\nmaterial = 'grain'\nshape = { kind = 'box', min = [-0.06, -0.06, -0.06], max = [0.06, 0.06, 0.1], open = ['+z'] }\n";
const PLATE: &str =
    "[[wall]]\nname = 'plate'\nmaterial = 'grain'\nshape = { kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }\n";
const LID: &str = "[[wall]]\nname = 'box'\nmaterial = 'grain'\nshape = { kind = 'box', min = [-0.05, -0.05, -0.05], max = [0.05, 0.05, 0.3], open = ['+z'] }\n\
    [[wall]]\nname = 'lid'\nmaterial = 'grain'\nshape = { kind = 'plane', point = [0, 0, 0.2], normal = [0, 0, -1] }\n\
    motion = { kind = 'force-driven', axis = [0, 0, -1], force = 5.0, mass = 0.05 }\n";
const SILO: &str = "[[wall]]\nname = 'floor'\nmaterial = 'grain'\nshape = { kind = 'disc', centre = [0, 0, 0], normal = [0, 0, 1], radius = 0.1, hole = 0.03 }\n";

/// A bed with its scene.
struct Bed {
    kind: &'static str,
    scene: MeasuredScene,
    frames: Vec<Snapshot>,
}

impl Bed {
    fn drawn(seed: u64) -> Bed {
        let mut random = Random(97 * seed + 1);
        random.uniform();
        let (kind, _) = KINDS[seed as usize % KINDS.len()];
        let (mut scene, mut frames) = match kind {
            "drum" => (drum_scene(-1.0, "[]"), tilted_drum(3, 35.0 * random.uniform(), 0.01, 0.005)),
            "heap" => (scene(PLATE, "[]", "from = 0.0"), heap(&mut random)),
            "lid" => (scene(LID, "[]", "from = 0.0"), lid(&mut random)),
            "silo" => (scene(SILO, "[]", "from = 0.0"), silo(&mut random)),
            "periodic" => {
                (scene(&PLATE.replace("[0, 0, 0]", "[0, 0, -0.06]"), "[]", "from = 0.0"), level(&mut random, 0.06))
            }
            _ => (scene(BOX, "[]", "from = 0.0"), level(&mut random, 0.054)),
        };
        if kind == "periodic" {
            let domain =
                Domain { min: [-0.06, -0.06, -0.15], max: [0.06, 0.06, 0.5], periodic: vec![Axis::X, Axis::Y] };
            scene.domain = domain;
        }
        if kind == "lid" {
            scene.gravity = [0.0; 3];
        }
        if kind == "box" {
            let change = |time: f64, size: f64| GravityChange { time, gravity: [0.0, 0.0, -9.81 * size] };
            scene.gravity_changes = vec![change(1.5, 1.0 + random.uniform()), change(3.0, 0.5)];
        }
        scene.measure.observables = ALL.to_vec();
        frames.iter_mut().for_each(|frame| alive(frame, &mut random, kind));
        Bed { kind, scene, frames }
    }

    fn measured(&self) -> Vec<Measurement> {
        measured(&self.scene, &self.frames)
    }
}

fn measured(scene: &MeasuredScene, frames: &[Snapshot]) -> Vec<Measurement> {
    let shown: Vec<&Snapshot> = frames.iter().collect();
    let Ok(measured) = measure_frames(scene, &shown[..]);
    measured.unwrap_or_default().measurements
}

fn level(random: &mut Random, half: f64) -> Vec<Snapshot> {
    let level = 0.02 + 0.02 * random.uniform();
    let bed = |random: &mut Random| {
        let places = random_crystal(random, half).into_iter().filter(|place| place.z < level);
        places.map(|place| place + Vector3::z() * (half - 0.054)).collect::<Vec<_>>()
    };
    (0..4).map(|index| frame(f64::from(index), particles(bed(random), 0.005))).collect()
}

fn heap(random: &mut Random) -> Vec<Snapshot> {
    let slope = (15.0 + 20.0 * random.uniform()).to_radians().tan();
    let bed = |random: &mut Random| {
        let mut places: Vec<_> = (random_crystal(random, 0.16).into_iter())
            .filter(|p| p.z > 0.005 && p.z < slope * (0.15 - p.x.hypot(p.y)))
            .collect();
        places.extend((0..20).map(|n| Vector3::new(0.3 + 0.02 * f64::from(n), 0.1, 0.005)));
        places
    };
    (0..3).map(|index| frame(f64::from(index), particles(bed(random), 0.005))).collect()
}

fn lid(random: &mut Random) -> Vec<Snapshot> {
    let bed = |index: u32| {
        let height = 0.05 - 0.004 * f64::from(index);
        let places: Vec<_> = random_crystal(random, 0.046).into_iter().filter(|p| p.z < height - 0.004).collect();
        let driven_walls = vec![DrivenWall { wall: 1, displacement: 0.2 - height, rate: 0.0 }];
        Snapshot { driven_walls, ..frame(f64::from(index), particles(places, 0.005)) }
    };
    (0..3).map(bed).collect()
}

/// Grains that fall through a hole at random and are deleted a frame later.
fn silo(random: &mut Random) -> Vec<Snapshot> {
    let start: Vec<_> = random_crystal(random, 0.04).into_iter().map(|p| p + Vector3::z() * 0.05).collect();
    let falls: Vec<f64> = start.iter().map(|_| 6.0 * random.uniform()).collect();
    let at = |index: u32| {
        let mut grains = particles(start.iter().copied(), 0.005);
        for (grain, fall) in grains.iter_mut().zip(&falls) {
            grain.position[2] -= if *fall < f64::from(index) { 0.2 } else { 0.0 };
        }
        grains.retain(|grain| falls[grain.id as usize] >= f64::from(index) - 1.0);
        frame(f64::from(index), grains)
    };
    (0..5).map(at).collect()
}

/// Gives a frame sizes, velocities and contacts.
fn alive(frame: &mut Snapshot, random: &mut Random, kind: &str) {
    let small = if random.0.is_multiple_of(2) { 0.6 } else { 0.95 };
    for grain in &mut frame.particles {
        let [x, y, z] = grain.position;
        grain.velocity = [-0.5 * (z + 0.03) + 0.01 * random.uniform(), 0.01 * random.uniform(), 0.5 * x];
        grain.spin = [y, 10.0 * random.uniform(), z];
        // Grains of a silo keep their sizes.
        if kind != "silo" {
            grain.radius *= small + (1.07 - small) * random.uniform();
        }
    }
    for pair in close_pairs(&frame.particles, 0.002) {
        let (a, b) = (&frame.particles[pair.first], &frame.particles[pair.second]);
        let arm = Vector3::from(b.position) - Vector3::from(a.position);
        let force = -random.uniform().max(1e-6).ln();
        frame.contacts.push(Contact {
            first: a.id,
            second: Partner::Grain(b.id),
            point: (Vector3::from(a.position) + 0.5 * arm).into(),
            normal: arm.normalize().into(),
            normal_force: force,
            tangential_force: arm.cross(&Vector3::x()).normalize().scale(0.4 * force * random.uniform()).into(),
        });
    }
    for grain in frame.particles.iter().take(20) {
        frame.contacts.push(Contact {
            first: grain.id,
            second: Partner::Wall(0),
            point: grain.position,
            normal: [0.0, 0.0, -1.0],
            normal_force: random.uniform(),
            tangential_force: [0.3 * random.uniform(), 0.0, 0.0],
        });
    }
}

/// Checks a property of as many beds as were asked for.
fn of_beds(usual: u64, check: impl Fn(&Bed, &mut Random)) {
    let asked = std::env::var("MAKADAM_RANDOM_SCENES").ok().map(|count| count.parse().expect("a whole number"));
    for seed in 0..asked.unwrap_or(usual) {
        let bed = Bed::drawn(seed);
        check(&bed, &mut Random(seed ^ 0x5eed));
    }
}

/// Asserts that two sets of numbers are the same ones with the same values, to a part of them.
fn assert_same(bed: &Bed, found: &[Measurement], expected: &[Measurement], part: f64, what: &str) {
    let names = |all: &[Measurement]| all.iter().map(|one| one.observable.clone()).collect::<Vec<_>>();
    assert_eq!(names(found), names(expected), "{} {what}", bed.kind);
    for (found, expected) in found.iter().zip(expected) {
        let off = (found.value - expected.value).abs();
        let name = &found.observable;
        assert!(
            off <= part * expected.value.abs() + 1e-12,
            "{} {what}: {name} is {} and was {}",
            bed.kind,
            found.value,
            expected.value
        );
    }
}

#[test]
fn beds_have_what_they_are_drawn_for() {
    for (seed, (kind, name)) in (0..).zip(KINDS) {
        let measured = Bed::drawn(seed).measured();
        assert!(measured.iter().any(|one| one.observable == name), "{kind}: {measured:?}");
    }
    let all = definitions().filter(|(_, definition)| !definition.name.contains('(')).count();
    let mut seen: Vec<String> =
        (0..24).flat_map(|seed| Bed::drawn(seed).measured()).map(|one| one.observable).collect();
    seen.sort();
    seen.dedup();
    // No bed lists a grain or has two populations.
    assert_eq!(seen.len(), all - 5, "{seen:?}");
}

#[test]
fn a_run_has_the_mean_of_its_frames() {
    of_beds(6, |bed, _| {
        let frames: Vec<Vec<Measurement>> =
            bed.frames.iter().map(|frame| measured(&bed.scene, std::slice::from_ref(frame))).collect();
        for one in bed.measured() {
            if definition(&one.observable).unwrap().span {
                continue;
            }
            let of_frame =
                |frame: &Vec<Measurement>| frame.iter().find(|of| of.observable == one.observable).map(|of| of.value);
            let values: Vec<f64> = frames.iter().filter_map(of_frame).collect();
            let expected = match one.observable.as_str() {
                "largest_overlap" | "coulomb_excess" => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                _ => values.iter().sum::<f64>() / values.len() as f64,
            };
            let off = (one.value - expected).abs();
            assert!(off <= 1e-12 * expected.abs(), "{}: {} is {} for {expected}", bed.kind, one.observable, one.value);
        }
    });
}

#[test]
fn no_number_depends_on_which_others_are_measured() {
    of_beds(6, |bed, _| {
        let all = bed.measured();
        let mut apart = Vec::new();
        for group in ALL {
            let mut scene = bed.scene.clone();
            scene.measure.observables = vec![group];
            apart.extend(measured(&scene, &bed.frames));
        }
        let order = |mut numbers: Vec<Measurement>| {
            numbers.sort_by(|a, b| a.observable.cmp(&b.observable));
            numbers
        };
        assert_eq!(order(apart), order(all), "{}", bed.kind);
    });
}

#[test]
fn numbers_are_those_of_the_scene_turned_and_shifted() {
    of_beds(6, |bed, random| {
        let shift = Vector3::from_fn(|_, _| 3.0 * random.uniform() - 1.5);
        let turn = Turn::drawn((random.uniform() * 24.0) as usize, shift);
        let (scene, frames) = turned(&turn, &bed.scene, &bed.frames);
        // The intruder's height alone goes by the origin, and no bed has one.
        assert_same(bed, &measured(&scene, &frames), &bed.measured(), 1e-8, &format!("{turn:?}"));
    });
}

#[test]
fn numbers_do_not_go_by_the_order_of_ids() {
    of_beds(6, |bed, random| {
        let most = bed.frames.iter().flat_map(|frame| &frame.particles).map(|grain| grain.id).max().unwrap();
        let mut new: Vec<u32> = (0..=most).collect();
        for place in (1..new.len()).rev() {
            new.swap(place, (random.uniform() * (place + 1) as f64) as usize);
        }
        let renamed = |frame: &Snapshot| {
            let mut frame = frame.clone();
            frame.particles.iter_mut().for_each(|grain| grain.id = new[grain.id as usize]);
            frame.particles.sort_by_key(|grain| grain.id);
            for contact in &mut frame.contacts {
                contact.first = new[contact.first as usize];
                if let Partner::Grain(second) = &mut contact.second {
                    *second = new[*second as usize];
                }
            }
            frame
        };
        let frames: Vec<Snapshot> = bed.frames.iter().map(renamed).collect();
        assert_same(bed, &measured(&bed.scene, &frames), &bed.measured(), 1e-9, "renamed");
    });
}

#[test]
fn grains_may_lie_in_any_period() {
    of_beds(6, |bed, random| {
        let mut frames = bed.frames.clone();
        for grain in frames.iter_mut().flat_map(|frame| &mut frame.particles) {
            for axis in bed.scene.domain.periodic.iter().map(|axis| axis.number()) {
                let length = bed.scene.domain.max[axis] - bed.scene.domain.min[axis];
                grain.position[axis] += length * (4.0 * random.uniform() - 2.0).floor();
            }
        }
        assert_same(bed, &measured(&bed.scene, &frames), &bed.measured(), 1e-9, "in other periods");
    });
}

#[test]
fn last_bits_of_radii_and_positions_do_not_matter() {
    of_beds(6, |bed, random| {
        let mut frames = bed.frames.clone();
        let mut nudge = |value: &mut f64| *value *= 1.0 + 1e-14 * (random.uniform() - 0.5);
        for grain in frames.iter_mut().flat_map(|frame| &mut frame.particles) {
            nudge(&mut grain.radius);
            grain.position.iter_mut().for_each(&mut nudge);
        }
        assert_same(bed, &measured(&bed.scene, &frames), &bed.measured(), 1e-7, "nudged");
    });
}
