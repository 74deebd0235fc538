//! The hard cases: the quick catalogue in Makadam, and the command around it.

use crate::support::makadam;
use makadam_compare::stability::{Verdict, catalogue, known_exception};
use std::time::Duration;

#[test]
fn the_quick_catalogue_ends_as_stated() {
    let mut failed = Vec::new();
    for case in catalogue().iter().filter(|case| !case.long) {
        let outcome =
            case.in_makadam(Duration::from_secs(120)).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        if (outcome.verdict == Verdict::AsStated) == known_exception(&case.name).is_some() {
            failed.push(format!("{}: {outcome:#?}", case.name));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn names_are_unique_and_every_case_measures_something() {
    let cases = catalogue();
    let mut names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), cases.len());
    let outcome =
        cases.iter().find(|case| case.name == "no-grains").unwrap().in_makadam(Duration::from_secs(60)).unwrap();
    assert!(!outcome.findings.is_empty());
}

#[test]
fn the_command_prints_a_study() {
    let folder = tempfile::tempdir().unwrap();
    let output = makadam(folder.path()).args(["stability", "no-grains", "drift", "--json", "-q"]).assert().success();
    let study: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!(study["as_stated"], true);
    assert_eq!(study["cases"].as_array().unwrap().len(), 2);
    assert_eq!(study["cases"][0]["outcomes"][0]["verdict"], "as-stated");
    assert!(folder.path().join("results/stability/stability.json").is_file());
    let tables = std::fs::read_to_string(folder.path().join("results/stability/stability.md")).unwrap();
    assert!(
        tables.contains("## Zero gravity\n\n| case | what is right | Makadam |\n| --- | --- | --- |\n| drift |"),
        "{tables}"
    );
    assert!(tables.contains("| as stated: end of the run "), "{tables}");
    // The scenes are there to be run by hand.
    let scene = folder.path().join("results/stability/scenes/drift.toml");
    makadam(folder.path()).args(["run", scene.to_str().unwrap(), "-q"]).assert().success();
}

#[test]
fn a_case_that_does_not_exist_is_a_usage_error() {
    let folder = tempfile::tempdir().unwrap();
    makadam(folder.path()).args(["stability", "no-such-case"]).assert().code(2);
    // One pattern that matches does not excuse another one.
    let output = makadam(folder.path()).args(["stability", "groove-smooth", "sizeratio"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("'sizeratio'") && message.contains("size-ratio"), "{message}");
    assert!(!folder.path().join("results").exists(), "nothing was run");
}
