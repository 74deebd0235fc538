//! All runs of one code on one scene: what a comparison knows of it.

use super::{CodeSummary, FinalState, Harvest, MeasuredRun, Source, Timing};
use makadam_measure::observables::ForcePool;
use makadam_measure::observables::{ForceDistribution, Series};

/// Bins of a force distribution and their width in mean forces.
const FORCE_BINS: (usize, f64) = (32, 0.25);

/// The runs of one code, in the order of their seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct CodeRuns {
    /// The code.
    pub code: String,
    /// Live or recorded.
    pub source: Source,
    /// Timing of the runs.
    pub timing: Timing,
    /// In a sentence, where the numbers came from.
    pub provenance: String,
    /// Its runs that ended well.
    pub runs: Vec<MeasuredRun>,
    /// Seeds that were asked for and whose runs failed: what a code is measured by lacks their values.
    pub failed: Vec<u64>,
    /// Reason for which none of the runs counts; absent where they do.
    pub discarded: Option<String>,
    /// Normal forces of all runs.
    pub forces: Option<ForceDistribution>,
    /// Observables over time in the run with the first seed.
    pub series: Vec<Series>,
    /// Grains at the end of the run with the first seed.
    pub final_state: Option<FinalState>,
}

impl CodeRuns {
    /// The runs for measuring made here and now, up to `side_by_side` of them at a time.
    pub fn live(code: &str, side_by_side: usize, mut harvests: Vec<Harvest>) -> CodeRuns {
        harvests.sort_by_key(|harvest| harvest.run.seed);
        let mut pool = ForcePool::new(code);
        harvests.iter().for_each(|harvest| pool.merge(&harvest.forces));
        let (bins, width) = FORCE_BINS;
        CodeRuns {
            code: code.into(),
            source: Source::Live,
            timing: if side_by_side > 1 { Timing::SideBySide } else { Timing::Measuring },
            provenance: match side_by_side {
                0 | 1 => "run by this command, one run after the other".into(),
                several => format!("run by this command, up to {several} runs side by side"),
            },
            forces: (pool.samples() > 0).then(|| pool.distribution(bins, width)),
            series: harvests.first().map(|first| first.series.clone()).unwrap_or_default(),
            final_state: harvests.first().and_then(|first| first.final_state.clone()),
            runs: harvests.into_iter().map(|harvest| harvest.run).collect(),
            failed: Vec::new(),
            discarded: None,
        }
    }

    /// Values of an observable, one a run that has it.
    pub fn values(&self, observable: &str) -> Vec<f64> {
        self.runs.iter().filter_map(|run| run.value(observable)).collect()
    }

    /// Summarises the runs; `None` without any.
    pub fn summary(&self) -> Option<CodeSummary> {
        let first = self.runs.first()?;
        let mut pace: Vec<f64> = self.runs.iter().map(MeasuredRun::pace).collect();
        pace.sort_by(f64::total_cmp);
        let middle = (pace[(pace.len() - 1) / 2] + pace[pace.len() / 2]) / 2.0;
        Some(CodeSummary {
            code: self.code.clone(),
            version: first.version.clone(),
            source: self.source,
            seeds: self.runs.iter().map(|run| run.seed).collect(),
            time_step: Some(first.time_step).filter(|step| *step > 0.0),
            rayleigh_fraction: first.rayleigh_fraction,
            wall_seconds_per_simulated_second: middle,
            timing: self.timing,
            processor: first.processor.clone(),
            provenance: self.provenance.clone(),
        })
    }
}
