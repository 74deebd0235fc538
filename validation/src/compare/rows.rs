//! From runs to rows: means, differences, verdicts, the bias of soft grains, live runs against the recorded spread.

use super::{CodeRuns, Comparison, MeasuredRun, Row};
use crate::statistics::{Ensemble, equivalence, inside_recorded_spread};
use makadam::scene::{Expectation, Scene};

/// Stiffness at which the bias of soft grains is measured, over the scene's.
pub const STIFF: f64 = 10.0;

/// Puts together what was measured of several codes, the judged one first.
pub fn comparison(scene: &Scene, codes: &[CodeRuns], notes: Vec<String>) -> Comparison {
    Comparison {
        scene: scene.clone(),
        rows: scene.compare.iter().flat_map(|expectation| rows(scene, expectation, codes)).collect(),
        codes: codes.iter().filter_map(CodeRuns::summary).collect(),
        series: codes.iter().flat_map(|code| code.series.iter().cloned()).collect(),
        forces: codes.iter().filter_map(|code| code.forces.clone()).collect(),
        final_states: codes.iter().filter_map(|code| code.final_state.clone()).collect(),
        soft_bias: codes.iter().flat_map(|code| soft_bias(scene, code)).collect(),
        notes,
    }
}

/// Rows of one observable: each code against each one after it, then the last code by itself.
fn rows(scene: &Scene, expectation: &Expectation, codes: &[CodeRuns]) -> Vec<Row> {
    let name = &expectation.observable;
    let known: Vec<(&CodeRuns, Ensemble)> =
        codes.iter().filter_map(|code| Some((code, Ensemble::of(&code.values(name))?))).collect();
    let mut rows = Vec::new();
    for (place, (code, ensemble)) in known.iter().enumerate() {
        let alone = row(scene, name, &code.code, &code.runs, ensemble);
        for (reference, other) in &known[place + 1..] {
            let test = equivalence(ensemble, other, expectation.margin, known.len());
            rows.push(Row {
                reference_code: Some(reference.code.clone()),
                difference: Some(test.difference),
                interval90: test.interval90,
                interval_of_verdict: test.interval_of_verdict,
                margin: expectation.margin,
                outcome: test.outcome,
                seeds_needed: test.seeds_needed,
                ..alone.clone()
            });
        }
        if place + 1 == known.len() {
            rows.push(Row { margin: expectation.margin, ..alone });
        }
    }
    rows
}

/// How far each compared observable of a code shifts where its grains are ten times as stiff.
fn soft_bias(scene: &Scene, code: &CodeRuns) -> Vec<Row> {
    let shifts = scene.compare.iter().filter_map(|expectation| {
        let name = &expectation.observable;
        let stiff: Vec<f64> = code.stiff_runs.iter().filter_map(|run| run.value(name)).collect();
        let (stiff, soft) = (Ensemble::of(&stiff)?, Ensemble::of(&code.values(name))?);
        let test = equivalence(&stiff, &soft, expectation.margin, 2);
        Some(Row {
            reference_code: Some(code.code.clone()),
            difference: Some(test.difference),
            interval90: test.interval90,
            margin: expectation.margin,
            ..row(scene, name, &code.code, &code.stiff_runs, &stiff)
        })
    });
    shifts.collect()
}

/// A row that stands alone.
fn row(scene: &Scene, observable: &str, code: &str, runs: &[MeasuredRun], ensemble: &Ensemble) -> Row {
    let unit = runs.iter().flat_map(|run| &run.measurements).find(|measurement| measurement.observable == observable);
    Row {
        scene: scene.name.clone(),
        observable: observable.into(),
        unit: unit.map(|measurement| measurement.unit.clone()).unwrap_or_default(),
        code: code.into(),
        mean: ensemble.mean,
        standard_deviation: ensemble.standard_deviation,
        seeds: ensemble.seeds,
        reference_code: None,
        difference: None,
        interval90: None,
        interval_of_verdict: None,
        margin: None,
        outcome: None,
        seeds_needed: None,
    }
}

/// A live run of a code against what was recorded of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveCheck {
    /// Observable.
    pub observable: String,
    /// Value of the live run.
    pub value: f64,
    /// 99% interval that the recorded runs predict.
    pub interval: [f64; 2],
    /// Whether the value lies inside.
    pub inside: bool,
}

/// Checks every observable that has a margin.
pub fn live_checks(scene: &Scene, live: &MeasuredRun, recorded: &CodeRuns) -> Vec<LiveCheck> {
    let checked = scene.compare.iter().filter(|expectation| expectation.margin.is_some()).filter_map(|expectation| {
        let value = live.value(&expectation.observable)?;
        let spread = inside_recorded_spread(value, &recorded.values(&expectation.observable))?;
        let observable = expectation.observable.clone();
        Some(LiveCheck { observable, value, interval: spread.interval, inside: spread.inside })
    });
    checked.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{Outcome, Source};
    use crate::observables::Measurement;
    use std::path::Path;

    fn packing() -> Scene {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
        Scene::load(&file).unwrap()
    }

    fn code(name: &str, values: &[f64]) -> CodeRuns {
        let run = |(index, &value): (usize, &f64)| MeasuredRun {
            code: name.into(),
            version: "1".into(),
            seed: index as u64 + 1,
            time_step: 1e-3,
            rayleigh_fraction: None,
            stiffness_factor: 1.0,
            wall_seconds: 3.0,
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
            provenance: String::new(),
            runs,
            stiff_runs: Vec::new(),
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
        let comparison = comparison(&packing(), &codes, Vec::new());
        let pairs: Vec<_> =
            comparison.rows.iter().map(|row| (row.code.as_str(), row.reference_code.as_deref(), row.outcome)).collect();
        assert_eq!(
            pairs,
            [
                ("Makadam", Some("YADE"), Some(Outcome::Agree)),
                ("Makadam", Some("LIGGGHTS"), Some(Outcome::Disagree)),
                ("YADE", Some("LIGGGHTS"), Some(Outcome::Disagree)),
                ("LIGGGHTS", None, None),
            ]
        );
        assert_eq!(comparison.codes[0].wall_seconds_per_simulated_second, 2.0);
        assert!((comparison.rows[1].difference.unwrap() + 0.02).abs() < 1e-12);
    }

    #[test]
    fn one_seed_is_undecided() {
        let codes = [code("Makadam", &[0.585]), code("YADE", &[0.585])];
        let comparison = comparison(&packing(), &codes, Vec::new());
        assert_eq!(comparison.rows[0].outcome, Some(Outcome::Undecided));
    }

    #[test]
    fn a_code_that_measured_nothing_is_left_out() {
        let codes = [code("Makadam", &[0.585, 0.586]), code("YADE", &[])];
        let comparison = comparison(&packing(), &codes, Vec::new());
        assert_eq!(comparison.rows.len(), 1);
        assert_eq!(comparison.rows[0].reference_code, None);
        assert_eq!(comparison.codes.len(), 1);
    }

    #[test]
    fn a_live_run_is_held_against_the_recorded_spread() {
        let recorded = code("YADE", &[0.584, 0.586, 0.586, 0.585]);
        let inside = live_checks(&packing(), &code("YADE", &[0.587]).runs[0], &recorded);
        assert!(inside[0].inside);
        let outside = live_checks(&packing(), &code("YADE", &[0.62]).runs[0], &recorded);
        assert!(!outside[0].inside);
    }
}
