//! Tables in text: CSV of any code, and YADE's `export.text` and `export.textExt`.

use super::columns::{Column, StatedColumns, number};
use super::table::{FrameTable, ImportError};
use std::collections::HashMap;
use std::path::Path;

/// Column separators.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

/// Reads the frames of a table with names in its first row. Rows with different times, or else with different steps, are different frames.
pub(super) fn csv(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let separator = separator(bytes).map_err(|(line, problem)| ImportError::new(file, line, problem))?;
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).delimiter(separator).from_reader(bytes);
    let heads = reader.headers().map_err(|error| ImportError::new(file, 1, error.to_string()))?.clone();
    if heads.iter().any(|name| name.parse::<f64>().is_ok()) {
        return Err(ImportError::new(file, 1, "the first row must name the columns, such as id,x,y,z,radius,vx,vy,vz"));
    }
    let table = FrameTable { line: 2, ..stated.table(file, 1, heads.iter().map(String::from).collect())? };
    // The second byte of a line end (\r\n) belongs to the next line, and is not counted before.
    let ends = |position: &csv::Position| bytes.get(position.byte() as usize) == Some(&b'\n');
    let line_of = |position: Option<&csv::Position>| {
        position.map_or(1, |position| position.line() as usize + usize::from(ends(position)))
    };
    let (of_times, of_steps) = (table.find(Column::Time), table.find(Column::Step));
    let told = of_times.or(of_steps).map(|column| table.places[column]);
    // Frames by their times or steps, in the order of first appearance.
    let mut frames: Vec<FrameTable> = Vec::new();
    let mut known: HashMap<u64, usize> = HashMap::new();
    if told.is_none() {
        frames.push(table.clone());
        known.insert(0, 0);
    }
    let mut record = csv::StringRecord::new();
    while reader
        .read_record(&mut record)
        .map_err(|error| ImportError::new(file, line_of(error.position()), error.to_string()))?
    {
        let line = line_of(record.position());
        let cells: Vec<&str> = record.iter().collect();
        // Zero has two signs. A cell that is not a number is refused with its row.
        let own = told.and_then(|place| number(cells[place]).ok()).unwrap_or(0.0) + 0.0;
        let at = *known.entry(own.to_bits()).or_insert_with(|| {
            let (time, step) = (of_times.map(|_| own), of_steps.map(|_| own as u64).filter(|_| of_times.is_none()));
            frames.push(FrameTable { line, time, step, ..table.clone() });
            frames.len() - 1
        });
        frames[at].add_row(line, &cells).map_err(|error| {
            let has_comma = separator == b';' && cells.iter().any(|cell| cell.contains(','));
            let remedy = if has_comma { "; write decimals behind a point" } else { "" };
            ImportError { problem: error.problem + remedy, ..error }
        })?;
        if of_times.is_none() && told.is_some() && !((0.0..1e15).contains(&own) && own.fract() == 0.0) {
            return Err(ImportError::new(file, line, format!("{own} is no number of a step")));
        }
    }
    Ok(frames)
}

/// Returns the separator of the names in the first row.
///
/// # Errors
/// The line and the message.
fn separator(bytes: &[u8]) -> Result<u8, (usize, String)> {
    let rows = bytes.split(|byte| *byte == b'\n').enumerate();
    let mut rows = rows.filter(|(_, row)| !row.trim_ascii().is_empty() && !row.starts_with(b"#"));
    let Some((line, row)) = rows.next() else { return Ok(b',') };
    let row = row.trim_ascii();
    let found: Vec<u8> = SEPARATORS.into_iter().filter(|separator| row.contains(separator)).collect();
    match found[..] {
        [separator] => Ok(separator),
        [] if row.contains(&b' ') => {
            Err((line + 1, "its columns are separated by spaces; separate them by commas, semicolons or tabs".into()))
        }
        [] => Ok(b','),
        _ => Err((line + 1, "its names are separated by several of comma, semicolon and tab; use one of them".into())),
    }
}

/// Reads YADE's columns; the first line names the format.
pub(super) fn yade(file: &Path, text: &str, stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let mut columns: Vec<String> = Vec::new();
    let mut table: Option<FrameTable> = None;
    for (at, line) in (1..).zip(text.lines()) {
        if let Some(comment) = line.trim_start().strip_prefix('#') {
            if let Some(format) = comment.trim().strip_prefix("format ") {
                if table.is_some() {
                    let problem =
                        "a second line #format; leave one frame in a file, or one run's frames in files of their own";
                    return Err(ImportError::new(file, at, problem));
                }
                columns = format.trim().split('_').map(String::from).collect();
            } else if columns.last().is_some_and(|last| last == "attrs") {
                // The last line of the comment lists the names of attributes.
                let names: Vec<String> = comment.split_whitespace().map(String::from).collect();
                if names.starts_with(&["x", "y", "z", "r"].map(String::from)) {
                    columns = names;
                }
            }
            continue;
        }
        let cells: Vec<&str> = line.split_whitespace().collect();
        if cells.is_empty() {
            continue;
        }
        if table.is_none() {
            columns.pop_if(|last| last == "attrs");
            while columns.len() < cells.len() && columns.len() >= 4 {
                columns.push(format!("unnamed{}", columns.len() + 1));
            }
            if cells.len() != columns.len() {
                let problem = format!("{} numbers where {} belong", cells.len(), columns.len());
                return Err(ImportError::new(file, at, problem));
            }
            table = Some(stated.table(file, at, std::mem::take(&mut columns))?);
        }
        table.as_mut().map_or(Ok(()), |table| table.add_row(at, &cells))?;
    }
    Ok(vec![table.map_or_else(|| stated.table(file, 1, columns), Ok)?])
}
