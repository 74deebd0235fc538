//! Scenes: the reference scenes load and populate; bad input names file, line and remedy.

use makadam::scene::{Scene, SolverMethod, SolverSettings, Stop, populate};
use std::path::{Path, PathBuf};

fn reference_scene(name: &str) -> (PathBuf, Scene) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    let scene = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    (file, scene)
}

#[test]
fn reference_scenes_populate_reproducibly() {
    for (name, count) in [("packing", 2000), ("drum", 1600), ("drum-caps", 1600), ("heap", 1500), ("drum-50k", 50_000)]
    {
        let (_, scene) = reference_scene(name);
        let grains = populate(&scene, 1).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(grains.len(), count, "{name}");
        assert_eq!(grains, populate(&scene, 1).unwrap(), "{name}: same seed, same grains");
        assert_ne!(grains, populate(&scene, 2).unwrap(), "{name}: another seed, other grains");
    }
}

fn refusal(from: &str, to: &str) -> String {
    let (file, _) = reference_scene("packing");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains(from), "the scene no longer holds {from:?}");
    let text = text.replacen(from, to, 1);
    let refused = Scene::parse(&text).map_or_else(|error| error, |scene| populate(&scene, 1).expect_err("accepted"));
    refused.in_file(Path::new("bad.toml"), Some(&text)).to_string()
}

#[test]
fn bad_input_names_file_line_and_remedy() {
    let message = refusal("duration = 1.5", "duraton = 1.5");
    assert!(message.starts_with("bad.toml:3:") && message.contains("duraton"), "{message}");
    let message = refusal("density = 2500.0", "density = \"2500 kg/m3\"");
    assert!(message.starts_with("bad.toml:8:") && message.contains("SI units"), "{message}");
    assert!(message.contains("expected a number"), "{message}");
    for count in ["1e3", "-5", "2.5"] {
        let message = refusal("count = 2000", &format!("count = {count}"));
        assert!(message.contains("expected a whole number from 0; write it without a sign, a point"), "{message}");
    }
    let message = refusal("gravity = [0.0, 0.0, -9.81]", "gravity = [0.0, -9.81]");
    assert!(message.contains("expected a list of length 3; write as many values in brackets"), "{message}");
    let message = refusal("density = 2500.0", "density = 2500.0\ndensity = 2500.0");
    assert!(message.starts_with("bad.toml:9:") && message.contains("keep one of the two lines"), "{message}");
    let message = refusal("restitution = 0.3", "restitution = 1.3");
    assert!(message.starts_with("bad.toml:12:") && message.contains("from 0 to 1"), "{message}");
    let message = refusal("material = \"grain\"", "material = \"gravel\"");
    assert!(message.starts_with("bad.toml:") && message.contains("name one of: grain, wall"), "{message}");
    let message = refusal("count = 2000", "count = 20000");
    assert!(message.contains("do not fit"), "{message}");
}

#[test]
fn methods_are_chosen_by_name_and_their_parameters_checked() {
    let parse = |method: &str| {
        let (file, _) = reference_scene("packing");
        let text = std::fs::read_to_string(&file).unwrap();
        let text = match text.contains("[solver]") {
            true => text.replacen("[solver]", &format!("[solver]\nmethod = {method}"), 1),
            false => text.replacen("[measure]", &format!("[solver]\nmethod = {method}\n\n[measure]"), 1),
        };
        Scene::parse(&text).map(|scene| scene.solver.method).map_err(|error| error.to_string())
    };
    for method in SolverMethod::ALL {
        assert_eq!(parse(&format!("{{ kind = '{}' }}", method.name())).unwrap(), method);
    }
    assert_eq!(parse("{ kind = 'anderson', memory = 5 }").unwrap(), SolverMethod::Anderson { memory: 5 });
    let message = parse("{ kind = 'anderson', memory = 9 }").unwrap_err();
    assert!(message.contains("solver.method.memory: 9") && message.contains("from 1 to 8"), "{message}");
    let message = parse("{ kind = 'jacobi', damping = 0.0 }").unwrap_err();
    assert!(message.contains("solver.method.damping: 0") && message.contains("from 0.001 to 1"), "{message}");
    assert!(parse("{ kind = 'gauss-seidel' }\nprecision = 'single'").is_ok());
    let message = parse("{ kind = 'anderson' }\nprecision = 'single'").unwrap_err();
    assert!(message.contains("solver.precision: single, with method anderson"), "{message}");
    let message = parse("{ kind = 'newton' }").unwrap_err();
    assert!(message.contains("newton") && message.contains("gauss-seidel"), "{message}");
}

