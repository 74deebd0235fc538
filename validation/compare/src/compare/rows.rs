//! From runs to rows: means, differences, verdicts, live runs against the recorded spread.
//!
//! The error probability of an interval holds for one test of the runs. Adding seeds until the interval lies inside the margin errs more
//! often. With tests at 8, 12, 16, 24, 32 and 48 seeds, 8% of differences as large as the margin pass a test of 2.5%. So
//! the number of seeds is part of the scene (`measure.seeds`), and runs of any other number are exploratory.

use super::comparison::{MAKADAM, at_odds};
use super::{CodeRuns, Comparison, MeasuredRun, Row, Source};
use makadam_frames::plan::{Expectation, MeasuredScene};
use makadam_measure::statistics::{Ensemble, Outcome, equivalence, prediction_interval};
use makadam_view::draw::numbers::plural;

/// Compares the measurements of several codes, the code under test first. Agreement counts only for the seeds that the scene
/// has registered.
pub fn comparison(scene: &MeasuredScene, codes: &[CodeRuns], mut notes: Vec<String>) -> Comparison {
    let moving = |code: &CodeRuns| Settled::of(scene, &code.runs).note(&code.code);
    notes.extend(codes.iter().filter(|code| code.discarded.is_none()).filter_map(moving));
    Comparison {
        scene: scene.clone(),
        judged: MAKADAM.into(),
        rows: scene.compare.iter().flat_map(|expectation| rows(scene, expectation, codes)).collect(),
        codes: codes.iter().filter_map(CodeRuns::summary).collect(),
        series: codes.iter().flat_map(|code| code.series.iter().cloned()).collect(),
        forces: codes.iter().filter_map(|code| code.forces.clone()).collect(),
        final_states: codes.iter().filter_map(|code| code.final_state.clone()).collect(),
        notes,
    }
}

/// Rows of one observable: each code against each one after it, then the last code by itself. A code that lacks a value for a
/// seed of its runs has no test: its rows state the missing values. A publication counts for the observables that it states.
fn rows(scene: &MeasuredScene, expectation: &Expectation, codes: &[CodeRuns]) -> Vec<Row> {
    let name = &expectation.observable;
    let states = |code: &&CodeRuns| code.source != Source::Published || !code.values(name).is_empty();
    let asked: Vec<Asked<'_>> = codes.iter().filter(states).map(|code| Asked::of(scene, code, name)).collect();
    let whole = asked.iter().filter(|asked| asked.missing.is_none()).count();
    let mut rows = Vec::new();
    for (place, one) in asked.iter().enumerate() {
        let alone = Row { margin: expectation.margin, ..one.row(scene, name) };
        for other in &asked[place + 1..] {
            rows.push(one.against(other, &alone, expectation, whole));
        }
        if place + 1 == asked.len() {
            rows.push(one.judged(alone));
        }
    }
    let is_registered = codes.first().is_some_and(|judged| is_registered(scene, judged));
    take_back(&mut rows, is_registered);
    rows
}

/// Returns true if a code was run with the seeds that the scene has registered.
fn is_registered(scene: &MeasuredScene, judged: &CodeRuns) -> bool {
    let seeds = judged.runs.iter().map(|run| run.seed).chain(judged.failed.iter().copied());
    unregistered(scene, seeds).is_none()
}

/// Withdraws verdicts that rows of the code under test do not prove. Agreement is exploratory where its seeds are not registered. Where they
/// are, no further number of seeds is named: runs are not added until they agree. Agreement is undecided where the references differ by more
/// than the margin, and more seeds decide nothing. `rows`: those of one observable, the code under test first.
fn take_back(rows: &mut [Row], is_registered: bool) {
    let Some(judged) = rows.first().map(|row| row.code.clone()) else { return };
    for place in (0..rows.len()).filter(|&place| rows[place].code == judged).collect::<Vec<_>>() {
        let is_open = at_odds(rows, &judged, &rows[place]);
        let row = &mut rows[place];
        row.seeds_needed = row.seeds_needed.filter(|_| !is_registered);
        match row.outcome {
            Some(Outcome::Agree | Outcome::Exploratory | Outcome::Undecided) if is_open => {
                (row.outcome, row.seeds_needed) = (Some(Outcome::Undecided), None);
            }
            Some(Outcome::Agree) if !is_registered => row.outcome = Some(Outcome::Exploratory),
            _ => {}
        }
    }
}

