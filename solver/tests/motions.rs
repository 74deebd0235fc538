//! Composed motions, tables of poses, walls that carry others, and driven walls with a largest speed.

use crate::common::bits::{hash_after, same_bits_everywhere, start, steps};
use crate::common::{CONVERGED_RIGID, FLOOR, Setup, grain, parse};
use approx::assert_relative_eq;
use makadam::scene::{Scene, Stop};
use makadam::snapshot::Partner;
use makadam::wall::PlacedWalls;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

type Vector = Vector3<f64>;

/// Two rotations about other points, one of which reverses, and a vibration.
const LIST: &str = "[
    { kind = 'rotating', point = [0.05, 0, 0], axis = [0, 0, 2], rate = 7, start = 0.1, reverse = 0.4 },
    { kind = 'rotating', point = [0, 0.02, 0.01], axis = [1, 1, 0], rate = -1.5, stop = 0.8 },
    { kind = 'vibrating', amplitude = [0, 0.004, 0.003], frequency = 3 },
]";

/// A closed box, of one shape for each face, with these lines of a wall; grains in it if `filled`.
fn closed_box(lines: &str, filled: bool) -> Scene {
    let shape = "kind = 'box', min = [-0.03, -0.02, -0.02], max = [0.03, 0.02, 0.02]";
    let grains = "[[population]]\ncount = 40\nmaterial = 'grain'\nradius = { kind = 'uniform', mean = 0.004, spread = 0.2 }\n\
                  region = { kind = 'box', min = [-0.03, -0.02, -0.02], max = [0.03, 0.02, 0.02] }\n";
    let body = format!(
        "[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = {{ {shape} }}\n{lines}\n{}",
        if filled { grains } else { "" }
    );
    Setup { body, ..Setup::default() }.scene()
}

fn walls_at(scene: &Scene, time: f64) -> PlacedWalls {
    PlacedWalls::at(&scene.wall, &scene.domain, time, &[], &[])
}

/// Pose of [`LIST`] in closed form.
fn pose(time: f64) -> Isometry3<f64> {
    let about = |point: [f64; 3], axis: [f64; 3], angle: f64| {
        let turn = UnitQuaternion::from_scaled_axis(Vector::from(axis).normalize() * angle);
        Translation3::from(Vector::from(point)) * turn * Translation3::from(-Vector::from(point))
    };
    let first = 7.0 * ((time.min(0.4) - 0.1).max(0.0) - (time - 0.4).max(0.0));
    let shake = Vector::new(0.0, 0.004, 0.003) * (6.0 * std::f64::consts::PI * time).sin();
    let turned = about([0.0, 0.02, 0.01], [1.0, 1.0, 0.0], -1.5 * time.min(0.8))
        * about([0.05, 0.0, 0.0], [0.0, 0.0, 1.0], first);
    Translation3::from(shake) * turned
}

#[test]
fn a_list_of_motions_is_their_product() {
    let scene = closed_box(&format!("motion = {LIST}"), false);
    let corner = Vector::new(0.03, -0.02, 0.02);
    for time in [0.0, 0.05, 0.1, 0.25, 0.55, 0.79, 1.3] {
        let walls = walls_at(&scene, time);
        let expected = pose(time) * Point3::from(corner);
        assert_relative_eq!(walls.point_of(0, &corner), expected.coords, epsilon = 1e-12);
        // Central difference of the path, away from the times at which a motion starts or stops.
        let [before, after] = [time - 1e-6, time + 1e-6].map(|time| (pose(time) * Point3::from(corner)).coords);
        if ![0.0, 0.1].contains(&time) {
            let velocity = walls.velocity_at(0, &expected.coords, &Vector::x());
            assert_relative_eq!(velocity, (after - before) / 2e-6, epsilon = 1e-8);
        }
    }
}

#[test]
fn a_table_of_a_rotation_is_that_rotation() {
    let rotating = "kind = 'rotating', point = [0.01, 0, 0], axis = [0, 1, 0], rate = 2, start = 0.2, stop = 1.7";
    // Two rows half a turn apart, after a shift of the time.
    let table = "kind = 'table', file = 'poses.csv', point = [0.01, 0, 0], start = 0.1, \
                 content = [[0.1, 0, 0, 0, 0, 0, 0], [0.6, 0, 0, 0, 0, 1, 0], [1.6, 0, 0, 0, 0, 3, 0]]";
    let [one, other] = [rotating, table].map(|motion| closed_box(&format!("motion = {{ {motion} }}"), false));
    let corner = Vector::new(0.03, -0.02, 0.02);
    for time in [0.0, 0.3, 0.9, 1.5, 1.699, 2.5] {
        let [one, other] = [&one, &other].map(|scene| walls_at(scene, time));
        let [place, same] = [&one, &other].map(|walls| walls.point_of(0, &corner));
        assert_relative_eq!(place, same, epsilon = 1e-12);
        let [velocity, equal] = [&one, &other].map(|walls| walls.velocity_at(0, &place, &Vector::x()));
        assert_relative_eq!(velocity, equal, epsilon = 1e-12);
    }
}

