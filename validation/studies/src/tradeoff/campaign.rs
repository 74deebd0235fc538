//! Execution of a plan: one run after the other on one core, the reference and cheap ones first, each stored when it ends.

use super::plan::{Configuration, Knobs, Plan};
use makadam::scene::{SolverMethod, SolverSettings, Stop, populate};
use makadam_compare::codes::{Code, CodeError, CoreClock, Purpose};
use makadam_compare::compare::{Announce, MeasuredRun, Runs, Share};
use makadam_compare::scenes::in_file;
use makadam_compare::study::{Key, RunCache, RunError};
use makadam_frames::output::file_stem;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::{Build, command_line, machine, scene_hash};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Wall time at which a run is stopped, over the limit at which it is cut short beforehand: expected times err.
const PATIENCE: f64 = 3.0;

/// Factor for a run of known duration, from its first seed or because it was cut short: machines get busy.
const MORE_PATIENCE: f64 = 30.0;

/// Receives the label of the current run and the completed fraction of the expected wall time.
pub type Progress = Arc<dyn Fn(&str, f64) + Send + Sync>;

/// A plan and what it is carried out on.
pub struct Campaign<'a> {
    /// The scene as its file says it.
    pub scene: &'a MeasuredScene,
    /// Its file.
    pub scene_file: &'a Path,
    /// Configurations to run.
    pub plan: &'a Plan,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// The codes of the plan, Makadam among them.
    pub codes: &'a [Box<dyn Code>],
    /// Wall time beyond which a run is cut short and its wall time extrapolated, s.
    pub time_limit: f64,
    /// Finished runs.
    pub cache: &'a RunCache,
    /// Receives the progress.
    pub progress: Progress,
}

/// Result of a campaign.
pub struct Outcome {
    /// Runs of each configuration of the plan, in the order of seeds.
    pub runs: Vec<Vec<KeptRun>>,
    /// Runs that were made now; the others were there.
    pub made: usize,
    /// The first failure of each configuration that failed, by its place: the seed, and why.
    pub failures: BTreeMap<usize, (u64, String)>,
    /// Codes that cannot run the scene and files that were damaged, in sentences.
    pub notes: Vec<String>,
    /// True if the user asked to stop before the end.
    pub interrupted: bool,
}

impl Outcome {
    /// Nothing yet, of so many configurations.
    pub fn none(configurations: usize) -> Outcome {
        let runs = vec![Vec::new(); configurations];
        Outcome { runs, made: 0, failures: BTreeMap::new(), notes: Vec::new(), interrupted: false }
    }

