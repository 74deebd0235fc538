//! Frames that the comparison accepts from a code under test: the requested ones, of this run, complete.

use crate::support::child::{signal, wait_for};
use crate::support::makadam;
use makadam::scene::populate;
use makadam_frames::plan::MeasuredScene;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// Writes the scene of these tests into a folder: a packing of a hundred grains, at the beginning of its fall, with two seeds registered.
fn write_scene(folder: &Path) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing-100/scene.toml");
    let text = fs::read_to_string(file).unwrap().replacen("duration = 0.6", "duration = 0.1", 1);
    let physics = text.split_once("[measure]").unwrap().0;
    let measure = "[measure]\ninterval = 0.05\nobservables = [\"packing-fraction\", \"contact-forces\", \"balances\"]\nseeds = 2\n";
    let compare = "[[compare]]\nobservable = \"largest_overlap\"\nmargin = 1.0\n";
    fs::write(folder.join("scene.toml"), format!("{physics}{measure}{compare}")).unwrap();
}

/// The description of `tests/codes/faulty.py` with a fault, and with lines in addition to its own.
fn described(fault: &str, more: &str) -> String {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/codes/faulty.py");
    format!(
        "name = \"Faulty\"\ncommand = [\"python3\", \"{}\", \"{{folder}}\", \"{{seed}}\", \"{fault}\"]\ntime-step = 1e-3\n{more}\n",
        program.display()
    )
}

/// Exit code, standard output and standard error of judging a described code.
fn judged(description: &str, more: &[&str]) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("code.toml"), description).unwrap();
    write_scene(folder.path());
    let mut command = makadam(folder.path());
    command.args(["compare", "scene.toml", "--own-code", "code.toml", "--codes", "makadam"]).args(more);
    let output = command.output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// Frames that state their steps in their names.
const OUT: &str = "grains = [\"out_{step}.csv\"]";

#[test]
fn frames_that_were_not_asked_for_or_are_not_whole_are_refused() {
    let from = ["--seeds", "1", "--set", "measure.from=0.05"];
    // Where the scene measures its end alone, the last frame has to be there.
    let end = &from[..2];
    let refused: [(&str, &[&str], &str); 9] = [
        ("lost-grain", &from, "the frame at 0.1 s has 99 grains, and grains.csv has 100; leave all of them"),
        ("renumbered", &from, "number a grain alike in all frames"),
        ("reversed", end, "in grains.csv; number grains as there"),
        ("far", end, "1 of 100 grains lie outside the domain of 'packing-100', the first of them grain 5 at [1000"),
        ("empty-frame", &from, "no frame with grains at 0.1 s; leave one at each time of frames.csv"),
        ("empty-frame", end, "no frame with grains at 0.1 s; leave one at each time of frames.csv"),
        ("early", end, "a frame at 0.08 s would be measured, and is not at a time of frames.csv"),
        ("late", end, "a frame at 0.12 s would be measured, and is not at a time of frames.csv"),
        ("parts", end, "it has a frame at 0.1 s, as "),
    ];
    for (fault, more, words) in refused {
        let files = if fault == "parts" { "grains = [\"out_{step}.csv\", \"out_b_{step}.csv\"]" } else { OUT };
        let (code, _, errors) = judged(&described(fault, files), more);
        assert!(code == 1 && errors.contains(words), "{fault}: {code}: {errors}");
    }
    for pattern in ["/tmp/out.csv", "../out.csv", ""] {
        let (code, _, errors) = judged(&described("none", &format!("grains = [\"{pattern}\"]")), end);
        assert!(code == 2 && errors.contains("leads out of the folder of a run; name files below"), "{code}: {errors}");
    }
    let (code, _, errors) = judged(&described("none", "grains = [\"*.csv\"]"), end);
    assert!(code == 1 && errors.contains("frames.csv is what the run was given"), "{code}: {errors}");
}

/// Steps of a code need not meet the times: a frame that is taken as one that was asked for is measured.
#[test]
fn frames_just_before_their_times_are_measured() {
    let (code, text, errors) = judged(&described("just-early", OUT), &["--seeds", "2", "--set", "measure.from=0.05"]);
    assert!(code == 0 || code == 4, "{code}: {text}{errors}");
    assert!(text.contains("Faulty"), "{text}");
}