#[test]
fn a_wall_that_another_one_carries_has_both_motions() {
    let spin = "{ kind = 'rotating', point = [0.0, 0.0, 0.0], axis = [1, 0, 0], rate = 5 }";
    let tilt = "{ kind = 'rotating', point = [0, 0, 0.1], axis = [0, 1, 0], rate = 0.5 }";
    let frame = |motion: &str| {
        format!(
            "[[wall]]\nname = 'frame'\nmaterial = 'wall'\nmotion = {motion}\nshape = {{ kind = 'disc', centre = [0, 0, 0.2], normal = [0, 0, 1], radius = 0.01 }}"
        )
    };
    let carried = closed_box(&format!("motion = {spin}\nparent = 'frame'\n{}", frame(tilt)), true);
    let listed = closed_box(&format!("motion = [{spin}, {tilt}]\n{}", frame(tilt)), true);
    assert_eq!(hash_after(&carried, 100, |_| ()), hash_after(&listed, 100, |_| ()));
    // A wall without a motion of its own, like the lifters of a drum, moves as its parent does.
    let [along, own] = ["parent = 'frame'", &format!("motion = {tilt}")]
        .map(|lines| closed_box(&format!("{lines}\n{}", frame(tilt)), true));
    assert_eq!(hash_after(&along, 100, |_| ()), hash_after(&own, 100, |_| ()));
}

#[test]
fn a_box_that_tumbles_keeps_its_grains_and_its_ledger() {
    let mut scene = closed_box(&format!("motion = {LIST}"), true);
    same_bits_everywhere(&scene, 60);
    // The ledger of unconverged solves closes, too.
    scene.solver.stop = Stop::Sweeps { sweeps: 100 };
    let mut simulation = start(&scene);
    simulation.open_ledger();
    steps(&mut simulation, 3000);
    let frame = simulation.snapshot();
    let at = pose(frame.time).inverse();
    for one in &frame.particles {
        let place = at * Point3::from(Vector::from(one.position));
        let inside = place.coords.abs() - Vector::new(0.03, 0.02, 0.02) + Vector::repeat(0.95 * one.radius);
        assert!(inside.max() < 0.0, "{place} at {} s", frame.time);
    }
    let balance = simulation.balance().expect("it is open");
    assert!(balance.closure.abs() <= 1e-9 * balance.exchanged(), "{balance:#?}");
}

/// A vibration that is the sum of two moves grains as the whole one does, resting contacts included.
#[test]
fn two_halves_of_a_vibration_move_grains_as_the_whole_does() {
    let half = "{ kind = 'vibrating', amplitude = [0, 0, 2e-4], frequency = 20 }";
    let whole = "{ kind = 'vibrating', amplitude = [0, 0, 4e-4], frequency = 20 }";
    let path = |motion: &str| {
        let plate = FLOOR.to_string() + &format!("motion = {motion}\n");
        let body = plate + &grain(0.005, [0.0, 0.0, 0.005], [0.0; 3]);
        let mut simulation = Setup { body, restitution: 0.8, ..Setup::default() }.start();
        (0..4000)
            .map(|_| {
                simulation.step();
                simulation.snapshot().particles[0].position[2]
            })
            .collect::<Vec<f64>>()
    };
    let [two, one] = [&format!("[{half}, {half}]"), whole].map(path);
    two.iter().zip(&one).for_each(|(two, one)| assert_relative_eq!(two, one, epsilon = 1e-10));
}

