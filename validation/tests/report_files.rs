//! The files of a report: data as the schema says, and all that its page links to.

use crate::support::sample;
use jsonschema::Validator;
use makadam_compare::scenes;
use makadam_measure::statistics::Outcome;
use makadam_qualification::report::{Qualification, ReportDocument, StudyOutcome, schema, write};
use roxmltree::{Document, ParsingOptions};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// A report with every kind of part: scenes with and without verdicts, a study.
fn full() -> Qualification {
    let comparisons = vec![sample::drum(true), sample::packing(), sample::alone()];
    Qualification { studies: vec![sample::study(StudyOutcome::Passed)], ..sample::qualification(comparisons) }
}

/// The data of its files, written once.
fn document() -> Value {
    static DOCUMENT: LazyLock<Value> = LazyLock::new(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let page_file = write(&full(), folder.path()).expect("a report");
        serde_json::from_slice(&fs::read(page_file.with_file_name("report.json")).expect("the data")).expect("JSON")
    });
    DOCUMENT.clone()
}

/// Lists the faults of a document, each with its place.
fn faults(validator: &Validator, document: &Value) -> Vec<String> {
    validator.iter_errors(document).map(|fault| format!("{}: {fault}", fault.instance_path())).collect()
}

fn validator() -> Validator {
    jsonschema::draft202012::new(&schema()).expect("a schema of draft 2020-12")
}

#[test]
fn a_report_is_what_its_schema_says() {
    assert_eq!(faults(&validator(), &document()), Vec::<String>::new());
}

