//! `makadam run`: the JSON contract, reproducible states, files that can be read.

use crate::support::changed::changed;
use crate::support::makadam;
use crate::support::small_scene::smoke;
use makadam_frames::run_frames::RunFrames;
use serde_json::Value;
use std::path::Path;

/// Runs 60 steps of the small scene and returns what is printed as JSON.
fn run(folder: &Path, arguments: &[&str]) -> Value {
    let output = makadam(folder)
        .arg("run")
        .arg(smoke())
        .args(["--steps", "60", "--json", "--restart", "--output", "out"])
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn json_keeps_its_contract() {
    let folder = tempfile::tempdir().unwrap();
    let summary = run(folder.path(), &["--seed", "5", "--threads", "2", "--scheduler", "central-queue"]);
    assert_eq!(summary["version"], 1);
    assert_eq!(summary["command"], "run");
    assert_eq!(summary["complete"], true);
    assert_eq!(summary["steps"], 60);
    assert_eq!(summary["particles"], 200);
    let hash = summary["state_hash"].as_str().unwrap();
    assert!(hash.len() == 16 && hash.chars().all(|c| c.is_ascii_hexdigit()), "{hash}");
    for field in ["simulated_seconds", "wall_seconds", "contact_sweeps", "nanoseconds_per_contact_sweep", "peak_bytes"]
    {
        assert!(summary[field].as_f64().is_some_and(|value| value > 0.0), "{field}: {}", summary[field]);
    }
    for phase in ["detect", "constrain", "sweep", "integrate", "output"] {
        assert!(summary["phase_seconds"][phase].as_f64().is_some_and(|value| value >= 0.0), "{phase}");
    }
    for direction in ["normal", "tangential_u", "tangential_v"] {
        for size in ["rms", "max"] {
            assert!(summary["residuals"][direction][size].is_f64(), "{direction}.{size}");
        }
    }
    assert!(summary["residuals"]["stop_reason"].is_string());
    assert!(summary["observables"]["largest_overlap"]["value"].is_f64());
    let provenance = &summary["provenance"];
    assert_eq!(provenance["seed"], 5);
    assert_eq!(provenance["threads"], 2);
    assert_eq!(provenance["scheduler"], "central-queue");
    for field in ["version", "commit", "compiler", "instruction_set", "scene_hash", "scene_file", "time", "processor"] {
        assert!(provenance[field].as_str().is_some_and(|text| !text.is_empty()), "{field}");
    }
    assert!(provenance["solver"]["step"].is_f64());
    // The file holds what was printed.
    let file = std::fs::read_to_string(folder.path().join("out/run.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&file).unwrap(), summary);
}

#[test]
fn equal_seeds_give_equal_states_and_others_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let hash = |seed: &str, threads: &str| {
        run(folder.path(), &["--seed", seed, "--threads", threads])["state_hash"].as_str().unwrap().to_string()
    };
    let first = hash("1", "1");
    assert_eq!(first, hash("1", "2"));
    assert_ne!(first, hash("2", "1"));
}

#[test]
fn frames_are_valid_and_complete() {
    let folder = tempfile::tempdir().unwrap();
    let summary = run(folder.path(), &[]);
    let frames = summary["frames"].as_u64().unwrap() as usize;
    let run = RunFrames::open(&folder.path().join("out")).unwrap();
    assert_eq!((run.count(), run.scene()), (frames, "smoke"));
    for number in 0..frames {
        let frame = run.read(number).unwrap();
        assert_eq!((frame.time, frame.grains.positions.len()), (run.time(number), 200));
        assert!(frame.grains.radii.iter().all(|radius| (radius / 0.005 - 1.0).abs() < 0.051));
        let names = frame.quantities();
        for name in
            ["angular_velocity", "coordination_number", "diameter", "force", "id", "mass", "material", "population"]
                .iter()
                .chain(&["pressure", "speed", "velocity"])
        {
            assert!(names.iter().any(|there| there == name), "no field {name} in {names:?}");
            assert_eq!(frame.quantity(name).unwrap().values.len(), 200);
        }
        assert_eq!(frame.quantity("material").unwrap().names, ["grain", "wall"]);
        // Five faces of the box, whose walls rest and are written once.
        assert_eq!(frame.walls.unwrap().triangles.len(), 10);
        if number + 1 == frames {
            assert_eq!(frame.contacts.unwrap().len() as u64, summary["contacts"].as_u64().unwrap());
        }
    }
    // The scene requests files for ParaView.
    let folder = folder.path();
    let scene = changed(folder, "[measure]", "[output]\nformats = [\"vtp\"]\n[measure]");
    let output = makadam(folder).arg("run").arg(scene).args(["--steps", "100", "--output", "vtp"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.join("vtp/frames/walls-00000.vtp").exists() && !folder.join("vtp/frames/walls-00001.vtp").exists());
    // Exports that are missing are made up for, and frames of an earlier export go.
    std::fs::remove_file(folder.join("vtp/grains.pvd")).unwrap();
    std::fs::write(folder.join("vtp/frames/grains-00099.vtp"), "").unwrap();
    let scene = folder.join("changed.toml");
    let again = ["--steps", "100", "--output", "vtp", "--resume"];
    assert!(makadam(folder).arg("run").arg(scene).args(again).output().unwrap().status.success());
    assert!(!folder.join("vtp/frames/grains-00099.vtp").exists());
    let list = std::fs::read_to_string(folder.join("vtp/grains.pvd")).unwrap();
    assert!(list.contains("frames/grains-00001.vtp") && folder.join("vtp/frames/grains-00001.vtp").exists(), "{list}");
    let script = std::fs::read_to_string(folder.join("vtp/open-in-paraview.py")).unwrap();
    assert!(script.contains("diameter") && script.contains("PVDReader"));
}

#[test]
fn a_scene_chooses_what_frames_hold_and_how_often() {
    let folder = tempfile::tempdir().unwrap();
    let table = "[output]\ninterval = 0.02\nfields = [\"speed\", \"coordination-number\"]\ncontacts = false\n[measure]";
    let scene = changed(folder.path(), "[measure]", table);
    let run = |scene: &Path| {
        makadam(folder.path())
            .arg("run")
            .arg(scene)
            .args(["--steps", "100", "--restart", "--output", "out"])
            .output()
            .unwrap()
    };
    let output = run(&scene);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let frames = RunFrames::open(&folder.path().join("out")).unwrap();
    let frame = frames.read(1).unwrap();
    assert!(frame.contacts.is_none());
    // The chosen fields are those of exports.
    let exported = makadam(folder.path()).args(["export", "out", "--format", "vtkhdf"]).output().unwrap();
    assert!(exported.status.success() && !folder.path().join("out/contacts.vtkhdf").exists());
    let file = hdf5_pure::File::open(folder.path().join("out/grains.vtkhdf")).unwrap();
    let has = |name: &str| file.dataset(&format!("VTKHDF/PointData/{name}")).is_ok();
    assert!(has("speed") && has("coordination_number") && has("diameter") && !has("velocity") && !has("stress"));
    // 100 steps of 0.5 ms: a frame each 20 ms and one at the end, while the table has a row each 50 ms.
    let times: Vec<String> = (0..frames.count()).map(|number| format!("{:.3}", frames.time(number))).collect();
    assert_eq!(times, ["0.000", "0.020", "0.040", "0.050"]);
    let rows = std::fs::read_to_string(folder.path().join("out/observables.csv")).unwrap();
    assert_eq!(rows.lines().count(), 3, "{rows}");

    let scene = changed(folder.path(), "[measure]", "[output]\nfields = [\"sped\"]\n[measure]");
    let output = run(&scene);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3));
    for word in ["sped", "speed", "angular_velocity", "pressure"] {
        assert!(message.contains(word), "{message}");
    }
    let scene = changed(folder.path(), "[measure]", "[output]\ninterval = 1e-9\n[measure]");
    let message = String::from_utf8_lossy(&run(&scene).stderr).into_owned();
    assert!(message.contains("output.interval"), "{message}");
}

#[test]
fn single_precision_is_another_result_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let double = run(folder.path(), &["-q", "--precision", "double"]);
    let single = run(folder.path(), &["-q", "--precision", "single"]);
    assert_ne!(double["state_hash"], single["state_hash"]);
    assert_ne!(double["provenance"]["scene_hash"], single["provenance"]["scene_hash"]);
}

