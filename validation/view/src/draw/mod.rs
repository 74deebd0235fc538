//! Drawing of numbers, tables and figures, common to all pages and the terminal.
//!
//! ```text
//! values ─> Axis ─> Plot ─> Drawing (SVG) ─> Figure ─> page, file
//! rows   ─> numbers, names ─> columns ─> terminal
//! ```

pub mod figure;
pub mod names;
pub mod numbers;
pub mod plot;
pub mod svg;

use self::numbers::{significant, with_error};
use comfy_table::{ContentArrangement, Table, presets};

/// Formats rows of equal length as lines, cells padded to the width of their column: text to the left, numbers to the right. Widths
/// are counted in characters, so the terminal must support UTF-8.
pub fn columns<R: AsRef<[String]>>(rows: &[R], is_words: impl Fn(usize) -> bool) -> String {
    let length = rows.first().map_or(0, |row| row.as_ref().len());
    let width = |column: usize| rows.iter().map(|row| row.as_ref()[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..length).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.as_ref().iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
            let gap = " ".repeat(width - cell.chars().count());
            if is_words(column) { format!("{cell}{gap}") } else { format!("{gap}{cell}") }
        });
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}

/// Formats values by name with their standard errors and units, one line each, rounded by the errors.
pub fn values<'a>(rows: impl IntoIterator<Item = (&'a str, f64, Option<f64>, &'a str)>) -> String {
    let line = |(name, value, error, unit): (&str, f64, Option<f64>, &str)| {
        let value = error.map_or_else(|| significant(value), |error| with_error(value, error));
        [name.to_string(), format!("{value} {unit}").trim_end().to_string()]
    };
    columns(&rows.into_iter().map(line).collect::<Vec<_>>(), |_| true)
}

/// Formats rows of text as columns; on a terminal, long cells continue in further lines of its width.
pub fn wrapped(rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
    rows.iter().for_each(|row| {
        table.add_row(row);
    });
    for column in table.column_iter_mut() {
        column.set_padding((0, 2));
    }
    let lines = table.to_string();
    lines.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
#[path = "../../tests/unit/draw_columns.rs"]
mod tests;
