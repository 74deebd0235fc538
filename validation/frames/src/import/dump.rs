//! Dumps of LIGGGHTS and LAMMPS: header lines before each frame, then rows of cells. Not always valid UTF-8.

use super::columns::{StatedColumns, column_of, number};
use super::table::{FrameTable, ImportError, Periods};
use std::path::Path;

/// Reads every frame of a dump, with as many cells per row as its head has names.
///
/// # Errors
/// [`ImportError`] for anything that is not a whole dump, and for a cell that has a meaning and is not a finite number.
pub(super) fn dump(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let mut lines = Lines { file, bytes, number: 0, text: String::new() };
    let mut frames = Vec::new();
    while let Some(Header { step, time, count, periods, names }) = lines.header()? {
        let heads = stated.heads(file, lines.number, of_code(names))?;
        let line = lines.number + 1;
        let mut table = FrameTable { line, time, step: Some(step), periods, ..heads.table(file) };
        for _ in 0..count {
            lines.next()?;
            let cells: Vec<&str> = lines.text.split_ascii_whitespace().collect();
            if cells.len() != heads.count() {
                return Err(lines.fault(format!("{} numbers where {} belong", cells.len(), heads.count())));
            }
            heads.add_row(&mut table, &cells).map_err(|problem| lines.fault(problem))?;
        }
        frames.push(table);
    }
    Ok(frames)
}

/// Names of the columns of a dump, by the rules of its codes. After `c_`, `f_` and `v_` stands the name that a deck gives a compute, a fix
/// or a variable: `v_x` is no velocity. A name that is listed again (`id type type x` in tutorials of LIGGGHTS) is the same property.
fn of_code(names: Vec<String>) -> Vec<String> {
    let is_given = |name: &String| ["c_", "f_", "v_"].iter().any(|prefix| name.starts_with(prefix));
    let name = |place: usize| match &names[place] {
        name if is_given(name) && column_of(name).is_some() => format!("{name} (of the deck)"),
        name if names[..place].contains(name) => format!("{name} (again)"),
        name => name.clone(),
    };
    (0..names.len()).map(name).collect()
}

/// Head of a frame.
struct Header {
    step: u64,
    time: Option<f64>,
    count: u64,
    periods: Option<Periods>,
    names: Vec<String>,
}

struct Lines<'a> {
    file: &'a Path,
    /// Bytes behind the line.
    bytes: &'a [u8],
    /// Number of the line, from 1.
    number: usize,
    text: String,
}

impl Lines<'_> {
    /// Reads the head of the next frame; none at the end of the file.
    fn header(&mut self) -> Result<Option<Header>, ImportError> {
        if !self.advance() {
            return Ok(None);
        }
        let mut time = None;
        while !self.text.starts_with("ITEM: TIMESTEP") {
            // LAMMPS can state units and time before.
            match self.text.trim_end() {
                "ITEM: UNITS" => self.units()?,
                "ITEM: TIME" => time = Some(self.real()?),
                _ => self.expect("ITEM: TIMESTEP")?,
            }
            self.next()?;
        }
        let step = self.integer()?;
        self.next()?;
        self.expect("ITEM: NUMBER OF ")?;
        let count = self.integer()?;
        self.next()?;
        self.expect("ITEM: BOX BOUNDS")?;
        let periods = self.periods()?;
        self.next()?;
        self.expect("ITEM: ")?;
        // "ITEM: ATOMS id x y z" or "ITEM: ENTRIES c_pairs[1] ...".
        let names = self.text.split_ascii_whitespace().skip(2).map(String::from).collect();
        Ok(Some(Header { step, time, count, periods, names }))
    }

    /// Reads the bounds of the box: lengths along the periodic axes, where the head names boundaries (`pp ff ff`).
    fn periods(&mut self) -> Result<Option<Periods>, ImportError> {
        let head = self.text["ITEM: BOX BOUNDS".len()..].to_string();
        let words: Vec<&str> = head.split_ascii_whitespace().collect();
        let is_boundary = |word: &&&str| word.len() == 2 && word.bytes().all(|letter| b"pfsm".contains(&letter));
        let flags: Vec<&str> = words.iter().filter(is_boundary).copied().collect();
        // Bounds, bounds with a tilt, or an edge vector with its part of the origin.
        let (has_tilts, has_edges) = (words.contains(&"xy"), words.contains(&"abc"));
        let mut periods = Periods::default();
        for axis in 0..3 {
            self.next()?;
            let numbers: Result<Vec<f64>, _> = self.text.split_ascii_whitespace().map(number).collect();
            let numbers = numbers.map_err(|problem| self.fault(problem))?;
            let (low, high, is_tilted) = match numbers[..] {
                [low, high] if !has_tilts && !has_edges => (low, high, false),
                [low, high, tilt] if has_tilts => (low, high, tilt != 0.0),
                [x, y, z, origin] if has_edges => {
                    let length = [x, y, z][axis];
                    (origin, origin + length, x.abs() + y.abs() + z.abs() > length)
                }
                _ => return Err(self.fault("the bounds of the box belong here".into())),
            };
            if is_tilted {
                let problem =
                    "the box is tilted, and the domain of a scene has right angles; run the code in such a box";
                return Err(self.fault(problem.into()));
            }
            if flags.len() == 3 && flags[axis] == "pp" {
                periods.lengths[axis] = high - low;
                // LIGGGHTS writes six digits.
                periods.rounding = periods.rounding.max(1e-5 * low.abs().max(high.abs()));
            }
        }
        Ok((flags.len() == 3).then_some(periods))
    }

    /// Reads the next line; false at the end of the file.
    fn advance(&mut self) -> bool {
        self.number += 1;
        let end = self.bytes.iter().position(|byte| *byte == b'\n').map_or(self.bytes.len(), |end| end + 1);
        let (line, rest) = self.bytes.split_at(end);
        self.text.clear();
        self.text.push_str(&String::from_utf8_lossy(line));
        self.bytes = rest;
        !line.is_empty()
    }

    fn next(&mut self) -> Result<(), ImportError> {
        match self.advance() {
            true => Ok(()),
            false => Err(self.fault("the file ends in the middle of a frame".into())),
        }
    }

    fn expect(&self, start: &str) -> Result<(), ImportError> {
        match self.text.starts_with(start) {
            true => Ok(()),
            false => Err(self.fault(format!("'{start}' belongs here"))),
        }
    }

    fn real(&mut self) -> Result<f64, ImportError> {
        self.next()?;
        number(self.text.trim()).map_err(|problem| self.fault(problem))
    }

    /// Reads the units of the dump: numbers in others than SI would be taken for metres, seconds and newtons.
    fn units(&mut self) -> Result<(), ImportError> {
        self.next()?;
        match self.text.trim() {
            "si" => Ok(()),
            other => {
                let problem = format!("the dump is in units '{other}'; write the dump in SI units ('units si')");
                Err(self.fault(problem))
            }
        }
    }

    fn integer(&mut self) -> Result<u64, ImportError> {
        self.next()?;
        self.text.trim().parse().map_err(|_| self.fault("a count belongs here".into()))
    }

    fn fault(&self, problem: String) -> ImportError {
        ImportError::new(self.file, self.number, problem)
    }
}