#[test]
fn an_accuracy_chooses_step_and_sweeps_and_says_what_it_took() {
    let folder = tempfile::tempdir().unwrap();
    let fine = run(folder.path(), &["-q", "--accuracy", "0.5%"]);
    let coarse = run(folder.path(), &["-q", "--accuracy", "2%"]);
    assert!(fine["time_step"].as_f64().unwrap() < coarse["time_step"].as_f64().unwrap());
    let solves = &fine["residuals"];
    assert_eq!(fine["provenance"]["solver"]["stop"]["kind"], "residual");
    assert!(solves["mean_sweeps"].as_f64().unwrap() <= solves["most_sweeps"].as_f64().unwrap());
    assert_eq!(solves["unconverged"], 0);
    for wrong in ["soon", "angle=", "hue=1", "1%,2%"] {
        let output = makadam(folder.path()).arg("run").arg(smoke()).args(["--accuracy", wrong]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn observables_are_a_table_over_time() {
    let folder = tempfile::tempdir().unwrap();
    let summary = run(folder.path(), &["-q"]);
    let mut table = csv::Reader::from_path(folder.path().join("out/observables.csv")).unwrap();
    let head = table.headers().unwrap().clone();
    assert_eq!(head.iter().take(4).collect::<Vec<_>>(), ["time", "step", "contacts", "kinetic_energy"]);
    assert!(head.iter().any(|name| name == "largest_overlap"));
    let rows: Vec<csv::StringRecord> = table.records().collect::<Result<_, _>>().unwrap();
    assert_eq!(rows.len() as u64, summary["frames"].as_u64().unwrap());
    assert!(rows.iter().flatten().all(|cell| cell.is_empty() || cell.parse::<f64>().unwrap().is_finite()));
}

#[test]
fn a_driven_wall_has_its_place_and_rate_in_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let lid = "[[wall]]\nname = 'lid'\nmaterial = 'wall'\n\
               shape = { kind = 'plane', point = [0.0, 0.0, 0.25], normal = [0.0, 0.0, -1.0] }\n\
               motion = { kind = 'force-driven', axis = [0, 0, -1], force = 0.2, mass = 0.1 }\n\n[[population]]";
    let scene = changed(folder.path(), "[[population]]", lid);
    makadam(folder.path()).arg("run").arg(&scene).args(["--steps", "40", "--output", "out"]).assert().success();
    let mut table = csv::Reader::from_path(folder.path().join("out/observables.csv")).unwrap();
    let columns = table.headers().unwrap().clone();
    let place = |name: &str| columns.iter().position(|column| column == name).unwrap_or_else(|| panic!("{columns:?}"));
    let last = table.records().last().unwrap().unwrap();
    let value = |name: &str| last[place(name)].parse::<f64>().unwrap();
    // Nothing holds it up yet: v = a t, and the sum of the steps' velocities.
    let (acceleration, step) = (9.81 + 0.2 / 0.1, value("time") / value("step"));
    let expected = acceleration * value("time");
    assert!((value("lid_rate") / expected - 1.0).abs() < 1e-9, "{} m/s, not {expected}", value("lid_rate"));
    let expected = 0.5 * acceleration * value("time") * (value("time") + step);
    assert!(
        (value("lid_displacement") / expected - 1.0).abs() < 1e-9,
        "{} m, not {expected}",
        value("lid_displacement")
    );
}

#[test]
fn a_prepared_flow_is_made_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = changed(folder.path(), "[measure]", "[prepare]\nduration = 0.05\nstep = 1e-3\n\n[measure]");
    let run = || {
        let output = makadam(folder.path())
            .arg("run")
            .arg(&scene)
            .args(["--steps", "20", "--json", "--restart", "--output", "out"])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let states = || -> Vec<_> {
        let folder = folder.path().join("cache/makadam/prepared");
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
    };
    let first = run();
    assert_eq!(states().len(), 1);
    let made = states()[0].metadata().unwrap().modified().unwrap();
    let second = run();
    assert_eq!(states()[0].metadata().unwrap().modified().unwrap(), made);
    assert_eq!(first["state_hash"], second["state_hash"]);
    assert!((first["simulated_seconds"].as_f64().unwrap() - 0.01).abs() < 1e-9);
    // A state that cannot be read is made anew.
    std::fs::write(&states()[0], "not a state").unwrap();
    assert_eq!(run()["state_hash"], first["state_hash"]);
}

#[test]
fn a_scene_is_found_by_name_and_described_for_people() {
    let folder = tempfile::tempdir().unwrap();
    let output = makadam(folder.path()).args(["run", "packing", "--steps", "20", "--output", "out"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut last = 0;
    // What was simulated comes first, how it was computed behind it.
    for word in ["2000 grains", "packing_fraction", "solves ", "time by phase", "bytes per grain", "state hash"] {
        let place = text.find(word).unwrap_or_else(|| panic!("no '{word}' in\n{text}"));
        assert!(place >= last, "'{word}' stands too early in\n{text}");
        last = place;
    }
    // Nothing but results on standard output, no progress off a terminal, no colours in a pipe.
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!text.contains('\x1b'));
}
