//! Tables in text: CSV of any code, and what YADE's `export.text` and `export.textExt` write.

use super::columns::{Column, Places};
use super::frame_table::{FrameTable, ImportError};
use super::stated::StatedColumns;
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

/// What YADE writes in columns; the first line names the format.
///
/// # Errors
/// [`ImportError`] with the line.
pub(super) fn yade(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let text = String::from_utf8_lossy(bytes);
    let mut columns: Vec<String> = Vec::new();
    let mut table: Option<(super::stated::Heads, FrameTable)> = None;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<FrameTable>, String> {
        csv(Path::new("a.csv"), text.as_bytes(), &StatedColumns::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_first_row_states_the_separator() {
        for text in [
            "id,x\n1,0.5\n",
            "id;x\n1;0.5\n",
            "id\tx\n1\t0.5\n",
            "\u{feff}id,x\r\n1,0.5\r\n",
            "# by hand\nid;x\n1;0.5\n",
        ] {
            assert_eq!(read(text).unwrap()[0].values, [1.0, 0.5], "{text}");
        }
        let error = read("id x y\n1 0 0\n").unwrap_err();
        assert!(error.contains("line 1: its columns are separated by spaces"), "{error}");
        let error = read("id;x,y\n1;0,0\n").unwrap_err();
        assert!(error.contains("several of comma, semicolon and tab"), "{error}");
        let error = read("id;x\n1;0,5\n").unwrap_err();
        assert!(error.contains("line 2: column x: '0,5' is not a number; write decimals behind a point"), "{error}");
    }

    #[test]
    fn only_columns_with_a_meaning_must_hold_numbers() {
        let frames = read("id,x,material,note,T\n1,0.5,glass,a b,nan\n2,1.5,3,,300\n").unwrap();
        let [frame] = &frames[..] else { panic!("{frames:?}") };
        assert_eq!(
            (&frame.columns[..], &frame.unread[..]),
            (&["id", "x", "material"].map(String::from)[..], &["note", "T"].map(String::from)[..])
        );
        assert_eq!((frame.word(0, 2), frame.word(1, 2), frame.values[5]), (Some("glass"), None, 3.0));
        let error = read("id,x\n1,nan\n").unwrap_err();
        assert!(error.contains("line 2: column x: 'nan' is not finite"), "{error}");
    }

    #[test]
    fn rows_of_a_time_are_a_frame_wherever_they_stand() {
        let frames = read("time,id,material\n0,1,glass\n1,1,glass\n-0,2,steel\n1,2,3\n").unwrap();
        let found: Vec<_> =
            frames.iter().map(|frame| (frame.time, frame.line, frame.rows().count(), frame.word(1, 2))).collect();
        assert_eq!(found, [(Some(0.0), 2, 2, Some("steel")), (Some(1.0), 3, 2, None)]);
        assert_eq!(frames[0].lines, [2, 4]);
        // A temperature is no time.
        assert_eq!(read("id,T\n1,300\n2,310\n").unwrap().len(), 1);
    }

    /// Ten times as many frames take ten times as long; a look at all earlier frames would take a hundred times as long.
    #[test]
    fn frames_are_told_apart_in_linear_time() {
        let rows = |frames: usize| (0..frames * 50).map(|row| format!("{},{row}\n", row / 50)).collect::<String>();
        let seconds = |frames: usize| {
            let text = format!("time,id\n{}", rows(frames));
            let clock = std::time::Instant::now();
            assert_eq!(read(&text).unwrap().len(), frames);
            clock.elapsed().as_secs_f64()
        };
        let (few, many) = (seconds(1000), seconds(10_000));
        assert!(many < 40.0 * few.max(1e-3), "{few} s for 1,000 frames, {many} s for 10,000");
    }
}
