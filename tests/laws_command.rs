//! `makadam laws`: published laws, measured and judged; finished runs are kept; wrong input.

use crate::support::makadam;
use serde_json::Value;
use std::path::Path;

fn study(folder: &Path, arguments: &[&str]) -> (Option<i32>, Value) {
    let output = makadam(folder).arg("laws").args(arguments).args(["--json", "-q"]).output().unwrap();
    let study = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    (output.status.code(), study)
}

fn finding<'a>(law: &'a Value, words: &str) -> &'a Value {
    let found = law["findings"].as_array().unwrap().iter().find(|one| one["what"].as_str().unwrap().contains(words));
    found.unwrap_or_else(|| panic!("no finding has '{words}'"))
}

#[test]
#[ignore = "takes long: scripts/nightly slow-tests"]
fn janssens_law_holds_in_a_narrow_tube_and_runs_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (code, study) = study(folder.path(), &["janssen", "--quick"]);
    assert_eq!((study["version"].as_u64(), study["command"].as_str()), (Some(1), Some("laws")));
    assert_eq!((study["hold"].as_bool(), study["quick"].as_bool(), code), (Some(true), Some(true), Some(0)));
    let law = &study["laws"][0];
    assert_eq!(law["name"], "janssen");
    let largest = finding(law, "largest deviation");
    assert!(largest["value"].as_f64().unwrap() < 0.05);
    assert_eq!((largest["high"].as_f64(), &largest["low"]), (Some(0.05), &Value::Null));
    // The deeper, the smaller the share that the floor bears; floor and wall together bear all of it.
    let rows = law["rows"].as_array().unwrap();
    let value = |row: usize, name: &str| rows[row]["values"][name].as_f64().unwrap();
    let share = |row: usize| value(row, "apparent_mass") / value(row, "mass");
    assert_eq!(rows.len(), 4);
    assert!((1..4).all(|row| share(row) < share(row - 1)) && share(0) < 0.95 && share(3) < 0.4);
    assert!((0..4).all(|row| (value(row, "balance") - 1.0).abs() < 0.01));

    let results = folder.path().join("results/laws/janssen");
    for file in ["laws.json", "rows.csv", "apparent-mass.svg", "scenes/janssen-2.toml", "runs/janssen-2-s1.json"] {
        assert!(results.join(file).is_file(), "{file}");
    }
    let drawing = std::fs::read_to_string(results.join("apparent-mass.svg")).unwrap();
    assert!(roxmltree::Document::parse(&drawing).is_ok());

    // What was kept is not measured again: the wall time is the old one.
    let (_, again) = self::study(folder.path(), &["janssen", "--quick"]);
    assert_eq!(again["laws"], study["laws"]);
    // What is kept of another scene is.
    let kept = results.join("runs/janssen-0.5-s1.json");
    let text = std::fs::read_to_string(&kept).unwrap();
    let own = rows[0]["scene_hash"].as_str().unwrap();
    std::fs::write(&kept, text.replace(own, "0000000000000000").replace("\"mass\":", "\"mess\":")).unwrap();
    let (_, again) = self::study(folder.path(), &["janssen", "--quick"]);
    assert_eq!(again["laws"][0]["rows"][0]["values"], study["laws"][0]["rows"][0]["values"]);
}

#[test]
fn a_law_that_is_missed_gives_exit_code_4() {
    // A column of eight grains in radius stops short of the law, which is one of columns of hundreds.
    let folder = tempfile::tempdir().unwrap();
    let (code, study) = study(folder.path(), &["collapse", "--quick"]);
    let law = &study["laws"][0];
    let ratio = finding(law, "run-out over the law's, a = 0.6")["value"].as_f64().unwrap();
    assert!((0.3..0.9).contains(&ratio), "{ratio}");
    assert_eq!((study["hold"].as_bool(), law["holds"].as_bool(), code), (Some(false), Some(false), Some(4)));
    assert!(folder.path().join("results/laws/collapse/run-out.svg").is_file());
}

#[test]
fn laws_are_listed_with_their_sources() {
    let folder = tempfile::tempdir().unwrap();
    let output = makadam(folder.path()).args(["laws", "--list"]).assert().success();
    let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    for words in ["janssen", "beverloo", "collapse", "Vanel & Clement", "Nedderman", "Lube"] {
        assert!(text.contains(words), "{words}");
    }
    assert!(!folder.path().join("results").exists());
}

#[test]
fn wrong_input_is_a_usage_error() {
    let folder = tempfile::tempdir().unwrap();
    let output = makadam(folder.path()).args(["laws", "newton"]).assert().code(2);
    let message = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(message.contains("there is no law 'newton'") && message.contains("janssen"), "{message}");
    makadam(folder.path()).args(["laws", "janssen", "--seeds", "0"]).assert().code(2);
    makadam(folder.path()).args(["laws", "janssen", "--jobs", "0"]).assert().code(2);
    makadam(folder.path()).args(["laws", "--list", "--json"]).assert().code(2);
    makadam(folder.path()).args(["stability", "--list", "--json"]).assert().code(2);
    assert!(!folder.path().join("results").exists());
}

#[test]
fn a_folder_that_cannot_be_written_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let output = makadam(folder.path()).args(["laws", "collapse", "--quick", "-o", "file"]).assert().code(1);
    assert!(String::from_utf8_lossy(&output.get_output().stderr).contains("file"));
}
