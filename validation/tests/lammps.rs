//! LAMMPS without the program: what it is told, what it is not asked, and how its dumps are read.

use makadam::snapshot::Partner;
use makadam_compare::codes::{Code, CodeError, Job, Lammps, Purpose};
use makadam_frames::import::{Column, column_of};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

fn scene(materials: &str, body: &str) -> MeasuredScene {
    let text = format!(
        "name = 'lammps'\ndescription = 'x'\nduration = 0.2\ngravity = [0, 0, -9.81]\n\
         domain = {{ min = [-0.3, -0.3, -0.3], max = [0.3, 0.3, 0.3] }}\n\
         [measure]\ninterval = 0.05\nfrom = 0.1\n{materials}{body}"
    );
    MeasuredScene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn material(name: &str, modulus: f64, friction: f64, more: &str) -> String {
    format!(
        "[material.{name}]\ndensity = 2500\nyoungs_modulus = {modulus:e}\npoisson_ratio = 0.3\nfriction = {friction}\n\
         restitution = 0.3\n{more}\n"
    )
}

fn wall(name: &str, shape: &str, motion: &str) -> String {
    format!("[[wall]]\nname = '{name}'\nmaterial = 'soft'\nshape = {{ {shape} }}\nmotion = {{ {motion} }}\n")
}

fn grain(material: &str, x: f64) -> String {
    format!("[[grain]]\nmaterial = '{material}'\nradius = 0.005\nposition = [{x}, 0, 0]\n")
}

const FIXED: &str = "kind = 'fixed'";

/// Runs a scene in a program that stands in for LAMMPS, a shell script; `folder` is that of the run.
fn run(scene: &MeasuredScene, folder: &Path, script: &str) -> Result<Recording, CodeError> {
    let place = tempfile::tempdir().unwrap();
    let (draft, program) = (place.path().join("draft"), place.path().join("lmp"));
    std::fs::write(&draft, format!("#!/bin/sh\n{script}\n")).unwrap();
    // Installed by another process: the system runs no file that one of this process's children may still hold open for writing.
    assert!(Command::new("install").args(["-m", "755"]).args([&draft, &program]).status().unwrap().success());
    let job = Job {
        scene,
        scene_file: Path::new("lammps.toml"),
        purpose: Purpose::Measuring,
        seed: 1,
        stiffness_factor: 1.0,
        rayleigh_fraction: 0.2,
        work_folder: folder,
        time_limit: Duration::from_secs(10),
        progress: &|_| {},
    };
    Lammps::new(&program).simulate(&job)
}

/// Returns the commands for LAMMPS of a scene, or the reason for a refusal: the program itself fails at once.
fn deck(scene: &MeasuredScene) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    match run(scene, folder.path(), "exit 1").unwrap_err() {
        CodeError::Crashed { .. } => Ok(std::fs::read_to_string(folder.path().join("deck.in")).unwrap()),
        error => Err(error.to_string()),
    }
}

/// The numbers behind a word of the deck's first line that begins with another.
fn numbers(deck: &str, line: &str, word: &str, count: usize) -> Vec<f64> {
    let line = deck.lines().find(|text| text.starts_with(line)).unwrap_or_else(|| panic!("no {line} in\n{deck}"));
    let words = line.split(' ').skip_while(|text| *text != word).skip(1).take(count);
    words.map(|number| number.parse().unwrap_or_else(|_| panic!("{number} in {line}"))).collect()
}

fn close(values: &[f64], expected: &[f64]) {
    assert_eq!(values.len(), expected.len(), "{values:?}");
    for (value, expected) in values.iter().zip(expected) {
        assert!((value - expected).abs() <= 1e-12 * expected.abs().max(1e-3), "{values:?}, not {expected:?}");
    }
}

#[test]
fn hertz_and_mindlin_have_the_moduli_of_both_materials() {
    let materials = material("hard", 1e8, 0.5, "") + &material("soft", 1e7, 0.2, "");
    let floor = wall("floor", "kind = 'plane', point = [0, 0, -0.1], normal = [0, 0, 1]", FIXED);
    let deck = deck(&scene(&materials, &(floor + &grain("hard", 0.0) + &grain("soft", 0.1)))).unwrap();
    let softness = |modulus: f64| 0.91 / modulus;
    let shear = |modulus: f64| 2.0 * 1.7 * 1.3 / modulus;
    let pairs = [("pair_coeff 1 1", 1e8, 1e8), ("pair_coeff 1 2", 1e8, 1e7), ("pair_coeff 2 2", 1e7, 1e7)];
    let walls = [("fix wall0 kind1", 1e8, 1e7), ("fix wall1 kind2", 1e7, 1e7)];
    for (line, a, b) in pairs.into_iter().chain(walls) {
        close(&numbers(&deck, line, "hertz", 2), &[4.0 / 3.0 / (softness(a) + softness(b)), 0.3]);
        let (normal, stiffness) = (2.0 / (softness(a) + softness(b)), 8.0 / (shear(a) + shear(b)));
        // Damped as the normal spring would be at its stiffness.
        let damping = (stiffness / normal).sqrt();
        close(&numbers(&deck, line, "mindlin/force", 2), &[stiffness, damping]);
    }
    assert!(!deck.contains("rolling") && !deck.contains("limit_damping"), "{deck}");
    assert!(deck.contains("group kind2 type 2\n") && deck.contains("stride2(0,"), "{deck}");
}