#[test]
fn what_was_assumed_of_frames_stands_beside_the_verdict() {
    let (code, text, errors) = judged(&described("no-radii", OUT), &["--seeds", "2", "--json"]);
    assert!(errors.is_empty(), "{errors}");
    let found: Value = serde_json::from_str(&text).unwrap();
    let notes: Vec<&str> = found["notes"].as_array().unwrap().iter().map(|note| note.as_str().unwrap()).collect();
    assert!(
        notes.iter().any(|note| note.starts_with("Faulty, seed 2: radii are those of the scene's grains")),
        "{notes:?}"
    );
    assert_eq!(found["codes"][0]["code"], "Faulty");
    assert!(
        found["codes"][0]["time_step"].is_null(),
        "by what frames are numbered is no step of the code: {}",
        found["codes"]
    );
    // Contacts of one frame of two are not those of both.
    let more = format!("{OUT}\ncontacts = [\"contacts.csv\"]\ncontacts-complete = true");
    let asked = ["--seeds", "2", "--set", "measure.from=0.05"];
    let (other, text, errors) = judged(&described("some-contacts", &more), &asked);
    assert_eq!((code, other), (0, 1), "{text}{errors}");
    assert!(errors.contains("no file lists contacts between grains of the frame at 0.1 s"), "{errors}");
}

#[test]
fn a_step_of_codes_that_are_not_run_is_refused() {
    let (code, _, errors) = judged(&described("no-radii", OUT), &["--seeds", "2", "--rayleigh-fraction", "0.5"]);
    assert!(code == 2 && errors.contains("--rayleigh-fraction is of runs"), "{code}: {errors}");
}

/// An interrupted comparison says so, and does not replace the report of a complete one.
#[test]
fn an_interruption_is_told_and_leaves_an_earlier_report() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder);
    let judge = |fault: &str, output: &str| {
        fs::write(folder.join("code.toml"), described(fault, OUT)).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_makadam"));
        command.args(["compare", "scene.toml", "--own-code", "code.toml", "--codes", "makadam", "--seeds", "2"]);
        command
            .args(["--output", output, "--jobs", "1"])
            .env("XDG_CACHE_HOME", folder.join("cache"))
            .current_dir(folder);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let runs = folder.join("cache/makadam/runs");
    // The words of an interruption while a seed runs, and how many folders of runs are left.
    let interrupted = |fault: &str, seed: &str, output: &str| {
        let _ = fs::remove_dir_all(folder.join("cache"));
        let mut child = judge(fault, output);
        let started = |entry: fs::DirEntry| {
            entry.file_name().to_string_lossy().contains(&format!("faulty-s{seed}-"))
                && ["grains.csv", "frames.csv"].iter().all(|name| entry.path().join(name).is_file())
        };
        let is_started = || fs::read_dir(&runs).is_ok_and(|entries| entries.flatten().any(started));
        wait_for(&mut child, "a code that was started", is_started);
        signal(&child, "-TERM");
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(1));
        (String::from_utf8_lossy(&ended.stderr).into_owned(), fs::read_dir(&runs).unwrap().count())
    };
    assert!(judge("none", "out").wait_with_output().unwrap().status.success());
    let page = |output: &str| fs::read_to_string(folder.join(output).join("report.html")).unwrap();
    let whole = page("out");
    let (said, left) = interrupted("slow", "1", "out");
    assert!(said.contains("interrupted; results so far: not stored, the earlier report stays in out"), "{said}");
    assert_eq!((page("out"), left), (whole, 0));
    // It is told before what failed by itself, whose folder alone stays for a look.
    let (said, left) = interrupted("first-fails", "2", "new");
    assert!(said.contains("interrupted; results so far: new/report.html"), "{said}");
    assert!(page("new").contains("Faulty, seed 2: Faulty was interrupted"));
    assert_eq!(left, 1);
}

/// Frames that cannot be read are told after the first seed: the others take as long again.
#[test]
fn unreadable_frames_end_the_first_seed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("code.toml"), described("lost-grain", OUT)).unwrap();
    write_scene(folder.path());
    let mut command = makadam(folder.path());
    command.args([
        "compare",
        "scene.toml",
        "--own-code",
        "code.toml",
        "--codes",
        "makadam",
        "--seeds",
        "20",
        "--jobs",
        "1",
    ]);
    let output = command.output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && errors.contains("has 99 grains"), "{errors}");
    let runs = fs::read_dir(folder.path().join("cache/makadam/runs")).unwrap();
    let names: Vec<String> = runs.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    assert!(matches!(&names[..], [name] if name.contains("faulty-s1-")), "{names:?}");
}

/// Grains may leave the domain where the scene says so, as those of Makadam do.
#[test]
fn escaped_grains_are_judged_where_the_scene_lets_them() {
    let escaped = ["--seeds", "1", "--set", "watch.on_escape=ignore"];
    let (code, text, errors) = judged(&described("outside", OUT), &escaped);
    assert!(code == 4 && text.contains("Faulty") && !text.contains("outside the domain"), "{code}: {text}{errors}");
    let (code, text, errors) = judged(&described("outside", OUT), &["--seeds", "1", "--set", "watch.on_escape=warn"]);
    assert!(code == 4 && text.contains("1 of 100 grains lie outside the domain"), "{code}: {text}{errors}");
}

