//! Report and tables of a study of parameters.

use super::{Failed, Point, Study};
use makadam_compare::study::{Answer, Document, DocumentError, File, Report, Section, Table, cells};
use makadam_frames::provenance::facts;
use makadam_view::draw::numbers::{plural, significant, with_error};

/// Largest number of observables side by side on a terminal.
const MOST_COLUMNS: usize = 6;

impl Document for Study {
    const NAME: &'static str = "sweep";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![self.point_rows().csv("points")?, self.run_rows().csv("runs")?])
    }

    fn report(&self) -> Report {
        let failed =
            |Failed { values, seed, problem }: &Failed| format!("{}, seed {seed}: {problem}", values.join(", "));
        Report {
            kind: "Makadam, a scene over values of its keys",
            title: format!("Sweep of {}", self.scene),
            facts: facts(&self.provenance),
            answer: Answer::of(
                self.failed.is_empty(),
                format!("{}.", plural(self.points.len(), "combination")),
                format!("{} failed.", plural(self.failed.len(), "run")),
            ),
            findings: Vec::new(),
            sections: vec![Section::new("Means and standard deviations over seeds", "", self.means())],
            notes: self.failed.iter().map(failed).collect(),
            limits: vec!["Means are over the seeds that have a value.".into()],
            provenance: self.provenance.clone().into_iter().collect(),
            files: "sweep.json, points.csv and runs.csv",
        }
    }
}

impl Study {
    /// Means over seeds with standard deviations: a row per combination or, for many observables, a row per observable.
    fn means(&self) -> Table {
        let names: Vec<&str> = self
            .observables()
            .filter(|name| self.shown.is_empty() || self.shown.iter().any(|one| one == name))
            .collect();
        let shown = |point: &Point, name: &str| {
            point.observables.get(name).map(|mean| match mean.seeds {
                1 => significant(mean.mean),
                _ => with_error(mean.mean, mean.standard_deviation),
            })
        };
        if names.len() > MOST_COLUMNS {
            let heads = self.points.iter().map(|point| point.values.join(", "));
            return Table::new(&[&self.keys.join(", ")], &[]).with_numbers(heads).of(names, |name| {
                let values = self.points.iter().map(|point| shown(point, name).into());
                [self.head(name).into()].into_iter().chain(values).collect()
            });
        }
        let heads = names.iter().map(|name| self.head(name));
        Table::new(&self.key_heads(), &[]).with_numbers(heads).of(&self.points, |point| {
            let values = point.values.iter().map(|value| value.as_str().into());
            values.chain(names.iter().map(|name| shown(point, name).into())).collect()
        })
    }

    /// Rows by combination at full precision: keys, seeds, then mean, standard deviation and seeds with a value of each observable.
    fn point_rows(&self) -> Table {
        let columns = self
            .observables()
            .flat_map(|name| [name.to_string(), format!("{name}_standard_deviation"), format!("{name}_seeds")]);
        Table::new(&self.key_heads(), &["seeds"]).with_numbers(columns).of(&self.points, |point| {
            let values = point.values.iter().map(|value| value.as_str().into());
            let means = self.observables().flat_map(|name| match point.observables.get(name) {
                Some(mean) if mean.seeds > 1 => cells![mean.mean, mean.standard_deviation, mean.seeds],
                Some(mean) => cells![mean.mean, None::<f64>, mean.seeds],
                None => cells![None::<f64>, None::<f64>, 0_usize],
            });
            values.chain(cells![point.runs.len()]).chain(means).collect()
        })
    }

    /// Rows by run: keys, seed, wall time, and each observable with its standard error.
    fn run_rows(&self) -> Table {
        let columns = self.observables().flat_map(|name| [name.to_string(), format!("{name}_standard_error")]);
        let runs = self.points.iter().flat_map(|point| point.runs.iter().map(move |run| (point, run)));
        Table::new(&self.key_heads(), &["seed", "wall_seconds"]).with_numbers(columns).of(runs, |(point, run)| {
            let values = point.values.iter().map(|value| value.as_str().into());
            let measured = self.observables().flat_map(|name| {
                let found = run.measurements.iter().find(|one| one.observable == *name);
                cells![found.map(|one| one.value), found.and_then(|one| one.standard_error)]
            });
            values.chain(cells![run.seed, run.wall_seconds]).chain(measured).collect()
        })
    }

    fn key_heads(&self) -> Vec<&str> {
        self.keys.iter().map(String::as_str).collect()
    }

    fn observables(&self) -> impl Iterator<Item = &str> {
        self.units.keys().map(String::as_str)
    }

    fn head(&self, name: &str) -> String {
        match self.units.get(name).filter(|unit| !unit.is_empty()) {
            Some(unit) => format!("{name} ({unit})"),
            None => name.into(),
        }
    }
}