#[test]
fn an_accuracy_takes_the_place_of_step_and_sweeps() {
    let (file, _) = reference_scene("packing");
    let text = std::fs::read_to_string(&file).unwrap();
    let parse = |accuracy: &str, modulus: &str, solver: &str| {
        let text = text.replace("youngs_modulus = 1e7", &format!("youngs_modulus = {modulus}"));
        let text = text.replacen("[material.grain]", &format!("accuracy = {accuracy}\n{solver}\n[material.grain]"), 1);
        Scene::parse(&text).map(|scene| scene.solver).map_err(|error| error.to_string())
    };
    let asked = |accuracy: &str, modulus: &str| parse(accuracy, modulus, "").unwrap();
    let tolerance = |settings: &SolverSettings| match settings.stop {
        Stop::Residual { tolerance, .. } => tolerance,
        other => panic!("{other:?}"),
    };
    let fine = asked("{ packing_fraction = 0.002 }", "1e7");
    let finer = asked("{ packing_fraction = 0.001 }", "1e7");
    approx::assert_relative_eq!(fine.step, 2.0 * finer.step, max_relative = 1e-12);
    // A contact's frequency goes as the root of its stiffness, which under a given load goes as E^(2/3).
    let (soft, stiff) = (asked("{ angle = 0.5 }", "1e7"), asked("{ angle = 0.5 }", "1e10"));
    approx::assert_relative_eq!(stiff.step * 10.0, soft.step, max_relative = 1e-12);
    // The strictest demand decides; overlaps need sweeps, not small steps.
    assert_eq!(asked("{ packing_fraction = 0.002, angle = 5.0 }", "1e7").step, fine.step);
    let overlap = asked("{ packing_fraction = 0.002, overlap = 1e-6 }", "1e7");
    assert_eq!(overlap.step, fine.step);
    assert!(tolerance(&overlap) < 0.1 * tolerance(&fine));
    // What is wrong is said with its remedy.
    let message = parse("{ angle = 0.5 }", "1e7", "[solver]\nstep = 1e-3\n").unwrap_err();
    assert!(message.contains("solver.step: given beside accuracy"), "{message}");
    let message = parse("{}", "1e7", "").unwrap_err();
    assert!(message.contains("accuracy: asks for nothing"), "{message}");
    let message = parse("{ angle = -1.0 }", "1e7", "").unwrap_err();
    assert!(message.contains("accuracy.angle: -1"), "{message}");
}

#[test]
fn overlapping_and_outlying_grains_are_refused() {
    let scene = |second: &str, radius: &str| {
        format!(
            "name = 'x'\ndescription = 'x'\nduration = 1.0\ndomain = {{ min = [-1, -1, -1], max = [1, 1, 1] }}\n\
             [material.m]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
             [[grain]]\nmaterial = 'm'\nradius = {radius}\nposition = [0, 0, 0]\n\
             [[grain]]\nmaterial = 'm'\nradius = 0.1\nposition = {second}\n"
        )
    };
    let refuse = |text: String| {
        let scene = Scene::parse(&text).unwrap();
        populate(&scene, 1).map(|grains| grains.len()).map_err(|error| error.to_string())
    };
    assert_eq!(refuse(scene("[0.1995, 0, 0]", "0.1")).unwrap(), 2);
    assert!(refuse(scene("[0.19, 0, 0]", "0.1")).unwrap_err().contains("overlap by"));
    assert!(refuse(scene("[0.19, 0, 0]", "0.1")).unwrap_err().contains("(largest_start_overlap)"));
    assert!(refuse(scene("[3.0, 0, 0]", "0.1")).unwrap_err().contains("outside the domain"));
}

#[test]
fn what_would_never_end_or_fill_the_memory_is_refused() {
    // Draws that hardly ever fall between the smallest and the largest radius.
    let uniform = "{ kind = \"uniform\", mean = 0.005, spread = 0.05 }";
    let narrow = "{ kind = 'normal', mean = 0.005, deviation = 0.004, min = 0.005, max = 0.005 }";
    let message = refusal(uniform, narrow);
    assert!(message.contains("population[0].radius.deviation: 0.004 m is far wider"), "{message}");
    // A lattice of tiny grains in a large region.
    let message = refusal(uniform, "{ kind = 'fixed', value = 1e-9 }");
    assert!(message.contains("lattice sites, more than") && message.contains("make the region smaller"), "{message}");
    // More grains than there are numbers for, in one group or in all of them.
    for count in ["100000001", "1000000000000000000"] {
        let message = refusal("count = 2000", &format!("count = {count}"));
        assert!(message.contains("population[0].count") && message.contains("is out of range"), "{message}");
    }
    let group = |count: &str| {
        format!(
            "[[population]]\ncount = {count}\nmaterial = 'grain'\nradius = {{ kind = 'fixed', value = 0.001 }}\n\
             region = {{ kind = 'box', min = [0, 0, 0], max = [0.01, 0.01, 0.01] }}\n"
        )
    };
    let message = refusal("[measure]", &format!("{}{}[measure]", group("60000000"), group("60000000")));
    assert!(message.contains("population[2].count: 120002000 is out of range"), "{message}");
    // More materials than their numbers have bits for.
    let material = "density = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n";
    let many: String = (0..255).map(|number| format!("[material.m{number}]\n{material}")).collect();
    let message = refusal("[material.grain]", &format!("{many}[material.grain]"));
    assert!(message.contains("257 materials") && message.contains("at most 256"), "{message}");
}
