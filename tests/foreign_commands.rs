//! Frames and codes from elsewhere: `measure`, `judge`, `export --for`.

use crate::support::makadam;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Exit code, standard output and standard error.
fn outcome(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = makadam(folder).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn data(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../").join(name).display().to_string()
}

/// A packing of a hundred grains, and what is varied of it.
const SCENE: [&str; 3] = ["packing-100", "--set", "measure.from=0.3"];

#[test]
fn a_run_is_measured_from_its_frames_as_it_measured_itself() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "--quiet", "-o", "out"].iter().chain(&SCENE).copied().collect::<Vec<_>>();
    let (code, _, errors) = outcome(folder.path(), &run);
    assert_eq!(code, 0, "{errors}");
    let summary: Value = serde_json::from_slice(&std::fs::read(folder.path().join("out/run.json")).unwrap()).unwrap();
    let wanted = summary["observables"].as_object().unwrap();
    let (code, text, errors) =
        outcome(folder.path(), &["measure", "out", "--scene", SCENE[0], SCENE[1], SCENE[2], "--json"]);
    assert_eq!(code, 0, "{errors}");
    let found: Value = serde_json::from_str(&text).unwrap();
    let measured = found["measurements"].as_array().unwrap();
    assert_eq!(measured.len(), wanted.len(), "{text}");
    for one in measured {
        let name = one["observable"].as_str().unwrap();
        // Frames on disk are in single precision: what is at an edge, or a difference of nearly equal numbers, tells that.
        if ["coulomb_excess", "sliding_share", "largest_overlap", "mean_overlap"].contains(&name) {
            continue;
        }
        let (own, other) = (one["value"].as_f64().unwrap(), wanted[name]["value"].as_f64().unwrap());
        assert!((own - other).abs() <= 2e-3 * other.abs().max(1e-6), "{name}: {own} and {other}");
    }
    let (code, text, _) = outcome(folder.path(), &["measure", "out", "--scene", "packing-100"]);
    assert!(code == 0 && text.contains("kinetic_energy") && text.contains("1 of 13 frames"), "{code}: {text}");
    // By another scene, or by what it has become, it is measured with a note.
    let heavy = ["--set", "material.grain.density=5000"];
    for (scene, more, words) in [
        ("packing-high-friction", &heavy[..0], "effects than packing-high-friction; give the scene"),
        ("packing-100", &heavy[..], "out is a run of packing-100 with other walls, materials, grains or effects"),
    ] {
        let errors = outcome(folder.path(), &[&["measure", "out", "--scene", scene], more].concat()).2;
        assert!(errors.contains(words), "{errors}");
    }
}

#[test]
fn frames_of_an_unsound_run_or_of_a_part_of_the_window_are_noted() {
    let folder = tempfile::tempdir().unwrap();
    let smoke = data("tests/scenes/smoke.toml");
    let run = |output: &str, more: &[&str]| {
        outcome(folder.path(), &[&["run", smoke.as_str(), "--quiet", "-o", output], more].concat())
    };
    let notes = |run: &str, more: &[&str]| {
        outcome(folder.path(), &[&["measure", run, "--scene", smoke.as_str()], more].concat()).2
    };
    let warned = [
        "--set",
        "solver.step=0.02",
        "--set",
        "watch.on_energy=\"warn\"",
        "--set",
        "watch.on_escape=\"ignore\"",
        "--set",
        "watch.on_deep_overlap=\"warn\"",
        "--set",
        "watch.every=1",
    ];
    run("unsound", &warned);
    let said = notes("unsound", &[]);
    assert!(said.contains("run.json says that its numbers are invalid: "), "{said}");
    assert_eq!(run("short", &["--set", "duration=0.3"]).0, 0);
    let from = ["--set", "measure.from=0.2"];
    let said = notes("short", &from);
    assert!(said.contains("and the scene is measured from 0.2 to 0.4 s, each 0.05 s"), "{said}");
    assert_eq!(run("whole", &[]).0, 0);
    assert_eq!(notes("whole", &from), "");
}