#[test]
fn walls_are_regions_of_one_surface_each() {
    let materials = material("soft", 1e7, 0.5, "");
    let body = wall("box", "kind = 'box', min = [-0.2, -0.2, -0.2], max = [0.2, 0.2, 0.2], open = ['+z', '-x']", FIXED)
        + &wall(
            "drum",
            "kind = 'cylinder', base = [0.01, 0.05, 0.02], axis = [0, -2, 0], radius = 0.05, length = 0.1",
            "kind = 'rotating', point = [0, 0, 0.02], axis = [0, 3, 0], rate = 5.0, start = 0.05, stop = 0.15, reverse = 0.1",
        )
        + &wall("slope", "kind = 'disc', centre = [0.1, 0, 0.1], normal = [0, 0, 2], radius = 0.03", FIXED)
        + &wall(
            "lift",
            "kind = 'disc', centre = [-0.1, 0, 0], normal = [0, 0, 1], radius = 0.03",
            "kind = 'vibrating', amplitude = [0, 0, 0.001], frequency = 10",
        )
        + &grain("soft", 0.0);
    let deck = deck(&scene(&materials, &body)).unwrap();
    for (face, point, normal) in [(0, [0.2, 0.2, 0.2], [-1.0, 0.0, 0.0]), (3, [-0.2, -0.2, -0.2], [0.0, 0.0, 1.0])] {
        close(&numbers(&deck, &format!("region surface{face} "), "plane", 6), &[point, normal].concat());
    }
    // Its base is at the upper end; the coordinates of its axis are x and z.
    close(&numbers(&deck, "region surface4 cylinder y", "y", 5), &[0.01, 0.02, 0.05, -0.05, 0.05]);
    let drum = deck.lines().find(|line| line.starts_with("region surface4 ")).unwrap();
    assert!(drum.contains("open 1 open 2 units box rotate v_turn1 "), "{drum}");
    close(&numbers(&deck, "region surface4 ", "v_turn1", 6), &[0.0, 0.0, 0.02, 0.0, 1.0, 0.0]);
    let turn = deck.lines().find(|line| line.starts_with("variable turn1 equal (5.0")).unwrap();
    assert!(turn.contains("(1)*((step>") && turn.contains("+(-1)*((step>"), "{turn}");
    // Its upper end is the disc.
    let disc = numbers(&deck, "region surface5 cylinder z", "z", 5);
    assert!(disc[4] == 0.1 && (0.0..1e-8).contains(&(disc[4] - disc[3])), "{disc:?}");
    let lift = deck.lines().find(|line| line.starts_with("region surface6 ")).unwrap();
    assert!(lift.contains("side out units box move v_x3 v_y3 v_z3"), "{lift}");
    assert!(deck.contains("variable z3 equal (1.00000000000000002e-3)*sin("), "{deck}");
    // Surfaces 4, 5 and 6 are the walls 1, 2 and 3 of the scene.
    assert!(deck.contains("variable met3 atom 0\nvariable met4 atom 1\nvariable met5 atom 2\n"), "{deck}");
}

/// The names under which a dump writes its columns.
fn names(deck: &str, dump: &str) -> Vec<String> {
    let asked = deck.lines().find(|line| line.starts_with(&format!("dump_modify {dump} "))).unwrap();
    let mut words = asked.split(' ');
    let mut names = Vec::new();
    while words.by_ref().any(|word| word == "colname") {
        names.push(words.nth(1).unwrap().into());
    }
    names
}

#[test]
fn measure_knows_the_columns_of_the_dumps() {
    let floor = wall("floor", "kind = 'plane', point = [0, 0, -0.1], normal = [0, 0, 1]", FIXED);
    let deck = deck(&scene(&material("soft", 1e7, 0.5, ""), &(floor + &grain("soft", 0.0)))).unwrap();
    let of = |dump: &str| -> Vec<Column> {
        names(&deck, dump).iter().map(|name| column_of(name).unwrap_or_else(|| panic!("{name}"))).collect()
    };
    let three = |of: fn(usize) -> Column| [0, 1, 2].map(of);
    let forces = [three(Column::NormalOnFirst), three(Column::TangentialOnFirst)].concat();
    assert_eq!(of("pairs"), [&[Column::First, Column::Second], &forces[..]].concat());
    let felt = [three(Column::Force), three(Column::Point)].concat();
    assert_eq!(of("wall0"), [&[Column::First], &felt[..], &[Column::Wall]].concat());
    assert_eq!((of("pairs"), of("wall0")), (of("pairslast"), of("wall0last")));
}