/// Numbers without a margin are listed, too.
#[test]
fn values_without_a_margin_are_listed() {
    let (_, text, errors) = judged(&described("none", OUT), &["--seeds", "2", "--json"]);
    let found: Value = serde_json::from_str(&text).unwrap_or_else(|_| panic!("{errors}"));
    let row = |name: &str| {
        let rows = found["rows"].as_array().unwrap();
        rows.iter().find(|row| row["observable"] == name && row["reference_code"] == "Makadam").cloned()
    };
    let listed = row("mean_overlap").expect("a row without a margin");
    assert!(listed["margin"].is_null() && listed["outcome"].is_null() && listed["difference"].is_number(), "{listed}");
    assert_eq!(row("largest_overlap").unwrap()["outcome"], "agree");
    // Positions alone tell no forces.
    assert!(row("gini").is_none());
}

/// A code is compared with Makadam where nothing is recorded of others.
#[test]
fn without_records_a_code_is_compared_with_makadam() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("code.toml"), described("none", OUT)).unwrap();
    write_scene(folder.path());
    let output = makadam(folder.path()).args(["compare", "scene.toml", "--own-code", "code.toml"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && text.contains("Faulty agrees with Makadam within the margins in 1 test"),
        "{text}"
    );
}

#[test]
fn frames_that_exist_are_judged() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder);
    let run = |words: &[&str]| {
        let output = makadam(folder).args(words).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
    };
    for seed in ["1", "2", "3"] {
        let (code, _, errors) = run(&["run", "scene.toml", "--seed", seed, "-o", &format!("own{seed}"), "--quiet"]);
        assert_eq!(code, 0, "{errors}");
    }
    // Runs of Makadam, as seeds that are registered and as others.
    let (code, text, errors) = run(&["compare", "scene.toml", "--frames", "own[12]/"]);
    assert!(code == 0 && text.contains("frames agrees with Makadam"), "{code}: {text}{errors}");
    let (code, text, errors) = run(&["compare", "scene.toml", "--frames", "own1", "own3"]);
    assert!(
        code == 4 && text.contains("registers seeds 1 to 2 (measure.seeds), and others were run"),
        "{text}{errors}"
    );
    // Tables of another code: all files of a folder, or those of a description, which needs no command.
    let scene = MeasuredScene::load(&folder.join("scene.toml")).unwrap();
    for seed in [1, 2] {
        let dropped = folder.join(format!("dropped-{seed}"));
        fs::create_dir(&dropped).unwrap();
        let mut table = String::from("time,id,x,y,z,radius\n");
        for (id, grain) in populate(&scene, seed).unwrap().iter().enumerate() {
            let [x, y, z] = grain.position;
            table += &format!("0.1,{id},{x},{y},{z},{}\n", grain.radius);
        }
        fs::write(dropped.join("grains.csv"), table).unwrap();
    }
    let (code, text, errors) = run(&["compare", "scene.toml", "--frames", "dropped-*/"]);
    assert!(code == 0 && text.contains("frames agrees with Makadam"), "{code}: {text}{errors}");
    fs::write(folder.join("code.toml"), "name = \"Mine\"\ngrains = [\"grains.csv\"]\n").unwrap();
    let (code, text, errors) = run(&["compare", "scene.toml", "--frames", "dropped-*/", "--own-code", "code.toml"]);
    assert!(code == 0 && text.contains("Mine agrees with Makadam"), "{code}: {text}{errors}");
    fs::create_dir(folder.join("unnumbered")).unwrap();
    fs::create_dir(folder.join("other1")).unwrap();
    let refused: [(&[&str], i32, &str); 5] = [
        (&["none*/"], 2, "there is no such folder; give one folder for each seed"),
        (&["unnumbered"], 2, "the name of a folder ends with the number of its seed"),
        (&["own1", "other1"], 2, "is of seed 1 too"),
        (&["other1"], 1, "there is no file of this pattern"),
        (&["own1", "--seeds", "2"], 2, "cannot be used with"),
    ];
    for (words, wanted, said) in refused {
        let (code, _, errors) = run(&[&["compare", "scene.toml", "--frames"], words].concat());
        assert!(code == wanted && errors.contains(said), "{words:?}: {code}: {errors}");
    }
    let (code, _, errors) = run(&["compare", "scene.toml", "--own-code", "code.toml"]);
    assert!(code == 2 && errors.contains("command is missing"), "{errors}");
}

/// The page of a description lists the keys that are read, and an unknown one is refused with them.
#[test]
fn keys_of_a_description_are_those_of_the_page() {
    let (code, _, errors) = judged(&described("none", "grain = 1"), &[]);
    assert!(code == 2 && errors.contains("unknown field `grain`"), "{errors}");
    let listed = errors.split("expected one of").nth(1).expect("the keys");
    let keys: Vec<&str> = listed.split('`').skip(1).step_by(2).collect();
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/own-code.md")).unwrap();
    let table = page.split("| key | meaning |").nth(1).unwrap().split("\n\n").next().unwrap();
    let documented: Vec<&str> = table.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    assert_eq!(documented, keys);
}
