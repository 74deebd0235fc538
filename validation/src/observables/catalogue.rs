//! Which quantities there are, and what a scene must measure to get them.

pub use super::definitions::Definition;
use super::definitions::GROUPS;
use crate::plan::{Observable, Scene};
use makadam::scene::nearest;
use makadam::scene::{SceneFileError, line_of};
use std::path::Path;

/// Names of all quantities that can be measured.
pub fn known() -> impl Iterator<Item = &'static str> {
    definitions().map(|(_, definition)| definition.name)
}

/// All quantities, each with the name of its group in `measure.observables`.
pub fn definitions() -> impl Iterator<Item = (&'static str, &'static Definition)> {
    GROUPS.iter().flat_map(|(_, group, quantities)| quantities.iter().map(|quantity| (*group, quantity)))
}

/// The group that a quantity belongs to, and the group's name in `measure.observables`; `None` if nothing measures it.
pub fn group_of(quantity: &str) -> Option<(Observable, &'static str)> {
    let found = GROUPS.iter().find(|(_, _, quantities)| quantities.iter().any(|known| known.name == quantity));
    found.map(|&(group, name, _)| (group, name))
}

/// Checks that what a scene compares is what it measures: a name that is misspelt, or whose group is not measured, would have no
/// value in any run. `text` is the scene's file, which names the line.
///
/// # Errors
/// [`SceneFileError::Invalid`] with the line, and the nearest names or what to add.
pub fn check(scene: &Scene, text: &str, file: &Path) -> Result<(), SceneFileError> {
    for (index, expectation) in scene.compare.iter().enumerate() {
        let name = expectation.observable.as_str();
        let invalid = |problem: String, remedy: String| {
            let line = line_of(text, &["compare", &index.to_string(), "observable"]);
            let problem = format!("compare[{index}].observable: {problem}");
            Err(SceneFileError::Invalid { file: file.to_path_buf(), line, problem, remedy })
        };
        match group_of(name) {
            None => {
                let near = nearest(name, known(), 3).join(", ");
                return invalid(format!("nothing measures '{name}'"), format!("the nearest names are: {near}"));
            }
            Some((group, words)) if !scene.measure.observables.contains(&group) => {
                return invalid(
                    format!("'{name}' is compared and not measured"),
                    format!("add \"{words}\" to measure.observables, which it belongs to"),
                );
            }
            Some(_) => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// The names that a source file gives to quantities.
    fn names_in(source: &str) -> BTreeSet<&str> {
        let marks = ["Quantity::mean(\"", "Quantity::largest(\"", "ANGLE: &str = \""];
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
    fn names_of_groups_are_those_that_scenes_say() {
        for (group, name, _) in GROUPS {
            assert_eq!(serde_json::to_value(group).unwrap(), name);
        }
    }
}
