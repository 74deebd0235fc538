//! Requested observables without a value: reported before a run, and after it with the reason.

use super::catalogue::{Definition, definition, definitions, group_of, missing};
use super::drum::Drum;
use super::measurement::Measured;
use makadam::scene::{DocumentPath, Finding, Motion, Severity, Shape};
use makadam_frames::plan::{MeasuredScene, Observable};
use makadam_frames::recording::Content;
use serde::Serialize;

/// Requested number without a value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unmeasured {
    /// Name of the observable.
    pub observable: &'static str,
    /// Reason.
    pub reason: String,
}

/// Returns warnings for requested groups without anything to measure in a scene. `text` is the text of its file, for line numbers.
pub fn impossible(scene: &MeasuredScene, text: Option<&str>) -> Vec<Finding> {
    let root = DocumentPath::default();
    let at = root.key("measure").key("observables");
    let found = scene.measure.observables.iter().filter_map(|group| {
        let (name, lacks) = lack(scene, *group)?;
        Some(Finding {
            severity: Severity::Warning,
            problem: format!("measure.observables: {name} has nothing to measure: {lacks}"),
            remedy: "leave it out, or add what it needs".into(),
            line: text.and_then(|text| at.line(text)),
        })
    });
    found.collect()
}

/// Returns the name of a group, and the missing part of the scene.
fn lack(scene: &MeasuredScene, group: Observable) -> Option<(&'static str, &'static str)> {
    let any = |wanted: fn(&Shape) -> bool| scene.wall.iter().any(|wall| wanted(&wall.shape));
    let (is_there, lacks) = match group {
        Observable::DynamicAngleOfRepose | Observable::DrumFlow => (has_drum(scene), NO_DRUM),
        Observable::Discharge => {
            let outlet = any(|shape| matches!(shape, Shape::Disc { hole, .. } if *hole > 0.0));
            (outlet || !scene.remove.is_empty(), "there is no sink, and no wall is a disc with a hole")
        }
        Observable::DrivenWall => {
            let of_stages = scene.stage.iter().flat_map(|stage| stage.motion.values());
            let mut motions = scene.wall.iter().map(|wall| &wall.motion).chain(of_stages);
            (motions.any(Motion::is_driven), "no wall is driven by a force or a torque")
        }
        Observable::Walls | Observable::Wear => (!scene.wall.is_empty(), "there are no walls"),
        Observable::Regions => (!scene.measure.region.is_empty(), "there is no [[measure.region]]"),
        Observable::Gauges => (!scene.gauge.is_empty(), "there is no [[gauge]]"),
        Observable::Intruder => (!scene.grain.is_empty(), "no grain is listed by itself under [[grain]]"),
        Observable::StaticAngleOfRepose => {
            (scene.gravity != [0.0; 3] || !scene.gravity_changes.is_empty(), "there is no gravity")
        }
        _ => (true, ""),
    };
    let name = definitions().find(|(_, definition)| group_of(definition.name).is_some_and(|(of, _)| of == group));
    (!is_there).then(|| (name.map_or("", |(name, _)| name), lacks))
}

const NO_DRUM: &str = "no cylinder turns about its own axis, across gravity";

/// Returns the reason for one number of a group without a value: the missing part of the scene, or of the measured frames.
fn lack_of_number(scene: &MeasuredScene, name: &str) -> Option<&'static str> {
    match name {
        "population_mixing_index" | "first_over_other_distance" if scene.population.len() < 2 => {
            Some("the scene has fewer than two populations")
        }
        "small_over_large_distance" | "first_over_other_distance" if !has_drum(scene) => Some(NO_DRUM),
        "wall_force_over_weight" if scene.gravity == [0.0; 3] && scene.gravity_changes.is_empty() => {
            Some("there is no gravity")
        }
        "wall_force_over_weight" => Some("no measured frame has contacts"),
        "coulomb_excess" => Some("no contact with friction bears a force"),
        _ => None,
    }
}

/// Returns true if a scene has a drum under gravity at some time.
fn has_drum(scene: &MeasuredScene) -> bool {
    let later = scene.gravity_changes.iter().map(|change| change.gravity);
    std::iter::once(scene.gravity).chain(later).any(|gravity| Drum::find(scene, gravity.into()).is_some())
}

/// Returns the requested numbers without a value, with the reason; `lacks` is content that the frames do not have.
pub fn unmeasured(scene: &MeasuredScene, lacks: &[Content], measured: &Measured) -> Vec<Unmeasured> {
    let asked = |name: &str| group_of(name).filter(|(group, _)| scene.measure.observables.contains(group));
    let has = |name: &str| {
        let is_known = |known: &Definition| known.name == name;
        measured.measurements.iter().any(|measured| definition(&measured.observable).is_some_and(is_known))
    };
    let turns = (0..scene.wall.len()).any(|wall| scene.course(wall).axis().is_some());
    let refusal = |group: Observable| measured.refusals.iter().find(|(refused, _)| *refused == group);
    let without = definitions().filter_map(|(_, definition)| Some((definition.name, asked(definition.name)?.0)));
    let lacking =
        |name: &str, group| lack(scene, group).map(|(_, lacks)| lacks).or_else(|| lack_of_number(scene, name));
    let reason = |name: &str, group: Observable| match (missing(scene, name, lacks), lacking(name, group)) {
        (Some(content), _) => format!("the frames have no {}", content.words()),
        (None, Some(lacks)) => lacks.into(),
        (None, None) => refusal(group).map_or_else(|| "it has no value in these frames".into(), |(_, why)| why.clone()),
    };
    let without = without.filter(|(name, _)| !has(name) && (turns || *name != "torque(wall)"));
    without.map(|(observable, group)| Unmeasured { observable, reason: reason(observable, group) }).collect()
}

#[cfg(test)]
#[path = "../../tests/unit/observables_possible.rs"]
mod tests;
