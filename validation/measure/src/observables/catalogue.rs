//! Catalogue of the observables: definition of each number, and the required content of scenes and frames. The file of a group registers it.

use super::measurement::Readings;
use super::view::View;
use super::{
    balances, contact_forces, coordination, discharge, driven_wall, drum_flow, dynamic_angle, gauges, intruder, mixing,
    packing_fraction, regions, static_angle, wall_loads,
};
use makadam::scene::{Motion, SceneFileError, Shape, Wall, line_of, suggestion};
use makadam_frames::plan::{MeasuredScene, Observable, moment};
use makadam_frames::recording::Content;
use serde::Serialize;
use std::path::Path;

/// All groups, in the order of the page.
pub(super) const GROUPS: [Group; 15] = [
    dynamic_angle::GROUP,
    static_angle::GROUP,
    packing_fraction::GROUP,
    coordination::GROUP,
    contact_forces::GROUP,
    balances::GROUP,
    drum_flow::GROUP,
    mixing::GROUP,
    driven_wall::GROUP,
    wall_loads::LOADS,
    wall_loads::WEAR,
    discharge::GROUP,
    gauges::GROUP,
    intruder::GROUP,
    regions::GROUP,
];

/// Group of observables measured together.
pub(super) struct Group {
    pub observable: Observable,
    /// Name in `measure.observables`.
    pub name: &'static str,
    /// Adds the readings of a single frame, or returns the reason for none.
    pub read: fn(&View<'_>, &mut Readings) -> Result<(), String>,
    pub definitions: &'static [Definition],
}

/// Readings of a frame for groups that measure all frames together: none.
pub(super) fn nothing_of_a_frame(_: &View<'_>, _: &mut Readings) -> Result<(), String> {
    Ok(())
}

/// Definition of a measurable number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Definition {
    /// Name in `[[compare]]`, tables and documents; `(wall)`, `(gauge)` or `(region)` at its end stands for the name of one.
    pub name: &'static str,
    /// Symbol in formulas.
    pub symbol: &'static str,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    /// Formula.
    pub formula: &'static str,
    /// Publication; empty for definitions of this program.
    pub source: &'static str,
    /// Content that frames need in addition to positions and sizes of grains.
    pub needs: &'static [Content],
    /// True for a number of all measured frames together. The value of any other number is the mean, or the maximum, of the values of the
    /// single frames.
    #[serde(skip)]
    pub span: bool,
    /// True if the value is the maximum over the frames, not the mean.
    #[serde(skip)]
    pub largest: bool,
}

impl Definition {
    /// Returns true for the name of the quantity, with any argument if it has one, at any time.
    fn is_named(&self, quantity: &str) -> bool {
        let (quantity, _) = moment(quantity);
        match (parts(self.name), parts(quantity)) {
            (Some((own, _)), Some((other, _))) => own == other,
            _ => self.name == quantity,
        }
    }

    pub(super) const fn source(self, source: &'static str) -> Definition {
        Definition { source, ..self }
    }

    pub(super) const fn needs(self, needs: &'static [Content]) -> Definition {
        Definition { needs, ..self }
    }

    pub(super) const fn of_span(self) -> Definition {
        Definition { span: true, ..self }
    }

    pub(super) const fn largest(self) -> Definition {
        Definition { largest: true, ..self }
    }
}

/// Defines a number by its name, symbol and unit, and its formula.
pub(super) const fn define([name, symbol, unit]: [&'static str; 3], formula: &'static str) -> Definition {
    Definition { name, symbol, unit, formula, source: "", needs: &[], span: false, largest: false }
}

pub(super) const CONTACTS: &[Content] = &[Content::Contacts];
pub(super) const WALL_CONTACTS: &[Content] = &[Content::WallContacts];
pub(super) const ALL_CONTACTS: &[Content] = &[Content::Contacts, Content::WallContacts];
pub(super) const VELOCITIES: &[Content] = &[Content::Velocities];
pub(super) const MOTION: &[Content] = &[Content::Velocities, Content::Spins];

/// Returns the names of all measurable quantities.
pub fn known() -> impl Iterator<Item = &'static str> {
    definitions().map(|(_, definition)| definition.name)
}

/// Returns all quantities, each with the name of its group in `measure.observables`.
pub fn definitions() -> impl Iterator<Item = (&'static str, &'static Definition)> {
    GROUPS.into_iter().flat_map(|group| group.definitions.iter().map(move |definition| (group.name, definition)))
}

/// Returns a quantity by its name; `None` for unknown names. The argument of a name, `torque(blade)`, is not checked.
pub fn definition(quantity: &str) -> Option<&'static Definition> {
    definitions().map(|(_, definition)| definition).find(|definition| definition.is_named(quantity))
}

/// Returns the content that a quantity needs and the frames of a scene lack, if any. Quantities based on distances from walls need the
/// poses of force-driven and torque-driven walls; quantities of drums need the rates of torque-driven walls.
pub fn missing(scene: &MeasuredScene, quantity: &str, lacks: &[Content]) -> Option<Content> {
    let definition = definition(quantity)?;
    let is_driven = |wall: &&Wall| wall.motion.is_driven();
    let needs_poses = match group_of(quantity)?.0 {
        Observable::PackingFraction | Observable::CoordinationNumber | Observable::ContactForces => true,
        Observable::Walls => quantity.starts_with("power"),
        Observable::Discharge => {
            let outlet = scene.wall.iter().find(|wall| matches!(wall.shape, Shape::Disc { hole, .. } if hole > 0.0));
            outlet.as_ref().is_some_and(is_driven)
        }
        Observable::DynamicAngleOfRepose | Observable::DrumFlow => {
            scene.wall.iter().any(|wall| matches!(wall.motion, Motion::TorqueDriven { .. }))
        }
        _ => false,
    };
    let poses = (needs_poses && scene.wall.iter().any(|wall| is_driven(&wall))).then_some(&Content::DrivenWalls);
    definition.needs.iter().chain(poses).find(|need| lacks.contains(need)).copied()
}

