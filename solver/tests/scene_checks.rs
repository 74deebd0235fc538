//! Checks of scenes: every key is read or refused, and preflight findings.

use makadam::Simulation;
use makadam::scene::{Finding, Scene, Severity};
use std::path::Path;

const FILE: &str = "sketch.toml";

/// A scene of a floor and a grain, with a line of it changed.
fn sketch(from: &str, to: &str) -> String {
    let text = "name = 'sketch'
description = 'A grain above a floor.'
duration = 0.2
gravity = [0.0, 0.0, -9.81]
domain = { min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }
[solver]
step = 5e-4
[material.grain]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.5
restitution = 0.3
[[wall]]
name = 'floor'
material = 'grain'
shape = { kind = 'plane', point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
motion = { kind = 'fixed' }
[[grain]]
material = 'grain'
radius = 0.005
position = [0.0, 0.0, 0.02]
";
    assert!(text.contains(from), "the sketch does not hold {from:?}");
    text.replacen(from, to, 1)
}

fn parse(text: &str) -> Result<Scene, String> {
    Scene::parse(text).map_err(|error| error.in_file(Path::new(FILE), Some(text)).to_string())
}

/// The refusal of a changed sketch, which has to name a line and hold all of the words.
#[track_caller]
fn refused(from: &str, to: &str, line: usize, words: &[&str]) -> String {
    let message = parse(&sketch(from, to)).expect_err("accepted");
    assert!(message.starts_with(&format!("{FILE}:{line}: ")), "not in line {line}: {message}");
    for word in words {
        assert!(message.contains(word), "no '{word}' in: {message}");
    }
    message
}

fn warnings(scene: &Scene) -> Vec<String> {
    scene.findings(None).iter().map(Finding::to_string).collect()
}

/// Warnings of motion that no step resolves.
fn unresolved(scene: &Scene) -> Vec<String> {
    warnings(scene).into_iter().filter(|told| told.contains("does not resolve")).collect()
}

#[test]
fn motion_above_a_diameter_per_step_warns() {
    let second = "[[grain]]\nmaterial = 'grain'\nradius = 0.004\nposition = [0.0, 0.05, 0.02]\n";
    let moving = |velocity: f64| {
        let listed = format!("position = [0.0, 0.0, 0.02]\nvelocity = [{velocity:?}, 0.0, 0.0]\n{second}");
        parse(&sketch("position = [0.0, 0.0, 0.02]\n", &listed)).unwrap()
    };
    assert_eq!(unresolved(&moving(17.9)), Vec::<String>::new(), "8.95 mm in a step, where the radii add up to 9");
    let told = unresolved(&moving(18.1));
    assert!(told.len() == 1 && told[0].contains("grains 0 and 1") && told[0].contains("0.009 m"), "{told:?}");
    assert!(told[0].contains("lower solver.step to 4e-4 s"), "{told:?}");
    // All at one velocity there is no relative motion.
    let together = sketch(
        "[0.0, 0.0, 0.02]\n",
        &format!("[0.0, 0.0, 0.02]\nvelocity = [40.0, 0, 0]\n{second}velocity = [40.0, 0, 0]\n"),
    );
    assert_eq!(unresolved(&parse(&together).unwrap()), Vec::<String>::new());
    // And a wall.
    let wall = |speed: f64| {
        let text =
            sketch("kind = 'fixed'", &format!("kind = 'translating', velocity = [0.0, 0.0, {speed:?}]")) + second;
        parse(&text).unwrap()
    };
    assert_eq!(unresolved(&wall(15.9)), Vec::<String>::new());
    let told = unresolved(&wall(16.1));
    assert!(told.len() == 1 && told[0].contains("wall 'floor'") && told[0].contains("does not resolve"), "{told:?}");
}

#[test]
fn accuracy_needs_gravity() {
    let text =
        sketch("gravity = [0.0, 0.0, -9.81]", "gravity = [0.0, 0.0, 0.0]").replace("[solver]\nstep = 5e-4\n", "");
    let text = text.replace("[material.grain]", "[accuracy]\nrelative = 0.01\n[material.grain]");
    let message = parse(&text).unwrap_err();
    assert!(
        message.contains("accuracy") && message.contains("no gravity") && message.contains("solver.step"),
        "{message}"
    );
    let later = text.replace("[accuracy]", "[[gravity_changes]]\ntime = 0.1\ngravity = [0, 0, -9.81]\n[accuracy]");
    parse(&later).unwrap();
}

#[test]
fn what_reading_would_pass_over_is_refused() {
    // Elements beyond the length of an array, wherever it stands.
    refused("[0.0, 0.0, -9.81]", "[0.0, 0.0, 0.0, -9.81]", 4, &["gravity: 4 values are listed, and 3 are read"]);
    refused("[0.0, 0.0, 0.02]", "[0.0, 0.0, 0.02, 7.0]", 22, &["grain[0].position: 4 values", "give 3 values"]);
    refused("max = [0.1, 0.1, 0.1]", "max = [0.1, 0.1, 0.1, 0.1]", 5, &["domain.max"]);
    // Keys beside the kind of what has no keys.
    let words = ["wall[0].motion: unknown key 'velocity' beside kind = 'fixed'", "known keys: kind"];
    refused("kind = 'fixed'", "kind = 'fixed', velocity = [0.0, 0.0, 1.0]", 18, &words);
    for (law, kind) in [("normal_law", "hertz"), ("normal_law", "rigid"), ("method", "gauss-seidel")] {
        let with = format!("[solver]\n{law} = {{ kind = '{kind}', zzz = 1 }}");
        refused("[solver]", &with, 7, &[&format!("solver.{law}: unknown key 'zzz' beside kind = '{kind}'")]);
    }
    // Keys that serde refuses by itself keep its list.
    refused("friction = 0.5", "fricton = 0.5", 12, &["fricton", "friction"]);
}

#[test]
fn what_is_said_at_its_default_is_read() {
    // These are left out where a scene is written, so that they look like keys that nobody has read.
    let all = "friction = 0.5\nrolling_friction = 0.0\ntwisting_friction = 0.0\n";
    assert!(parse(&sketch("friction = 0.5\n", all)).is_ok());
    assert!(
        parse(&sketch("duration = 0.2", "duration = 0.2\nlargest_start_overlap = 0.01\ngravity_changes = []")).is_ok()
    );
    let disc = "kind = 'disc', centre = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], radius = 0.09, hole = 0.0";
    let plane = "kind = 'plane', point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0]";
    assert!(parse(&sketch(plane, disc)).is_ok());
    assert!(
        parse(&sketch("step = 5e-4", "step = 5e-4\nmethod = { kind = 'gauss-seidel' }\nprecision = 'double'")).is_ok()
    );
    // Beside such a key, one that is not read is still found, and the other one listed as known.
    let fixed = "kind = 'fixed', zzz = 1";
    let message = refused("kind = 'fixed'", fixed, 18, &["zzz"]);
    assert!(!message.contains("point"), "{message}");
}

#[test]
fn nothing_is_said_twice() {
    let rules = "[[pair]]\nbetween = ['grain', 'wall']\nfriction = 0.1\n[[pair]]\nbetween = ['wall', 'grain']\nfriction = 0.9\n";
    let wall = "[material.wall]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n";
    let text = format!("{wall}{rules}[[wall]]");
    refused("[[wall]]", &text, 24, &["pair[1].between: pair[0] is a rule of 'wall' and 'grain' already"]);
    let again = "[[wall]]\nname = 'floor'\nmaterial = 'grain'\nshape = { kind = 'plane', point = [0.0, 0.0, 0.1], normal = [0.0, 0.0, -1.0] }\n[[grain]]";
    refused("[[grain]]", again, 20, &["wall[1].name: 'floor' is the name of wall[0] too"]);
}

#[test]
fn names_can_be_shown_tabled_and_made_those_of_files() {
    for name in [".", "..", "", "  ", "a/b", "a\\\\b", "=1+1", "@x", "\\u001b[31mred", "a\\nb", "a\\u202eb"] {
        refused("name = 'sketch'", &format!("name = \"{name}\""), 1, &["name"]);
    }
    refused("name = 'sketch'", &format!("name = '{}'", "x".repeat(101)), 1, &["101 bytes", "at most 100"]);
    assert!(parse(&sketch("name = 'sketch'", &format!("name = '{}'", "x".repeat(100)))).is_ok());
    let message = refused("name = 'floor'", "name = \"\\u001b]0;x\"", 15, &["wall[0].name", "\\u{1b}"]);
    assert!(!message.contains('\u{1b}'), "{message}");
    let message = refused("[material.grain]", "[material.\"\\u001b\"]", 8, &["material"]);
    assert!(!message.contains('\u{1b}'), "{message:?}");
    // Words of the reader hold no such characters either.
    let message = refused("friction = 0.5", "\"\\u001b[31m\" = 0.5", 12, &["unknown field"]);
    assert!(!message.contains('\u{1b}'), "{message:?}");
}

#[test]
fn numbers_in_messages_are_short() {
    for value in ["1e300", "-1e300", "-1e-300", "123456789.123456789"] {
        let message = refused("restitution = 0.3", &format!("restitution = {value}"), 13, &["is out of range"]);
        assert!(message.len() < 140, "{message}");
    }
    refused("restitution = 0.3", "restitution = 1.3", 13, &["restitution: 1.3 is out of range", "from 0 to 1"]);
}

#[test]
fn unusual_values_need_the_key_that_accepts_them() {
    refused("step = 5e-4", "step = 1e-10", 7, &["solver.step", "from 0.000000001 to 0.1 s", "unusual_values = true"]);
    let accepted = |from: &str, to: &str| {
        let text = sketch(from, to).replace("duration = 0.2", "duration = 0.2\nunusual_values = true");
        parse(&text)
    };
    assert!(accepted("step = 5e-4", "step = 1e-10").is_ok());
    let density = "density = 2500.0";
    assert!(sketch("step", "step").contains(density));
    for value in ["density = 2.7e6", "density = 1e-3"] {
        assert!(parse(&sketch(density, value)).unwrap_err().contains("unusual_values"), "{value}");
        assert!(accepted(density, value).is_ok(), "{value}");
    }
    // There are limits to what can be computed with.
    assert!(accepted("step = 5e-4", "step = 1e-16").unwrap_err().contains("from 1e-15 to 0.1 s"));
    // Written scenes keep it, and say nothing of it where it is off.
    let written = toml::to_string(&accepted("step = 5e-4", "step = 1e-10").unwrap()).unwrap();
    assert!(written.contains("unusual_values = true") && parse(&written).is_ok());
    assert!(!toml::to_string(&parse(&sketch("step", "step")).unwrap()).unwrap().contains("unusual_values"));
}

#[test]
fn sweeps_of_a_step_are_bounded() {
    refused("step = 5e-4", "inner_sweeps = 4294967295", 7, &["solver.inner_sweeps", "from 1 to 1000"]);
    refused("step = 5e-4", "inner_sweeps = 0", 7, &["solver.inner_sweeps"]);
    let both = "stop = { kind = 'sweeps', sweeps = 1000000 }\ninner_sweeps = 2";
    refused("step = 5e-4", both, 8, &["2000000 sweeps a step", "at most 1000000"]);
    assert!(parse(&sketch("step = 5e-4", "inner_sweeps = 1000")).is_ok());
}

#[test]
fn a_scene_built_in_code_is_checked_as_one_from_a_file() {
    let sound = parse(&sketch("step", "step")).unwrap();
    let make = |change: &dyn Fn(&mut Scene)| {
        let mut scene = sound.clone();
        change(&mut scene);
        Simulation::new(&scene, 1).map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(make(&|_| ()), Ok(()));
    let message = make(&|scene| scene.grain[0].material = "gold".into()).unwrap_err();
    assert!(message.starts_with("grain[0].material: there is no material 'gold'"), "{message}");
    let message = make(&|scene| scene.wall[0].material = "gold".into()).unwrap_err();
    assert!(message.starts_with("wall[0].material: there is no material 'gold'"), "{message}");
    let message = make(&|scene| scene.solver.step = f64::NAN).unwrap_err();
    assert!(message.starts_with("solver.step: NaN is out of range"), "{message}");
    let message = make(&|scene| scene.grain[0].position[2] = 0.001).unwrap_err();
    assert!(message.starts_with("grain[0].position: grain 0 at"), "{message}");
    // Nor does one go on from a checkpoint with it.
    let checkpoint = Simulation::new(&sound, 1).unwrap().checkpoint();
    let mut wrong = sound.clone();
    wrong.wall[0].material = "gold".into();
    let message = Simulation::start_from(&wrong, &checkpoint).unwrap_err().to_string();
    assert!(message.contains("wall[0].material: there is no material 'gold'"), "{message}");
}

#[test]
fn a_motion_that_the_step_passes_over_is_refused() {
    // 2 kHz stand still at 0.5 ms: each step takes a whole period.
    let shaken = "kind = 'vibrating', amplitude = [0.0, 0.0, 1e-3], frequency = 2000.0";
    let words = [
        "wall[0].motion: a period of wall 'floor' lasts 0.0005 s, 1 steps",
        "give solver.step at most 4.16e-5 s",
        "solver.step stands in line 7",
    ];
    refused("kind = 'fixed'", shaken, 18, &words);
    let enough = sketch("kind = 'fixed'", shaken);
    assert!(parse(&enough.replace("5e-4", "4.16e-5")).is_ok());
    let default = parse(&enough.replace("step = 5e-4", "")).unwrap_err();
    assert!(default.contains("solver.step is not in the file"), "{default}");
    // What does not shake, or not in time, is not held against the step.
    assert!(parse(&enough.replace("1e-3]", "0.0]")).is_ok());
    assert!(parse(&enough.replace("2000.0", "2000.0, start = 0.2")).is_ok());
    // Turns, and motions that are over before a step is.
    let turn = "kind = 'rotating', point = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], rate = 5000.0";
    refused("kind = 'fixed'", turn, 18, &["a turn of wall 'floor'"]);
    let short = "kind = 'translating', velocity = [0.0, 0.0, 1.0], start = 0.1, stop = 0.1001";
    refused("kind = 'fixed'", short, 18, &["wall[0].motion.stop", "less than the step"]);
    let back =
        "kind = 'rotating', point = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], rate = 5.0, start = 0.1, reverse = 0.1001";
    refused("kind = 'fixed'", back, 18, &["wall[0].motion.reverse"]);
    // A pulse of gravity, but not a jump.
    let change = |times: [f64; 3]| {
        let [a, b, c] = times;
        format!(
            "duration = 0.2\ngravity_changes = [{{ time = {a}, gravity = [0.0, 0.0, -9.81] }}, {{ time = {b}, gravity = \
             [0.0, 0.0, 900.0] }}, {{ time = {c}, gravity = [0.0, 0.0, -9.81] }}]"
        )
    };
    let words = ["gravity_changes[1]: gravity changes and goes back within 0.0002 s"];
    refused("duration = 0.2", &change([0.1, 0.1001, 0.1002]), 4, &words);
    assert!(parse(&sketch("duration = 0.2", &change([0.1, 0.101, 0.102]))).is_ok());
    let jump = "duration = 0.2\ngravity_changes = [{ time = 0.1, gravity = [0.0, 0.0, -9.81] }, { time = 0.1001, gravity = [0.0, 0.0, 9.81] }]";
    assert!(parse(&sketch("duration = 0.2", jump)).is_ok());
    // A scene's own rules hold for steps that are set in code too.
    let mut scene = parse(&enough.replace("5e-4", "4e-5")).unwrap();
    scene.solver.step = 5e-4;
    assert!(Simulation::new(&scene, 1).is_err());
}

#[test]
fn the_step_of_an_accuracy_keeps_to_the_motions() {
    let shaken = "kind = 'vibrating', amplitude = [0.0, 0.0, 1e-5], frequency = 800.0";
    let text =
        sketch("kind = 'fixed'", shaken).replace("[solver]\nstep = 5e-4", "accuracy = { packing_fraction = 0.01 }");
    let still = sketch("[solver]\nstep = 5e-4", "accuracy = { packing_fraction = 0.01 }");
    let (shaken, still) = (parse(&text).unwrap(), parse(&still).unwrap());
    assert!(still.solver.step > 2.0 * shaken.solver.step, "{} {}", still.solver.step, shaken.solver.step);
    assert_eq!(shaken.solver.step, 1.0 / (12.0 * 800.0));
}

#[test]
fn accuracy_bounds_the_step_by_impacts_and_fast_walls() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let accuracy = "accuracy = { packing_fraction = 0.02 }\n[material.grain]";
    let text = std::fs::read_to_string(file).unwrap().replacen("[material.grain]", accuracy, 1);
    let step = |text: &str| parse(text).unwrap().solver.step;
    // The rule of packing fractions takes 2 ms. Grains that fall 0.2 m in such steps overlap by more than half their radius.
    let bounded = step(&text);
    assert!((0.8e-3..1.2e-3).contains(&bounded), "{bounded}");
    let unwatched = step(&text.replacen("[material.grain]", "watch = { on_overlap = 'ignore' }\n[material.grain]", 1));
    assert!((1.95e-3..1.99e-3).contains(&unwatched), "{unwatched}");
    // In a step a wall moves by at most the smallest diameter.
    let grain = "[[grain]]\nmaterial = 'grain'\nradius = 0.004\nposition = [0.0, 0.05, 0.02]\n";
    let belt = sketch("kind = 'fixed'", "kind = 'translating', velocity = [40.0, 0.0, 0.0]") + grain;
    assert_eq!(step(&belt.replace("[solver]\nstep = 5e-4", "accuracy = { packing_fraction = 0.01 }")), 0.008 / 40.0);
}

#[test]
fn values_in_other_units_are_asked_about() {
    let told = |from: &str, to: &str, words: &[&str]| {
        let told = warnings(&parse(&sketch(from, to)).unwrap());
        assert!(told.iter().any(|line| words.iter().all(|word| line.contains(word))), "{to}: {told:?}");
    };
    let none = |from: &str, to: &str| {
        let told = warnings(&parse(&sketch(from, to)).unwrap());
        assert!(!told.iter().any(|line| line.contains('?')), "{to}: {told:?}");
    };
    told("density = 2500.0", "density = 2.5", &["material.grain.density: 2.5 kg/m3", "is it in g/cm3?", "2500 kg/m3"]);
    told("density = 2500.0", "density = 22.5", &["is it in g/cm3?"]);
    none("density = 2500.0", "density = 22.6");
    none("density = 2500.0", "density = 22590.0");
    told("density = 2500.0", "density = 22600.0", &["denser than any material"]);
    told("friction = 0.5", "friction = 26.6", &["material.grain.friction: 26.6", "angle in degrees?", "0.501"]);
    none("friction = 0.5", "friction = 4.0");
    told("youngs_modulus = 1e7", "youngs_modulus = 7e3", &["softer than beads of hydrogel", "GPa?"]);
    none("youngs_modulus = 1e7", "youngs_modulus = 1.2e12");
    told("youngs_modulus = 1e7", "youngs_modulus = 2e12", &["stiffer than diamond"]);
    told("-9.81]", "-9810.0]", &["gravity: 9810 m/s2", "mm/s2?"]);
    told("radius = 0.005", "radius = 4e-7", &["colloids", "1e-6 m"]);
    let pair = "friction = 0.5\nrestitution = 0.3\n[[pair]]\nbetween = ['grain', 'grain']\nfriction = 30.0";
    told("friction = 0.5\nrestitution = 0.3", pair, &["pair[0].friction: 30", "degrees?"]);
}

#[test]
fn a_scene_in_millimetres_is_asked_about() {
    // Every length a thousand times as large; what stands in metres is not asked about.
    let metres = sketch("", "");
    let millimetres = metres
        .replace("[-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1]", "[-100.0, -100.0, -100.0], max = [100.0, 100.0, 100.0]")
        .replace("radius = 0.005", "radius = 5.0")
        .replace("0.02]", "20.0]");
    assert_eq!(warnings(&parse(&metres).unwrap()), Vec::<String>::new());
    let found = parse(&millimetres).unwrap().findings(Some(&millimetres));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].severity, found[0].line), (Severity::Warning, Some(21)));
    let words = "grain[0].radius: grains of 10 m in diameter are boulders (above 0.256 m); are lengths in metres? 10 mm are 0.01 m";
    assert_eq!(found[0].to_string(), words);
}