/// A press comes down at its largest speed and then bears its force, as one without a limit does at rest.
#[test]
fn a_press_has_a_largest_speed_and_bears_its_force() {
    let press = |more: &str| {
        format!(
            "[[wall]]\nname = 'press'\nmaterial = 'wall'\nshape = {{ kind = 'plane', point = [0, 0, 0.05], normal = [0, 0, -1] }}\n\
             motion = {{ kind = 'force-driven', axis = [0, 0, 1], force = -5.0, mass = 0.01{more} }}\n"
        )
    };
    let body = |more: &str| FLOOR.to_string() + &press(more) + &grain(0.005, [0.0, 0.0, 0.005], [0.0; 3]);
    let setup = Setup {
        solver: CONVERGED_RIGID.into(),
        body: body(", largest_speed = 0.1"),
        restitution: 0.0,
        ..Setup::default()
    };
    same_bits_everywhere(&setup.scene(), 50);
    let mut simulation = setup.start();
    let mut slowest = 0.0_f64;
    while simulation.time() < 0.3 {
        simulation.step();
        slowest = slowest.min(simulation.snapshot().driven_walls[0].rate);
        assert_relative_eq!(
            simulation.snapshot().driven_walls[0].displacement,
            -0.1 * simulation.time(),
            epsilon = 2e-4
        );
    }
    assert_eq!(slowest, -0.1);
    while simulation.time() < 0.6 {
        simulation.step();
    }
    let frame = simulation.snapshot();
    let on_press: f64 =
        { frame.contacts.iter() }.filter(|one| one.second == Partner::Wall(1)).map(|one| one.normal_force).sum();
    assert_relative_eq!(on_press, 5.0 + 0.01 * 9.81, max_relative = 1e-6);
}

#[test]
fn motions_that_make_no_sense_are_refused() {
    let wall = |lines: &str| {
        let body = format!(
            "{FLOOR}{lines}\n[[wall]]\nname = 'other'\nmaterial = 'wall'\nshape = {{ kind = 'plane', point = [0, 0, 1], normal = [0, 0, -1] }}\nparent = 'floor'\n"
        );
        parse(&Setup { body, ..Setup::default() }.text("")).err().unwrap_or_default()
    };
    let driven = "{ kind = 'force-driven', axis = [0, 0, 1], force = 1, mass = 1 }";
    let table = |rows: &str| format!("motion = {{ kind = 'table', file = 'poses.csv', content = {rows} }}");
    for (lines, expected) in [
        ("motion = []".to_string(), "wall[0].motion"),
        (format!("motion = [{driven}, {driven}]"), "a list composes prescribed motions alone"),
        (format!("motion = {driven}"), "a force or a torque moves wall 'floor'"),
        ("parent = 'other'".into(), "would carry itself"),
        ("parent = 'shaft'".into(), "there is no wall 'shaft'"),
        (table("[[0, 0, 0, 0, 0, 0, 0]]"), "has 1 rows"),
        (table("[[0, 0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0, 0]]"), "is not after"),
        (table("[[0, 0, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 4, 0]]"), "half a turn"),
        (table("[[0, 1, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0, 0]]"), "zeros in the first row"),
        (table("[[0, 0, 0, 0, 0, 0, 0], [5e-5, 0, 0, 0, 0, 0.1, 0]]"), "less than the step"),
        (
            "motion = [{ kind = 'rotating', point = [0, 0, 0], axis = [0, 0, 1], rate = 3000 }, \
          { kind = 'rotating', point = [0, 0, 0], axis = [0, 0, 1], rate = 3000 }]"
                .into(),
            "a turn of wall 'floor'",
        ),
        ("motion = { kind = 'table', file = 'no-such.csv' }".into(), "no-such.csv"),
        (
            "motion = { kind = 'force-driven', axis = [0, 0, 1], force = 1, mass = 1, largest_speed = 0 }".into(),
            "largest_speed",
        ),
    ] {
        let error = wall(&lines);
        assert!(error.contains(expected), "{lines}: {error}");
    }
}

/// Tables of stages are read from their files, too.
#[test]
fn a_stage_reads_its_table() {
    let folder = std::env::temp_dir().join(format!("makadam-table-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("lift.csv"), "time,z\n0,0\n0.5,0.01\n").unwrap();
    let stage =
        "[[stage]]\nname = 'lift'\nduration = 1.0\nmotion = { floor = { kind = 'table', file = 'lift.csv' } }\n";
    let text = Setup { body: FLOOR.to_string() + stage, ..Setup::default() }.text("");
    let scene = Scene::parse_in(&text, &folder).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let mut simulation = start(&scene);
    steps(&mut simulation, 2500);
    assert_relative_eq!(simulation.wall_displacement(0).unwrap().0[2], 0.005, epsilon = 1e-12);
}