    /// Failures and notes, in sentences.
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
    /// Runs what is not there yet.
    ///
    /// # Errors
    /// [`RunError`]; a run that fails by itself is only noted.
    pub fn carry_out(&self) -> Result<Outcome, RunError> {
        let grains = populate(self.scene, 1).map_err(in_file(self.scene_file))?;
        let mut costs = Costs {
            scene: self.scene,
            grains: grains.len() as f64,
            rayleigh_step: self.scene.rayleigh_step(&grains),
            known: BTreeMap::new(),
        };
        let configurations = &self.plan.configurations;
        let mut outcome = Outcome::none(configurations.len());
        let missing = self.find(&mut outcome, &mut costs)?;
        let mut unsupported: BTreeSet<String> = BTreeSet::new();
        for (number, &(seed, place)) in missing.iter().enumerate() {
            let configuration = &configurations[place];
            // A run that was cut short tells its wall time; another seed would tell the same.
            let known = outcome.runs[place].first().is_some_and(|first| first.extrapolated);
            // One that failed with a seed keeps no bound, whatever it does with the others; of a reference every seed counts.
            let known = known || outcome.failures.contains_key(&place) && !self.plan.is_grid(place);
            if known || unsupported.contains(&configuration.code) {
                continue;
            }
            let label = format!("{} {}, seed {seed}", configuration.code, configuration.setting());
            let (progress, count) = (self.progress.clone(), missing.len() as f64);
            let progress = Arc::new(move |fraction: f64| progress(&label, (number as f64 + fraction) / count));
            // Only a first seed: what it tells of the wall time decides for the others.
            let may_cut = outcome.runs[place].is_empty() && !self.plan.is_grid(place);
            match self.attempt(configuration, seed, may_cut, &mut costs, progress) {
                Ok(kept) => {
                    let runs = &mut outcome.runs[place];
                    self.cache.keep(&self.key(place, seed), &kept)?;
                    costs.learn(configuration, kept.core_seconds(), kept.run.simulated_seconds);
                    runs.push(kept);
                    runs.sort_by_key(|kept| kept.run.seed);
                    outcome.made += 1;
                }
                Err(CodeError::Interrupted { .. }) => {
                    outcome.interrupted = true;
                    break;
                }
                Err(error @ CodeError::Unsupported { .. }) => {
                    outcome.notes.push(error.to_string());
                    unsupported.insert(configuration.code.clone());
                }
                Err(
                    error @ (CodeError::Crashed { .. }
                    | CodeError::InvalidState { .. }
                    | CodeError::Output { .. }
                    | CodeError::TimedOut { .. }),
                ) => {
                    outcome.failures.entry(place).or_insert((seed, error.to_string()));
                }
                Err(error) => return Err(error.into()),
            }
        }
        Ok(outcome)
    }

