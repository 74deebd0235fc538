//! Report and tables of a study of parameters.

use super::{Failed, Point, Study, run_name};
use makadam_compare::study::{Answer, Cell, Document, DocumentError, File, Report, Section, Table, cells};
use makadam_frames::provenance::facts;
use makadam_frames::recording::Noticed;
use makadam_view::draw::numbers::{plural, significant, with_error};
use std::collections::BTreeMap;

/// Largest number of observables side by side on a terminal.
const MOST_COLUMNS: usize = 6;

/// Returns true if a watchdog objected to a run of the combination.
fn is_doubtful(point: &Point) -> bool {
    point.runs.iter().any(|run| !run.alarms.is_empty())
}

impl Document for Study {
    const NAME: &'static str = "sweep";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![self.point_rows().csv("points")?, self.run_rows().csv("runs")?])
    }

    fn report(&self) -> Report {
        let failed = |Failed { values, seed, problem }: &Failed| format!("{}: {problem}", run_name(values, *seed));
        let title = match self.keys.is_empty() {
            true => "Means over seeds, with the 90% interval of the mean",
            false => "Means ± standard deviations over seeds (runs with a value)",
        };
        Report {
            kind: "Makadam, a scene over seeds and values of its keys",
            title: format!("Sweep of {}", self.scene),
            facts: facts(&self.provenance),
            answer: Answer::of(
                self.failed.is_empty(),
                format!("{}.", plural(self.points.len(), "combination")),
                format!("{} failed.", plural(self.failed.len(), "run")),
            ),
            findings: Vec::new(),
            sections: vec![Section::new(title, "", if self.keys.is_empty() { self.one() } else { self.means() })],
            notes: self.failed.iter().map(failed).chain(self.doubts()).collect(),
            limits: vec![
                "Means are over the seeds that have a value. Bold, or with a star: some of these runs are not sound."
                    .into(),
            ],
            provenance: self.provenance.clone().into_iter().collect(),
            files: "sweep.json, points.csv and runs.csv",
        }
    }
}

impl Study {
    fn shows(&self, name: &str) -> bool {
        self.shown.is_empty() || self.shown.iter().any(|one| one == name)
    }

    /// Sentences on runs that are not sound, and on shown observables without a value, each with the reason in the first such run.
    fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        for point in &self.points {
            for run in point.runs.iter().filter(|run| !run.alarms.is_empty()) {
                let words: Vec<String> = run.alarms.iter().map(Noticed::words).collect();
                doubts.push(format!("* {}: {}", run_name(&point.values, run.seed), words.join("; ")));
            }
            let mut reasons: BTreeMap<(u64, &str), Vec<&str>> = BTreeMap::new();
            let mut known = Vec::new();
            for run in &point.runs {
                for (name, why) in run.without_value.iter().filter(|(name, _)| self.shows(name)) {
                    if !known.contains(&name) {
                        known.push(name);
                        reasons.entry((run.seed, why)).or_default().push(name);
                    }
                }
            }
            for ((seed, why), names) in reasons {
                doubts.push(format!("{}: {}: no value: {why}", run_name(&point.values, seed), names.join(", ")));
            }
        }
        doubts
    }

    /// Table of the scene itself: a row per observable.
    fn one(&self) -> Table {
        let names = self.observables().filter(|name| self.shows(name));
        let table = Table::new(&["observable"], &["runs", "mean", "standard deviation", "from", "to"]);
        table.of(names, |name| {
            let mean = self.points[0].observables.get(name);
            let several = mean.filter(|mean| mean.seeds > 1);
            let interval = |end: usize| mean.and_then(|mean| mean.interval90()).map(|ends| significant(ends[end]));
            let head = Cell::from(self.head(name)).strong(is_doubtful(&self.points[0]));
            let deviation = several.map(|mean| significant(mean.standard_deviation));
            [head]
                .into_iter()
                .chain(cells![
                    mean.map_or(0, |mean| mean.seeds),
                    mean.map(|mean| significant(mean.mean)),
                    deviation,
                    interval(0),
                    interval(1)
                ])
                .collect()
        })
    }

    /// Means over seeds with standard deviations: a row per combination or, for many observables, a row per observable.
    fn means(&self) -> Table {
        let names: Vec<&str> = self.observables().filter(|name| self.shows(name)).collect();
        let shown = |point: &Point, name: &str| {
            let text = point.observables.get(name).map(|mean| match mean.seeds {
                1 => format!("{} (1)", significant(mean.mean)),
                seeds => format!("{} ({seeds})", with_error(mean.mean, mean.standard_deviation)),
            });
            Cell::from(text).strong(is_doubtful(point))
        };
        if names.len() > MOST_COLUMNS {
            let heads = self.points.iter().map(|point| point.values.join(", "));
            return Table::new(&[&self.keys.join(", ")], &[]).with_numbers(heads).of(names, |name| {
                let values = self.points.iter().map(|point| shown(point, name));
                [self.head(name).into()].into_iter().chain(values).collect()
            });
        }
        let heads = names.iter().map(|name| self.head(name));
        Table::new(&self.key_heads(), &[]).with_numbers(heads).of(&self.points, |point| {
            let values = point.values.iter().map(|value| value.as_str().into());
            values.chain(names.iter().map(|name| shown(point, name))).collect()
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

    /// Rows by run: keys, seed, wall time, soundness, and each observable with its standard error.
    fn run_rows(&self) -> Table {
        let columns = self.observables().flat_map(|name| [name.to_string(), format!("{name}_standard_error")]);
        let runs = self.points.iter().flat_map(|point| point.runs.iter().map(move |run| (point, run)));
        Table::new(&self.key_heads(), &["seed", "wall_seconds", "sound"]).with_numbers(columns).of(
            runs,
            |(point, run)| {
                let values = point.values.iter().map(|value| value.as_str().into());
                let measured = self.observables().flat_map(|name| {
                    let found = run.measurements.iter().find(|one| one.observable == *name);
                    cells![found.map(|one| one.value), found.and_then(|one| one.standard_error)]
                });
                values.chain(cells![run.seed, run.wall_seconds, run.alarms.is_empty()]).chain(measured).collect()
            },
        )
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
