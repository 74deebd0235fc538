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
