//! Carries out a plan: one run after the other on one core, the reference and cheap ones first, each kept as it ends.

use super::configuration::Configuration;
use super::cost::Costs;
use super::kept::{KeptRun, run_key};
use super::plan::Plan;
use crate::compare::{Harvest, Runs, Share};
use crate::output::WriteError;
use crate::peers::{Code, CodeError, CoreClock, Purpose};
use crate::plan::Scene;
use crate::provenance::{Build, command_line, machine};
use crate::scenes::{SceneError, in_file};
use crate::study::{Found, Key, RunCache};
use makadam::scene::populate;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Wall time at which a run is stopped, over the limit at which it is cut short beforehand: expected times err.
const PATIENCE: f64 = 3.0;

/// The same for a run that should not take long, since its first seed did not or it has been cut short: machines get busy.
const MORE_PATIENCE: f64 = 30.0;

/// Told what runs and which share of the expected wall time has passed, 0 to 1.
pub type Progress = Arc<dyn Fn(&str, f64) + Send + Sync>;

/// A plan and what it is carried out on.
pub struct Campaign<'a> {
    /// The scene as its file says it.
    pub scene: &'a Scene,
    /// Its file.
    pub scene_file: &'a Path,
    /// What is run.
    pub plan: &'a Plan,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// The codes of the plan, Makadam among them.
    pub codes: &'a [Box<dyn Code>],
    /// Wall time beyond which a run is cut short and its wall time extrapolated, s.
    pub time_limit: f64,
    /// Where finished runs are kept.
    pub cache: &'a RunCache,
    /// Told of the progress.
    pub progress: Progress,
}

/// What there is after a campaign.
pub struct Outcome {
    /// Runs of each configuration of the plan, in the order of seeds.
    pub runs: Vec<Vec<KeptRun>>,
    /// Runs that were made now; the others were there.
    pub made: usize,
    /// The first failure of each configuration that failed, by its place: the seed, and why.
    pub failures: BTreeMap<usize, (u64, String)>,
    /// Codes that cannot run the scene and files that were damaged, in sentences.
    pub notes: Vec<String>,
    /// Whether the user asked to stop before the end.
    pub interrupted: bool,
}

impl Outcome {
    /// Nothing yet, of so many configurations.
    pub fn none(configurations: usize) -> Outcome {
        let runs = vec![Vec::new(); configurations];
        Outcome { runs, made: 0, failures: BTreeMap::new(), notes: Vec::new(), interrupted: false }
    }

    /// What failed and what was noticed, in sentences.
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

/// Why a campaign could not go on. What had been run is kept.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A run cannot be kept or read back.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A code cannot run at all.
    #[error(transparent)]
    Code(#[from] CodeError),
}

/// One run that is due.
struct Task<'a> {
    /// Place of the configuration in the plan.
    place: usize,
    /// Seed of the initial positions.
    seed: u64,
    /// Code, setting and seed in words.
    label: &'a str,
    /// Expected wall times: of what came before, of this run, of everything, s.
    span: [f64; 3],
    /// Whether it may be cut short.
    may_cut: bool,
}

/// What came of one attempt.
enum Attempt {
    Run(Box<KeptRun>),
    Failed(String),
    Unsupported(CodeError),
    Interrupted,
}