#[test]
fn files_of_other_codes_are_measured_and_what_they_lack_is_said() {
    let folder = tempfile::tempdir().unwrap();
    // The radii of these files.
    let scene = std::fs::read_to_string(data("reference-scenes/packing-100/scene.toml")).unwrap();
    let scene = scene.replace("mean = 0.005, spread = 0.05", "mean = 0.008, spread = 0.1");
    std::fs::write(folder.path().join("packing.toml"), scene).unwrap();
    let plain = data("validation/tests/frames/yade/plain.txt");
    let (code, text, errors) = outcome(folder.path(), &["measure", &plain, "--scene", "packing.toml", "--time", "0.6"]);
    // Forces are compared in this scene, and there are none.
    assert_eq!(code, 4, "{text}{errors}");
    assert!(text.contains("not measured: gini: the frames have no contacts between grains"), "{text}");
    assert!(text.contains("largest_overlap"), "{text}");
    let vtu = data("validation/tests/frames/yade/spheres.{step}.vtu");
    let (_, text, notes) = outcome(folder.path(), &["measure", &vtu, "--scene", "packing.toml", "--time-step", "1e-2"]);
    assert!(!text.contains("kinetic_energy: "), "velocities and spins are there: {text}");
    assert!(notes.contains("the last frame is measured, at 4 s, and the scene ends at 0.6 s"), "{notes}");
    assert!(notes.contains("the frames have 60 grains, and the scene has 100"), "{notes}");
    let refused: [(&[&str], i32, &str); 8] = [
        (&["measure", &plain, "--scene", "packing-100", "--time", "0.6"], 3, "and the scene has no such grain"),
        (&["measure", &plain, "--scene", "packing.toml"], 3, "\n  time = SECONDS   # time of the only frame"),
        (&["measure", "nothing.csv", "--scene", "packing.toml"], 3, "nothing.csv: line 1:"),
        (&["measure", &plain, "--scene", "packing-101"], 3, "no scene 'packing-101'"),
        (&["measure", &plain, "--scene", "packing.toml", "--columns", "x,y"], 3, "4 numbers, and 2 columns"),
        (
            &["measure", &plain, "--scene", "packing.toml", "--kinds", "1=glass"],
            2,
            "the scene has no glass; it has grain",
        ),
        (
            &["measure", &plain, "code.toml", "--scene", "packing.toml"],
            2,
            "code.toml is a manifest, which names all files",
        ),
        (
            &["measure", &plain, "--scene", "packing.toml", "--time", "0", "--set", "measure.from=0.4"],
            2,
            "no frame is measured",
        ),
    ];
    for (arguments, wanted, words) in refused {
        let (code, _, errors) = outcome(folder.path(), arguments);
        assert!(code == wanted && errors.contains(words), "{arguments:?}: {code}: {errors}");
    }
}

#[test]
fn a_manifest_states_what_files_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..100).map(|id| format!("{},0,0,{id},{}\n", id + 7, 0.01)).collect();
    std::fs::write(folder.path().join("a_3.csv"), format!("number,a,b,c,size\n{rows}")).unwrap();
    let manifest = |more: &str| {
        let text = format!("grains = ['a_{{step}}.csv']\ncolumns = ['id', 'x', 'y', 'z', 'd']\n{more}");
        std::fs::write(folder.path().join("frames.toml"), text).unwrap();
        outcome(folder.path(), &["measure", "frames.toml", "--scene", "packing-100", "--set", "compare=[]"])
    };
    let (code, text, notes) = manifest("time-step = 0.2\nfirst-id = 7\n");
    assert!(code == 0 && text.contains("largest_overlap"), "{code}: {text}{notes}");
    assert!(!notes.contains("the last frame is measured, at"), "its time is 0.6 s: {notes}");
    let (code, _, errors) = manifest("time-step = 0.2\nfirst-id = 6\n");
    assert!(code == 3 && errors.contains("there is no grain 106"), "{code}: {errors}");
    let (code, _, errors) = manifest("timestep = 0.2\n");
    assert!(code == 3 && errors.contains("frames.toml: line 3: unknown field `timestep`"), "{code}: {errors}");
}