#[test]
fn settings_without_effect_are_told() {
    let with = |settings: &str| warnings(&parse(&sketch("step = 5e-4", settings)).unwrap());
    assert_eq!(with("inner_sweeps = 2\nover_relaxation = 1.1"), Vec::<String>::new());
    let told = with("inner_sweeps = 2\nover_relaxation = 1.1\nmethod = { kind = 'jacobi' }");
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].contains("solver.inner_sweeps: has no effect with method jacobi"), "{told:?}");
    let late = "kind = 'translating', velocity = [0.0, 0.0, 0.1], start = 0.5";
    let told = warnings(&parse(&sketch("kind = 'fixed'", late)).unwrap());
    assert!(told.len() == 1 && told[0].contains("never moves: the scene ends at 0.2 s"), "{told:?}");
    let still = "kind = 'translating', velocity = [0.0, 0.0, 0.1], start = 0.1, stop = 0.1";
    let told = warnings(&parse(&sketch("kind = 'fixed'", still)).unwrap());
    assert!(told.len() == 1 && told[0].contains("never moves: it stops at 0.1 s, when it starts"), "{told:?}");
}

#[test]
fn sources_and_sinks_that_never_act_are_told() {
    let source = "[[insert]]\nmaterial = 'grain'\nradius = { kind = 'discrete', radii = [0.004], shares = [1] }\n\
                  region = { kind = 'box', min = [0.02, 0.02, 0.02], max = [0.06, 0.06, 0.06] }\n";
    let sink = "[[remove]]\nregion = { kind = 'box', min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, -0.05] }\n";
    let stages = "[[stage]]\nname = 'one'\nduration = 0.2\n[[stage]]\nname = 'two'\nduration = 0.4\n";
    let told = |tables: &[&str]| {
        let text = sketch("", "") + &tables.concat();
        warnings(&parse(&if tables.contains(&stages) { text.replace("duration = 0.2\ng", "g") } else { text }).unwrap())
    };
    for acts in [
        vec![source, "rate = 100\nfrom = 0.1\n"],
        vec![source, "total = 1\n"],
        vec![sink, "until = 0.1\n"],
        vec![stages, source, "rate = 100\nfrom = 0.5\n"],
        vec![stages, sink, "stage = 'two'\nfrom = 0.3\n"],
    ] {
        assert_eq!(told(&acts), Vec::<String>::new(), "{acts:?}");
    }
    for (never, words) in [
        (vec![source, "rate = 100\nfrom = 0.2\n"], "insert[0].from: never acts: the run, or its stage, ends at 0.2 s"),
        (vec![source, "total = 9\nfrom = 3\n"], "insert[0].from: never acts"),
        (vec![source, "rate = 4\n"], "insert[0]: less than one grain is due"),
        (vec![source, "mass_rate = 1e-6\n"], "insert[0]: less than one grain is due"),
        (vec![sink, "from = 0.5\n"], "remove[0].from: never acts"),
        (
            vec![stages, source, "stage = 'one'\nrate = 100\nfrom = 0.3\n"],
            "insert[0].from: never acts: the run, or its",
        ),
        (vec![stages, sink, "from = 0.7\n"], "remove[0].from: never acts: the run, or its stage, ends at 0.6"),
    ] {
        let told = told(&never);
        assert!(told.len() == 1 && told[0].contains(words), "{never:?}: {told:?}");
    }
}

