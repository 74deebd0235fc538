//! Dumps of LIGGGHTS and LAMMPS: header lines before each frame, then rows of numbers. Not always valid UTF-8.

use std::io::BufRead;

/// One frame of a dump.
#[derive(Clone, Debug, PartialEq)]
pub struct DumpFrame {
    /// Number of the time step.
    pub step: u64,
    /// Simulated time, s, where the dump tells it (`dump_modify time yes` of LAMMPS).
    pub time: Option<f64>,
    /// Names of the columns as the dump gives them; computed ones such as `c_pairs[1]` say nothing of what they are.
    pub names: Vec<String>,
    /// Line of its first row in the file, from 1.
    pub line: usize,
    columns: usize,
    values: Vec<f64>,
}

impl DumpFrame {
    /// The numbers of its rows, one row after the other.
    pub(super) fn into_values(self) -> Vec<f64> {
        self.values
    }

    /// Its rows.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.max(1))
    }
}

/// Where and why a dump cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub struct DumpFault {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong.
    pub problem: String,
}

/// Reads every frame of a dump of which each row has `columns` numbers.
///
/// # Errors
/// [`DumpFault`] for anything that is not a whole dump of finite numbers.
pub fn read_dump(reader: impl BufRead, columns: usize) -> Result<Vec<DumpFrame>, DumpFault> {
    frames_of(reader, Some(columns.max(1)))
}

/// Reads every frame of a dump, with as many numbers a row as its head has names.
///
/// # Errors
/// As [`read_dump`].
pub fn read_named_dump(reader: impl BufRead) -> Result<Vec<DumpFrame>, DumpFault> {
    frames_of(reader, None)
}

fn frames_of(reader: impl BufRead, columns: Option<usize>) -> Result<Vec<DumpFrame>, DumpFault> {
    let mut lines = Lines { reader, number: 0, text: String::new(), bytes: Vec::new() };
    let mut frames = Vec::new();
    while lines.advance()? {
        let mut time = None;
        while !lines.text.starts_with("ITEM: TIMESTEP") {
            // LAMMPS can say units and time before.
            match lines.text.trim_end() {
                "ITEM: UNITS" => lines.units()?,
                "ITEM: TIME" => time = Some(lines.number()?),
                _ => lines.expect("ITEM: TIMESTEP")?,
            }
            lines.next()?;
        }
        let step = lines.integer()?;
        lines.next()?;
        lines.expect("ITEM: NUMBER OF ")?;
        let count = lines.integer()?;
        lines.next()?;
        lines.expect("ITEM: BOX BOUNDS")?;
        for _ in 0..3 {
            lines.next()?;
        }
        lines.next()?;
        lines.expect("ITEM: ")?;
        // "ITEM: ATOMS id x y z" or "ITEM: ENTRIES c_pairs[1] ...".
        let names: Vec<String> = lines.text.split_ascii_whitespace().skip(2).map(String::from).collect();
        let columns = columns.unwrap_or(names.len());
        let line = lines.number + 1;
        let mut values = Vec::new();
        for _ in 0..count {
            lines.next()?;
            let before = values.len();
            for word in lines.text.split_ascii_whitespace() {
                match word.parse::<f64>() {
                    Ok(value) if value.is_finite() => values.push(value),
                    Ok(_) => return Err(lines.fault(format!("'{word}' is not finite: the run has blown up"))),
                    Err(_) => return Err(lines.fault(format!("'{word}' is not a number"))),
                }
            }
            if values.len() - before != columns {
                return Err(lines.fault(format!("{} numbers where {columns} belong", values.len() - before)));
            }
        }
        frames.push(DumpFrame { step, time, names, line, columns, values });
    }
    Ok(frames)
}

struct Lines<R> {
    reader: R,
    number: usize,
    text: String,
    bytes: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    /// Reads the next line; false at the end of the file.
    fn advance(&mut self) -> Result<bool, DumpFault> {
        self.bytes.clear();
        self.number += 1;
        match self.reader.read_until(b'\n', &mut self.bytes) {
            Ok(0) => Ok(false),
            Ok(_) => {
                self.text.clear();
                self.text.push_str(&String::from_utf8_lossy(&self.bytes));
                Ok(true)
            }
            Err(error) => Err(self.fault(error.to_string())),
        }
    }

    fn next(&mut self) -> Result<(), DumpFault> {
        match self.advance()? {
            true => Ok(()),
            false => Err(self.fault("the file ends in the middle of a frame".into())),
        }
    }

    fn expect(&self, start: &str) -> Result<(), DumpFault> {
        match self.text.starts_with(start) {
            true => Ok(()),
            false => Err(self.fault(format!("'{start}' belongs here"))),
        }
    }

    fn number(&mut self) -> Result<f64, DumpFault> {
        self.next()?;
        let number = self.text.trim().parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.fault("a number belongs here".into()))
    }

    /// The units of the dump: numbers of others than SI would be taken for metres, seconds and newtons.
    fn units(&mut self) -> Result<(), DumpFault> {
        self.next()?;
        match self.text.trim() {
            "si" => Ok(()),
            other => {
                let problem = format!("the dump is in units '{other}'; write the dump in SI units ('units si')");
                Err(self.fault(problem))
            }
        }
    }

    fn integer(&mut self) -> Result<u64, DumpFault> {
        self.next()?;
        self.text.trim().parse().map_err(|_| self.fault("a count belongs here".into()))
    }

    fn fault(&self, problem: String) -> DumpFault {
        DumpFault { line: self.number, problem }
    }
}
