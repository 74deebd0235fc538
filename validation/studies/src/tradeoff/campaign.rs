//! Execution of a plan: one run after the other on one core, the reference first, each stored at its end.

use super::plan::{Configuration, Plan};
use makadam_compare::codes::{Code, CodeError, Purpose};
use makadam_compare::compare::{Announce, MeasuredRun, Runs};
use makadam_compare::study::{RunCache, RunError};
use makadam_frames::plan::MeasuredScene;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Duration;

/// Plan and its input.
pub struct Campaign<'a> {
    /// Scene as written in its file.
    pub scene: &'a MeasuredScene,
    /// File.
    pub scene_file: &'a Path,
    /// Configurations to run.
    pub plan: &'a Plan,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// Codes of the plan, Makadam among them.
    pub codes: &'a [Box<dyn Code>],
    /// Wall time after which a run of another code than Makadam is stopped, s.
    pub time_limit: f64,
    /// Finished runs.
    pub cache: &'a RunCache,
    /// Opens progress displays.
    pub announce: Announce<'a>,
}

/// Result of a campaign.
pub struct Outcome {
    /// Runs of each configuration of the plan, in the order of seeds.
    pub runs: Vec<Vec<MeasuredRun>>,
    /// First failure of each configuration that failed, by its index: the seed and the reason.
    pub failures: BTreeMap<usize, (u64, String)>,
    /// Codes that cannot run the scene and files that were damaged, as sentences.
    pub notes: Vec<String>,
    /// True if the user asked to stop before the end.
    pub interrupted: bool,
}

impl Outcome {
    /// Returns an empty outcome of the given number of configurations.
    pub fn none(configurations: usize) -> Outcome {
        let runs = vec![Vec::new(); configurations];
        Outcome { runs, failures: BTreeMap::new(), notes: Vec::new(), interrupted: false }
    }

    /// Failures and notes, as sentences.
    pub fn sentences(&self, plan: &Plan) -> Vec<String> {
        let failed = self.failures.iter().map(|(place, (seed, why))| {
            let configuration = &plan.configurations[*place];
            let Configuration { code, stiffness_factor, .. } = configuration;
            let setting = configuration.setting();
            format!("{code} {setting}, stiffness factor {stiffness_factor}, failed with seed {seed}, and counts as beyond the bounds: {why}")
        });
        failed.chain(self.notes.iter().cloned()).collect()
    }
}

impl Campaign<'_> {
    /// Takes the stored runs and makes the others: every configuration with its first seed, then with the next one. Within a seed the
    /// reference at the scene's stiffness comes first, because errors are relative to it.
    ///
    /// # Errors
    /// [`RunError`]; a run that fails by itself is only noted.
    pub fn carry_out(&self) -> Result<Outcome, RunError> {
        let count = self.plan.configurations.len();
        let mut outcome = Outcome::none(count);
        let mut unsupported: BTreeSet<&str> = BTreeSet::new();
        let reference = self.plan.refinement(1.0).map(|refinement| refinement.grids[2]);
        let mut places: Vec<usize> = (0..count).collect();
        places.sort_by_key(|place| Some(*place) != reference);
        for (seed, &place) in (1..=self.seeds).flat_map(|seed| places.iter().map(move |place| (seed, place))) {
            let code = self.plan.configurations[place].code.as_str();
            // A configuration that failed with a seed meets no bound, whatever its other seeds give; every seed of a reference counts.
            let is_known = outcome.failures.contains_key(&place) && !self.plan.is_grid(place);
            if is_known || unsupported.contains(code) {
                continue;
            }
            match self.run(place, seed) {
                Ok(run) => outcome.runs[place].push(run),
                Err(RunError::Interrupted) => {
                    outcome.interrupted = true;
                    break;
                }
                Err(RunError::Code(error @ CodeError::Unsupported { .. })) => {
                    outcome.notes.push(error.to_string());
                    unsupported.insert(code);
                }
                Err(
                    error @ (RunError::Invalid(_)
                    | RunError::Code(
                        CodeError::Crashed { .. } | CodeError::Output { .. } | CodeError::TimedOut { .. },
                    )),
                ) => {
                    outcome.failures.entry(place).or_insert((seed, error.to_string()));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(outcome)
    }

    /// Returns one run, from the cache or new.
    fn run(&self, place: usize, seed: u64) -> Result<MeasuredRun, RunError> {
        let configuration = &self.plan.configurations[place];
        let code = self.codes.iter().find(|code| code.name() == configuration.code);
        let code = code.ok_or(CodeError::Missing { code: "a code of the plan" })?;
        let label = format!("{} {}, seed {seed}", configuration.code, configuration.setting());
        let (scene, announce) = (configuration.scene(self.scene), |_: &str| (self.announce)(&label));
        let runs = Runs {
            purpose: Purpose::Timing,
            rayleigh_fraction: configuration.rayleigh_fraction().unwrap_or_default(),
            stiffness_factor: configuration.stiffness_factor,
            ..Runs::of_one_seed(&scene, self.scene_file, seed, Duration::from_secs_f64(self.time_limit), &announce)
        };
        let mut run = runs.take_as(self.cache, code.as_ref(), seed, true)?.run;
        run.measurements.retain(|measurement| measurement.value.is_finite());
        Ok(run)
    }
}
