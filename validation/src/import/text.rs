//! Tables in text: CSV of any code, what YADE's `export.text` and `export.textExt` write, and YADE's legacy VTK files.

use super::frame_table::{FrameTable, ImportError};
use std::path::Path;

/// Frames of a table with names in its first row. Rows whose times differ are frames of their own, or else those whose steps differ.
///
/// # Errors
/// [`ImportError`] with the line.
pub(super) fn csv(file: &Path, bytes: &[u8]) -> Result<Vec<FrameTable>, ImportError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
    let heads = reader.headers().map_err(|error| ImportError::new(file, 1, error.to_string()))?.clone();
    let columns: Vec<String> = heads.iter().map(String::from).collect();
    if columns.iter().any(|name| name.parse::<f64>().is_ok()) {
        return Err(ImportError::new(file, 1, "the first row must name the columns, such as id,x,y,z,radius,vx,vy,vz"));
    }
    if columns.iter().filter(|name| is_time(name)).count() > 1 {
        return Err(ImportError::new(file, 1, "two columns tell the time; leave one of them"));
    }
    let (mut values, mut lines) = (Vec::new(), Vec::new());
    // The second byte of a line's end (\r\n) is taken with the next line, and not counted before.
    let ends = |position: &csv::Position| bytes.get(position.byte() as usize) == Some(&b'\n');
    let line_of = |position: Option<&csv::Position>| {
        position.map_or(1, |position| position.line() as usize + usize::from(ends(position)))
    };
    for record in reader.records() {
        let record = record.map_err(|error| ImportError::new(file, line_of(error.position()), error.to_string()))?;
        let line = line_of(record.position());
        for cell in &record {
            values.push(number(cell).map_err(|problem| ImportError::new(file, line, problem))?);
        }
        lines.push(line);
    }
    let table =
        FrameTable { file: file.into(), line: 2, time: None, step: None, columns, values, driven_walls: Vec::new() };
    by_frame(table, &lines)
}

/// Whether a column tells the time of its rows.
fn is_time(name: &str) -> bool {
    ["time", "t"].contains(&name.to_lowercase().as_str())
}

/// Whether a column tells the step of its rows.
fn is_step(name: &str) -> bool {
    ["step", "timestep"].contains(&name.to_lowercase().as_str())
}

