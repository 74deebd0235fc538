//! From runs to rows: means, differences, verdicts, live runs against the recorded spread.

use super::comparison::{MAKADAM, at_odds};
use super::registered::{Settled, unregistered};
use super::{CodeRuns, Comparison, MeasuredRun, Row};
use crate::plan::{Expectation, Scene};
use crate::statistics::Outcome;
use crate::statistics::{Ensemble, equivalence, inside_recorded_spread};

/// Puts together what was measured of several codes, the code under test first. Its agreement counts for the seeds alone that the scene
/// has registered.
pub fn comparison(scene: &Scene, codes: &[CodeRuns], mut notes: Vec<String>) -> Comparison {
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

/// Rows of one observable: each code against each one after it, then the last code by itself. A code that lacks a value of a
/// seed that it was run with has no test: its rows say what is missing.
fn rows(scene: &Scene, expectation: &Expectation, codes: &[CodeRuns]) -> Vec<Row> {
    let name = &expectation.observable;
    let asked: Vec<Asked<'_>> = codes.iter().map(|code| Asked::of(scene, code, name)).collect();
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
    keep_to_registered(&mut rows, is_registered);
    leave_open(&mut rows);
    rows
}

/// Reports whether a code was run with the seeds that the scene has registered.
fn is_registered(scene: &Scene, judged: &CodeRuns) -> bool {
    let seeds = judged.runs.iter().map(|run| run.seed).chain(judged.failed.iter().copied());
    unregistered(scene, seeds).is_none()
}

/// Makes agreement of the judged code exploratory where its seeds are not registered. Where they are, no number of further seeds is named:
/// runs are not added to until they agree. `rows`: those of one observable, the judged code's first.
fn keep_to_registered(rows: &mut [Row], is_registered: bool) {
    let Some(judged) = rows.first().map(|row| row.code.clone()) else { return };
    for row in rows.iter_mut().filter(|row| row.code == judged) {
        match row.outcome {
            Some(Outcome::Agree) if !is_registered => row.outcome = Some(Outcome::Exploratory),
            _ if is_registered => row.seeds_needed = None,
            _ => {}
        }
    }
}

/// Where the references differ from each other by more than the margin, agreement with one of them proves nothing, and more seeds decide
/// nothing. `rows`: those of one observable, the judged code's first.
fn leave_open(rows: &mut [Row]) {
    let Some(judged) = rows.first().map(|row| row.code.clone()) else { return };
    for place in 0..rows.len() {
        let row = &rows[place];
        let is_open = matches!(row.outcome, Some(Outcome::Agree | Outcome::Exploratory | Outcome::Undecided))
            && row.code == judged;
        if is_open && at_odds(rows, &judged, row) {
            (rows[place].outcome, rows[place].seeds_needed) = (Some(Outcome::Undecided), None);
        }
    }
}

/// What the runs of a code have of an observable that is asked for.
struct Asked<'a> {
    code: &'a str,
    unit: &'a str,
    ensemble: Option<Ensemble>,
    /// What they lack, in words; absent where every run has a value.
    missing: Option<String>,
}

