//! The files of a roofline: rows of points and roofs, figures, a page.

use super::figure::figure;
use super::study::Study;
use super::terminal::{sweeps, threads};
use crate::draw::figure::Figure;
use crate::draw::numbers::two_digits;
use crate::study::{Document, DocumentError, File, Table, cells, page, table};
use minijinja::context;

impl Document for Study {
    const NAME: &'static str = "roofline";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![table("points", &self.points)?, roof_rows(self).csv("roofs")?])
    }

    fn figures(&self) -> Vec<Figure> {
        self.roofs.iter().map(|roofs| figure(self, roofs)).collect()
    }

    fn page(&self, figures: &[Figure]) -> Result<String, minijinja::Error> {
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
        let others = context! {
            set => &self.instruction_set,
            processor => self.provenance.get("processor"),
            date => self.provenance.get("date"),
            pair => context! { total => self.pair.total(), of => self.pair },
            wall => context! { total => self.wall.total(), of => self.wall },
            roofs => roofs.collect::<Vec<_>>(),
            sweeps => sweeps(self).html(),
        };
        page(include_str!("page.html"), "Roofline of the contact sweep", figures, self.provenance.clone(), others)
    }
}

/// Roofs, one a row.
fn roof_rows(study: &Study) -> Table {
    let mut table = Table::named("threads instruction_set roof working_set_bytes unit rate");
    for roofs in &study.roofs {
        let mut push = |roof: &str, working_set: Option<usize>, unit: &str, rate: f64| {
            table.row(cells![roofs.threads, &study.instruction_set, roof, working_set, unit, rate]);
        };
        push("peak", None, "flop/s", roofs.peak_flops_per_second);
        for level in &roofs.levels {
            push(&level.name, Some(level.working_set_bytes), "byte/s", level.bytes_per_second);
        }
        let memory = roofs.levels.last().map(|level| level.working_set_bytes);
        push("triad", memory, "byte/s", roofs.triad_bytes_per_second);
        push("copy", memory, "byte/s", roofs.copy_bytes_per_second);
    }
    table
}
