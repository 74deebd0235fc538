//! Which grain of the scene a row is: by the numbers that the caller states to be the scene's, or else by what the file states of the grain,
//! its material and its radius.
//!
//! Grains of one kind (a population, or listed grains that are alike) are interchangeable but for their numbers; those stand in the order of
//! the file's. A grain that fits several kinds is refused.

use super::columns::{Column, Places};
use super::frame_table::{FrameTable, ImportError};
use super::stated::Stated;
use crate::plan::Scene;
use crate::recording::SAME_SIZE;
use std::collections::BTreeMap;

/// Numbers that a code gives its grains, and those of the scene.
pub(super) type Numbers = BTreeMap<i64, u32>;

/// Statement of the files about one grain, over all frames.
struct Row<'t> {
    radius: Option<f64>,
    kind: Option<String>,
    table: &'t FrameTable,
    row: usize,
}

/// Grains of the scene that are alike but for their places.
pub(super) struct Group<'s> {
    /// Number of the first of them.
    first: u32,
    count: usize,
    /// Smallest and largest radius, m.
    pub radii: (f64, f64),
    material: &'s str,
    /// Number of the population; none for listed grains.
    population: Option<usize>,
}

impl Group<'_> {
    /// Grains of the scene that are alike, in the order of their numbers.
    pub fn all(scene: &Scene) -> Vec<Group<'_>> {
        let mut groups: Vec<Group<'_>> = Vec::new();
        let mut next = 0;
        for grain in &scene.grain {
            let radii = (grain.radius, grain.radius);
            match groups.last_mut().filter(|last| last.radii == radii && last.material == grain.material) {
                Some(last) => last.count += 1,
                None => {
                    groups.push(Group { first: next, count: 1, radii, material: &grain.material, population: None })
                }
            }
            next += 1;
        }
        for (place, population) in scene.population.iter().enumerate().filter(|(_, population)| population.count > 0) {
            groups.push(Group {
                first: next,
                count: population.count,
                radii: population.radius.bounds(),
                material: &population.material,
                population: Some(place),
            });
            next += population.count as u32;
        }
        groups
    }

    /// The one radius of its grains, for each of them, m.
    pub fn each_radius(&self) -> impl Iterator<Item = f64> + use<> {
        std::iter::repeat_n(self.radii.0, self.count)
    }

    fn has_radius(&self, radius: f64) -> bool {
        (self.radii.0 * (1.0 - SAME_SIZE)..=self.radii.1 * (1.0 + SAME_SIZE)).contains(&radius)
    }

    /// Reports whether the value of a table of kinds names this group: by material, or as `population.1`.
    fn is_named(&self, name: &str) -> bool {
        self.material == name || self.population.is_some_and(|place| name == format!("population.{place}"))
    }
}

/// Names that `kinds` may use, for messages.
fn known_kinds(scene: &Scene) -> String {
    let materials = scene.material.keys().cloned();
    let populations = (0..scene.population.len()).map(|place| format!("population.{place}"));
    materials.chain(populations).collect::<Vec<_>>().join(", ")
}

/// Checks that a table of kinds names materials and populations of the scene.
///
/// # Errors
/// What is wrong with it.
pub fn check_kinds(scene: &Scene, kinds: &BTreeMap<String, String>) -> Result<(), String> {
    let is_known = |name: &str| {
        scene.material.contains_key(name)
            || (0..scene.population.len()).any(|place| name == format!("population.{place}"))
    };
    match kinds.iter().find(|(_, name)| !is_known(name)) {
        None => Ok(()),
        Some((value, name)) => {
            Err(format!("kinds: {value}={name}: the scene has no {name}; it has {}", known_kinds(scene)))
        }
    }
}