/// One frame a value of the column of times, or else of that of steps, in the order in which they first come; the whole table, if it has
/// neither column.
fn by_frame(table: FrameTable, lines: &[usize]) -> Result<Vec<FrameTable>, ImportError> {
    let place = |is: fn(&str) -> bool| table.columns.iter().position(|name| is(name));
    let (of_times, of_steps) = (place(is_time), place(is_step));
    let Some(place) = of_times.or(of_steps) else {
        return Ok(vec![table]);
    };
    let mut frames: Vec<(f64, FrameTable)> = Vec::new();
    for (row, line) in table.rows().zip(lines) {
        let own = row[place];
        let known = frames.iter().rposition(|(known, _)| *known == own);
        let known = known.unwrap_or_else(|| {
            frames.push((own, FrameTable { line: *line, values: Vec::new(), ..table.clone() }));
            frames.len() - 1
        });
        frames[known].1.values.extend(row);
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
pub(super) fn yade(file: &Path, bytes: &[u8]) -> Result<Vec<FrameTable>, ImportError> {
    let text = String::from_utf8_lossy(bytes);
    let mut columns: Vec<String> = Vec::new();
    let (mut values, mut first) = (Vec::new(), 0);
    for (number_before, line) in text.lines().enumerate() {
        let at = number_before + 1;
        if let Some(comment) = line.trim_start().strip_prefix('#') {
            if let Some(format) = comment.trim().strip_prefix("format ") {
                if !values.is_empty() {
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
        if line.trim().is_empty() {
            continue;
        }
        if first == 0 {
            first = at;
        }
        let before = values.len();
        for word in line.split_whitespace() {
            values.push(number(word).map_err(|problem| ImportError::new(file, at, problem))?);
        }
        let found = values.len() - before;
        if columns.last().is_some_and(|last| last == "attrs") {
            columns.pop();
        }
        // Attributes without a comment have no names.
        while columns.len() < found && columns.len() >= 4 && first == at {
            columns.push(format!("unnamed{}", columns.len() + 1));
        }
        if found != columns.len() {
            let problem = format!("{found} numbers where {} belong ({})", columns.len(), columns.join(", "));
            return Err(ImportError::new(file, at, problem));
        }
    }
    Ok(vec![FrameTable {
        file: file.into(),
        line: first.max(1),
        time: None,
        step: None,
        columns,
        values,
        driven_walls: Vec::new(),
    }])
}

/// A legacy VTK file in ASCII, as YADE's `VTKExporter` and LIGGGHTS's `dump custom/vtk` write it: points, and numbers of points.
///
/// # Errors
/// [`ImportError`] with the line.
pub(super) fn legacy_vtk(file: &Path, bytes: &[u8]) -> Result<Vec<FrameTable>, ImportError> {
    let text = String::from_utf8_lossy(bytes);
    // What stands between METADATA and an empty line describes the array before.
    let mut describes = false;
    let is_data = |(_, text): &(usize, &str)| {
        describes = if text.trim() == "METADATA" { true } else { describes && !text.trim().is_empty() };
        !describes
    };
    let mut words = text
        .lines()
        .enumerate()
        // Before the third line there are words of whoever wrote it.
        .skip(2)
        .filter(is_data)
        .flat_map(|(line, text)| text.split_ascii_whitespace().map(move |word| (line + 1, word)))
        .peekable();
    let fault = |line: usize, problem: &str| ImportError::new(file, line, problem);
    match words.next() {
        Some((_, "ASCII")) => {}
        Some((line, _)) => {
            return Err(fault(line, "only legacy VTK files in ASCII are read; write XML (.vtu, .vtp) instead"));
        }
        None => return Err(fault(3, "the file ends here")),
    }
    let mut count = 0;
    let mut arrays: Vec<(Vec<String>, Vec<f64>)> = Vec::new();
    let (mut first, mut of_points) = (1, false);
    // Arrays of a field that are still to come.
    let mut in_field = 0;
    while let Some((line, word)) = words.next() {
        let mut next = |what: &str| words.next().ok_or_else(|| fault(line, &format!("{what} belongs behind {word}")));
        let (name, components) = match word {
            name if in_field > 0 => {
                in_field -= 1;
                let mut number = |what: &str| {
                    let (line, word) = next(what)?;
                    word.parse::<usize>().map_err(|_| fault(line, &format!("'{word}' is no {what}")))
                };
                let (components, tuples) = (number("number of components")?, number("number of rows")?);
                let kind = next("a type of numbers")?.1;
                if !of_points {
                    words.by_ref().take(components.saturating_mul(tuples)).for_each(drop);
                    continue;
                }
                if kind == "string" || tuples != count || components == 0 {
                    let problem = format!(
                        "{name} has {tuples} rows of {kind}, and there are {count} points; leave numbers, one row a point"
                    );
                    return Err(fault(line, &problem));
                }
                (name.to_string(), components)
            }
            "POINTS" => {
                count =
                    next("a number of points")?.1.parse::<usize>().map_err(|_| fault(line, "no number of points"))?;
                next("a type of numbers")?;
                first = line + 1;
                ("points".to_string(), 3)
            }
            "POINT_DATA" | "CELL_DATA" => {
                of_points = word == "POINT_DATA";
                let told = next("a number")?.1;
                if of_points && told.parse() != Ok(count) {
                    return Err(fault(line, &format!("data of {told} points, and there are {count}")));
                }
                continue;
            }
            "FIELD" => {
                next("a name")?;
                let (line, word) = next("a number of arrays")?;
                in_field = word.parse().map_err(|_| fault(line, "no number of arrays"))?;
                continue;
            }
            "SCALARS" => {
                let name = next("a name")?.1.to_string();
                next("a type of numbers")?;
                // A number of components may stand before the table of colours.
                let components = match words.next() {
                    Some((_, "LOOKUP_TABLE")) => 1,
                    Some((_, number)) => {
                        words.next();
                        number.parse::<usize>().ok().filter(|components| (1..=9).contains(components)).unwrap_or(1)
                    }
                    None => return Err(fault(line, "the file ends here")),
                };
                words.next();
                (name, components)
            }
            "VECTORS" | "NORMALS" => {
                let name = next("a name")?.1.to_string();
                next("a type of numbers")?;
                (name, 3)
            }
            _ => continue,
        };
        if !of_points && name != "points" {
            continue;
        }
        let wanted = count.checked_mul(components).filter(|wanted| *wanted <= bytes.len());
        let wanted = wanted.ok_or_else(|| fault(line, "more numbers than the file can hold"))?;
        let mut numbers = Vec::with_capacity(wanted);
        for _ in 0..wanted {
            let (line, word) =
                words.next().ok_or_else(|| fault(line, &format!("{name} ends before its last number")))?;
            numbers.push(number(word).map_err(|problem| fault(line, &problem))?);
        }
        arrays.push((component_names(&name, components), numbers));
    }
    if arrays.is_empty() {
        return Err(fault(1, "it holds no points"));
    }
    Ok(vec![join(file, first, count, arrays)])
}

/// Names of the columns that an array becomes.
pub(super) fn component_names(name: &str, components: usize) -> Vec<String> {
    match components {
        1 => vec![name.to_string()],
        _ => (0..components).map(|axis| format!("{name}_{axis}")).collect(),
    }
}

/// One table from arrays of as many tuples.
pub(super) fn join(file: &Path, line: usize, count: usize, arrays: Vec<(Vec<String>, Vec<f64>)>) -> FrameTable {
    let mut values = Vec::new();
    for tuple in 0..count {
        for (names, numbers) in &arrays {
            values.extend(&numbers[tuple * names.len()..(tuple + 1) * names.len()]);
        }
    }
    let columns = arrays.into_iter().flat_map(|(names, _)| names).collect();
    FrameTable { file: file.into(), line, time: None, step: None, columns, values, driven_walls: Vec::new() }
}

/// A finite number.
fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("'{word}' is not finite: the run has blown up")),
        Err(_) => Err(format!("'{word}' is not a number")),
    }
}