impl Campaign<'_> {
    /// Runs what is not there yet.
    ///
    /// # Errors
    /// [`CampaignError`]; a run that fails by itself is only noted.
    pub fn carry_out(&self) -> Result<Outcome, CampaignError> {
        let grains = populate(self.scene, 1).map_err(in_file(self.scene_file))?;
        let mut costs = Costs::new(self.scene, grains.len(), self.scene.rayleigh_step(&grains));
        let configurations = &self.plan.configurations;
        let mut outcome = Outcome::none(configurations.len());
        let mut missing = self.find(&mut outcome, &mut costs)?;
        let mut unsupported: BTreeSet<String> = BTreeSet::new();
        let mut done = 0.0;
        while let Some((seed, place)) = self.next(&missing, &costs) {
            missing.remove(&(seed, place));
            let configuration = &configurations[place];
            // A run that was cut short tells its wall time; another seed would tell the same.
            let known = outcome.runs[place].first().is_some_and(|first| first.extrapolated);
            // One that failed with a seed keeps no bound, whatever it does with the others; of a reference every seed counts.
            let known = known || outcome.failures.contains_key(&place) && !self.plan.is_grid(place);
            if known || unsupported.contains(&configuration.code) {
                continue;
            }
            let here = self.expected(place, &costs);
            let left: f64 = missing.iter().map(|&(_, place)| self.expected(place, &costs)).sum();
            let label = format!("{} {}, seed {seed}", configuration.code, configuration.setting());
            let clock = Instant::now();
            // Only a first seed: what it tells of the wall time decides for the others.
            let may_cut = outcome.runs[place].is_empty() && !self.plan.is_grid(place);
            let task = Task { place, seed, label: &label, span: [done, here, done + here + left], may_cut };
            match self.attempt(&task, &mut costs)? {
                Attempt::Run(kept) => {
                    let runs = &mut outcome.runs[place];
                    self.cache.keep(&self.key(place, seed), &kept)?;
                    costs.learn(configuration, kept.core_seconds(), kept.run.simulated_seconds);
                    runs.push(*kept);
                    runs.sort_by_key(|kept| kept.run.seed);
                    outcome.made += 1;
                }
                Attempt::Failed(why) => {
                    outcome.failures.entry(place).or_insert((seed, why));
                }
                Attempt::Unsupported(error) => {
                    outcome.notes.push(error.to_string());
                    unsupported.insert(configuration.code.clone());
                }
                Attempt::Interrupted => {
                    outcome.interrupted = true;
                    break;
                }
            }
            done += clock.elapsed().as_secs_f64();
        }
        Ok(outcome)
    }

    /// Takes what is on the shelf; returns seed and place of what is not.
    fn find(&self, outcome: &mut Outcome, costs: &mut Costs) -> Result<BTreeSet<(u64, usize)>, CampaignError> {
        let mut missing = BTreeSet::new();
        for (place, configuration) in self.plan.configurations.iter().enumerate() {
            for seed in 1..=self.seeds {
                match self.cache.find(&self.key(place, seed))? {
                    Found::Run(kept) if self.serves(&kept) => {
                        costs.learn(configuration, kept.core_seconds(), kept.run.simulated_seconds);
                        outcome.runs[place].push(kept);
                        continue;
                    }
                    Found::Damaged(file) => outcome.notes.push(format!(
                        "a kept run was damaged and has been run again; the file is now {}",
                        file.display()
                    )),
                    Found::Run(_) | Found::Nothing => {}
                }
                missing.insert((seed, place));
            }
        }
        Ok(missing)
    }

    /// Whether a kept run is what would be run now: one that was cut short is not, where the limit has been raised.
    fn serves(&self, kept: &KeptRun) -> bool {
        !kept.extrapolated || kept.pace() * self.scene.duration > self.time_limit
    }

    /// What is run next: every configuration with its first seed, then with the next one. Within a seed the reference at
    /// the scene's stiffness comes first, without which nothing has an error, then what is cheapest.
    fn next(&self, missing: &BTreeSet<(u64, usize)>, costs: &Costs) -> Option<(u64, usize)> {
        let reference = self.plan.refinement(1.0).map(|refinement| refinement.grids[2]);
        let cost = |place: usize| costs.seconds(&self.plan.configurations[place]);
        missing.iter().copied().min_by(|a, b| {
            let later = |place: usize| Some(place) != reference;
            a.0.cmp(&b.0).then(later(a.1).cmp(&later(b.1))).then(cost(a.1).total_cmp(&cost(b.1)))
        })
    }

    /// Expected wall time of a run, s.
    fn expected(&self, place: usize, costs: &Costs) -> f64 {
        let seconds = costs.seconds(&self.plan.configurations[place]);
        if self.plan.is_grid(place) { seconds } else { seconds.min(self.time_limit) }
    }

    fn key(&self, place: usize, seed: u64) -> Key {
        let configuration = &self.plan.configurations[place];
        let version = self.code(configuration).and_then(|code| code.version()).unwrap_or_default();
        run_key(self.scene, configuration, &version, seed, &machine())
    }

    fn code(&self, configuration: &Configuration) -> Option<&dyn Code> {
        self.codes.iter().find(|code| code.name() == configuration.code).map(AsRef::as_ref)
    }

    /// One run, cut short where it may be and is expected to last, or turns out to last, beyond the limit.
    fn attempt(&self, task: &Task<'_>, costs: &mut Costs) -> Result<Attempt, CampaignError> {
        let configuration = &self.plan.configurations[task.place];
        let stretch = |costs: &Costs| task.may_cut.then(|| self.stretch(configuration, costs)).flatten();
        let mut simulated = stretch(costs);
        let mut clock = CoreClock::start();
        let began = Instant::now();
        let mut result = self.run(task, simulated);
        if let (Err((CodeError::TimedOut { .. }, share)), None, true) = (&result, simulated, task.may_cut) {
            // It took longer than expected: now it is known how long.
            costs.learn(
                configuration,
                began.elapsed().as_secs_f64() * clock.share().unwrap_or(1.0),
                share.max(1e-6) * self.scene.duration,
            );
            simulated =
                Some(stretch(costs).unwrap_or(0.5 * share * self.scene.duration).max(self.scene.measure.interval));
            clock = CoreClock::start();
            result = self.run(task, simulated);
        }
        let core_share = clock.share();
        match result {
            Ok(harvest) => {
                let mut run = harvest.run;
                run.measurements.retain(|measurement| measurement.value.is_finite());
                if simulated.is_some() {
                    // The end of the scene was not reached: nothing was measured that could be compared.
                    run.measurements.clear();
                }
                Ok(Attempt::Run(Box::new(KeptRun {
                    configuration: configuration.clone(),
                    extrapolated: simulated.is_some(),
                    core_share,
                    run,
                    build: Build::here(),
                    command: command_line(),
                })))
            }
            Err((CodeError::Interrupted { .. }, _)) => Ok(Attempt::Interrupted),
            Err((error @ CodeError::Unsupported { .. }, _)) => Ok(Attempt::Unsupported(error)),
            Err((
                error @ (CodeError::Crashed { .. }
                | CodeError::Worthless { .. }
                | CodeError::Output { .. }
                | CodeError::LongLog { .. }
                | CodeError::TimedOut { .. }),
                _,
            )) => Ok(Attempt::Failed(error.to_string())),
            Err((CodeError::Scene(error), _)) => Err(error.into()),
            Err((error, _)) => Err(error.into()),
        }
    }

    /// Simulated time that takes about the limit of wall time, s, a whole number of frames; absent where the whole
    /// duration does.
    fn stretch(&self, configuration: &Configuration, costs: &Costs) -> Option<f64> {
        let seconds = costs.seconds(configuration);
        if seconds <= self.time_limit {
            return None;
        }
        let (duration, interval) = (self.scene.duration, self.scene.measure.interval);
        let frames = (duration * self.time_limit / seconds / interval).floor().max(1.0);
        Some(frames * interval).filter(|stretch| *stretch < duration)
    }

    /// One run over `simulated` seconds, or all of the scene's; a failure comes with the share that was done. One that may
    /// be cut short is not waited for so long.
    fn run(&self, task: &Task<'_>, simulated: Option<f64>) -> Result<Harvest, (CodeError, f64)> {
        let configuration = &self.plan.configurations[task.place];
        let [before, own, all] = task.span;
        let mut scene = configuration.scene(self.scene);
        scene.duration = simulated.unwrap_or(scene.duration);
        let reached = Arc::new(AtomicU64::new(0));
        let announce = |_: &str| -> Share {
            let (progress, label, reached) = (self.progress.clone(), task.label.to_string(), reached.clone());
            Box::new(move |share| {
                reached.store(share.to_bits(), Ordering::Relaxed);
                progress(&label, (before + share * own) / all);
            })
        };
        let limit = self.time_limit * if task.may_cut && simulated.is_none() { PATIENCE } else { MORE_PATIENCE };
        let runs = Runs {
            scene: self.scene,
            scene_file: self.scene_file,
            purpose: Purpose::Timing,
            seeds: vec![task.seed],
            rayleigh_fraction: configuration.rayleigh_fraction().unwrap_or_default(),
            stiffness_factor: configuration.stiffness_factor,
            time_limit: Duration::from_secs_f64(limit),
            recordings: None,
            announce: &announce,
        };
        let Some(code) = self.code(configuration) else {
            return Err((CodeError::Missing { code: "a code of the plan" }, 0.0));
        };
        runs.one(code, &scene, task.seed).map_err(|error| (error, f64::from_bits(reached.load(Ordering::Relaxed))))
    }
}