/// The scene's numbers of the grains of all frames.
///
/// # Errors
/// [`ImportError`] where a number is none, or is not that of one grain in all frames, or where the files do not state which grains of the
/// scene they hold.
pub(super) fn numbers(
    scene: &Scene,
    stated: &Stated,
    grains: &[(f64, &FrameTable)],
    notes: &mut Vec<String>,
) -> Result<Numbers, ImportError> {
    rows_are_grains(grains, notes)?;
    let rows = rows_by_number(grains)?;
    let groups = Group::all(scene);
    let by_file = grains.first().and_then(|(_, table)| table.first_id);
    let by_file = by_file.filter(|first| grains.iter().all(|(_, table)| table.first_id == Some(*first)));
    if let Some(first) = stated.first_id.or(by_file) {
        if let Some((_, table)) =
            grains.iter().find(|(_, table)| !table.values.is_empty() && Places::of(table).find(Column::Id).is_none())
        {
            return Err(table.fault(
                0,
                "first-id states how grains are numbered, and there is no column id; leave their numbers in one",
            ));
        }
        return as_the_scene(scene, &groups, first, &rows, stated);
    }
    if let [_] = groups[..] {
        notes.extend(other_kinds(scene, stated, &rows));
        return Ok(rows.keys().copied().zip(0..).collect());
    }
    let mut taken = vec![0; groups.len()];
    let mut numbers = Numbers::new();
    for (own, row) in &rows {
        let place = group_of(scene, &groups, stated, &rows, *own)?;
        let Group { first, count, .. } = groups[place];
        if taken[place] == count {
            let problem = format!(
                "grain {own} is one more of its kind (material {}, radius {}) than the scene has, {count}",
                groups[place].material,
                range(groups[place].radii)
            );
            return Err(row.table.fault(row.row, problem));
        }
        numbers.insert(*own, first + taken[place] as u32);
        taken[place] += 1;
    }
    Ok(numbers)
}

/// Refuses rows without numbers where frames have other counts: which grains came or went is not stated.
fn rows_are_grains(grains: &[(f64, &FrameTable)], notes: &mut Vec<String>) -> Result<(), ImportError> {
    let has_numbers = |table: &FrameTable| Places::of(table).find(Column::Id).is_some();
    let filled: Vec<&FrameTable> =
        grains.iter().map(|(_, table)| *table).filter(|table| !table.values.is_empty()).collect();
    let Some(unnumbered) = filled.iter().find(|table| !has_numbers(table)) else { return Ok(()) };
    let problem = if filled.iter().any(|table| has_numbers(table)) {
        "its grains have no numbers (a column id), and those of other frames have; leave them in all frames"
    } else if filled.iter().any(|table| table.rows().count() != unnumbered.rows().count()) {
        "frames have other numbers of grains, and no column id states which grains came or went; leave the numbers of grains in a column id"
    } else {
        if filled.len() > 1 {
            notes.push("grains have no numbers (a column id): a row is taken for the same grain in all frames".into());
        }
        return Ok(());
    };
    Err(unnumbered.fault(0, problem))
}

