//! A study of parameters as tables.

use super::{Point, Study};
use crate::draw::numbers::{significant, with_error};
use crate::study::{Table, cells};

/// Observables that fit beside each other on a terminal.
const MOST_COLUMNS: usize = 6;

impl Study {
    /// Means over seeds with standard deviations: a line per combination, or, of many observables, a line per observable.
    pub fn text(&self, wanted: &[String]) -> String {
        let names: Vec<&str> = self
            .observables()
            .into_iter()
            .filter(|name| wanted.is_empty() || wanted.iter().any(|one| one == name))
            .collect();
        let shown = |point: &Point, name: &str| {
            point.observables.get(name).map(|mean| match mean.seeds {
                1 => significant(mean.mean),
                _ => with_error(mean.mean, mean.standard_deviation),
            })
        };
        if names.len() > MOST_COLUMNS {
            let heads = self.points.iter().map(|point| point.values.join(", "));
            let keys = self.keys.join(", ");
            let table = Table::new(&[&keys], &[]).with_numbers(heads).of(names, |name| {
                let values = self.points.iter().map(|point| shown(point, name).into());
                [self.head(name).into()].into_iter().chain(values).collect()
            });
            return table.text();
        }
        let keys: Vec<&str> = self.keys.iter().map(String::as_str).collect();
        let table = Table::new(&keys, &[]).with_numbers(names.iter().map(|name| self.head(name)));
        let table = table.of(&self.points, |point: &Point| {
            let values = point.values.iter().map(|value| value.as_str().into());
            values.chain(names.iter().map(|name| shown(point, name).into())).collect()
        });
        table.text()
    }

    /// The same at full precision, as CSV: keys, seeds, then mean, standard deviation and seeds with a value of each observable.
    pub fn points_csv(&self) -> Vec<u8> {
        let names = self.observables();
        let columns = names
            .iter()
            .flat_map(|name| [(*name).to_string(), format!("{name}_standard_deviation"), format!("{name}_seeds")]);
        let keys: Vec<&str> = self.keys.iter().map(String::as_str).collect();
        let table = Table::new(&keys, &["seeds"]).with_numbers(columns).of(&self.points, |point: &Point| {
            let values = point.values.iter().map(|value| value.as_str().into());
            let means = names.iter().flat_map(|name| match point.observables.get(*name) {
                Some(mean) if mean.seeds > 1 => cells![mean.mean, mean.standard_deviation, mean.seeds],
                Some(mean) => cells![mean.mean, None::<f64>, mean.seeds],
                None => cells![None::<f64>, None::<f64>, 0_usize],
            });
            values.chain(cells![point.runs.len()]).chain(means).collect()
        });
        bytes(table)
    }

    /// One line a run: keys, seed, wall time, and each observable with its standard error.
    pub fn runs_csv(&self) -> Vec<u8> {
        let names = self.observables();
        let columns = names.iter().flat_map(|name| [(*name).to_string(), format!("{name}_standard_error")]);
        let keys: Vec<&str> = self.keys.iter().map(String::as_str).collect();
        let runs = self.points.iter().flat_map(|point| point.runs.iter().map(move |run| (point, run)));
        let table = Table::new(&keys, &["seed", "wall_seconds"]).with_numbers(columns).of(runs, |(point, run)| {
            let values = point.values.iter().map(|value| value.as_str().into());
            let measured = names.iter().flat_map(|name| {
                let found = run.measurements.iter().find(|one| one.observable == **name);
                cells![found.map(|one| one.value), found.and_then(|one| one.standard_error)]
            });
            values.chain(cells![run.seed, run.wall_seconds]).chain(measured).collect()
        });
        bytes(table)
    }

    fn observables(&self) -> Vec<&str> {
        self.units.keys().map(String::as_str).collect()
    }

    fn head(&self, name: &str) -> String {
        match self.units.get(name).filter(|unit| !unit.is_empty()) {
            Some(unit) => format!("{name} ({unit})"),
            None => name.into(),
        }
    }
}

fn bytes(table: Table) -> Vec<u8> {
    table.csv("table").expect("cells are numbers and plain text").1
}
