//! Tables in text: CSV of any code, and what YADE's `export.text` and `export.textExt` write.

use super::columns::{Column, Places, StatedColumns};
use super::table::{FrameTable, ImportError};
use std::collections::HashMap;
use std::path::Path;

/// Characters that may separate columns.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

/// Frames of a table with names in its first row. Rows whose times differ are frames of their own, or else those whose steps differ.
///
/// # Errors
/// [`ImportError`] with the line.
pub(super) fn csv(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let separator = separator(bytes).map_err(|(line, problem)| ImportError::new(file, line, problem))?;
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).delimiter(separator).from_reader(bytes);
    let heads = reader.headers().map_err(|error| ImportError::new(file, 1, error.to_string()))?.clone();
    if heads.iter().any(|name| name.parse::<f64>().is_ok()) {
        return Err(ImportError::new(file, 1, "the first row must name the columns, such as id,x,y,z,radius,vx,vy,vz"));
    }
    let heads = stated.heads(file, 1, heads.iter().map(String::from).collect())?;
    // The second byte of a line's end (\r\n) is taken with the next line, and not counted before.
    let ends = |position: &csv::Position| bytes.get(position.byte() as usize) == Some(&b'\n');
    let line_of = |position: Option<&csv::Position>| {
        position.map_or(1, |position| position.line() as usize + usize::from(ends(position)))
    };
    let mut table = FrameTable { line: 2, ..heads.table(file) };
    let mut record = csv::StringRecord::new();
    loop {
        let is_row = reader.read_record(&mut record);
        match is_row.map_err(|error| ImportError::new(file, line_of(error.position()), error.to_string()))? {
            true => {
                let line = line_of(record.position());
                let cells: Vec<&str> = record.iter().collect();
                heads.add_row(&mut table, &cells).map_err(|problem| {
                    let has_comma = separator == b';' && cells.iter().any(|cell| cell.contains(','));
                    let remedy = if has_comma { "; write decimals behind a point" } else { "" };
                    ImportError::new(file, line, problem + remedy)
                })?;
                table.lines.push(line);
            }
            false => return by_frame(table),
        }
    }
}

/// The character that separates the names in the first row.
///
/// # Errors
/// The line, and what is wrong with it.
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

/// One frame per value of the column of times, or else of that of steps, in the order in which they first come; the whole table, if it
/// has neither column.
fn by_frame(table: FrameTable) -> Result<Vec<FrameTable>, ImportError> {
    let (of_times, of_steps) = {
        let places = Places::of(&table);
        (places.find(Column::Time), places.find(Column::Step))
    };
    let Some(place) = of_times.or(of_steps) else {
        return Ok(vec![table]);
    };
    let width = table.columns.len();
    let empty = FrameTable {
        file: table.file.clone(),
        columns: table.columns.clone(),
        unread: table.unread.clone(),
        ..FrameTable::default()
    };
    let mut frames: Vec<(f64, FrameTable)> = Vec::new();
    let mut known: HashMap<u64, usize> = HashMap::new();
    for (row, (values, line)) in table.rows().zip(&table.lines).enumerate() {
        // Zero has two signs.
        let own = values[place] + 0.0;
        let at = *known.entry(own.to_bits()).or_insert_with(|| {
            frames.push((own, FrameTable { line: *line, ..empty.clone() }));
            frames.len() - 1
        });
        let frame = &mut frames[at].1;
        let start = frame.values.len();
        frame.values.extend(values);
        frame.lines.push(*line);
        let words = table.words.range(row * width..(row + 1) * width);
        frame.words.extend(words.map(|(cell, word)| (start + cell - row * width, word.clone())));
    }
    let told = |(own, frame): (f64, FrameTable)| {
        if of_times.is_some() {
            return Ok(FrameTable { time: Some(own), ..frame });
        }
        match (0.0..1e15).contains(&own) && own.fract() == 0.0 {
            true => Ok(FrameTable { step: Some(own as u64), ..frame }),
            false => Err(frame.fault(0, format!("{own} is no number of a step"))),
        }
    };
    frames.into_iter().map(told).collect()
}

/// Reads YADE's columns; the first line names the format.
///
/// # Errors
/// [`ImportError`] with the line.
pub(super) fn yade(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let text = String::from_utf8_lossy(bytes);
    let mut columns: Vec<String> = Vec::new();
    let mut table: Option<(super::columns::Heads, FrameTable)> = None;
    for (number_before, line) in text.lines().enumerate() {
        let at = number_before + 1;
        if let Some(comment) = line.trim_start().strip_prefix('#') {
            if let Some(format) = comment.trim().strip_prefix("format ") {
                if table.is_some() {
                    let problem =
                        "a second line #format; leave one frame in a file, or one run's frames in files of their own";
                    return Err(ImportError::new(file, at, problem));
                }
                columns = format.trim().split('_').map(String::from).collect();
            } else if columns.last().is_some_and(|last| last == "attrs") {
                // The last line of the comment names what the format calls attributes.
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
            if columns.last().is_some_and(|last| last == "attrs") {
                columns.pop();
            }
            while columns.len() < cells.len() && columns.len() >= 4 {
                columns.push(format!("unnamed{}", columns.len() + 1));
            }
            if cells.len() == columns.len() {
                let heads = stated.heads(file, at, std::mem::take(&mut columns))?;
                let empty = FrameTable { line: at, ..heads.table(file) };
                table = Some((heads, empty));
            }
        }
        let count = table.as_ref().map_or(columns.len(), |(heads, _)| heads.count());
        match &mut table {
            Some((heads, table)) if cells.len() == count => {
                heads.add_row(table, &cells).map_err(|problem| ImportError::new(file, at, problem))?;
                table.lines.push(at);
            }
            _ => {
                let problem = format!("{} numbers where {count} belong", cells.len());
                return Err(ImportError::new(file, at, problem));
            }
        }
    }
    match table {
        Some((_, table)) => Ok(vec![table]),
        None => Ok(vec![stated.heads(file, 1, columns)?.table(file)]),
    }
}
