//! Result of a comparison of one scene: the data of tables, JSON, CSV and the report.

use makadam::snapshot::Particle;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::{ForceDistribution, Series};
use makadam_measure::statistics::Outcome;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Origin of a code's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Run here and now.
    Live,
    /// Read from `reference-scenes/*/reference/`.
    Recorded,
    /// Read from `reference-scenes/*/reference/published.csv`: numbers of a publication, without seeds.
    Published,
}

/// Conditions under which a code's runs were timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Timing {
    /// By runs for timing, from the inputs from which each code is fastest, one run after the other: processor time of the stepping, without
    /// set-up and output. What a ratio of speeds can be taken of.
    Alone,
    /// By runs for measuring, one after the other: their inputs may slow a code down, so that they are no measure of its speed.
    Measuring,
    /// Several runs at a time, which share the machine's memory and caches: no measure of speed.
    #[default]
    SideBySide,
    /// Some time ago, on the processor that is named with it.
    Recorded,
    /// Not timed: numbers of a publication.
    Published,
}

/// One observable of one code, and its difference from a reference code.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// Name of the observable, for example `packing_fraction`.
    pub observable: String,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// The code.
    pub code: String,
    /// Mean over seeds; absent where no seed has a value.
    pub mean: Option<f64>,
    /// Standard deviation over seeds; absent where no seed has a value.
    pub standard_deviation: Option<f64>,
    /// Number of seeds that have a value; 0 for a published value.
    pub seeds: usize,
    /// The code that this one is compared with; absent on rows that stand alone.
    pub reference_code: Option<String>,
    /// Mean minus the reference code's mean.
    pub difference: Option<f64>,
    /// 90% interval of the difference (Welch).
    pub interval90: Option<[f64; 2]>,
    /// Interval that the verdict rests on: two one-sided tests at 5% over the number of reference codes.
    pub interval_of_verdict: Option<[f64; 2]>,
    /// Margin of equivalence, from the scene; absent where the observable is reported without a verdict.
    pub margin: Option<f64>,
    /// Verdict; absent where there is no margin or no reference code, unless the observable was not measured.
    pub outcome: Option<Outcome>,
    /// Whose values are missing and how many, where the outcome is [`Outcome::NotMeasured`].
    #[serde(default)]
    pub missing: Option<String>,
    /// Seeds that would decide, where the outcome is undecided.
    pub seeds_needed: Option<usize>,
}

impl Row {
    /// Returns the displayed interval of the difference: that of the verdict, or that of 90% where there is no margin.
    pub fn shown_interval(&self) -> Option<[f64; 2]> {
        self.interval_of_verdict.filter(|_| self.margin.is_some()).or(self.interval90)
    }
}

impl Comparison {
    /// Returns true if the references differ from each other by more than the margin of a row of the code under test: the row proves nothing then.
    pub fn references_at_odds(&self, row: &Row) -> bool {
        at_odds(&self.rows, &self.judged, row)
    }
}

pub(super) fn at_odds(rows: &[Row], judged: &str, row: &Row) -> bool {
    let floor = |other: &&Row| other.code != judged && other.observable == row.observable;
    let beyond = |difference: f64| row.margin.is_some_and(|margin| difference.abs() > margin);
    rows.iter().filter(floor).filter_map(|floor| floor.difference).any(beyond)
}

/// Returns the names that a field takes, each once, in the order of their appearance.
pub fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

/// Runs of a code in short.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CodeSummary {
    /// The code.
    pub code: String,
    /// Its version.
    pub version: String,
    /// Live or recorded.
    pub source: Source,
    /// Seeds that were run.
    pub seeds: Vec<u64>,
    /// Time step, s; absent where the code does not tell.
    pub time_step: Option<f64>,
    /// Time step over the Rayleigh step, for explicit codes.
    pub rayleigh_fraction: Option<f64>,
    /// Median over runs of the time of the stepping over simulated time, one core: processor time, or wall time of runs that do not tell it.
    pub wall_seconds_per_simulated_second: f64,
    /// Conditions of that time.
    #[serde(default)]
    pub timing: Timing,
    /// Processor on which these runs were timed.
    pub processor: String,
    /// In a word or a sentence, where the numbers came from.
    pub provenance: String,
}

/// The grains of one code at the end of a run, for pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FinalState {
    /// The code.
    pub code: String,
    /// Seed of the run.
    pub seed: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Grains.
    pub particles: Vec<Particle>,
}

/// Default code under test.
pub(crate) const MAKADAM: &str = "Makadam";

fn makadam() -> String {
    MAKADAM.into()
}

/// Everything that a comparison of one scene yields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// The scene.
    pub scene: MeasuredScene,
    /// The code that is judged.
    #[serde(default = "makadam")]
    pub judged: String,
    /// The judged code against each other one, then the first of these against the next, an observable after the other.
    pub rows: Vec<Row>,
    /// Runs of each code in short.
    pub codes: Vec<CodeSummary>,
    /// Observables over time, one run a code.
    pub series: Vec<Series>,
    /// Distributions of normal forces.
    pub forces: Vec<ForceDistribution>,
    /// Final states, one a code, of the same seed.
    pub final_states: Vec<FinalState>,
    /// Notes: recorded numbers used, runs that failed, live runs outside the recorded spread.
    pub notes: Vec<String>,
}
