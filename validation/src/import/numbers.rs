//! Which grain of the scene a row is, as far as numbers and radii tell.

use super::columns::{Column, Places};
use super::frame_table::{FrameTable, ImportError};
use crate::plan::Scene;
use crate::recording::SAME_SIZE;
use std::collections::BTreeMap;

/// Numbers that a code gives its grains, and those of the scene.
pub(super) type Numbers = BTreeMap<i64, u32>;

/// The scene's numbers of the grains of all frames.
///
/// Numbers from 0, or from 1, are those of the scene. Others stand for their rank, which says nothing where grains are of several kinds and
/// their radii are not those of the kinds.
///
/// # Errors
/// [`ImportError`] where a number is none, or is not that of one grain in all frames, or where grains of several kinds cannot be told apart.
pub(super) fn numbers(
    scene: &Scene,
    grains: &[(f64, &FrameTable)],
    notes: &mut Vec<String>,
) -> Result<Numbers, ImportError> {
    let radii = radii_by_number(grains)?;
    if radii.is_empty() {
        return Ok(Numbers::new());
    }
    let has_numbers = |(_, table): &(f64, &FrameTable)| Places::of(table).find(Column::Id).is_some();
    if grains.len() > 1 && !grains.iter().any(has_numbers) {
        notes.push("grains have no numbers (a column id): a row is taken for the same grain in all frames".into());
    }
    let counted_from = |first: i64| -> Numbers { radii.keys().map(|own| (*own, (own - first) as u32)).collect() };
    let are_from = |first: &i64| {
        let range = *first..*first + scene.grain_count() as i64;
        radii.keys().all(|own| range.contains(own))
    };
    let ranked = || -> Numbers { radii.keys().copied().zip(0..).collect() };
    let direct: Vec<Numbers> = [0, 1].into_iter().filter(are_from).map(counted_from).collect();
    let kinds = Kinds::of(scene);
    if kinds.0.len() <= 1 {
        return Ok(direct.into_iter().next().unwrap_or_else(ranked));
    }
    let has_radii = radii.len() == scene.grain_count() && radii.values().all(Option::is_some);
    let candidates = if direct.is_empty() && has_radii { vec![ranked()] } else { direct };
    let (fitting, misfits): (Vec<_>, Vec<_>) = candidates
        .into_iter()
        .map(|numbers| (kinds.misfit(&numbers, &radii), numbers))
        .partition(|(misfit, _)| misfit.is_none());
    match <[_; 1]>::try_from(fitting) {
        Ok([(_, numbers)]) => Ok(numbers),
        Err(several) => {
            let ends = radii.first_key_value().zip(radii.last_key_value());
            let of = ends.map_or(String::new(), |((first, _), (last, _))| {
                format!("{} are numbered from {first} to {last}", radii.len())
            });
            let misfit = misfits.into_iter().find_map(|(misfit, _)| misfit).filter(|_| several.is_empty());
            let misfit = misfit.map_or(String::new(), |problem| format!(", and {problem}"));
            let problem = format!(
                "the {} grains of the scene are of several kinds, and the numbers here do not tell which is which: {of}{misfit}; number \
                 them from 0, listed grains first and then those of each population",
                scene.grain_count()
            );
            Err(grains[0].1.fault(0, problem))
        }
    }
}

/// The radius of each number, m, as far as the files tell it.
fn radii_by_number(grains: &[(f64, &FrameTable)]) -> Result<BTreeMap<i64, Option<f64>>, ImportError> {
    let mut all: BTreeMap<i64, Option<f64>> = BTreeMap::new();
    for (time, table) in grains {
        let places = Places::of(table);
        let id = places.find(Column::Id);
        let size = places.radius();
        for (row, values) in table.rows().enumerate() {
            let own = id.map_or(row as f64, |place| values[place]);
            if own.fract() != 0.0 || own.abs() > 1e15 {
                return Err(table.fault(row, format!("{own} is no number of a grain")));
            }
            let radius = size.map(|(place, factor)| factor * values[place]);
            let known = all.entry(own as i64).or_insert(radius);
            match (*known, radius) {
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
                (None, Some(_)) => *known = radius,
                _ => {}
            }
        }
    }
    Ok(all)
}

/// Grains of one kind follow each other in the scene's numbers: the number behind the last, and between which radii (m) they are.
struct Kinds(Vec<(usize, f64, f64)>);

impl Kinds {
    fn of(scene: &Scene) -> Kinds {
        let listed = scene.grain.iter().map(|grain| (1, (grain.radius, grain.radius)));
        let drawn = scene.population.iter().map(|population| (population.count, population.radius.bounds()));
        let mut end = 0;
        let ending = |(count, (low, high)): (usize, (f64, f64))| {
            end += count;
            (end, low, high)
        };
        Kinds(listed.chain(drawn).filter(|(count, _)| *count > 0).map(ending).collect())
    }

    /// The first grain whose radius its kind cannot have, in words.
    fn misfit(&self, numbers: &Numbers, radii: &BTreeMap<i64, Option<f64>>) -> Option<String> {
        numbers.iter().find_map(|(own, number)| {
            let radius = radii[own]?;
            let kind = self.0.partition_point(|(end, ..)| *end <= *number as usize);
            let (_, low, high) = *self.0.get(kind)?;
            let fits = (low * (1.0 - SAME_SIZE)..=high * (1.0 + SAME_SIZE)).contains(&radius);
            (!fits).then(|| format!("grain {own} has a radius of {radius} m, where the scene has {low} to {high} m"))
        })
    }
}
