//! A roofline as data, and its files.

use super::figure::figure;
use super::machine::Roofs;
use super::point::Point;
use super::terminal::{cells, threads};
use crate::draw::figure::Figure;
use crate::draw::numbers::two_digits;
use crate::draw::svg::standalone;
use crate::output::cells::csv;
use crate::output::{create_folder, write_whole};
use crate::report::ReportError;
use crate::report::page::{environment, style};
use makadam::sweep::Operations;
use minijinja::context;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Roofs and the sweeps beneath them, from one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Version of this layout.
    pub version: u32,
    /// Always "roofline".
    pub command: String,
    /// Instruction set of roofs and kernels.
    pub instruction_set: String,
    /// Operations of a contact of two grains.
    pub pair: Operations,
    /// Operations of a contact with a wall.
    pub wall: Operations,
    /// By number of threads.
    pub roofs: Vec<Roofs>,
    /// Measured sweeps.
    pub points: Vec<Point>,
    /// Where they came from.
    pub provenance: BTreeMap<String, String>,
}

/// A roof as a row of `roofs.csv`.
#[derive(Serialize)]
struct RoofRow<'a> {
    threads: usize,
    instruction_set: &'a str,
    roof: &'a str,
    working_set_bytes: Option<usize>,
    unit: &'static str,
    rate: f64,
}

impl Study {
    /// Writes `roofline.html` with its figures, `points.csv`, `roofs.csv` and `roofline.json` into a folder, which is made
    /// if it is not there; returns the page's path.
    ///
    /// # Errors
    /// [`ReportError`] if a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ReportError> {
        create_folder(folder)?;
        write_whole(&folder.join("points.csv"), &csv(&self.points)?)?;
        write_whole(&folder.join("roofs.csv"), &csv(&self.roof_rows())?)?;
        write_whole(&folder.join("roofline.json"), &serde_json::to_vec_pretty(self)?)?;
        let figures: Vec<Figure> = self.roofs.iter().map(|roofs| figure(self, roofs)).collect();
        for figure in &figures {
            write_whole(&folder.join(format!("{}.svg", figure.name)), standalone(&figure.svg).as_bytes())?;
        }
        let page = folder.join("roofline.html");
        write_whole(&page, self.render(&figures)?.as_bytes())?;
        Ok(page)
    }

    fn roof_rows(&self) -> Vec<RoofRow<'_>> {
        let mut rows = Vec::new();
        for roofs in &self.roofs {
            let mut push = |roof, working_set_bytes, unit, rate| {
                let (threads, instruction_set) = (roofs.threads, self.instruction_set.as_str());
                rows.push(RoofRow { threads, instruction_set, roof, working_set_bytes, unit, rate });
            };
            push("peak", None, "flop/s", roofs.peak_flops_per_second);
            for level in &roofs.levels {
                push(&level.name, Some(level.working_set_bytes), "byte/s", level.bytes_per_second);
            }
            let memory = roofs.levels.last().map(|level| level.working_set_bytes);
            push("triad", memory, "byte/s", roofs.triad_bytes_per_second);
            push("copy", memory, "byte/s", roofs.copy_bytes_per_second);
        }
        rows
    }

    fn render(&self, figures: &[Figure]) -> Result<String, minijinja::Error> {
        let mut environment = environment()?;
        environment.add_template("page", include_str!("page.html"))?;
        let roofs = self.roofs.iter().map(|roofs| {
            let levels =
                roofs.levels.iter().map(|level| (level.name.clone(), two_digits(level.bytes_per_second / 1e9)));
            context! {
                threads => threads(roofs.threads),
                peak => two_digits(roofs.peak_flops_per_second / 1e9),
                levels => levels.collect::<Vec<_>>(),
                triad => two_digits(roofs.triad_bytes_per_second / 1e9),
                copy => two_digits(roofs.copy_bytes_per_second / 1e9),
            }
        });
        let provenance = self.provenance.iter().map(|(key, value)| (key.replace('_', " "), value));
        environment.get_template("page")?.render(context! {
            style => style(),
            set => &self.instruction_set,
            processor => self.provenance.get("processor"),
            date => self.provenance.get("date"),
            pair => context! { total => self.pair.total(), of => self.pair },
            wall => context! { total => self.wall.total(), of => self.wall },
            roofs => roofs.collect::<Vec<_>>(),
            figures => figures,
            points => self.points.iter().map(|point| cells(self, point)).collect::<Vec<_>>(),
            provenance => provenance.collect::<Vec<_>>(),
        })
    }
}