#[test]
fn a_code_of_ones_own_is_judged_and_found_to_disagree() {
    let folder = tempfile::tempdir().unwrap();
    let described = data("tests/codes/dropped.toml");
    let scene = [
        "--set",
        "measure.observables=[\"packing-fraction\"]",
        "--set",
        "compare=[{observable=\"packing_fraction\", margin=0.01}]",
    ];
    let mut command =
        vec!["compare", "packing-100", "--own-code", &described, "--codes", "makadam", "--seeds", "3", "-o", "report"];
    command.extend(scene);
    let (code, text, errors) = outcome(folder.path(), &command);
    assert_eq!(code, 4, "{text}{errors}");
    assert!(text.contains("Disagree: of 1 test of 1 scene against Makadam, 0 agree, 1 disagrees"), "{text}");
    let report = std::fs::read_to_string(folder.path().join("report/report.html")).unwrap();
    assert!(report.contains("Dropped"));
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        file.display().to_string()
    };
    let toml = std::fs::read_to_string(&described).unwrap();
    let here = PathBuf::from(&described).parent().unwrap().display().to_string();
    let toml = toml.replace("{here}", &here);
    let refused = [
        (toml.replace("out.csv", "other.csv"), 1, "other.csv: line 1: No such file or directory"),
        (toml.replace("python3", "no-such-program"), 2, "there is no program 'no-such-program'"),
        (toml.replace("\"Dropped\"", "\"yade\""), 2, "is no name for a code of your own"),
        (toml.replace("\"Dropped\"", "\" YADE \""), 2, "'YADE' is no name for a code of your own"),
        (toml.replace("\"Dropped\"", "\"Makadam \""), 2, "'Makadam' is no name for a code of your own"),
        (toml.replace("\"Dropped\"", "\"  \""), 2, "'' is no name for a code of your own"),
        (toml.replace("version", "versoin"), 2, "line 3: unknown field `versoin`"),
        (toml.replace("\"{folder}\"", "\"/nowhere\""), 1, "Dropped failed"),
    ];
    for (text, wanted, words) in refused {
        let file = write("code.toml", &text);
        let (code, _, errors) = outcome(
            folder.path(),
            &["compare", "packing-100", "--own-code", &file, "--codes", "makadam", "--seeds", "1"],
        );
        assert!(code == wanted && errors.contains(words), "{code} in place of {wanted}: {errors}");
    }
}

#[test]
fn a_seed_that_fails_is_a_value_that_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let described = data("tests/codes/dropped.toml");
    let here = PathBuf::from(&described).parent().unwrap().display().to_string();
    let toml = std::fs::read_to_string(&described).unwrap().replace("{here}", &here);
    // Seed 2 fails; the margin is so wide that the others agree.
    let toml =
        toml.replacen("command = [", "command = [\"sh\", \"-c\", \"test $0 != 2 && exec \\\"$@\\\"\", \"{seed}\", ", 1);
    let file = folder.path().join("code.toml");
    std::fs::write(&file, toml).unwrap();
    let margin = "compare=[{observable=\"packing_fraction\", margin=10.0}]";
    let observed = "measure.observables=[\"packing-fraction\"]";
    let (code, text, errors) = outcome(
        folder.path(),
        &[
            "compare",
            "packing-100",
            "--own-code",
            &file.display().to_string(),
            "--codes",
            "makadam",
            "--seeds",
            "3",
            "--set",
            observed,
            "--set",
            margin,
        ],
    );
    assert_eq!(code, 1, "{text}{errors}");
    assert!(text.contains("Not measured: of 1 test of 1 scene, 0 agree") && !text.contains("agrees with"), "{text}");
    assert!(text.contains("Dropped has a value in 2 of 3 seeds"), "{text}");
    assert!(errors.contains("Dropped failed"), "{errors}");
}

#[test]
fn scenes_are_written_for_other_codes() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, errors) = outcome(folder.path(), &["export", "packing-100", "--for", "liggghts", "-o", "deck"]);
    assert_eq!(code, 0, "{errors}");
    assert!(text.contains("liggghts -in deck.in"), "{text}");
    assert!(text.contains("makadam measure deck/frames.toml --scene packing-100"), "{text}");
    for name in ["deck.in", "grains.data", "wall0.stl"] {
        assert!(folder.path().join("deck").join(name).is_file(), "{name}");
    }
    let (code, text, _) = outcome(folder.path(), &["export", "packing-100", "--for", "yade"]);
    assert!(code == 0 && text.contains("yade -j1 -n -x yade_driver.py"), "{code}: {text}");
    // What somebody keeps there stays.
    let deck = folder.path().join("deck/deck.in");
    std::fs::write(&deck, "mine").unwrap();
    let (code, _, errors) = outcome(folder.path(), &["export", "packing-100", "--for", "liggghts", "-o", "deck"]);
    assert!(code == 2 && errors.contains("deck is not empty"), "{code}: {errors}");
    assert_eq!(std::fs::read_to_string(deck).unwrap(), "mine");
    let (code, _, errors) = outcome(folder.path(), &["export", "packing-100", "--for", "makadam"]);
    assert!(code == 2 && errors.contains("possible values: yade, liggghts, lammps, migflow"), "{code}: {errors}");
    let (code, _, errors) = outcome(folder.path(), &["export", "packing-100"]);
    assert!(code == 2 && errors.contains("--format"), "{code}: {errors}");
}

