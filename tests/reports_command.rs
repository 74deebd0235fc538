//! `makadam reports`: every report below a folder on one page, with what changed; nothing is left out without a word.

use crate::compare_command::with_references;
use crate::support::makadam;
use serde_json::{Value, json};
use std::path::Path;

/// Exit code, standard output and standard error.
fn outcome(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = makadam(folder).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// A comparison of three runs with recorded references, its report in the folder `archive/first`.
fn compared(folder: &Path) -> Value {
    let scene = with_references(folder).display().to_string();
    let (code, _, errors) = outcome(folder, &["compare", &scene, "--quiet", "--output", "archive/first"]);
    assert_eq!(code, 0, "{errors}");
    serde_json::from_slice(&std::fs::read(folder.join("archive/first/report.json")).unwrap()).unwrap()
}

/// Keeps a report of another day under a name of its own.
fn keep(folder: &Path, name: &str, date: &str, report: &Value) {
    let mut report = report.clone();
    report["qualification"]["provenance"]["date"] = date.into();
    let folder = folder.join("archive").join(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("report.json"), serde_json::to_vec(&report).unwrap()).unwrap();
}

#[test]
fn reports_are_listed_newest_first_with_what_changed() {
    let folder = tempfile::tempdir().unwrap();
    let report = compared(folder.path());
    keep(folder.path(), "later/one", "2126-01-01T10:00:00Z", &report);
    let mut changed = report.clone();
    let rows = changed["qualification"]["comparisons"][0]["rows"].as_array_mut().unwrap();
    rows.retain(|row| row["reference_code"] != "LIGGGHTS" || row["code"] != "Makadam");
    rows[0]["outcome"] = "disagree".into();
    keep(folder.path(), "later/two", "2126-02-01T10:00:00Z", &changed);
    let mut wider = report.clone();
    for row in wider["qualification"]["comparisons"][0]["rows"].as_array_mut().unwrap() {
        row["margin"] = row["margin"].as_f64().map(|margin| 2.0 * margin).into();
    }
    wider["qualification"]["tier"] = "release".into();
    keep(folder.path(), "wider", "2126-02-03T10:00:00Z", &wider);
    let mut before_it = report.clone();
    before_it["qualification"]["tier"] = "release".into();
    keep(folder.path(), "narrower", "2126-02-02T10:00:00Z", &before_it);
    let mut other = report.clone();
    other["qualification"]["tier"] = "quick".into();
    keep(folder.path(), "other #1", "2126-03-01T10:00:00Z", &other);

    let (code, text, errors) = outcome(folder.path(), &["reports", "archive"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    let places = ["other #1/report.json", "later/two/report.json", "later/one/report.json", "first/report.json"];
    let found = places.map(|place| text.find(place).unwrap_or_else(|| panic!("no {place} in {text}")));
    assert!(found.is_sorted(), "{text}");
    assert!(text.contains("Disagree") && text.contains("0 of 1") && text.contains("2 of 2"), "{text}");
    assert!(text.contains("later/two/report.json against later/one/report.json:"), "{text}");
    assert!(text.contains("lost: changed, ") && text.contains("agree before, disagree now"), "{text}");
    // The one before it differs in nothing but its date, and the other tier has none before it.
    assert!(!text.contains("against first/report.json"), "{text}");

    let page = std::fs::read_to_string(folder.path().join("archive/index.html")).unwrap();
    for part in [
        "href=\"other%20%231/report.json\"",
        "href=\"first/report.html\"",
        "<span class=\"outcome disagree\">Disagree</span>",
        "the first of its kind",
        "the same",
        "1 lost, 1 changed",
        "2 under other conditions",
        "agree before, disagree now",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    let links = page.split("href=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    for link in links.filter(|link| !link.starts_with('#')) {
        let file = link.replace("%20", " ").replace("%23", "#");
        assert!(folder.path().join("archive").join(&file).is_file(), "{file}");
    }

    // Once more, as a document: the page is not taken for a report, and is written anew.
    let (code, text, _) = outcome(folder.path(), &["reports", "archive", "--json"]);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, &document["version"], &document["command"]), (0, &json!(1), &json!("reports")));
    let reports = document["reports"].as_array().unwrap();
    assert_eq!(reports.len(), 6);
    assert_eq!(reports[3]["standing"], "disagree");
    assert_eq!(reports[3]["against"]["file"], "later/one/report.json");
    assert_eq!(reports[3]["against"]["changes"]["lost"].as_array().unwrap().len(), 1);
    assert_eq!((&reports[5]["against"], &reports[5]["page"]), (&Value::Null, &json!("first/report.html")));
    assert!(reports[5]["wall_seconds"].as_f64().unwrap() > 0.0 && reports[5]["processor"].is_string());
}

#[test]
fn what_cannot_be_read_is_named_and_nothing_at_all_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join("archive").join(name).join("report.json");
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, text).unwrap();
    };
    let (code, _, errors) = outcome(folder.path(), &["reports", "archive"]);
    assert!(code == 2 && errors.contains("cannot read the folder archive"), "{code}: {errors}");
    std::fs::create_dir(folder.path().join("archive")).unwrap();
    let (code, _, errors) = outcome(folder.path(), &["reports", "archive"]);
    assert!(code == 2 && errors.contains("there is no report.json in archive"), "{code}: {errors}");
    assert!(!folder.path().join("archive/index.html").exists());

    write("cut", "{\"version\": 1, \"verdict\":");
    write("new", "{\"version\": 9}");
    let (code, _, errors) = outcome(folder.path(), &["reports", "archive"]);
    assert_eq!(code, 1, "{errors}");
    for words in ["cut/report.json", "EOF while parsing", "new/report.json", "none of the 2 reports found"] {
        assert!(errors.contains(words), "no {words} in {errors}");
    }
    let page = std::fs::read_to_string(folder.path().join("archive/index.html")).unwrap().replace("&#x2f;", "/");
    assert!(page.contains("Not read") && page.contains("cut/report.json") && page.contains("new/report.json"));

    // One that can be read beside them.
    compared(folder.path());
    let (code, text, errors) = outcome(folder.path(), &["reports", "archive", "--json"]);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, document["unreadable"].as_array().unwrap().len()), (0, 2));
    assert!(errors.contains("not read: cut/report.json"), "{errors}");
    let page = std::fs::read_to_string(folder.path().join("archive/index.html")).unwrap();
    assert!(page.contains("Not read") && page.contains("first/report.html"));

    // A pipe would be waited for.
    let pipe = folder.path().join("archive/pipe/report.json");
    std::fs::create_dir(pipe.parent().unwrap()).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut command = makadam(folder.path());
    let output = command.args(["reports", "archive"]).timeout(std::time::Duration::from_secs(60)).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{errors}");
    assert!(errors.contains("not read: pipe/report.json: it is no regular file"), "{errors}");

    // A page that somebody else has written stays.
    std::fs::write(folder.path().join("archive/index.html"), "mine").unwrap();
    let (code, _, errors) = outcome(folder.path(), &["reports", "archive"]);
    assert!(code == 2 && errors.contains("index.html is no page of reports"), "{code}: {errors}");
    assert_eq!(std::fs::read_to_string(folder.path().join("archive/index.html")).unwrap(), "mine");
}