/// Numbers that the caller states to be the scene's.
fn as_the_scene(
    scene: &Scene,
    groups: &[Group<'_>],
    first: i64,
    rows: &BTreeMap<i64, Row<'_>>,
    stated: &Stated,
) -> Result<Numbers, ImportError> {
    let last = first + scene.grain_count() as i64 - 1;
    let number = |(own, row): (&i64, &Row<'_>)| {
        if !(first..=last).contains(own) {
            let problem = format!(
                "there is no grain {own}: the scene's grains are numbered from {first} to {last}; state the number of its first grain \
                 (--first-id, or first-id in a manifest)"
            );
            return Err(row.table.fault(row.row, problem));
        }
        let id = (own - first) as u32;
        let group = &groups[groups.partition_point(|group| group.first <= id) - 1];
        if let Some(radius) = row.radius.filter(|radius| !group.has_radius(*radius)) {
            let problem = format!(
                "grain {own} has a radius of {radius} m, where the scene has {}; number grains as the scene does, listed ones first and then \
                 those of each population",
                range(group.radii)
            );
            return Err(row.table.fault(row.row, problem));
        }
        if let Some(name) =
            row.kind.as_ref().and_then(|kind| name_of(scene, stated, kind)).filter(|name| !group.is_named(name))
        {
            let problem = format!(
                "grain {own} is of {name}, where the scene has {}; number grains as the scene does",
                group.material
            );
            return Err(row.table.fault(row.row, problem));
        }
        Ok((*own, id))
    };
    rows.iter().map(number).collect()
}

/// The material or population that a value stands for, as far as it is stated.
fn name_of<'a>(scene: &'a Scene, stated: &'a Stated, kind: &str) -> Option<&'a str> {
    let stated = stated.kinds.get(kind).map(String::as_str);
    stated.or_else(|| scene.material.get_key_value(kind).map(|(name, _)| &**name))
}

/// The one group that has a grain's kind and radius.
fn group_of(
    scene: &Scene,
    groups: &[Group<'_>],
    stated: &Stated,
    rows: &BTreeMap<i64, Row<'_>>,
    own: i64,
) -> Result<usize, ImportError> {
    let row = &rows[&own];
    let fault = |problem: String| Err(row.table.fault(row.row, problem));
    let name = row.kind.as_deref().and_then(|kind| name_of(scene, stated, kind));
    let fits = |group: &Group<'_>| {
        row.radius.is_none_or(|radius| group.has_radius(radius)) && name.is_none_or(|name| group.is_named(name))
    };
    let fitting: Vec<usize> = (0..groups.len()).filter(|place| fits(&groups[*place])).collect();
    let radius = row.radius.map_or("no stated radius".into(), |radius| format!("a radius of {radius} m"));
    match (&fitting[..], name, &row.kind) {
        ([place], ..) => Ok(*place),
        ([], Some(name), _) => {
            fault(format!("grain {own} is of {name} and has {radius}, and the scene has no such grain"))
        }
        ([], None, _) => fault(format!("grain {own} has {radius}, and the scene has no such grain")),
        (_, None, Some(kind)) => fault(format!(
            "the grains of the scene are of several kinds, and the file does not state what its value {kind} is; add --kinds \
             {}, or kinds in a manifest, with one of {} for each MATERIAL",
            kinds_of(rows).iter().map(|kind| format!("{kind}=MATERIAL")).collect::<Vec<_>>().join(","),
            known_kinds(scene)
        )),
        (_, Some(name), Some(kind)) => fault(format!(
            "several populations of the scene are of {name}, and the file does not state which one its value {kind} is; add --kinds \
             {kind}=population.0,..., or kinds in a manifest"
        )),
        (_, _, None) => fault(format!(
            "the grains of the scene are of several kinds, and the file does not state which grain {own} is: it has {radius} and no column \
             type or material; where grains are numbered as in the scene, listed ones first and then those of each population, add \
             --first-id NUMBER (the number of the first), or first-id in a manifest"
        )),
    }
}

/// Values of the files' column of kinds, each once.
fn kinds_of<'r>(rows: &'r BTreeMap<i64, Row<'_>>) -> Vec<&'r str> {
    let mut kinds: Vec<&str> = rows.values().filter_map(|row| row.kind.as_deref()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

/// Values of kinds that contradict a scene of one material, in a sentence.
fn other_kinds(scene: &Scene, stated: &Stated, rows: &BTreeMap<i64, Row<'_>>) -> Option<String> {
    let kinds = kinds_of(rows);
    let is_other = kinds.len() > 1
        || kinds.iter().any(|kind| name_of(scene, stated, kind).is_none() && kind.parse::<f64>().is_err());
    is_other.then(|| {
        let material = Group::all(scene).first().map_or(String::new(), |group| group.material.to_string());
        format!(
            "the files name the materials {}, and all grains of the scene are of {material}, which is taken",
            kinds.join(", ")
        )
    })
}

/// A range of radii, for messages.
pub(super) fn range((low, high): (f64, f64)) -> String {
    if low == high { format!("{low} m") } else { format!("{low} to {high} m") }
}

/// The radius and the kind of each number, as far as the files state them.
fn rows_by_number<'t>(grains: &[(f64, &'t FrameTable)]) -> Result<BTreeMap<i64, Row<'t>>, ImportError> {
    let mut all: BTreeMap<i64, Row<'t>> = BTreeMap::new();
    for (time, table) in grains {
        let places = Places::of(table);
        let (id, kind) = (places.find(Column::Id), places.find(Column::Kind));
        let size = places.radius();
        for (row, values) in table.rows().enumerate() {
            let own = id.map_or(row as f64, |place| values[place]);
            if own.fract() != 0.0 || own.abs() > 1e15 {
                return Err(table.fault(row, format!("{own} is no number of a grain")));
            }
            let radius = size.map(|(place, factor)| factor * values[place]);
            let kind = kind.map(|place| table.word(row, place).map_or_else(|| values[place].to_string(), String::from));
            let known = all.entry(own as i64).or_insert_with(|| Row { radius, kind: kind.clone(), table, row });
            if let (Some(before), Some(now)) = (&known.kind, &kind)
                && before != now
            {
                let problem = format!(
                    "grain {own} is of {now} at {time} s, and of {before} before; number a grain alike in all frames"
                );
                return Err(table.fault(row, problem));
            }
            match (known.radius, radius) {
                (Some(before), Some(now)) if (now - before).abs() > SAME_SIZE * before.abs() => {
                    let problem = match id {
                        Some(_) => format!(
                            "grain {own} has a radius of {now} m at {time} s, and of {before} m before; number a grain alike in all frames"
                        ),
                        None => format!(
                            "row {row} has a radius of {now} m at {time} s, and of {before} m before: rows are in another order; leave the numbers of grains in a column id"
                        ),
                    };
                    return Err(table.fault(row, problem));
                }
                (None, Some(_)) => known.radius = radius,
                _ => {}
            }
        }
    }
    Ok(all)
}
