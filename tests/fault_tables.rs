//! The tables of faults stay those of the sources: what a fault takes the place of stands there once.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

#[test]
fn each_fault_has_its_place_in_the_sources() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for (table, key, fewest) in [("mutations.toml", "mutation", 40), ("broken-builds.toml", "broken", 10)] {
        let text = fs::read_to_string(root.join("tests").join(table)).expect("a table");
        let faults: BTreeMap<String, Vec<BTreeMap<String, String>>> = toml::from_str(&text).expect("faults");
        assert!(faults[key].len() >= fewest, "{table}");
        for fault in &faults[key] {
            let source = fs::read_to_string(root.join(&fault["file"])).expect("a source file");
            assert_eq!(source.matches(fault["find"].trim()).count(), 1, "{table}: {}", fault["what"]);
            assert_ne!(fault["find"], fault["change"], "{table}: {}", fault["what"]);
        }
    }
}

/// The recorded table has the outcome of each fault, and each was detected.
#[test]
fn each_fault_was_seen() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests");
    let read = |name: &str| fs::read_to_string(root.join(name)).expect("a table");
    for (faults, key, table, named, seen) in [
        ("mutations.toml", "mutation", "mutations.csv", 1, 3),
        ("broken-builds.toml", "broken", "broken-builds.csv", 0, 1),
    ] {
        let faults: BTreeMap<String, Vec<BTreeMap<String, String>>> = toml::from_str(&read(faults)).expect("faults");
        let on_record = read(table);
        let mut lines = csv::Reader::from_reader(on_record.as_bytes());
        let rows: Vec<csv::StringRecord> = lines.records().collect::<Result<_, _>>().expect("rows");
        let rows = rows.iter().filter(|row| row[named] != *"no fault");
        let rows: Vec<(&str, &str)> = rows.map(|row| (&row[named], &row[seen])).collect();
        let names: Vec<&str> = rows.iter().map(|row| row.0).collect();
        let expected: Vec<&str> = faults[key].iter().map(|fault| fault["what"].as_str()).collect();
        assert_eq!(names, expected, "{table}");
        assert!(rows.iter().all(|row| !row.1.is_empty() && row.1 != "0"), "{table}");
    }
}