/// Values of a requested observable in the runs of a code.
struct Asked<'a> {
    code: &'a str,
    unit: &'a str,
    ensemble: Option<Ensemble>,
    /// Missing values; absent where every run has one.
    missing: Option<String>,
}

impl<'a> Asked<'a> {
    /// Returns the values of the runs of a code that are at rest, where the scene requires rest.
    fn of(scene: &MeasuredScene, code_runs: &'a CodeRuns, observable: &str) -> Asked<'a> {
        let CodeRuns { code, runs, failed, discarded, .. } = code_runs;
        let settled = Settled::of(scene, runs);
        let found = || runs.iter().flat_map(|run| &run.measurements).filter(|found| found.observable == observable);
        let values: Vec<f64> = settled.at_rest.iter().filter_map(|run| run.value(observable)).collect();
        let missing = match (values.len(), settled.at_rest.len() + failed.len()) {
            _ if discarded.is_some() => discarded.clone(),
            _ if runs.is_empty() && failed.is_empty() => Some(format!("{code} has no runs")),
            _ if settled.refusal(code).is_some() => settled.refusal(code),
            (found, all) if found == all => None,
            (0, _) => Some(format!("{code} has no value")),
            (found, all) => Some(format!("{code} has a value in {found} of {all} seeds")),
        };
        let ensemble = match code_runs.source {
            Source::Published => values.first().map(|value| Ensemble::published(*value)),
            Source::Live | Source::Recorded => Ensemble::of(&values),
        };
        Asked { code, unit: found().next().map_or("", |found| &found.unit), ensemble, missing }
    }

    /// Row of one code.
    fn row(&self, scene: &MeasuredScene, observable: &str) -> Row {
        Row {
            scene: scene.name.clone(),
            observable: observable.into(),
            unit: self.unit.into(),
            code: self.code.into(),
            mean: self.ensemble.map(|ensemble| ensemble.mean),
            standard_deviation: self.ensemble.map(|ensemble| ensemble.standard_deviation),
            seeds: self.ensemble.map_or(0, |ensemble| ensemble.seeds),
            ..Row::default()
        }
    }

    /// Row of one code, with its missing values.
    fn judged(&self, alone: Row) -> Row {
        let outcome = self.missing.as_ref().map(|_| Outcome::NotMeasured);
        Row { outcome, missing: self.missing.clone(), ..alone }
    }

    /// Row of the difference from another code, with `codes` codes compared in all.
    fn against(&self, other: &Asked<'_>, alone: &Row, expectation: &Expectation, codes: usize) -> Row {
        let pair = Row { reference_code: Some(other.code.into()), ..alone.clone() };
        let missing: Vec<&str> = [self, other].iter().filter_map(|asked| asked.missing.as_deref()).collect();
        match (&self.ensemble, &other.ensemble) {
            (Some(own), Some(others)) if missing.is_empty() => {
                let test = equivalence(own, others, expectation.margin, codes);
                Row {
                    difference: Some(test.difference),
                    interval90: test.interval90,
                    interval_of_verdict: test.interval_of_verdict,
                    outcome: test.outcome,
                    seeds_needed: test.seeds_needed,
                    ..pair
                }
            }
            _ => Row { outcome: Some(Outcome::NotMeasured), missing: Some(missing.join("; ")), ..pair },
        }
    }
}

/// Live value of an observable, and the interval that the recorded runs predict.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveCheck {
    pub observable: String,
    /// Value of the live run, if it has one.
    pub value: Option<f64>,
    /// Predicted interval, if there are enough recorded runs.
    pub interval: Option<[f64; 2]>,
}

impl LiveCheck {
    /// Returns true if the value lies inside the interval; `None` without either.
    pub fn inside(&self) -> Option<bool> {
        self.value.zip(self.interval).map(|(value, [low, high])| (low..=high).contains(&value))
    }
}