impl<'a> Asked<'a> {
    /// Values of the runs of a code that are at rest, where the scene asks for that.
    fn of(scene: &Scene, code_runs: &'a CodeRuns, observable: &str) -> Asked<'a> {
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
        Asked { code, unit: found().next().map_or("", |found| &found.unit), ensemble: Ensemble::of(&values), missing }
    }

    /// A row that stands alone.
    fn row(&self, scene: &Scene, observable: &str) -> Row {
        Row {
            scene: scene.name.clone(),
            observable: observable.into(),
            unit: self.unit.into(),
            code: self.code.into(),
            mean: self.ensemble.map(|ensemble| ensemble.mean),
            standard_deviation: self.ensemble.map(|ensemble| ensemble.standard_deviation),
            seeds: self.ensemble.map_or(0, |ensemble| ensemble.seeds),
            reference_code: None,
            difference: None,
            interval90: None,
            interval_of_verdict: None,
            margin: None,
            outcome: None,
            missing: None,
            seeds_needed: None,
        }
    }

    /// The row that stands alone, with what it lacks.
    fn judged(&self, alone: Row) -> Row {
        let outcome = self.missing.as_ref().map(|_| Outcome::NotMeasured);
        Row { outcome, missing: self.missing.clone(), ..alone }
    }

    /// The row of the difference from another code, `codes` codes being compared in all.
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

/// A live run of a code against what was recorded of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveCheck {
    /// Observable.
    pub observable: String,
    /// Value of the live run, if it has one.
    pub value: Option<f64>,
    /// Interval that the recorded runs predict, if there are enough of them.
    pub interval: Option<[f64; 2]>,
    /// Whether the value lies inside; absent where there is nothing to tell it from.
    pub inside: Option<bool>,
}

/// Checks every observable that has a margin, each with `confidence`.
pub fn live_checks(scene: &Scene, live: &MeasuredRun, recorded: &CodeRuns, confidence: f64) -> Vec<LiveCheck> {
    let check = |expectation: &Expectation| {
        let value = live.value(&expectation.observable);
        let values = recorded.values(&expectation.observable);
        // A spread of some of the runs is none of all of them.
        let whole = values.len() == recorded.runs.len() && recorded.discarded.is_none();
        let spread = inside_recorded_spread(value.unwrap_or(f64::NAN), &values, confidence).filter(|_| whole);
        LiveCheck {
            observable: expectation.observable.clone(),
            value,
            interval: spread.map(|spread| spread.interval),
            inside: value.and(spread).map(|spread| spread.inside),
        }
    };
    scene.compare.iter().filter(|expectation| expectation.margin.is_some()).map(check).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::compare::{Source, Timing};
    use crate::observables::Measurement;
    use std::path::Path;

    /// The packing with the margin of its packing fraction that these tests count by, any run at rest, and so many seeds registered.
    fn packing(seeds: u64) -> Scene {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
        let mut scene = Scene::load(&file).unwrap();
        scene.compare[0].margin = Some(0.006);
        (scene.measure.seeds, scene.measure.rest_energy) = (Some(seeds), None);
        scene
    }

    /// Runs of a code with these packing fractions.
    pub fn code(name: &str, values: &[f64]) -> CodeRuns {
        let run = |(index, &value): (usize, &f64)| MeasuredRun {
            code: name.into(),
            version: "1".into(),
            contact_law: String::new(),
            seed: index as u64 + 1,
            time_step: 1e-3,
            rayleigh_fraction: None,
            wall_seconds: 3.0,
            core_seconds: None,
            simulated_seconds: 1.5,
            processor: String::new(),
            date: String::new(),
            scene_hash: String::new(),
            measurements: vec![Measurement {
                observable: "packing_fraction".into(),
                unit: String::new(),
                value,
                standard_error: None,
                frames: 1,
            }],
        };
        let runs = values.iter().enumerate().map(run).collect();
        CodeRuns {
            code: name.into(),
            source: Source::Live,
            timing: Timing::SideBySide,
            provenance: String::new(),
            runs,
            failed: Vec::new(),
            discarded: None,
            forces: None,
            series: Vec::new(),
            final_state: None,
        }
    }

    #[test]
    fn three_codes_give_three_pairs_and_the_last_code_alone() {
        let codes = [
            code("Makadam", &[0.585, 0.586, 0.587, 0.586]),
            code("YADE", &[0.584, 0.586, 0.586, 0.585]),
            code("LIGGGHTS", &[0.605, 0.606, 0.607, 0.606]),
        ];
        let comparison = comparison(&packing_fraction(4), &codes, Vec::new());
        let pairs: Vec<_> =
            comparison.rows.iter().map(|row| (row.code.as_str(), row.reference_code.as_deref(), row.outcome)).collect();
        assert_eq!(
            pairs,
            [
                ("Makadam", Some("YADE"), Some(Outcome::Undecided)),
                ("Makadam", Some("LIGGGHTS"), Some(Outcome::Disagree)),
                ("YADE", Some("LIGGGHTS"), Some(Outcome::Disagree)),
                ("LIGGGHTS", None, None),
            ]
        );
        assert_eq!(comparison.codes[0].wall_seconds_per_simulated_second, 2.0);
        assert!((comparison.rows[1].difference.unwrap() + 0.02).abs() < 1e-12);
    }

    #[test]
    fn where_references_are_at_odds_agreement_with_one_proves_nothing() {
        let makadam = code("Makadam", &[0.585, 0.586, 0.587, 0.586]);
        let between = |yade: f64, liggghts: f64| {
            let near = |middle: f64| [middle - 0.0002, middle, middle + 0.0002, middle];
            let codes = [makadam.clone(), code("YADE", &near(yade)), code("LIGGGHTS", &near(liggghts))];
            let rows = comparison(&packing_fraction(4), &codes, Vec::new()).rows;
            [rows[0].outcome, rows[1].outcome].map(Option::unwrap)
        };
        // The margin is 0.006.
        assert_eq!(between(0.5840, 0.5880), [Outcome::Agree; 2]);
        assert_eq!(between(0.5825, 0.5895), [Outcome::Undecided; 2]);
        assert_eq!(between(0.5860, 0.6060), [Outcome::Undecided, Outcome::Disagree]);
    }

    #[test]
    fn one_seed_is_undecided() {
        let codes = [code("Makadam", &[0.585]), code("YADE", &[0.585])];
        let comparison = comparison(&packing(2), &codes, Vec::new());
        assert_eq!(comparison.rows[0].outcome, Some(Outcome::Undecided));
    }

    /// The packing, compared by its packing fraction alone.
    pub fn packing_fraction(seeds: u64) -> Scene {
        let mut scene = packing(seeds);
        scene.compare.truncate(1);
        scene
    }

    /// Outcomes where the seeds of the first code are those that are registered.
    fn outcomes(codes: &[CodeRuns]) -> Vec<(String, Option<String>, Option<Outcome>, String)> {
        let seeds = codes[0].runs.len() + codes[0].failed.len();
        let rows = comparison(&packing_fraction(seeds as u64), codes, Vec::new()).rows.into_iter();
        rows.map(|row| (row.code, row.reference_code, row.outcome, row.missing.unwrap_or_default())).collect()
    }

    #[test]
    fn an_expectation_that_nobody_measured_is_a_row_that_says_so() {
        let codes = [code("Makadam", &[0.585, 0.586]), code("YADE", &[0.585, 0.586])];
        let comparison = comparison(&packing(2), &codes, Vec::new());
        let of =
            |name: &str| comparison.rows.iter().find(|row| row.observable == name && row.code == "Makadam").unwrap();
        for name in ["coordination_number", "share_below_mean", "gini", "wall_force_over_weight"] {
            let row = of(name);
            assert_eq!((row.outcome, row.mean, row.seeds), (Some(Outcome::NotMeasured), None, 0), "{name}");
            assert_eq!(row.missing.as_deref(), Some("Makadam has no value; YADE has no value"));
        }
        assert_eq!(of("packing_fraction").missing, None);
    }

    #[test]
    fn a_seed_without_a_value_is_no_smaller_ensemble() {
        let mut short = code("Makadam", &[0.585, 0.586, 0.585]);
        short.runs[1].measurements.clear();
        let whole = code("YADE", &[0.585, 0.586, 0.585]);
        let said = "Makadam has a value in 2 of 3 seeds".to_string();
        let not = Some(Outcome::NotMeasured);
        let rows = outcomes(&[short.clone(), whole.clone()]);
        assert_eq!(rows[0], ("Makadam".into(), Some("YADE".into()), not, said.clone()));
        assert_eq!(rows[1], ("YADE".into(), None, None, String::new()));
        // A peer as well as the judged code, and the judged code by itself.
        short.code = "LIGGGHTS".into();
        let rows = outcomes(&[code("Makadam", &[0.585, 0.586]), whole, short.clone()]);
        let words: Vec<&str> = rows.iter().map(|row| row.3.as_str()).collect();
        let said = "LIGGGHTS has a value in 2 of 3 seeds";
        assert_eq!(words, ["", said, said, said]);
        assert_eq!(rows[0].2, Some(Outcome::Agree), "what is whole is judged");
        assert_eq!(outcomes(&[short])[0].2, not);
    }

    #[test]
    fn a_seed_that_failed_is_a_missing_value() {
        let short = CodeRuns { failed: vec![3], ..code("Makadam", &[0.585, 0.586]) };
        let rows = outcomes(&[short, code("YADE", &[0.585, 0.586, 0.585])]);
        assert_eq!(
            (rows[0].2, rows[0].3.as_str()),
            (Some(Outcome::NotMeasured), "Makadam has a value in 2 of 3 seeds")
        );
        let none = CodeRuns { failed: vec![1, 2], ..code("Makadam", &[]) };
        assert_eq!(outcomes(&[none, code("YADE", &[0.585, 0.586])])[0].3, "Makadam has no value");
    }

    #[test]
    fn runs_that_do_not_count_are_held_against_nothing() {
        let other = CodeRuns { discarded: Some("of another scene".into()), ..code("YADE", &[0.584, 0.586, 0.586]) };
        let rows = outcomes(&[code("Makadam", &[0.585, 0.586]), other.clone()]);
        assert_eq!((rows[0].2, rows[0].3.as_str()), (Some(Outcome::NotMeasured), "of another scene"));
        let checks = live_checks(&packing(2), &code("YADE", &[0.585]).runs[0], &other, 0.99);
        assert!(checks.iter().all(|check| check.inside.is_none()));
    }

    #[test]
    fn a_code_without_runs_is_said() {
        let codes = [code("Makadam", &[0.585, 0.586]), code("YADE", &[])];
        let rows = outcomes(&codes);
        assert_eq!(rows[0].2, Some(Outcome::NotMeasured));
        assert_eq!(rows[0].3, "YADE has no runs");
        assert_eq!(comparison(&packing(2), &codes, Vec::new()).codes.len(), 1);
    }

    #[test]
    fn a_live_run_is_held_against_the_recorded_spread() {
        let recorded = code("YADE", &[0.584, 0.586, 0.586, 0.585]);
        let inside = live_checks(&packing(2), &code("YADE", &[0.587]).runs[0], &recorded, 0.99);
        assert_eq!(inside[0].inside, Some(true));
        assert_eq!(inside.len(), 5, "one a margin");
        assert!(inside[1..].iter().all(|check| check.inside.is_none()), "none of these was measured");
        let outside = live_checks(&packing(2), &code("YADE", &[0.62]).runs[0], &recorded, 0.99);
        assert_eq!(outside[0].inside, Some(false));
    }
}