#[test]
fn every_held_scene_is_what_the_schema_says_of_scenes() {
    let (validator, mut document) = (validator(), document());
    for name in scenes::names() {
        let scene = scenes::load(&scenes::find(name, &[]).expect("a scene")).expect("a scene");
        document["qualification"]["comparisons"][0]["scene"] = serde_json::to_value(&scene).expect("plain data");
        assert_eq!(faults(&validator, &document), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn a_report_with_a_wrong_type_or_a_missing_field_is_refused() {
    let (validator, whole) = (validator(), document());
    let row = "/qualification/comparisons/0/rows/0";
    for (place, wrong) in [
        ("/version", json!("1")),
        ("/verdict/standing", json!("fine")),
        ("/verdict/agree", json!(-1)),
        ("/qualification/wall_seconds", json!(null)),
        ("/qualification/comparisons", json!({})),
        (&format!("{row}/mean"), json!("27.13")),
        (&format!("{row}/interval90"), json!([1.0])),
        (&format!("{row}/outcome"), json!("Agree")),
        ("/qualification/comparisons/0/scene/domain/min", json!([0.0, 0.0])),
        ("/qualification/comparisons/0/final_states/0/particles/0/id", json!(0.5)),
        ("/qualification/studies/0/tests/0/outcome", json!("excused")),
    ] {
        let mut document = whole.clone();
        *document.pointer_mut(place).unwrap_or_else(|| panic!("{place} is in no report")) = wrong;
        let faults = faults(&validator, &document);
        assert!(faults.iter().any(|fault| fault.starts_with(place)), "{place}: {faults:?}");
    }
    for place in [
        "/version",
        "/verdict",
        "/verdict/sentence",
        "/qualification/provenance",
        "/qualification/outside_spread",
        &format!("{row}/margin"),
        "/qualification/comparisons/0/scene/solver",
        "/qualification/comparisons/0/codes/0/processor",
    ] {
        let (parent, key) = place.rsplit_once('/').expect("a place");
        let mut document = whole.clone();
        let parent = document.pointer_mut(parent).and_then(Value::as_object_mut).expect("an object");
        parent.remove(key).unwrap_or_else(|| panic!("{place} is in no report"));
        let faults = faults(&validator, &document);
        assert!(faults.iter().any(|fault| fault.contains(&format!("\"{key}\" is a required property"))), "{faults:?}");
    }
}

#[test]
fn every_field_of_a_report_is_described() {
    let schema = schema();
    for (name, table) in schema["$defs"].as_object().expect("types") {
        for (key, value) in table["properties"].as_object().into_iter().flatten() {
            assert!(value["description"].is_string(), "{key} of {name}");
        }
    }
}

#[test]
fn every_link_of_the_page_leads_to_a_file_beside_it_and_every_figure_has_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page_file = write(&full(), folder.path()).expect("a report");
    let page = fs::read_to_string(&page_file).expect("the page");
    let options = ParsingOptions { allow_dtd: true, ..Default::default() };
    let page = Document::parse_with_options(&page, options).expect("well-formed markup");
    let links = page.descendants().filter_map(|node| node.attribute("href")).filter(|link| !link.starts_with('#'));
    let mut links: Vec<&str> = links.collect();
    assert!(links.iter().all(|link| folder.path().join(link).is_file()), "{links:?}");
    links.sort_unstable();
    links.dedup();
    let expected = ["bias.csv", "forces.csv", "grains.csv", "report.json", "rows.csv", "series.csv", "stability.csv"];
    assert_eq!(links, expected);
    for figure in page.descendants().filter(|node| node.has_tag_name("figure")) {
        let linked = figure.descendants().any(|node| node.attribute("href").is_some_and(|link| link.ends_with(".csv")));
        let caption = figure.descendants().find(|node| node.has_tag_name("figcaption")).and_then(|node| node.text());
        assert!(linked, "{caption:?}");
    }
}

/// The records of a file by the names of their columns.
fn records(file: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(file).expect("a file").deserialize().collect::<Result<_, _>>().expect("rows of one length")
}

#[test]
fn files_hold_the_numbers_that_figures_draw() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let qualification = full();
    write(&qualification, folder.path()).expect("a report");
    let all = |name: &str| records(&folder.path().join(name));
    let number = |record: &BTreeMap<String, String>, column: &str| record[column].parse::<f64>().expect("a number");
    let [drum, packing, alone] = &qualification.comparisons[..] else { panic!("three scenes") };

    // Every point of the curves.
    let runs = all("series.csv");
    let points: Vec<_> = [drum, packing, alone].into_iter().flat_map(|c| &c.series).collect();
    assert!(points.iter().all(|s| s.time.len() <= 600), "none of them is thinned");
    assert_eq!(runs.len(), points.iter().map(|s| s.time.len()).sum::<usize>());
    assert_eq!((number(&runs[0], "time_s"), number(&runs[0], "value")), (points[0].time[0], points[0].value[0]));

    // The bins of each code with the counting error, and the curve of the literature.
    let forces = all("forces.csv");
    let first = forces.iter().find(|record| record["code"] == drum.forces[0].code).expect("a bin");
    assert_eq!(number(first, "density"), drum.forces[0].density[0]);
    assert!(number(first, "density_low") < number(first, "density"));
    assert_eq!(forces.iter().filter(|r| r["scene"] == "drum" && r["code"] == "Mueth 1998").count(), 201);

    // Every grain of the pictures.
    let grains = all("grains.csv");
    let states: Vec<_> = [drum, packing, alone].into_iter().flat_map(|c| &c.final_states).collect();
    assert_eq!(grains.len(), states.iter().map(|state| state.particles.len()).sum::<usize>());
    assert_eq!(number(&grains[5], "z_m"), states[0].particles[5].position[2]);
}

#[test]
fn tests_are_there_for_machines() {
    let mut drum = sample::drum(false);
    drum.rows.iter_mut().for_each(|row| row.outcome = row.margin.and(Some(Outcome::Agree)));
    drum.rows[0].outcome = Some(Outcome::Disagree);
    let mut qualification = sample::qualification(vec![drum]);
    qualification.outside_spread = vec!["packing: a live run lies <outside>".into()];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page_file = write(&qualification, folder.path()).expect("a report");
    let json = fs::read(page_file.with_file_name("report.json")).expect("the data");
    assert_eq!(serde_json::from_slice::<ReportDocument>(&json).expect("a report").qualification, qualification);
}
