//! The inputs from which reference codes are timed give the physics of those from which they are measured, where the reference codes are installed.

use makadam::snapshot::{Partner, Snapshot};
use makadam_compare::codes::{Code, Job, Lammps, Liggghts, Purpose, Yade};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::{Content, Recording};
use std::path::Path;
use std::time::Duration;

fn reference_codes() -> [Box<dyn Code>; 3] {
    [Box::new(Liggghts::default()), Box::new(Yade::default()), Box::new(Lammps::default())]
}

fn run(code: &dyn Code, scene: &MeasuredScene, purpose: Purpose) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let job = Job {
        scene,
        scene_file: Path::new("timed.toml"),
        purpose,
        seed: 1,
        stiffness_factor: 1.0,
        rayleigh_fraction: 0.2,
        work_folder: folder.path(),
        time_limit: Duration::from_secs(300),
        progress: &|_| {},
    };
    code.simulate(&job).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs a scene for measuring and for timing in every reference code that is installed.
fn both(scene: &MeasuredScene, check: impl Fn(&str, &Recording, &Recording)) {
    for code in reference_codes() {
        if code.version().is_none() {
            eprintln!("skipped: {} is not installed", code.name());
            continue;
        }
        let measured = run(code.as_ref(), scene, Purpose::Measuring);
        let timed = run(code.as_ref(), scene, Purpose::Timing);
        assert_eq!((measured.time_step, measured.frames.len()), (timed.time_step, timed.frames.len()));
        assert_eq!(measured.lacks, []);
        check(code.name(), &measured, &timed);
    }
}

const MATERIALS: &str = "[material.grain]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n\
     [material.shell]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 1.0\nrestitution = 0.3\n\
     [material.cap]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.0\nrestitution = 0.3\n";