/// Checks every observable that has a margin, each with `confidence`. The seed of the live run is not among the recorded ones: a value
/// always lies within a set that contains it.
pub fn live_checks(scene: &MeasuredScene, live: &MeasuredRun, recorded: &CodeRuns, confidence: f64) -> Vec<LiveCheck> {
    let check = |expectation: &Expectation| {
        let values = recorded.values(&expectation.observable);
        // The spread of some of the runs is not that of all.
        let is_whole = values.len() == recorded.runs.len() && recorded.discarded.is_none();
        LiveCheck {
            observable: expectation.observable.clone(),
            value: live.value(&expectation.observable),
            interval: prediction_interval(&values, 1, confidence).filter(|_| is_whole),
        }
    };
    scene.compare.iter().filter(|expectation| expectation.margin.is_some()).map(check).collect()
}

/// Largest fraction of the runs of a code that may be excluded because they are not at rest.
const MOST_MOVING: f64 = 0.2;

/// Reason why runs of these seeds are not those registered by the scene, as a clause; `None` for seeds 1 to the registered number.
pub(super) fn unregistered(scene: &MeasuredScene, seeds: impl Iterator<Item = u64>) -> Option<String> {
    let mut seeds: Vec<u64> = seeds.collect();
    seeds.sort_unstable();
    let made = plural(seeds.len(), "seed");
    match scene.measure.seeds {
        None => Some(format!(
            "{} registers no seeds, and {made} were run; give measure.seeds in its file before the runs",
            scene.name
        )),
        Some(registered) if seeds.iter().copied().eq(1..=registered) => None,
        Some(registered) if seeds.len() as u64 == registered => {
            Some(format!("{} registers seeds 1 to {registered} (measure.seeds), and others were run", scene.name))
        }
        Some(registered) => {
            Some(format!("{} registers {registered} seeds (measure.seeds), and {made} were run", scene.name))
        }
    }
}

impl Comparison {
    /// Reason why the runs of the code under test are not those registered by the scene, as a clause; `None` where they are.
    pub fn unregistered(&self) -> Option<String> {
        let judged = self.codes.iter().find(|code| code.code == self.judged)?;
        unregistered(&self.scene, judged.seeds.iter().copied())
    }
}

/// Runs of a code, divided by rest at their end.
pub(super) struct Settled<'a> {
    /// Runs that count.
    pub at_rest: Vec<&'a MeasuredRun>,
    /// Seeds of the other runs.
    pub moving: Vec<u64>,
}

impl<'a> Settled<'a> {
    /// Separates runs at rest from others by their kinetic energy per grain; where a scene states no maximum, all runs count. A run without
    /// a kinetic energy counts as moving.
    pub fn of(scene: &MeasuredScene, runs: &'a [MeasuredRun]) -> Settled<'a> {
        let largest = scene.measure.rest_energy.map(|energy| energy * scene.grain_count() as f64);
        let is_at_rest = |run: &&MeasuredRun| match (largest, run.value("kinetic_energy")) {
            (None, _) => true,
            (Some(largest), Some(energy)) => energy <= largest,
            (Some(_), None) => false,
        };
        let (at_rest, moving): (Vec<_>, Vec<_>) = runs.iter().partition(is_at_rest);
        Settled { at_rest, moving: moving.into_iter().map(|run| run.seed).collect() }
    }

    /// Reason why none of the runs counts: more of them move than may be excluded.
    pub fn refusal(&self, code: &str) -> Option<String> {
        let all = self.at_rest.len() + self.moving.len();
        let too_many = self.moving.len() as f64 > MOST_MOVING * all as f64;
        too_many.then(|| {
            format!("{} of {all} runs of {code} are not known to be at rest (measure.rest_energy)", self.moving.len())
        })
    }

    /// Excluded seeds, as a sentence; `None` where there are none.
    pub fn note(&self, code: &str) -> Option<String> {
        let seeds: Vec<String> = self.moving.iter().map(u64::to_string).collect();
        (!seeds.is_empty()).then(|| {
            let all = self.at_rest.len() + seeds.len();
            format!(
                "{code}: {} of {all} runs are not at rest at their end and are left out (measure.rest_energy): seeds {}",
                seeds.len(),
                seeds.join(", ")
            )
        })
    }
}

#[cfg(test)]
#[path = "../../tests/unit/compare_rows.rs"]
pub(super) mod tests;