#[test]
fn what_an_exported_deck_leaves_is_measured_as_compare_measures_it() {
    for (code, program) in [("liggghts", "liggghts"), ("lammps", "lmp")] {
        let program = std::env::var(format!("MAKADAM_{}", code.to_uppercase())).unwrap_or(program.into());
        if Command::new(&program).arg("-help").output().is_err() {
            eprintln!("skipped: {program} is not installed (scripts/install-codes)");
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let deck = folder.path().join("deck");
        assert_eq!(outcome(folder.path(), &["export", "packing-100", "--for", code, "-o", "deck"]).0, 0);
        assert!(Command::new(&program).args(["-in", "deck.in"]).current_dir(&deck).output().unwrap().status.success());
        // The manifest beside the deck states the step, the columns of contacts and how grains are numbered.
        let command = ["measure", "deck/frames.toml", "--scene", "packing-100", "--json"];
        let (exit, text, errors) = outcome(folder.path(), &command);
        assert_eq!(exit, 0, "{errors}");
        let measured: Value = serde_json::from_str(&text).unwrap();
        let codes = format!("makadam,{code}");
        let live = ["compare", "packing-100", "--codes", &codes, "--live", "--seeds", "1", "--json"];
        let compared: Value = serde_json::from_str(&outcome(folder.path(), &live).1).unwrap();
        let row = compared["rows"].as_array().unwrap().last().unwrap();
        assert_eq!(row["code"].as_str().unwrap().to_lowercase(), code);
        let measured = measured["measurements"].as_array().unwrap();
        let force = measured.iter().find(|one| one["observable"] == row["observable"]).unwrap();
        assert_eq!(force["value"], row["mean"], "{code}");
    }
}

#[test]
fn frames_of_other_codes_become_starts() {
    let folder = tempfile::tempdir().unwrap();
    let convert = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).unwrap();
        let (code, _, errors) = outcome(folder.path(), &["export", name, "--format", "csv", "-o", "start"]);
        let file = folder.path().join(format!("start/{}-start.csv", name.split('.').next().unwrap()));
        if code == 0 { Ok(std::fs::read_to_string(file).unwrap()) } else { Err((code, errors)) }
    };
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
                ITEM: ATOMS id type x y z radius vx vy vz\n2 1 0.5 0.5 0.25 0.01 0 0 -1\n1 1 0.25 0.5 0.5 0.02 1 0 0\n";
    let expected = "x,y,z,radius,vx,vy,vz\n0.25,0.5,0.5,0.02,1,0,0\n0.5,0.5,0.25,0.01,0,0,-1\n";
    assert_eq!(convert("dump.liggghts", dump).unwrap(), expected);
    let yade = "#format x_y_z_r\n0.25 0.5 0.5 0.02\n0.5 0.5 0.25 0.01\n";
    assert_eq!(convert("yade.txt", yade).unwrap(), "x,y,z,radius\n0.25,0.5,0.5,0.02\n0.5,0.5,0.25,0.01\n");
    assert_eq!(convert("wide.csv", "x,y,z,diameter\n1,2,3,0.5\n").unwrap(), "x,y,z,radius\n1,2,3,0.25\n");
    let (code, errors) = convert("without.csv", "x,y,z\n1,2,3\n").unwrap_err();
    assert_eq!(code, 3, "{errors}");
    assert!(errors.contains("no column radius"), "{errors}");
}

#[test]
fn grains_of_a_start_keep_their_materials_in_exports() {
    let folder = tempfile::tempdir().unwrap();
    let grains = "x,y,z,radius,material\n0,0,0.005,0.005,light\n0.02,0,0.005,0.005,heavy\n";
    std::fs::write(folder.path().join("start.csv"), grains).unwrap();
    let material = |name: &str, density: f64| {
        format!(
            "[material.{name}]\ndensity = {density:?}\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n"
        )
    };
    let scene = format!(
        "name = 'two'\nduration = 0.01\ndomain = {{ min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.2] }}\n{}{}\
         [[wall]]\nname = 'floor'\nmaterial = 'light'\nshape = {{ kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }}\n\
         [start]\nfile = 'start.csv'\n",
        material("light", 2500.0),
        material("heavy", 7800.0)
    );
    std::fs::write(folder.path().join("two.toml"), scene).unwrap();
    let (code, _, errors) = outcome(folder.path(), &["run", "two.toml", "-o", "out", "--quiet"]);
    assert_eq!(code, 0, "{errors}");
    let (code, _, errors) = outcome(folder.path(), &["export", "out", "--format", "csv"]);
    assert_eq!(code, 0, "{errors}");
    let table = std::fs::read_to_string(folder.path().join("out/csv/grains-00000.csv")).unwrap();
    let materials: Vec<&str> = table.lines().skip(1).filter_map(|line| line.rsplit(',').next()).collect();
    assert_eq!(materials, ["light", "heavy"], "{table}");
}
