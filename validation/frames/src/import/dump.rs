//! Dumps of LIGGGHTS and LAMMPS: header lines before each frame, then rows of cells. Not always valid UTF-8.

use super::columns::{StatedColumns, column_of, number};
use super::table::{FrameTable, ImportError, Periods};
use std::path::Path;
use std::str::Lines;

/// Reads all frames of a dump, with one cell per row for each name in its head.
///
/// # Errors
/// [`ImportError`] for an incomplete dump, and for a cell with a meaning and without a finite number.
pub(super) fn dump(file: &Path, text: &str, stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let mut reader = Reader { file, lines: text.lines(), number: 0, text: "" };
    let mut frames = Vec::new();
    while let Some((mut table, count)) = reader.head(stated)? {
        for _ in 0..count {
            reader.next()?;
            table.add_row(reader.number, &reader.text.split_ascii_whitespace().collect::<Vec<_>>())?;
        }
        frames.push(table);
    }
    Ok(frames)
}

/// Returns the names of the columns of a dump, by the rules of its codes. After `c_`, `f_` and `v_` follows the name of a compute, a fix
/// or a variable in a deck: `v_x` is not a velocity. A name listed twice (`id type type x` in tutorials of LIGGGHTS) is the same property.
fn of_code(names: &[&str]) -> Vec<String> {
    let is_given = |name: &str| ["c_", "f_", "v_"].iter().any(|prefix| name.starts_with(prefix));
    let name = |place: usize| match names[place] {
        name if is_given(name) && column_of(name).is_some() => format!("{name} (of the deck)"),
        name if names[..place].contains(&name) => format!("{name} (again)"),
        name => name.into(),
    };
    (0..names.len()).map(name).collect()
}

struct Reader<'a> {
    file: &'a Path,
    /// Lines after the present one.
    lines: Lines<'a>,
    /// Number of the present line, from 1.
    number: usize,
    text: &'a str,
}

impl Reader<'_> {
    /// Reads the head of the next frame: its table without rows, and their number; `None` at the end of the file.
    fn head(&mut self, stated: &StatedColumns) -> Result<Option<(FrameTable, u64)>, ImportError> {
        if !self.advance() {
            return Ok(None);
        }
        let mut time = None;
        while !self.text.starts_with("ITEM: TIMESTEP") {
            // LAMMPS can state units and time first.
            match self.text.trim_end() {
                "ITEM: UNITS" => self.units()?,
                "ITEM: TIME" => {
                    self.next()?;
                    time = Some(number(self.text.trim()).map_err(|problem| self.fault(problem))?);
                }
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
        let names: Vec<&str> = self.text.split_ascii_whitespace().skip(2).collect();
        let table = stated.table(self.file, self.number, of_code(&names))?;
        Ok(Some((FrameTable { line: self.number + 1, time, step: Some(step), periods, ..table }, count)))
    }

    /// Reads the bounds of the box: lengths along the periodic axes, if the head names boundaries (`pp ff ff`).
    fn periods(&mut self) -> Result<Option<Periods>, ImportError> {
        let words: Vec<&str> = self.text["ITEM: BOX BOUNDS".len()..].split_ascii_whitespace().collect();
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
                _ => return Err(self.fault("the bounds of the box belong here")),
            };
            if is_tilted {
                let problem =
                    "the box is tilted, and the domain of a scene has right angles; run the code in such a box";
                return Err(self.fault(problem));
            }
            if flags.len() == 3 && flags[axis] == "pp" {
                periods.lengths[axis] = high - low;
                // LIGGGHTS writes six digits.
                periods.rounding = periods.rounding.max(1e-5 * low.abs().max(high.abs()));
            }
        }
        Ok((flags.len() == 3).then_some(periods))
    }

    /// Reads the next line; returns false at the end of the file.
    fn advance(&mut self) -> bool {
        self.number += 1;
        let line = self.lines.next();
        self.text = line.unwrap_or_default();
        line.is_some()
    }

    fn next(&mut self) -> Result<(), ImportError> {
        match self.advance() {
            true => Ok(()),
            false => Err(self.fault("the file ends in the middle of a frame")),
        }
    }

    fn expect(&self, start: &str) -> Result<(), ImportError> {
        match self.text.starts_with(start) {
            true => Ok(()),
            false => Err(self.fault(format!("'{start}' belongs here"))),
        }
    }

    /// Reads the units of the dump: numbers in other units than SI would count as metres, seconds and newtons.
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
        self.text.trim().parse().map_err(|_| self.fault("a count belongs here"))
    }

    fn fault(&self, problem: impl Into<String>) -> ImportError {
        ImportError::new(self.file, self.number, problem)
    }
}
