//! What `makadam laws` yields.

use super::{Law, Values};
use crate::study::Finding;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What one run measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Name of the case.
    pub(crate) case: String,
    /// Seed of the initial positions.
    pub(crate) seed: u64,
    /// What was chosen and what was measured, by name.
    pub(crate) values: Values,
    /// Hash of the scene, 16 hexadecimal digits.
    pub(crate) scene_hash: String,
    /// Version of Makadam.
    pub(crate) makadam: String,
    /// Number of grains.
    pub(crate) grains: usize,
    /// Steps taken.
    pub(crate) steps: u64,
    /// Wall time, s.
    pub(crate) wall_seconds: f64,
}

/// A case over its seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Mean {
    /// Name of the case.
    pub(crate) case: String,
    /// Number of seeds.
    pub(crate) seeds: usize,
    /// Means, by name.
    pub(crate) values: Values,
    /// Standard deviations over seeds, by name; empty for a single seed.
    pub(crate) deviations: Values,
}

impl Mean {
    /// Cases in their order, each over its seeds.
    pub(crate) fn of(rows: &[Row]) -> Vec<Mean> {
        let mut names: Vec<&str> = rows.iter().map(|row| row.case.as_str()).collect();
        names.dedup();
        names.into_iter().map(|name| Mean::of_case(name, rows)).collect()
    }

    fn of_case(name: &str, rows: &[Row]) -> Mean {
        let own: Vec<&Row> = rows.iter().filter(|row| row.case == name).collect();
        let (mut values, mut deviations) = (Values::new(), Values::new());
        for key in own.iter().flat_map(|row| row.values.keys()) {
            if values.contains_key(key) {
                continue;
            }
            let each: Vec<f64> = own.iter().map(|row| row.values.get(key).copied().unwrap_or(f64::NAN)).collect();
            let mean = each.iter().sum::<f64>() / each.len() as f64;
            values.insert(key.clone(), mean);
            if each.len() > 1 {
                let square: f64 = each.iter().map(|value| (value - mean).powi(2)).sum();
                deviations.insert(key.clone(), (square / (each.len() - 1) as f64).sqrt());
            }
        }
        Mean { case: name.into(), seeds: own.len(), values, deviations }
    }

    /// A mean; not a number where it was not measured.
    pub(crate) fn of_value(&self, name: &str) -> f64 {
        self.values.get(name).copied().unwrap_or(f64::NAN)
    }
}

/// One law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LawResult {
    /// Its name.
    pub(crate) name: &'static str,
    /// What it says.
    pub(crate) statement: &'static str,
    /// Where it was published.
    pub(crate) source: &'static str,
    /// Whether every figure keeps its bounds.
    pub(crate) holds: bool,
    /// Figures and their bounds.
    pub(crate) findings: Vec<Finding>,
    /// Cases over their seeds.
    pub(crate) means: Vec<Mean>,
    /// One a run.
    pub(crate) rows: Vec<Row>,
}

impl LawResult {
    /// A law judged by its rows.
    pub(crate) fn new(law: &dyn Law, rows: Vec<Row>) -> LawResult {
        let means = Mean::of(&rows);
        let findings = law.judge(&means);
        LawResult {
            name: law.name(),
            statement: law.statement(),
            source: law.source(),
            holds: findings.iter().all(Finding::holds),
            findings,
            means,
            rows,
        }
    }
}

/// Everything that a run of `makadam laws` found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Study {
    /// Version of this document.
    pub(crate) version: u32,
    /// Always "laws".
    pub(crate) command: &'static str,
    /// Whether all laws hold.
    pub(crate) hold: bool,
    /// Whether fewer and smaller cases were run.
    pub(crate) quick: bool,
    /// Seeds of each case.
    pub(crate) seeds: Vec<u64>,
    /// The laws.
    pub(crate) laws: Vec<LawResult>,
    /// Where the numbers came from, by name.
    pub(crate) provenance: BTreeMap<String, String>,
}
