//! Unit tests of `src/observables/catalogue.rs`.

use super::*;
use std::collections::BTreeSet;

/// The names that a source file gives to quantities.
fn names_in(source: &str) -> BTreeSet<&str> {
    let marks = ["Quantity::mean(\"", "Quantity::largest(\"", "ANGLE: &str = \"", "_NAME: &str = \""];
    let after = |mark: &'static str| source.split(mark).skip(1).filter_map(|rest| rest.split('"').next());
    marks.into_iter().flat_map(after).collect()
}

#[test]
fn the_catalogue_names_what_the_sources_measure() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/observables");
    let mut seen = BTreeSet::new();
    for (group, name, quantities) in GROUPS {
        let file = match group {
            Observable::DynamicAngleOfRepose => "dynamic_angle".into(),
            Observable::StaticAngleOfRepose => "static_angle".into(),
            Observable::CoordinationNumber => "coordination".into(),
            Observable::SizeMixing => "mixing".into(),
            _ => name.replace('-', "_"),
        };
        let source = std::fs::read_to_string(folder.join(format!("{file}.rs"))).unwrap();
        assert_eq!(names_in(&source), quantities.iter().map(|quantity| quantity.name).collect(), "{name}");
        seen.insert(format!("{file}.rs"));
    }
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if !seen.contains(&name) && name != "catalogue.rs" && entry.path().is_file() {
            let source = std::fs::read_to_string(entry.path()).unwrap();
            assert!(names_in(&source).is_empty(), "{name} measures something that no group holds");
        }
    }
}

#[test]
fn the_page_is_what_the_definitions_say() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/observables.md");
    let written = std::fs::read_to_string(&file).unwrap_or_default();
    assert_eq!(written, page(), "make it anew: makadam print observables --markdown > docs/observables.md");
}

#[test]
fn names_of_groups_are_those_that_scenes_say() {
    for (group, name, _) in GROUPS {
        assert_eq!(serde_json::to_value(group).unwrap(), name);
    }
}
