//! Identity of grains: maps the rows of files to the scene's grains, by declared scene numbers, or else by the material and the radius in the
//! file.
//!
//! Grains of one kind (a population, or identical listed grains) are interchangeable except for their numbers, which follow the order of the
//! file's numbers. Grains that match several kinds are refused.

use super::columns::Column;
use super::frames::{Assembly, Frame};
use super::manifest::{Manifest, Missing, known_kinds};
use super::table::{FrameTable, ImportError};
use crate::plan::{Alike, MeasuredScene, Roster};
use crate::recording::SAME_SIZE;
use makadam::scene::populate;
use std::collections::{BTreeMap, BTreeSet};

/// Grain numbers of a code, and the numbers of the scene.
pub(super) type Numbers = BTreeMap<i64, u32>;

/// Statement of the files about one grain, over all frames.
struct Row<'t> {
    radius: Option<f64>,
    kind: Option<String>,
    table: &'t FrameTable,
    row: usize,
}

/// Grains of frames, matched with the grains of a scene.
pub(super) struct Identity<'a> {
    scene: &'a MeasuredScene,
    manifest: &'a Manifest,
    groups: Vec<Alike>,
    /// File number of the scene's first grain, for files with the scene's numbering.
    first_id: Option<i64>,
}

impl<'a> Identity<'a> {
    pub fn new(scene: &'a MeasuredScene, manifest: &'a Manifest, frames: &[Frame<'_>]) -> Identity<'a> {
        let own = frames.first().and_then(|frame| frame.grains.first_id);
        let own = own.filter(|first| frames.iter().all(|frame| frame.grains.first_id == Some(*first)));
        Identity { scene, manifest, groups: Roster::new(scene).groups, first_id: manifest.first_id.or(own) }
    }

    /// Returns the grain number of a row of a file; rows without numbers count from the first.
    pub fn own_number(&self, id: Option<usize>, row: usize, cells: &[f64]) -> f64 {
        id.map_or_else(|| (self.first_id.unwrap_or(0) + row as i64) as f64, |column| cells[column])
    }

    /// Returns the scene numbers of the grains of all frames.
    ///
    /// # Errors
    /// [`ImportError`] for a number that changes its grain, or that the scene lacks.
    pub fn numbers(&self, frames: &[Frame<'_>], missing: &mut Missing) -> Result<Numbers, ImportError> {
        self.check_unnumbered(frames, missing)?;
        let rows = self.rows_by_number(frames)?;
        if let Some(first) = self.first_id {
            return rows.iter().map(|(own, row)| Ok((*own, self.as_the_scene(first, *own, row)?))).collect();
        }
        let kinds: BTreeSet<&str> = rows.values().filter_map(|row| row.kind.as_deref()).collect();
        let is_open = |kind: &str| self.name_of(kind).is_none() && (kinds.len() > 1 || kind.parse::<f64>().is_err());
        let mut taken = vec![0; self.groups.len()];
        let mut numbers = Numbers::new();
        for (own, row) in &rows {
            let fault = |problem: String| Err(row.table.fault(row.row, problem));
            let name = row.kind.as_deref().and_then(|kind| self.name_of(kind));
            let fits = |group: &Alike| {
                row.radius.is_none_or(|radius| has_radius(group, radius))
                    && name.is_none_or(|name| self.is_named(group, name))
            };
            let fitting: Vec<usize> = (0..self.groups.len()).filter(|index| fits(&self.groups[*index])).collect();
            let [index] = fitting[..] else {
                let radius = row.radius.map_or("no stated radius".into(), |radius| format!("a radius of {radius} m"));
                let of = name.map_or(String::new(), |name| format!(" is of {name} and"));
                if fitting.is_empty() {
                    return fault(format!(
                        "grain {own}{of} has {radius}, and the scene has no such grain: it has {}; give lengths in metres, and the \
                         scene that was run",
                        self.radii_text()
                    ));
                }
                self.add_missing(row, &kinds, missing);
                continue;
            };
            if self.groups.len() == 1 && row.kind.as_deref().is_some_and(is_open) {
                self.add_missing(row, &kinds, missing);
            }
            let (Alike { first, count, radii, .. }, material) =
                (&self.groups[index], self.material(&self.groups[index]));
            if taken[index] == *count {
                return fault(format!(
                    "grain {own} is one more of its kind (material {material}, radius {}) than the scene has, {count}",
                    range(*radii)
                ));
            }
            numbers.insert(*own, (first + taken[index]) as u32);
            taken[index] += 1;
        }
        Ok(numbers)
    }

    /// Returns the scene's radii by grain number, m, for files without radii: for kinds with a single radius, or for declared numbering and
    /// placement of the scene.
    pub fn radii(&self, table: &FrameTable, assembly: &mut Assembly<'_>) -> Result<Vec<f64>, ImportError> {
        let Assembly { missing, notes, .. } = assembly;
        if self.groups.iter().all(|group| group.radii.0 == group.radii.1) {
            notes.push(format!("radii are those of the scene, {}", self.radii_text()));
            let of = |group: &Alike| std::iter::repeat_n(group.radii.0, group.count as usize);
            return Ok(self.groups.iter().flat_map(of).collect());
        }
        if let (Some(_), Some(seed)) = (self.manifest.first_id, self.manifest.seed) {
            notes.push(format!("radii are those of the scene's grains with seed {seed}, by their numbers"));
            let grains = populate(self.scene, seed).map_err(|error| table.fault(0, error.to_string()))?;
            return Ok(grains.iter().map(|grain| grain.radius).collect());
        }
        let meaning = format!(
            "the files have no column radius or diameter among {}, and the scene has radii of {}: name it by columns, or state numbers and \
             seed of grains that the scene has placed",
            table.names(),
            self.radii_text()
        );
        missing.add(table, 0, "first-id = NUMBER", meaning);
        missing.add(table, 0, "seed = NUMBER", "the seed by which the scene placed the grains");
        Ok(Vec::new())
    }

    /// Checks that rows without numbers are the scene's grains, as `first-id` states; the order of rows in a single frame is free.
    fn check_unnumbered(&self, frames: &[Frame<'_>], missing: &mut Missing) -> Result<(), ImportError> {
        let wanted = self.scene.grain_count();
        let filled = || frames.iter().map(|frame| frame.grains).filter(|table| !table.values.is_empty());
        for table in filled().filter(|table| table.find(Column::Id).is_none()) {
            let count = table.rows().len();
            if self.first_id.is_some() && count != wanted {
                let problem = format!(
                    "first-id states that rows are the scene's grains, and there are {count} for {wanted}; leave the numbers of grains in a \
                     column id"
                );
                return Err(table.fault(0, problem));
            }
            if self.first_id.is_none() && filled().nth(1).is_some() {
                let meaning = "each frame has the scene's grains row by row: listed ones first, then those of each population; else leave \
                               the numbers of grains in a column id";
                missing.add(table, 0, "first-id = 0", meaning);
            }
        }
        Ok(())
    }

    /// Returns the scene number for files with the scene's numbering from `first`.
    fn as_the_scene(&self, first: i64, own: i64, row: &Row<'_>) -> Result<u32, ImportError> {
        let last = first + self.scene.grain_count() as i64 - 1;
        let fault = |problem: String| Err(row.table.fault(row.row, problem));
        if !(first..=last).contains(&own) {
            return fault(format!("there is no grain {own}: first-id states numbers from {first} to {last}"));
        }
        let id = (own - first) as u32;
        let group = &self.groups[self.groups.partition_point(|group| group.first <= u64::from(id)) - 1];
        if let Some(radius) = row.radius.filter(|radius| !has_radius(group, *radius)) {
            return fault(format!(
                "grain {own} has a radius of {radius} m, where the scene has {}; number grains as the scene does, listed ones first and then \
                 those of each population",
                range(group.radii)
            ));
        }
        let name = row.kind.as_deref().and_then(|kind| self.name_of(kind));
        match name.filter(|name| !self.is_named(group, name)) {
            Some(name) => fault(format!(
                "grain {own} is of {name}, where the scene has {}; number grains as the scene does",
                self.material(group)
            )),
            None => Ok(id),
        }
    }

    /// Returns the name of the material of a group.
    fn material(&self, group: &Alike) -> &str {
        self.scene.material.keys().nth(usize::from(group.kind.material)).map_or("", String::as_str)
    }

    /// Returns true if the value of a table of kinds names a group: by material, or as `population.1`.
    fn is_named(&self, group: &Alike, name: &str) -> bool {
        self.material(group) == name || group.kind.population.is_some_and(|index| name == format!("population.{index}"))
    }

    /// Returns the declared material or population of a value.
    fn name_of<'n>(&'n self, kind: &'n str) -> Option<&'n str> {
        let stated = self.manifest.kinds.get(kind).map(String::as_str);
        stated.or_else(|| self.scene.material.get_key_value(kind).map(|(name, _)| &**name))
    }

    /// Adds the manifest line for the kind of a grain.
    fn add_missing(&self, row: &Row<'_>, kinds: &BTreeSet<&str>, missing: &mut Missing) {
        if row.kind.is_none() {
            let meaning = "number of the scene's first grain, where grains are numbered as in the scene, listed ones first and then those of \
                           each population; else leave a column type or material: the scene has several kinds that fit";
            return missing.add(row.table, row.row, "first-id = NUMBER", meaning);
        }
        let pairs: Vec<String> = kinds.iter().map(|kind| format!("{kind} = \"KIND\"")).collect();
        let meaning = format!("each KIND one of {}", known_kinds(self.scene).join(", "));
        missing.add(row.table, row.row, format!("kinds = {{ {} }}", pairs.join(", ")), meaning);
    }

    /// Returns the radii of the scene, for messages.
    fn radii_text(&self) -> String {
        let (low, high) =
            (self.groups.iter().map(|group| group.radii.0), self.groups.iter().map(|group| group.radii.1));
        range((low.fold(f64::INFINITY, f64::min), high.fold(0.0, f64::max)))
    }

    /// Returns the radius and kind of each number, as far as the files state them.
    fn rows_by_number<'t>(&self, frames: &[Frame<'t>]) -> Result<BTreeMap<i64, Row<'t>>, ImportError> {
        let mut all: BTreeMap<i64, Row<'t>> = BTreeMap::new();
        for Frame { grains: table, .. } in frames {
            let (id, kind, size) = (table.find(Column::Id), table.find(Column::Kind), table.radius());
            for (row, cells) in table.rows().enumerate() {
                let own = self.own_number(id, row, cells);
                if own.fract() != 0.0 || own.abs() > 1e15 {
                    return Err(table.fault(row, format!("{own} is not the number of a grain")));
                }
                let radius = size.map(|(column, factor)| factor * cells[column]);
                let kind =
                    kind.map(|column| table.word(row, column).map_or_else(|| cells[column].to_string(), String::from));
                let known = all.entry(own as i64).or_insert_with(|| Row { radius, kind: kind.clone(), table, row });
                let changed = |what: String| {
                    let remedy = "number a grain alike in all frames, in a column id";
                    Err(table.fault(row, format!("grain {own} {what} before; {remedy}")))
                };
                match (&known.kind, &kind) {
                    (Some(before), Some(now)) if before != now => {
                        return changed(format!("is of {now}, and was of {before}"));
                    }
                    _ => {}
                }
                match (known.radius, radius) {
                    (Some(before), Some(now)) if (now - before).abs() > SAME_SIZE * before.abs() => {
                        return changed(format!("has a radius of {now} m, and had one of {before} m"));
                    }
                    (None, Some(_)) => known.radius = radius,
                    _ => {}
                }
            }
        }
        Ok(all)
    }
}

fn has_radius(group: &Alike, radius: f64) -> bool {
    (group.radii.0 * (1.0 - SAME_SIZE)..=group.radii.1 * (1.0 + SAME_SIZE)).contains(&radius)
}

/// Formats a range of radii, for messages.
fn range((low, high): (f64, f64)) -> String {
    let [low, high] = [low, high].map(|radius| format!("{radius:.9e}").parse().unwrap_or(radius));
    if low == high { format!("{low} m") } else { format!("{low} to {high} m") }
}
