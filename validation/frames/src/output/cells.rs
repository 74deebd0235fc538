//! Tables as CSV, without cells that programs for tables would take for formulas.

use serde::Serialize;

/// Rows of a table as CSV.
pub fn csv(rows: &[impl Serialize]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(without_formulas(writer.into_inner().map_err(|error| error.into_error())?))
}

/// Rows below their head, which stands there even if there is no row.
pub fn csv_below(head: &[&str], rows: impl Iterator<Item = impl Serialize>) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(head)?;
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(without_formulas(writer.into_inner().map_err(|error| error.into_error())?))
}

/// A table in CSV in which no text begins as a formula does: such cells get an apostrophe in front, which these programs read as
/// "this is text". Numbers stay as they are. What is no CSV comes back as it was.
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

/// A cell as it was before [`without_formulas`].
pub fn as_meant(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|cell| is_formula(cell)).unwrap_or(cell)
}

fn is_formula(cell: &str) -> bool {
    cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err()
}

#[cfg(test)]
#[path = "../../tests/unit/output_cells.rs"]
mod tests;
