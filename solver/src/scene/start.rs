//! Initial grains of a CSV file: a line with the names of the columns, then a line for each grain.

use super::document::{Checked, Document, DocumentPath};
use super::error::Fault;
use super::{GrainEntry, Scene};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// Names of the columns with numbers. Every file has the first four.
const COLUMNS: [&str; 10] = ["x", "y", "z", "radius", "vx", "vy", "vz", "wx", "wy", "wz"];

/// Grains of a file, such as a frame that `makadam export --format csv` writes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// CSV file, relative to the scene's file, with columns x, y, z, radius (m), optionally vx, vy, vz (m/s), wx, wy, wz (rad/s), material.
    pub file: String,
    /// Material, without a column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Text of the file, in scenes that Makadam writes.
    #[serde(default)]
    pub content: String,
    #[serde(skip)]
    grains: Parsed,
}

/// Grains of the content, parsed once.
#[derive(Clone, Debug, Default)]
struct Parsed(OnceLock<Arc<[GrainEntry]>>);

impl PartialEq for Parsed {
    /// Returns true: the content decides.
    fn eq(&self, _: &Parsed) -> bool {
        true
    }
}

impl Start {
    /// Returns the grains of the file, in the order of its lines.
    pub fn grains(&self) -> &[GrainEntry] {
        self.grains.0.get_or_init(|| self.parse().unwrap_or_default())
    }

    /// Makes a fault of a line, from 1.
    pub(super) fn at_line(&self, line: usize, problem: &str, remedy: &str) -> Fault {
        let at = DocumentPath::default().key("start").key("file");
        at.fault(format!("'{}' line {line}: {problem}", self.file), remedy)
    }

    /// Makes the fault of a grain, by its index, from that of one of its values.
    pub(super) fn of_grain(&self, index: usize, fault: &Fault) -> Fault {
        let (problem, remedy) = fault.in_words();
        self.at_line(index + 2, &problem, &remedy)
    }

    /// Reads the content.
    fn parse(&self) -> Result<Arc<[GrainEntry]>, Fault> {
        let mut lines = self
            .content
            .trim_start_matches('\u{feff}')
            .lines()
            .map(|line| line.split(',').map(str::trim).collect::<Vec<&str>>());
        let head = lines.next().unwrap_or_default();
        let place = |name: &str| head.iter().position(|own| *own == name);
        let is_known = |name: &str| name == "material" || COLUMNS.contains(&name);
        let wrong = (0..head.len()).find(|&own| !is_known(head[own]) || place(head[own]) != Some(own));
        let wrong = wrong.map(|own| format!("column '{}' is unknown or listed twice", head[own]));
        let missing = COLUMNS[..4].iter().find(|name| place(name).is_none());
        if let Some(problem) = wrong.or(missing.map(|name| format!("there is no column '{name}'"))) {
            let remedy = "give x, y, z, radius, and optionally vx, vy, vz, wx, wy, wz, material, each once";
            return Err(self.at_line(1, &problem, remedy));
        }
        let (of_material, places) = (place("material"), COLUMNS.map(place));
        if of_material.is_some() == self.material.is_some() {
            return Err(self.at_line(1, "column 'material' or start.material names materials", "give one of them"));
        }
        let mut grains = Vec::new();
        for (line, cells) in (2..).zip(lines) {
            if cells.len() != head.len() {
                let problem = format!("{} values, and line 1 names {} columns", cells.len(), head.len());
                return Err(self.at_line(line, &problem, "give one value for each column, and no empty lines"));
            }
            let mut values = [0.0; COLUMNS.len()];
            for ((value, name), place) in values.iter_mut().zip(COLUMNS).zip(places) {
                let Some(cell) = place.map(|place| cells[place]) else { continue };
                *value = cell.parse().map_err(|_| {
                    let problem = format!("column {name}: '{cell}' is not a number");
                    self.at_line(line, &problem, "give a number in SI units, such as 0.005")
                })?;
            }
            let [x, y, z, radius, vx, vy, vz, wx, wy, wz] = values;
            let material = of_material.map(|place| cells[place]).or(self.material.as_deref()).unwrap_or_default();
            let (position, velocity, spin) = ([x, y, z], [vx, vy, vz], [wx, wy, wz]);
            grains.push(GrainEntry { material: material.into(), radius, position, velocity, spin });
        }
        Ok(grains.into())
    }
}

impl Scene {
    /// Returns the listed grains: those of the scene, then those of its start file.
    pub fn listed(&self) -> impl Iterator<Item = &GrainEntry> {
        self.grain.iter().chain(self.start.iter().flat_map(Start::grains))
    }

    /// Reads the grains of the start, from its file unless the scene holds the content.
    pub(super) fn read_start(&mut self, document: &Document<'_>) -> Checked {
        let Some(start) = &mut self.start else { return Ok(()) };
        if start.content.is_empty() {
            let at = DocumentPath::default().key("start").key("file");
            let (path, bytes) = document.file(&start.file, "a CSV", &at)?;
            let no_text = |error| at.fault(format!("'{path}' cannot be read: {error}"), "save it as text in UTF-8");
            start.content = String::from_utf8(bytes).map_err(no_text)?;
        }
        start.grains = Parsed(OnceLock::from(start.parse()?));
        Ok(())
    }
}