    /// Takes what is stored; returns seed and place of what is not, in the order of execution: every configuration with its first seed,
    /// then with the next one. Within a seed the reference at the scene's stiffness comes first, without which nothing has an error,
    /// then what is cheapest.
    fn find(&self, outcome: &mut Outcome, costs: &mut Costs<'_>) -> Result<Vec<(u64, usize)>, RunError> {
        let mut missing = Vec::new();
        for (place, configuration) in self.plan.configurations.iter().enumerate() {
            for seed in 1..=self.seeds {
                let kept = self.cache.find::<KeptRun>(&self.key(place, seed))?;
                // One that was cut short may run longer under the present limit.
                let is_short =
                    |kept: &KeptRun| kept.extrapolated && kept.pace() * self.scene.duration <= self.time_limit;
                match kept.filter(|kept| !is_short(kept)) {
                    Some(kept) => {
                        costs.learn(configuration, kept.core_seconds(), kept.run.simulated_seconds);
                        outcome.runs[place].push(kept);
                    }
                    None => missing.push((seed, place)),
                }
            }
        }
        let reference = self.plan.refinement(1.0).map(|refinement| refinement.grids[2]);
        let cost = |place: usize| costs.seconds(&self.plan.configurations[place]);
        missing.sort_by(|a, b| {
            let later = |place: usize| Some(place) != reference;
            a.0.cmp(&b.0).then(later(a.1).cmp(&later(b.1))).then(cost(a.1).total_cmp(&cost(b.1)))
        });
        Ok(missing)
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
    fn attempt(
        &self,
        configuration: &Configuration,
        seed: u64,
        may_cut: bool,
        costs: &mut Costs<'_>,
        progress: Arc<impl Fn(f64) + Send + Sync + 'static>,
    ) -> Result<KeptRun, CodeError> {
        let mut simulated = may_cut.then(|| self.stretch(configuration, costs)).flatten();
        let reached = Arc::new(AtomicU64::new(0));
        let announce = |_: &str| -> Share {
            let (progress, reached) = (progress.clone(), reached.clone());
            Box::new(move |fraction| {
                reached.store(fraction.to_bits(), Ordering::Relaxed);
                progress(fraction);
            })
        };
        let run = |simulated: Option<f64>| {
            // A run that may be cut short is not waited for so long.
            let patience = if may_cut && simulated.is_none() { PATIENCE } else { MORE_PATIENCE };
            self.run(configuration, seed, simulated, patience * self.time_limit, &announce)
        };
        let (mut clock, began) = (CoreClock::start(), Instant::now());
        let mut result = run(simulated);
        if let (Err(CodeError::TimedOut { .. }), None, true) = (&result, simulated, may_cut) {
            // It took longer than expected: now it is known how long.
            let fraction = f64::from_bits(reached.load(Ordering::Relaxed));
            let wall = began.elapsed().as_secs_f64() * clock.share().unwrap_or(1.0);
            costs.learn(configuration, wall, fraction.max(1e-6) * self.scene.duration);
            let shorter = self.stretch(configuration, costs).unwrap_or(0.5 * fraction * self.scene.duration);
            simulated = Some(shorter.max(self.scene.measure.interval));
            clock = CoreClock::start();
            result = run(simulated);
        }
        let core_share = clock.share();
        let mut run = result?;
        run.measurements.retain(|measurement| measurement.value.is_finite());
        if simulated.is_some() {
            // The end of the scene was not reached: nothing was measured that could be compared.
            run.measurements.clear();
        }
        Ok(KeptRun {
            configuration: configuration.clone(),
            extrapolated: simulated.is_some(),
            core_share,
            run,
            build: Build::here(),
            command: command_line(),
        })
    }

    /// Simulated time that takes about the limit of wall time, s, a whole number of frames; absent where the whole
    /// duration does.
    fn stretch(&self, configuration: &Configuration, costs: &Costs<'_>) -> Option<f64> {
        let seconds = costs.seconds(configuration);
        if seconds <= self.time_limit {
            return None;
        }
        let (duration, interval) = (self.scene.duration, self.scene.measure.interval);
        let frames = (duration * self.time_limit / seconds / interval).floor().max(1.0);
        Some(frames * interval).filter(|stretch| *stretch < duration)
    }

    /// One run over `simulated` seconds, or all of the scene's.
    fn run(
        &self,
        configuration: &Configuration,
        seed: u64,
        simulated: Option<f64>,
        time_limit: f64,
        announce: Announce<'_>,
    ) -> Result<MeasuredRun, CodeError> {
        let mut scene = configuration.scene(self.scene);
        scene.duration = simulated.unwrap_or(scene.duration);
        let code = self.code(configuration).ok_or(CodeError::Missing { code: "a code of the plan" })?;
        let runs = Runs {
            scene: self.scene,
            scene_file: self.scene_file,
            purpose: Purpose::Timing,
            seeds: vec![seed],
            rayleigh_fraction: configuration.rayleigh_fraction().unwrap_or_default(),
            stiffness_factor: configuration.stiffness_factor,
            time_limit: Duration::from_secs_f64(time_limit),
            recordings: None,
            announce,
        };
        Ok(runs.one(code, &scene, seed)?.run)
    }
}

/// Stored result of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptRun {
    /// Its configuration.
    pub configuration: Configuration,
    /// True if it was stopped before the scene's end, so that it has a wall time and no measurements.
    pub extrapolated: bool,
    /// Share of a core that the run got, 0 to 1; absent where the system does not tell.
    pub core_share: Option<f64>,
    /// Its measurements and times.
    pub run: MeasuredRun,
    /// The program that started it, and the machine.
    pub build: Build,
    /// The command line.
    pub command: String,
}

impl KeptRun {
    /// Processor time of the stepping on one core, s; where the run does not tell it, wall time times the share of a core that it got.
    pub fn core_seconds(&self) -> f64 {
        self.run.core_seconds.unwrap_or(self.run.wall_seconds * self.core_share.unwrap_or(1.0))
    }

    /// Processor time per simulated second, s.
    pub fn pace(&self) -> f64 {
        self.core_seconds() / self.run.simulated_seconds
    }
}