#[test]
fn grains_resist_rolling_up_to_the_cap_of_the_scene() {
    let materials = material("soft", 1e7, 0.5, "rolling_friction = 0.1");
    let floor = wall("floor", "kind = 'plane', point = [0, 0, -0.1], normal = [0, 0, 1]", FIXED);
    let deck = deck(&scene(&materials, &(floor + &grain("soft", 0.0)))).unwrap();
    for line in ["pair_coeff 1 1", "fix wall0 kind1"] {
        close(&numbers(&deck, line, "sds", 3)[1..], &[0.0, 0.1]);
    }
}

#[test]
fn what_has_no_region_is_refused_with_the_reason() {
    let materials = material("soft", 1e7, 0.5, "");
    let cases = [
        (
            wall("silo", "kind = 'disc', centre = [0, 0, 0], normal = [0, 0, 1], radius = 0.1, hole = 0.02", FIXED),
            "hole",
        ),
        (
            wall("kiln", "kind = 'cylinder', base = [0, 0, 0], axis = [0, 1, 1], radius = 0.1, length = 0.2", FIXED),
            "kiln",
        ),
        (wall("bed", "kind = 'spheres', centres = [[0, 0, -0.1]], radius = 0.01", FIXED), "spheres"),
    ];
    for (body, reason) in cases {
        let refused = deck(&scene(&materials, &(body + &grain("soft", 0.0)))).unwrap_err();
        assert!(refused.contains("LAMMPS cannot express") && refused.contains(reason), "{refused}");
    }
    let mut dead = scene(&materials, &(grain("soft", 0.0) + &grain("soft", 0.1)));
    dead.material.values_mut().for_each(|one| one.restitution = 0.0);
    assert!(deck(&dead).unwrap_err().contains("restitution above 0"));
}

#[test]
fn contacts_have_the_force_on_the_partner_and_the_point_in_the_overlap() {
    let floor = wall("floor", "kind = 'plane', point = [0, 0, -0.006], normal = [0, 0, 1]", FIXED);
    let scene = scene(&material("soft", 1e7, 0.5, ""), &(floor + &grain("soft", 0.0) + &grain("soft", 0.011)));
    let folder = tempfile::tempdir().unwrap();
    let _ = run(&scene, folder.path(), "exit 1");
    let text = std::fs::read_to_string(folder.path().join("deck.in")).unwrap();
    let last: u64 = text.lines().find_map(|line| line.strip_prefix("run ")).unwrap().parse().unwrap();
    let dump = |head: &str, rows: &str| {
        let count = rows.lines().count();
        let frame = |step: u64| {
            format!(
                "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS {head}\n{rows}"
            )
        };
        // Both ends of the run are there twice.
        [0, 0, last / 2, 3 * last / 4, last, last].map(frame).concat()
    };
    let made = tempfile::tempdir().unwrap();
    for (name, head, rows) in [
        ("grains", "id x y z vx vy vz omegax omegay omegaz", "2 0.0098 0 0 0 0 0 0 0 0\n1 0 0 0 0 0 0 0 0 0\n"),
        ("pairs", "id1 id2 fnx fny fnz ftx fty ftz", "2 1 3 0 0 0 0.5 0\n"),
        ("wall0", "id1 fx fy fz px py pz wall", "1 0.25 0 2 0 0 -0.0049 0\n"),
    ] {
        std::fs::write(made.path().join(format!("{name}.dump")), dump(head, rows)).unwrap();
    }
    std::fs::write(made.path().join("engine.log"), "Loop time of 12.5 on 1 procs\n").unwrap();
    let script = format!(
        "[ \"$1\" = -help ] && echo 'Parallel Simulator - 1.2' && exit\ncp {0}/*.dump {0}/engine.log .",
        made.path().display()
    );
    let recording = run(&scene, folder.path(), &script).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(recording.wall_seconds, 12.5);
    let frames = recording.frames;
    assert_eq!(frames.len(), 4);
    let [pair, wall] = &frames[3].contacts[..] else { panic!("{:?}", frames[3].contacts) };
    assert_eq!((pair.first, pair.second, wall.first, wall.second), (1, Partner::Grain(0), 0, Partner::Wall(0)));
    close(&pair.normal, &[-1.0, 0.0, 0.0]);
    close(&pair.point, &[0.0049, 0.0, 0.0]);
    close(&[pair.normal_force], &[3.0]);
    close(&pair.tangential_force, &[0.0, -0.5, 0.0]);
    close(&wall.normal, &[0.0, 0.0, -1.0]);
    close(&[wall.normal_force], &[2.0]);
    close(&wall.tangential_force, &[-0.25, 0.0, 0.0]);
}
