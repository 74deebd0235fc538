//! Starts from CSV files.

use crate::common::{CONVERGED_RIGID, FLOOR, Setup};
use makadam::Simulation;
use makadam::scene::{Scene, populate};
use std::path::PathBuf;

/// Scene with a start table, and the folder with its file.
fn scene_in(name: &str, csv: &str, start: &str) -> (PathBuf, String) {
    let folder = std::env::temp_dir().join(format!("makadam-start-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("start.csv"), csv).unwrap();
    let setup = Setup { body: FLOOR.into(), solver: CONVERGED_RIGID.into(), ..Setup::default() };
    let mut table = toml::Table::try_from(setup.scene()).unwrap();
    table.insert("start".into(), toml::Value::Table(toml::from_str(start).unwrap()));
    (folder, toml::to_string(&table).unwrap())
}

fn error(csv: &str, start: &str) -> String {
    let name = std::thread::current().name().unwrap_or_default().replace(':', "-");
    let (folder, text) = scene_in(&name, csv, start);
    let error = Scene::parse_in(&text, &folder).unwrap_err().to_string();
    std::fs::remove_dir_all(folder).unwrap();
    error
}

#[test]
fn grains_have_the_values_of_the_file() {
    let csv = "radius, x, y, z, material, vx, vy, vz, wz\n0.005, 0.1, 0.2, 0.005, grain, 1, 2, 3, 4\n\
               0.003, -0.1, 1e-3, 0.1, wall, 0, 0, -1.5, 0\n";
    let (folder, text) = scene_in("values", csv, "file = 'start.csv'");
    let scene = Scene::parse_in(&text, &folder).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let grains = populate(&scene, 1).unwrap();
    assert_eq!((grains.len(), scene.grain_count()), (2, 2));
    assert_eq!((grains[0].position, grains[0].velocity), ([0.1, 0.2, 0.005], [1.0, 2.0, 3.0]));
    assert_eq!((grains[0].spin, grains[0].radius), ([0.0, 0.0, 4.0], 0.005));
    assert_eq!((grains[1].material.as_str(), grains[1].velocity), ("wall", [0.0, 0.0, -1.5]));
    // A written scene is complete without the file, and gives the same bits.
    let written = toml::to_string(&scene).unwrap();
    let again = Scene::parse(&written).unwrap();
    assert_eq!(again, scene);
    assert_eq!(toml::to_string(&again).unwrap(), written);
    let [mut one, mut other] = [scene, again].map(|scene| Simulation::new(&scene, 1).unwrap());
    for _ in 0..50 {
        one.step();
        other.step();
    }
    assert_eq!(one.state_hash(), other.state_hash());
}

#[test]
fn a_file_and_listed_grains_give_the_same_bits() {
    let csv = "x,y,z,radius\n0,0,0.005,0.005\n0.02,0,0.007,0.005\n";
    let (folder, text) = scene_in("bits", csv, "file = 'start.csv'\nmaterial = 'grain'");
    let scene = Scene::parse_in(&text, &folder).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let listed = Scene { grain: scene.listed().cloned().collect(), start: None, ..scene.clone() };
    let [mut one, mut other] = [scene, listed].map(|scene| Simulation::new(&scene, 1).unwrap());
    for _ in 0..100 {
        one.step();
        other.step();
    }
    assert_eq!(one.state_hash(), other.state_hash());
}

#[test]
fn errors_name_line_column_and_remedy() {
    let named = "file = 'start.csv'\nmaterial = 'grain'";
    for (csv, start, parts) in [
        ("x,y,z\n", named, ["start.file", "line 1: there is no column 'radius'", "give x, y, z, radius"]),
        ("x,y,z,radius,id\n", named, ["start.file", "line 1: column 'id' is unknown", "give x, y, z, radius"]),
        ("x,y,z,radius,x\n", named, ["start.file", "line 1: column 'x' is unknown or listed twice", "each once"]),
        (
            "x,y,z,radius\n0,0,1,0.01\n0,0,up,0.01\n",
            named,
            ["start.file", "line 3: column z: 'up' is not a number", "SI"],
        ),
        ("x,y,z,radius\n0,0,1\n", named, ["start.file", "line 2: 3 values", "one value for each column"]),
        ("x,y,z,radius\n0,0,1,-2\n", named, ["start.file", "line 2: radius: -2 is out of range", "from 0.000000001"]),
        ("x,y,z,radius\n0,0,nan,1\n", named, ["start.file", "line 2: position", "finite"]),
        ("x,y,z,radius\n0,0,1,0.1\n", "file = 'start.csv'", ["start.file", "material", "give one of them"]),
        (
            "x,y,z,radius\n0,0,1,0.1\n",
            "file = 'start.csv'\nmaterial = 'iron'",
            ["line 2: material", "iron", "grain, wall"],
        ),
        ("x,y,z,radius\n", named, ["start.file", "line 1: names of columns, and no grains", "[[insert]]"]),
        (
            "",
            "file = 'none.csv'\nmaterial = 'grain'",
            ["start.file", "none.csv' cannot be read", "relative to the folder"],
        ),
    ] {
        let error = error(csv, start);
        assert!(parts.iter().all(|part| error.contains(part)), "{csv:?}: {error}");
    }
}

#[test]
fn overlaps_at_the_start_are_refused() {
    let (folder, text) =
        scene_in("overlap", "x,y,z,radius\n0,0,1,0.01\n0,0,1.01,0.01\n", "file = 'start.csv'\nmaterial = 'grain'");
    let error = populate(&Scene::parse_in(&text, &folder).unwrap(), 1).unwrap_err().to_string();
    std::fs::remove_dir_all(folder).unwrap();
    assert!(error.contains("start.file") && error.contains("grains 0 and 1 overlap"), "{error}");
}

#[test]
fn a_source_needs_no_grains_at_the_start() {
    let (folder, text) = scene_in("empty", "x,y,z,radius\n", "file = 'start.csv'\nmaterial = 'grain'");
    let source = "[[insert]]\nmaterial = 'grain'\nradius = { kind = 'discrete', radii = [0.005], shares = [1] }\ntotal = 3\n\
                  region = { kind = 'box', min = [0, 0, 0.1], max = [0.1, 0.1, 0.2] }\n";
    let scene = Scene::parse_in(&(text + "\n" + source), &folder).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    assert_eq!((scene.grain_count(), scene.most_grains()), (0, 3));
}

/// The default step follows the grains of a file as it follows listed ones.
#[test]
fn the_default_step_knows_the_grains_of_a_file() {
    let csv = "x,y,z,radius,vz\n0,0,0.0001,0.00005,-3\n";
    let (folder, text) = scene_in("default-step", csv, "file = 'start.csv'\nmaterial = 'grain'");
    let text: String =
        text.lines().filter(|line| !line.starts_with("step = ")).map(|line| format!("{line}\n")).collect();
    let scene = Scene::parse_in(&text, &folder).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    assert!((1e-6..2e-6).contains(&scene.solver.step), "{}", scene.solver.step);
}
