//! Unit tests of `src/observables/catalogue.rs`.

use super::*;
use std::collections::BTreeSet;

/// Names of the readings and measurements that a source file makes.
fn names_in(source: &str) -> BTreeSet<&str> {
    let after = |mark: &'static str| source.split(mark).skip(1).filter_map(|rest| rest.trim_start().split('"').nth(1));
    let starts = |mark: &'static str| source.split(mark).skip(1).map(|rest| rest.trim_start().starts_with('"'));
    let named = |mark| after(mark).zip(starts(mark)).filter_map(|(name, is_text)| is_text.then_some(name));
    ["readings.add(", "readings.add_in(", "readings.add_of(", "Measurement::of("].into_iter().flat_map(named).collect()
}

/// Name of the source file of a group, without its ending.
fn file_of(group: &Group) -> String {
    match group.observable {
        Observable::DynamicAngleOfRepose => "dynamic_angle".into(),
        Observable::StaticAngleOfRepose => "static_angle".into(),
        Observable::CoordinationNumber => "coordination".into(),
        Observable::SizeMixing => "mixing".into(),
        Observable::Walls | Observable::Wear => "wall_loads".into(),
        _ => group.name.replace('-', "_"),
    }
}

#[test]
fn each_file_measures_what_it_registers() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/observables");
    for file in GROUPS.iter().map(file_of).collect::<BTreeSet<String>>() {
        let source = std::fs::read_to_string(folder.join(format!("{file}.rs"))).unwrap();
        let own = GROUPS.iter().filter(|group| file_of(group) == file);
        let defined: BTreeSet<&str> = own.flat_map(|group| group.definitions).map(|one| one.name).collect();
        assert!(names_in(&source).is_subset(&defined), "{file}: {:?}", names_in(&source));
        // Once in its definition, once where it is measured.
        let is_measured = |name: &&&str| source.matches(&format!("\"{name}\"")).count() > 1;
        assert_eq!(defined.iter().find(|name| !is_measured(name)), None, "{file}");
    }
}

#[test]
fn the_page_is_what_the_definitions_say() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/observables.md");
    let written = std::fs::read_to_string(&file).unwrap_or_default();
    assert_eq!(written, page(), "make it anew: makadam print observables --markdown > docs/observables.md");
}

#[test]
fn names_of_groups_are_those_that_scenes_say() {
    for Group { observable, name, .. } in GROUPS {
        assert_eq!(serde_json::to_value(observable).unwrap(), name);
    }
}