/// Returns the page of all quantities, in Markdown.
pub fn page() -> String {
    let mut page = String::from(
        "# Observables\n\nWhat each measured number is. `makadam print observables` prints the same; this page is made by \
         `makadam print observables --markdown`. Name a group under `measure.observables`, a number under `[[compare]]`. Means ⟨⟩ are over \
         contacts or grains; the *bulk* is what lies at least two mean diameters from walls and free surface (one, where fewer than 50 \
         grains would be left). Every number follows from positions, velocities and contacts alone, by one code for every simulator.\n\n\
         The value of a run is the mean over the measured frames, for `largest_overlap` and `coulomb_excess` the maximum. It equals that of \
         the columns of `observables.csv`. Angles, thickness and speed of the flowing layer, Lacey's index in drums and discharge use \
         all measured frames together; the table has the values of single frames. Gravity and walls are those of the time of the frame.\n\n\
         The free surface is the outline of the bed in a drum, a level where the bed is level between walls, otherwise the outline of a \
         heap, averaged over azimuth. Without gravity there is none, and grains must fill the space between the walls. Packing fraction, \
         coordination and contact forces are not measured if the bulk holds a hole: a point farther than a mean diameter from the surface \
         of every grain.\n\n\
         A drum is the first cylinder that turns about its own axis, at least 45 degrees from gravity. Speed ratio and torque use the frames \
         in which it turns. Angles, flowing layer and surface speed need one sense of rotation in all measured frames. The axis of a heap is \
         that of the upright cylinders, which must have one and must not have moved sideways. Without cylinders it is the median of the \
         grains.\n",
    );
    let mut group = "";
    for (own, Definition { name, symbol, unit, formula, source, .. }) in definitions() {
        if own != group {
            page += &format!("\n## {own}\n\n| name | symbol | unit | definition |\n| --- | --- | --- | --- |\n");
            group = own;
        }
        let unit = if unit.is_empty() { "–" } else { unit };
        let source = if source.is_empty() { String::new() } else { format!(" ({source})") };
        let formula = formula.replace('|', "\\|");
        page += &format!("| `{name}` | {symbol} | {unit} | {formula}{source} |\n");
    }
    page
}

/// Returns the name of a quantity without its argument, and the argument; `None` without an argument.
fn parts(name: &str) -> Option<(&str, &str)> {
    name.strip_suffix(')')?.split_once('(')
}

/// Returns the group of a quantity, and the group's name in `measure.observables`; `None` for unknown quantities.
pub fn group_of(quantity: &str) -> Option<(Observable, &'static str)> {
    let has = |group: &Group| group.definitions.iter().any(|known| known.is_named(quantity));
    GROUPS.into_iter().find(has).map(|group| (group.observable, group.name))
}

/// Checks that a scene measures the quantities that it compares: a misspelt name, or a name of a group that is not measured, would have no
/// value in any run. `text` is the text of the scene file, for the line of the error.
///
/// # Errors
/// [`SceneFileError::Invalid`] with the line, and the nearest names or the missing entry.
pub fn check(scene: &MeasuredScene, text: &str, file: &Path) -> Result<(), SceneFileError> {
    for (index, expectation) in scene.compare.iter().enumerate() {
        let name = expectation.observable.as_str();
        let invalid = |problem: String, remedy: String| {
            let line = line_of(text, &["compare", &index.to_string(), "observable"]);
            let problem = format!("compare[{index}].observable: {problem}");
            Err(SceneFileError::Invalid { file: file.to_path_buf(), line, problem, remedy })
        };
        match group_of(name) {
            None => {
                let remedy = suggestion(name, known(), "`makadam print observables` lists all names");
                return invalid(format!("nothing measures '{name}'"), remedy);
            }
            Some((group, words)) if !scene.measure.observables.contains(&group) => {
                return invalid(
                    format!("'{name}' is compared and not measured"),
                    format!("add \"{words}\" to measure.observables, which it belongs to"),
                );
            }
            Some(_) => {
                let kind = definition(name).and_then(|definition| Some(parts(definition.name)?.1)).unwrap_or_default();
                let names: Vec<&str> = match kind {
                    "gauge" => scene.gauge.iter().map(|gauge| gauge.name.as_str()).collect(),
                    "region" => scene.measure.region.iter().map(|region| region.name.as_str()).collect(),
                    _ => scene.wall.iter().map(|wall| wall.name.as_str()).collect(),
                };
                if let Some((_, own)) = parts(moment(name).0).filter(|(_, own)| !names.contains(own)) {
                    let remedy = suggestion(own, names, &format!("give the name of a {kind} of the scene"));
                    return invalid(format!("'{name}': the scene has no {kind} '{own}'"), remedy);
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "../../tests/unit/observables_catalogue.rs"]
mod tests;