#[test]
fn a_duration_is_some_whole_number_of_steps() {
    let with = |step: &str| sketch("step = 5e-4", &format!("step = {step}"));
    let refused = parse(&with("0.1").replace("duration = 0.2", "duration = 0.04")).unwrap_err().to_string();
    assert!(refused.contains("no step of 0.1 s is taken in 0.04 s") && refused.contains("at most 4e-2 s"), "{refused}");
    let told = warnings(&parse(&with("0.09")).unwrap());
    let uneven = "duration: 0.2 s are no whole number of steps of 0.09 s: 0.18 s are simulated";
    assert!(told.iter().any(|line| line.contains(uneven)), "{told:?}");
    assert_eq!(warnings(&parse(&with("3e-4")).unwrap()), Vec::<String>::new(), "a sixth of a thousandth is lost");
}

#[test]
fn memory_is_estimated_before_it_is_allocated() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let mut scene = Scene::load(file).unwrap();
    // The simulation itself holds less than the estimate, and not many times less.
    let (held, estimate) = (Simulation::new(&scene, 1).unwrap().memory_bytes() as u64, scene.memory());
    assert!(held < estimate && estimate < 20 * held, "{held} {estimate}");
    scene.population[0].count = 100_000_000;
    assert!(scene.memory() > 100_000_000_000);
}