/// The key of a seed's run: scene, knobs, seed, the code and its version (which holds the [key of the build](makadam::BUILD)
/// where the code is Makadam), the key of the sources that measure, and the processor, since a wall time of another one is another
/// number.
pub fn run_key(scene: &MeasuredScene, configuration: &Configuration, version: &str, seed: u64, processor: &str) -> Key {
    let scene = configuration.scene(scene);
    let knobs = serde_json::to_string(configuration).expect("a configuration holds only numbers and plain text");
    let name = format!("{}-{}-s{seed}", file_stem(&scene.name), configuration.code.to_lowercase());
    // Explicit codes are run from inputs for timing.
    let purpose = if configuration.rayleigh_fraction().is_some() { "timing" } else { "" };
    let scene = format!("{:016x}", scene_hash(&scene));
    Key::new(name, &[&scene, &knobs, version, &seed.to_string(), processor, makadam_compare::BUILD, purpose]).apart()
}

/// Time of a grain's step before anything has run, s: of the right order on a processor of the 2020s.
const GUESSES: [(&str, f64); 4] = [("Makadam", 1e-7), ("LIGGGHTS", 3e-7), ("LAMMPS", 5e-7), ("YADE", 9e-7)];

/// Cost of one sweep over the contacts of a grain, over that of everything else in a step of Makadam.
const SWEEP: f64 = 0.17;

/// Sweeps that a solve is expected to take where its residual or its time says when to stop.
const OPEN_ENDED: u32 = 20;

struct Costs<'a> {
    scene: &'a MeasuredScene,
    grains: f64,
    /// Rayleigh step at the scene's stiffness, s.
    rayleigh_step: f64,
    /// Wall time and expected units of the runs so far, by code.
    known: BTreeMap<String, [f64; 2]>,
}

impl Costs<'_> {
    /// Grain steps of a second, those of Makadam weighted by their sweeps.
    fn units(&self, configuration: &Configuration) -> f64 {
        let per_second = match &configuration.knobs {
            Knobs::Solver { settings, .. } => {
                let is_open = !matches!(settings.stop, Stop::Sweeps { .. });
                let sweeps = settings.stop.max_sweeps().min(if is_open { OPEN_ENDED } else { u32::MAX });
                (1.0 + SWEEP * f64::from(sweeps) * sweeps_of_iteration(settings)) / settings.step
            }
            // The Rayleigh step goes as the inverse root of the stiffness.
            Knobs::Explicit { rayleigh_fraction } => {
                configuration.stiffness_factor.sqrt() / (rayleigh_fraction * self.rayleigh_step)
            }
        };
        self.grains * per_second
    }

    /// Expected wall time of a run over the scene's whole duration, s.
    fn seconds(&self, configuration: &Configuration) -> f64 {
        let each = match self.known.get(&configuration.code) {
            Some([seconds, units]) => seconds / units,
            None => GUESSES.iter().find(|(code, _)| *code == configuration.code).map_or(1e-6, |guess| guess.1),
        };
        each * self.units(configuration) * self.scene.duration
    }

    /// Takes note of a run's wall time over a simulated time, both in s.
    fn learn(&mut self, configuration: &Configuration, wall: f64, simulated: f64) {
        let units = self.units(configuration) * simulated;
        let known = self.known.entry(configuration.code.clone()).or_default();
        known[0] += wall;
        known[1] += units;
    }
}

/// Wall time of an iteration over that of a sweep, from `reference-scenes/drum-50k/convergence`; a rough guide, which the runs
/// themselves correct.
fn sweeps_of_iteration(settings: &SolverSettings) -> f64 {
    let inner = f64::from(settings.inner_sweeps.max(1));
    match settings.method {
        SolverMethod::GaussSeidel => inner,
        SolverMethod::NonlinearConjugateGradients => inner + 1.7,
        SolverMethod::Anderson { .. } => inner + 3.9,
        SolverMethod::Jacobi { .. } => 3.9,
        SolverMethod::AcceleratedProjectedGradients | SolverMethod::ProjectedConjugateGradients => 6.0,
    }
}
