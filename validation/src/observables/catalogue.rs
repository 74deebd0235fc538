//! Which quantities there are, and what a scene must measure to get them.

use crate::nearest::nearest;
use crate::plan::{Observable, Scene};
use makadam::scene::{SceneFileError, line_of};
use std::path::Path;

/// The groups of quantities, as `measure.observables` names them, with their quantities, as `[[compare]]` names them.
const GROUPS: [(Observable, &str, &[&str]); 9] = [
    (Observable::DynamicAngleOfRepose, "dynamic-angle-of-repose", &["dynamic_angle_of_repose", "surface_line_angle"]),
    (Observable::StaticAngleOfRepose, "static-angle-of-repose", &["static_angle_of_repose", "heap_height"]),
    (Observable::PackingFraction, "packing-fraction", &["packing_fraction"]),
    (
        Observable::CoordinationNumber,
        "coordination-number",
        &[
            "coordination_number",
            "coordination_number_without_rattlers",
            "rattler_share",
            "mechanical_coordination_number",
            "bulk_grains",
        ],
    ),
    (
        Observable::ContactForces,
        "contact-forces",
        &[
            "share_below_mean",
            "gini",
            "force_second_moment",
            "weak_load_share",
            "friction_mobilisation",
            "sliding_share",
            "fabric_anisotropy",
            "mean_normal_force",
        ],
    ),
    (
        Observable::Balances,
        "balances",
        &["wall_force_over_weight", "largest_overlap", "mean_overlap", "coulomb_excess", "kinetic_energy"],
    ),
    (
        Observable::DrumFlow,
        "drum-flow",
        &["shell_layer_speed_ratio", "wall_torque", "flowing_layer_thickness", "surface_speed", "lacey_mixing_index"],
    ),
    (
        Observable::SizeMixing,
        "size-mixing",
        &["size_mixing_index", "small_over_large_distance", "population_mixing_index", "first_over_other_distance"],
    ),
    (Observable::DrivenWall, "driven-wall", &["driven_wall_displacement"]),
];

/// Names of all quantities that can be measured.
pub fn known() -> impl Iterator<Item = &'static str> {
    GROUPS.iter().flat_map(|(_, _, quantities)| quantities.iter().copied())
}

/// The group that a quantity belongs to, and the group's name in `measure.observables`; `None` if nothing measures it.
pub fn group_of(quantity: &str) -> Option<(Observable, &'static str)> {
    let found = GROUPS.iter().find(|(_, _, quantities)| quantities.contains(&quantity));
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
            assert_eq!(names_in(&source), quantities.iter().copied().collect(), "{name}");
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
