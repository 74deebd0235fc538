//! Loads and wear of walls, and gauges, from the scene to tables, summary and exports.

use crate::support::makadam;
use serde_json::Value;

const SCENE: &str = r#"
name = "slide"
duration = 0.04
domain = { min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }
[material.glass]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.0
restitution = 0.0
[[wall]]
name = "table-1"
material = "glass"
shape = { kind = "plane", point = [0, 0, 0], normal = [0, 0, 1] }
[[grain]]
material = "glass"
radius = 0.005
position = [-0.015, 0, 0.005]
velocity = [1, 0, 0]
[[gauge]]
name = "half way"
shape = { kind = "rectangle", corner = [0, -0.05, 0], edges = [[0, 0.1, 0], [0, 0, 0.05]] }
[solver]
step = 1e-4
normal_law = { kind = "rigid" }
[measure]
interval = 0.01
from = 0.01
observables = ["walls", "wear", "gauges"]
[output]
formats = ["vtp"]
[[compare]]
observable = "force-z(table-1)"
"#;

#[test]
fn loads_wear_and_gauges_are_measured_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("slide.toml"), SCENE).unwrap();
    let output = makadam(folder).args(["run", "slide.toml", "--json", "--output", "out"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let value =
        |name: &str| summary["observables"][name]["value"].as_f64().unwrap_or_else(|| panic!("{name}: {summary}"));
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    let is = |name: &str, expected: f64| assert!((value(name) / expected - 1.0).abs() < 1e-6, "{name} {}", value(name));
    is("force_z(table-1)", -9.81 * mass);
    is("archard(table-1)", 9.81 * mass * 0.04);
    is("flux(half way)", mass / 0.03);
    assert_eq!(value("power(table-1)"), 0.0);
    assert_eq!(summary["without_value"], serde_json::json!({}));
    let table = std::fs::read_to_string(folder.join("out/observables.csv")).unwrap();
    let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| {
        let place = head.iter().position(|known| *known == name).unwrap_or_else(|| panic!("no {name} in {head:?}"));
        table.lines().skip(1).map(|line| line.split(',').nth(place).unwrap().to_string()).collect::<Vec<_>>()
    };
    assert_eq!(column("grains_forward(half way)"), ["0.0", "0.0", "1.0", "1.0", "1.0"]);
    // No step has been taken at the first frame.
    assert_eq!(column("force_z(table-1)")[0], "");
    let walls = std::fs::read(folder.join("out/frames/walls-00004.vtp")).unwrap();
    let text = String::from_utf8_lossy(&walls);
    assert!(["pressure", "archard", "finnie"].iter().all(|name| text.contains(&format!("Name=\"{name}\""))));
}

#[test]
fn a_wall_that_does_not_exist_has_no_loads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("slide.toml"), SCENE.replace("force-z(table-1)", "force-z(table-2)")).unwrap();
    let output = makadam(folder).args(["check", "slide.toml"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("the scene has no wall 'table-2'") && said.contains("table-1"), "{said}");
}

#[test]
fn fields_of_a_run_without_grains_are_zero() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let empty = SCENE.replace(
        "[[grain]]\nmaterial = \"glass\"\nradius = 0.005\nposition = [-0.015, 0, 0.005]\nvelocity = [1, 0, 0]\n",
        "",
    );
    std::fs::write(folder.join("empty.toml"), empty.replace("\"vtp\"", "\"fields\"")).unwrap();
    let output = makadam(folder).args(["run", "empty.toml", "--output", "out"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.join("out/fields.pvd").is_file());
}

/// A lifter that the drum carries counts in the torque of the drum as one that turns by itself.
#[test]
fn a_carried_wall_has_its_share_of_the_torque() {
    let drum = r#"
name = "drum"
duration = 0.3
domain = { min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }
[material.glass]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.5
restitution = 0.3
[[wall]]
name = "shell"
material = "glass"
shape = { kind = "cylinder", base = [0, -0.02, 0], axis = [0, 1, 0], radius = 0.05, length = 0.04 }
motion = { kind = "rotating", point = [0, 0, 0], axis = [0, 1, 0], rate = 4 }
[[wall]]
name = "lifter"
material = "glass"
shape = { kind = "rectangle", corner = [-0.05, -0.02, 0], edges = [[0.02, 0, 0], [0, 0.04, 0]] }
MOTION
[[wall]]
name = "ends"
material = "glass"
shape = { kind = "box", min = [-0.09, -0.02, -0.09], max = [0.09, 0.02, 0.09], open = ["-x", "+x", "-z", "+z"] }
[[population]]
count = 120
material = "glass"
radius = { kind = "uniform", mean = 0.004, spread = 0.1 }
region = { kind = "cylinder", base = [0, -0.02, 0], axis = [0, 1, 0], radius = 0.05, length = 0.04 }
[solver]
step = 5e-4
[measure]
interval = 0.02
from = 0.1
observables = ["drum-flow", "walls"]
"#;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = |name: &str, motion: &str| -> Value {
        std::fs::write(folder.join("drum.toml"), drum.replace("MOTION", motion)).unwrap();
        let output = makadam(folder).args(["run", "drum.toml", "--json", "--output", name]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let carried = run("carried", "parent = \"shell\"");
    let own = run("own", "motion = { kind = \"rotating\", point = [0, 0, 0], axis = [0, 1, 0], rate = 4 }");
    assert_eq!(carried["state_hash"], own["state_hash"]);
    assert_eq!(carried["observables"], own["observables"]);
    let names = carried["observables"].as_object().unwrap();
    assert!(names.contains_key("wall_torque") && names.contains_key("torque(lifter)"), "{names:?}");
}