/// A drum about an axis of coordinates with smooth caps; `grain` is a place in the coordinates across, along and up.
fn drum(along: usize, duration: f64, grain: [f64; 3], body: &str) -> MeasuredScene {
    let (across, up) = ((along + 2) % 3, (along + 1) % 3);
    let vector = |numbers: [(usize, f64); 3]| {
        let mut vector = [0.0; 3];
        numbers.into_iter().for_each(|(at, value)| vector[at] = value);
        format!("{vector:?}")
    };
    let only = |at: usize, value: f64| vector([(at, value), ((at + 1) % 3, 0.0), ((at + 2) % 3, 0.0)]);
    let size = |value: f64| vector([(across, value), (up, value), (along, 0.6 * value)]);
    let text = format!(
        "name = 'timed'\ndescription = 'x'\nduration = {duration}\ngravity = {}\ndomain = {{ min = {}, max = {} }}\n\
         [measure]\ninterval = {}\nfrom = 0.0\n{MATERIALS}\
         [[wall]]\nname = 'shell'\nmaterial = 'shell'\n\
         shape = {{ kind = 'cylinder', base = {}, axis = {}, radius = 0.05, length = 0.04 }}\n\
         motion = {{ kind = 'rotating', point = [0.0, 0.0, 0.0], axis = {}, rate = 3.0 }}\n\
         [[wall]]\nname = 'front'\nmaterial = 'cap'\nshape = {{ kind = 'disc', centre = {}, normal = {}, radius = 0.05 }}\n\
         [[wall]]\nname = 'back'\nmaterial = 'cap'\nshape = {{ kind = 'disc', centre = {}, normal = {}, radius = 0.05 }}\n\
         [[grain]]\nmaterial = 'grain'\nradius = 0.005\nposition = {}\n{body}",
        only(up, -9.81),
        size(-0.055),
        size(0.055),
        duration / 20.0,
        only(along, -0.02),
        only(along, 1.0),
        only(along, 1.0),
        only(along, -0.02),
        only(along, 1.0),
        only(along, 0.02),
        only(along, -1.0),
        vector([(across, grain[0]), (along, grain[1]), (up, grain[2])]),
    );
    MeasuredScene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn place(frame: &Snapshot, axis: usize) -> f64 {
    frame.particles[0].position[axis]
}

/// A grain on the wall of a turning drum is spun up to the drum's speed and sways there. A primitive cylinder must drag it as the mesh does,
/// about each axis, with the right sign.
#[test]
#[ignore = "takes long: scripts/nightly slow-tests"]
fn a_turning_drum_drags_a_grain_as_its_mesh_does() {
    for along in 0..3 {
        let scene = drum(along, 0.3, [0.0, 0.003, -0.045], "");
        both(&scene, |code, measured, timed| {
            let full = 3.0 * 0.05 / 0.005;
            let spins = |recording: &Recording| {
                recording.frames.iter().map(|frame| frame.particles[0].spin[along]).collect::<Vec<_>>()
            };
            let (one, other) = (spins(measured), spins(timed));
            let last = one[one.len() - 1];
            assert!(
                (0.6 * full..1.4 * full).contains(&last),
                "{code} about {along}: it spins at {last}, not about {full}"
            );
            let mean = |spins: &[f64]| spins.iter().sum::<f64>() / spins.len() as f64;
            assert!(
                (mean(&one) - mean(&other)).abs() < 0.02 * full,
                "{code} about {along}: spins {one:.1?} and {other:.1?}"
            );
            // A grain in YADE is knocked wherever it passes from facet to facet, by either mesh at other places.
            for (one, other) in one.iter().zip(&other).filter(|_| code != "YADE") {
                assert!((one - other).abs() < 0.04 * full, "{code} about {along}: spins at {one} and {other}");
            }
            for (one, other) in measured.frames.iter().zip(&timed.frames) {
                for axis in 0..3 {
                    let (one, other) = (place(one, axis), place(other, axis));
                    assert!((one - other).abs() < 5e-4, "{code} about {along}: at {one} and {other} on axis {axis}");
                }
            }
        });
    }
}

/// Four grains fall into a box and come to rest at the same heights, whether it is a mesh or planes.
#[test]
#[ignore = "takes long: scripts/nightly slow-tests"]
fn few_grains_in_a_box_come_to_rest_at_the_same_heights() {
    let mut text = format!(
        "name = 'timed'\ndescription = 'x'\nduration = 1.0\ngravity = [0.0, 0.0, -9.81]\n\
         domain = {{ min = [-0.01, -0.01, -0.01], max = [0.041, 0.041, 0.3] }}\n[measure]\ninterval = 0.25\nfrom = 0.0\n{MATERIALS}\
         [[wall]]\nname = 'box'\nmaterial = 'grain'\n\
         shape = {{ kind = 'box', min = [0.0, 0.0, 0.0], max = [0.031, 0.029, 0.2], open = ['+z'] }}\n"
    );
    for index in 0..4 {
        let (x, y) = (0.007 + 0.012 * f64::from(index % 2), 0.008 + 0.011 * f64::from(index / 2));
        text += &format!(
            "[[grain]]\nmaterial = 'grain'\nradius = 0.005\nposition = [{x}, {y}, {}]\n",
            0.01 + 0.02 * f64::from(index)
        );
    }
    both(&MeasuredScene::parse(&text).unwrap(), |code, measured, timed| {
        let heights = |recording: &Recording| {
            recording.frames.last().unwrap().particles.iter().map(|grain| grain.position[2]).collect::<Vec<_>>()
        };
        for (id, (one, other)) in heights(measured).into_iter().zip(heights(timed)).enumerate() {
            assert!((one - other).abs() < 1e-5, "{code}: grain {id} rests at {one} and {other}");
        }
    });
}

/// A run for timing states what it leaves out: no wall contact is missing silently.
#[test]
#[ignore = "takes long: scripts/nightly slow-tests"]
fn what_a_timed_run_lacks_is_said() {
    let scene = drum(1, 0.2, [0.0, 0.003, -0.045], "");
    both(&scene, |code, measured, timed| {
        let on_walls = |recording: &Recording| {
            recording
                .frames
                .iter()
                .flat_map(|frame| &frame.contacts)
                .any(|contact| matches!(contact.second, Partner::Wall(_)))
        };
        assert!(on_walls(measured), "{code}");
        assert_eq!(on_walls(timed), !timed.lacks.contains(&Content::WallContacts), "{code}");
        if code == "LIGGGHTS" {
            assert_eq!(timed.lacks, [Content::WallContacts]);
        }
    });
}

/// The decks themselves: a drum and a box are primitives, what moves is a mesh, and the deck for measuring has none but meshes.
#[test]
fn decks_for_timing_have_primitives_where_walls_are_endless() {
    let folder = tempfile::tempdir().unwrap();
    let deck = |name: &str, purpose: Purpose| {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../reference-scenes/{name}/scene.toml"));
        let scene = MeasuredScene::load(&file).unwrap();
        let job = Job {
            scene: &scene,
            scene_file: &file,
            purpose,
            seed: 1,
            stiffness_factor: 1.0,
            rayleigh_fraction: 0.2,
            work_folder: folder.path(),
            time_limit: Duration::ZERO,
            progress: &|_| {},
        };
        Liggghts::default().write_input(&job).unwrap();
        std::fs::read_to_string(folder.path().join("deck.in")).unwrap()
    };
    let count = |text: &str, word: &str| text.matches(word).count();
    for (name, planes, cylinders, meshes) in
        [("packing", 5, 0, 0), ("drum", 2, 1, 0), ("drum-caps", 0, 1, 2), ("heap", 1, 0, 2)]
    {
        let timed = deck(name, Purpose::Timing);
        let found = (count(&timed, "plane "), count(&timed, "cylinder "), count(&timed, " mesh/surface "));
        assert_eq!(found, (planes, cylinders, meshes), "{name}");
        assert!(!timed.contains("walls.dump"), "{name}");
        let measured = deck(name, Purpose::Measuring);
        assert!(!measured.contains("primitive") && measured.contains("walls.dump"), "{name}");
    }
    // A second dump of a table would repeat the frame at which the interval changes, which readers refuse.
    for purpose in [Purpose::Timing, Purpose::Measuring] {
        let drum = deck("drum", purpose);
        let found = ["dump grains all ", "dump_modify grains every ", "undump"].map(|words| count(&drum, words));
        assert_eq!(found, [1, 1, 0], "{drum}");
    }
    // The cylinder lies along z, where `shear` works, and is turned at the speed of the surface for a grain of the mean radius.
    let drum = deck("drum", Purpose::Timing);
    let words = drum.lines().find(|line| line.contains("zcylinder")).unwrap();
    let shear: f64 = words.split_once(" shear x ").unwrap().1.split(' ').next().unwrap().parse().unwrap();
    assert!((shear - 1.0 / 0.95).abs() < 1e-3, "{words}");
}
