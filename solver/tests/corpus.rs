//! Checkpoints that earlier builds have written: each goes on to known bits, or is refused in words.
//!
//! A change of the format of checkpoints makes the files of the former format ones that must be refused. A change of bits, which
//! [golden](../golden.rs) would show as well, makes them ones that end elsewhere. In either case they are made anew, and those of
//! former formats stay:
//!
//! ```text
//! cargo test --package makadam corpus:: -- --ignored
//! ```

use crate::common::bits::steps;
use makadam::scene::Scene;
use makadam::{BUILD, Simulation};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Steps before a checkpoint, and after it.
const STEPS: usize = 300;

/// Lines of a scene's material, of its domain, of its lid (of its floor, where that vibrates) and of its solver that call for an
/// effect.
const SCENES: [(&str, [&str; 4]); 9] = [
    ("friction", ["friction = 0.5", "", "", ""]),
    ("rolling", ["friction = 0.5\nrolling_friction = 0.1\ntwisting_friction = 0.1", "", "", ""]),
    ("cohesion", ["friction = 0.5\ncohesion = { kind = 'surface-energy', work = 0.05 }", "", "", ""]),
    ("rigid", ["friction = 0.5", "", "", "normal_law = { kind = 'rigid' }"]),
    (
        "driven-wall",
        ["friction = 0.5", "", "motion = { kind = 'force-driven', axis = [0, 0, 1], force = -0.5, mass = 0.02 }", ""],
    ),
    ("periodic", ["friction = 0.5", "periodic = ['x', 'y']", "", ""]),
    (
        "vibrating",
        ["friction = 0.5", "", "motion = { kind = 'vibrating', amplitude = [0, 0, 0.0002], frequency = 20 }", ""],
    ),
    ("single", ["friction = 0.5", "", "", "precision = 'single'"]),
    ("ledger", ["friction = 0.5", "", "", ""]),
];

/// A dozen grains and more between a floor and a lid, and walls where the domain does not repeat itself.
fn scene(name: &str, [material, domain, motion, solver]: [&str; 4]) -> Scene {
    let (floor, lid) = if name == "vibrating" { (motion, "") } else { ("", motion) };
    let sides = match domain {
        "" => {
            "[[wall]]\nname = 'sides'\nmaterial = 'grain'\n\
             shape = { kind = 'box', min = [0, 0, -0.1], max = [0.044, 0.044, 0.2], open = ['-z', '+z'] }\n"
        }
        _ => "",
    };
    let text = format!(
        "name = '{name}'\ndescription = ''\nduration = 1\n[domain]\nmin = [0, 0, -0.1]\nmax = [0.044, 0.044, 0.2]\n{domain}\n\
         [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nrestitution = 0.3\n{material}\n{sides}\
         [[wall]]\nname = 'floor'\nmaterial = 'grain'\nshape = {{ kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }}\n{floor}\n\
         [[wall]]\nname = 'lid'\nmaterial = 'grain'\nshape = {{ kind = 'plane', point = [0, 0, 0.1], normal = [0, 0, -1] }}\n{lid}\n\
         [[population]]\ncount = 30\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.1 }}\n\
         region = {{ kind = 'box', min = [0, 0, 0], max = [0.044, 0.044, 0.09] }}\n[solver]\nstep = 2e-4\n{solver}\n"
    );
    Scene::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus")
}

/// A simulation of a scene after so many steps.
fn run(name: &str, scene: &Scene) -> Simulation {
    let mut simulation = crate::common::bits::start(scene);
    if name == "ledger" {
        simulation.open_ledger();
    }
    steps(&mut simulation, STEPS);
    simulation
}

/// Hash of the state that a simulation comes to.
fn end(mut simulation: Simulation) -> u64 {
    steps(&mut simulation, STEPS);
    simulation.state_hash()
}

/// A line of the list.
struct Known {
    scene: String,
    build: String,
    resumed: u64,
    started: u64,
}

/// Known facts of each file.
fn list() -> BTreeMap<String, Known> {
    let text = std::fs::read_to_string(folder().join("known.csv")).unwrap_or_default();
    let known = |line: &str| {
        let [file, scene, build, resumed, started] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let number = |text: &str| u64::from_str_radix(text, 16).unwrap_or_else(|error| panic!("{line}: {error}"));
        let (resumed, started) = (number(resumed), number(started));
        (file.to_string(), Known { scene: scene.into(), build: build.into(), resumed, started })
    };
    text.lines().skip(1).map(known).collect()
}

#[test]
fn checkpoints_of_earlier_builds_go_on_to_known_bits_or_are_refused_in_words() {
    let scenes: BTreeMap<&str, Scene> = SCENES.into_iter().map(|(name, lines)| (name, scene(name, lines))).collect();
    let format = crate::common::bits::start(&scenes["friction"]).checkpoint()[7];
    let mut went_on = Vec::new();
    for (name, known) in list() {
        let (file, scene) = (folder().join(&name), &scenes[known.scene.as_str()]);
        let bytes = std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let outcomes = [
            (Simulation::resume(scene, &bytes), known.resumed, "resumed"),
            (Simulation::start_from(scene, &bytes), known.started, "started from"),
        ];
        for (outcome, expected, how) in outcomes {
            match outcome {
                Ok(simulation) => {
                    let has_ledger = simulation.balance().is_some();
                    assert_eq!(has_ledger, known.scene == "ledger" && how == "resumed", "{name}, {how}");
                    let found = end(simulation);
                    assert_eq!(found, expected, "{name}, of build {}, {how}: {found:016x}", known.build);
                }
                Err(error) => {
                    let (error, version) = (error.to_string(), format!("version {}", bytes[7]));
                    assert!(bytes[7] != format && error.contains(&version), "{name}: {error}");
                }
            }
        }
        if bytes[7] == format {
            went_on.push(known.scene);
        }
    }
    for (name, _) in SCENES {
        assert!(
            went_on.iter().any(|known| known == name),
            "no checkpoint of {name} in format {format}: make them anew"
        );
    }
}

#[test]
fn scenes_of_the_corpus_have_the_contacts_that_their_effects_need() {
    for (name, lines) in SCENES {
        let scene = scene(name, lines);
        let simulation = run(name, &scene);
        let touching = simulation.snapshot().contacts.len();
        assert!(touching > 15, "{name}: {touching} contacts bear a force");
        let resumed = Simulation::resume(&scene, &simulation.checkpoint()).unwrap();
        assert_eq!(end(resumed), end(simulation), "{name}");
    }
}

#[test]
#[ignore = "writes the corpus anew"]
fn make_the_corpus_anew() {
    let mut known = list();
    for (name, lines) in SCENES {
        let scene = scene(name, lines);
        let simulation = run(name, &scene);
        let bytes = simulation.checkpoint();
        let file = format!("{name}-v{}.checkpoint", bytes[7]);
        std::fs::write(folder().join(&file), &bytes).unwrap();
        let started = end(Simulation::start_from(&scene, &bytes).unwrap());
        known.insert(file, Known { scene: name.into(), build: BUILD.into(), resumed: end(simulation), started });
    }
    let mut text = String::from("file,scene,build,resumed,started\n");
    for (file, Known { scene, build, resumed, started }) in known {
        writeln!(text, "{file},{scene},{build},{resumed:016x},{started:016x}").unwrap();
    }
    std::fs::write(folder().join("known.csv"), text).unwrap();
}
