//! Arrays of as many tuples as one table: what VTK's formats hold.

use super::columns::column_of;
use super::frame_table::{FrameTable, ImportError};
use super::stated::StatedColumns;
use std::path::Path;

/// An array of a file.
pub(super) struct Named {
    name: String,
    components: usize,
    /// Numbers, tuple after tuple; none where the array was passed over, since its name has no meaning.
    numbers: Option<Vec<f64>>,
}

impl Named {
    /// Names an array and its numbers.
    pub fn new(name: impl Into<String>, components: usize, numbers: Option<Vec<f64>>) -> Named {
        Named { name: name.into(), components, numbers }
    }
}

/// Names of the columns that an array becomes.
fn component_names(name: &str, components: usize) -> Vec<String> {
    match components {
        1 => vec![name.to_string()],
        _ => (0..components).map(|axis| format!("{name}_{axis}")).collect(),
    }
}

/// Reports whether an array is to be read: its columns have a meaning, or the caller names all columns.
pub(super) fn is_wanted(name: &str, components: usize, stated: &StatedColumns) -> bool {
    !stated.is_empty() || component_names(name, components).iter().any(|name| column_of(name).is_some())
}

/// Puts arrays of `count` tuples into one table.
///
/// # Errors
/// [`ImportError`] where an array is shorter, or holds what is no finite number under a name that has a meaning.
pub(super) fn table_of(
    file: &Path,
    count: usize,
    arrays: &[Named],
    stated: &StatedColumns,
) -> Result<FrameTable, ImportError> {
    let fault = |problem: String| ImportError::new(file, 1, problem);
    let names: Vec<String> = arrays.iter().flat_map(|array| component_names(&array.name, array.components)).collect();
    let heads = stated.heads(file, 1, names)?;
    let places: Vec<(usize, usize)> =
        (0..arrays.len()).flat_map(|array| (0..arrays[array].components).map(move |axis| (array, axis))).collect();
    let mut table = heads.table(file);
    let mut columns: Vec<(&[f64], usize, usize)> = Vec::new();
    for (array, axis) in heads.used().iter().map(|place| places[*place]) {
        let Named { name, components, numbers } = &arrays[array];
        let numbers = numbers.as_deref().ok_or_else(|| fault(format!("array {name} holds no numbers")))?;
        if numbers.len() != components * count {
            let problem = format!("array {name} has {} numbers where {} belong", numbers.len(), components * count);
            return Err(fault(problem));
        }
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err(fault(format!("array {name}: a number is not finite: the run has blown up")));
        }
        columns.push((numbers, *components, axis));
    }
    table.values.reserve(count * columns.len());
    for tuple in 0..count {
        table.values.extend(columns.iter().map(|(numbers, components, axis)| numbers[tuple * components + axis]));
    }
    Ok(table)
}
