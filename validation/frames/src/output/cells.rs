//! Sanitized texts: tables without cells that spreadsheet programs would take for formulas, and names for output to a
//! terminal.

use serde::Serialize;
use std::borrow::Cow;

/// Encodes the rows of a table as CSV, below the names of their fields.
pub fn csv(rows: &[impl Serialize]) -> Result<Vec<u8>, csv::Error> {
    table(csv::Writer::from_writer(Vec::new()), rows.iter())
}

/// Encodes rows below their head, which is present even without rows.
pub fn csv_below(head: &[&str], rows: impl Iterator<Item = impl Serialize>) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(head)?;
    table(writer, rows)
}

fn table(
    mut writer: csv::Writer<Vec<u8>>,
    mut rows: impl Iterator<Item = impl Serialize>,
) -> Result<Vec<u8>, csv::Error> {
    rows.try_for_each(|row| writer.serialize(row))?;
    Ok(without_formulas(writer.into_inner().map_err(|error| error.into_error())?))
}

/// Sanitizes a table in CSV: cells that begin like a formula get a leading apostrophe, which spreadsheet programs read as
/// "this is text". Numbers are unchanged, and so are bytes that are not CSV.
pub(crate) fn without_formulas(table: Vec<u8>) -> Vec<u8> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&table[..]);
    let Ok(records) = reader.records().collect::<Result<Vec<csv::StringRecord>, _>>() else { return table };
    if !records.iter().flatten().any(is_formula) {
        return table;
    }
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    for record in &records {
        let cells = record.iter().map(|cell| if is_formula(cell) { format!("'{cell}") } else { cell.to_string() });
        if writer.write_record(cells).is_err() {
            return table;
        }
    }
    writer.into_inner().unwrap_or(table)
}

/// Returns a cell without the apostrophe of `without_formulas`.
pub fn as_meant(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|cell| is_formula(cell)).unwrap_or(cell)
}

fn is_formula(cell: &str) -> bool {
    cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err()
}

/// Colour codes of the program, after an escape character.
const COLOURS: [&str; 6] = ["[0m", "[31m", "[31;1m", "[32m", "[33m", "[34m"];

/// Sanitizes a text for a terminal: names, and texts of other programs, can contain control characters. These are escaped
/// as in JSON, so that documents stay the same; line ends, tabs and, with `colours`, the program's own colour codes stay.
pub fn shown(text: &str, colours: bool) -> Cow<'_, str> {
    let obeyed = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\t')) || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len());
    for (at, c) in text.char_indices() {
        let own = colours && c == '\x1b' && COLOURS.iter().any(|colour| text[at + 1..].starts_with(colour));
        match obeyed(c) && !own {
            true => plain += &format!("\\u{:04x}", u32::from(c)),
            false => plain.push(c),
        }
    }
    Cow::Owned(plain)
}

#[cfg(test)]
#[path = "../../tests/unit/output_cells.rs"]
mod tests;
