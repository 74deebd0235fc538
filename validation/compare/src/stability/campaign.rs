//! Runs of stress tests: cases in codes, side by side. Each outcome is stored when its run ends, and the study is written with each
//! finished case.

use super::{Case, CaseResult, Evidence, Outcome, Study, Verdict};
use crate::codes::{Code, CodeError, Job, Purpose};
use crate::scenes::named;
use crate::study::{Document, Finding, Key, RunCache, RunError, run_jobs, write_scenes};
use makadam::Simulation;
use makadam::scene::{Grain, Reaction, Watch, populate};
use makadam::snapshot::Snapshot;
use makadam::watch::{Trouble, Watchdog};
use makadam_frames::stepping::{Halt, Stepping, Taken, steps_in};
use rayon::prelude::*;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time step of explicit codes over the Rayleigh step, where a case leaves the step to them.
const RAYLEIGH_FRACTION: f64 = 0.2;

/// Cases and the codes that run them.
pub struct Campaign<'a> {
    /// Cases, in the order of the tables.
    pub cases: &'a [Case],
    /// Codes that run each case.
    pub codes: &'a [Box<dyn Code>],
    /// Wall time after which a run is stopped, s.
    pub time_limit: f64,
    /// Folder of the study.
    pub folder: &'a Path,
    /// Stored outcomes.
    pub cache: &'a RunCache,
}

impl Campaign<'_> {
    /// Runs every case in every code, and writes scenes and study into the folder. `ended` receives each outcome, `progress` the fraction
    /// of the work that is done.
    ///
    /// # Errors
    /// [`RunError`]; finished cases stay written.
    pub fn run(
        &self,
        ended: &(dyn Fn(&Case, &Outcome) + Sync),
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Study, RunError> {
        write_scenes(self.cases.iter().map(|case| &case.scene), self.folder)?;
        let study = Mutex::new(Study::new(self));
        let work = |case: &Case| (case.scene.grain_count() + 1) as f64 * case.scene.duration / case.scene.solver.step;
        run_jobs(self.cases, work, progress, |case, _| -> Result<(), RunError> {
            let outcome = |code: &dyn Code| self.outcome(case, code).inspect(|outcome| ended(case, outcome));
            let outcomes = self.codes.par_iter().map(|code| outcome(code.as_ref())).collect::<Result<_, _>>()?;
            let mut study = study.lock().expect("nothing panics while it holds the lock");
            study.add(CaseResult::new(case, outcomes), self.cases);
            study.write(self.folder)?;
            Ok(())
        })?;
        Ok(study.into_inner().expect("nothing panics while it holds the lock"))
    }

    /// Returns the outcome of a case in a code, stored or of a run now.
    ///
    /// # Errors
    /// [`RunError`] if it has to be run and cannot.
    pub fn outcome(&self, case: &Case, code: &dyn Code) -> Result<Outcome, RunError> {
        let version = format!("{} {}, {}", code.name(), code.version().unwrap_or_default(), code.contact_law());
        let settings = format!("{:?} {}", case.peer_step, self.time_limit);
        let name = format!("{}-{}", case.name, code.name().to_lowercase());
        self.cache.take(&Key::of_run(name, &case.scene, case.scene.seed, &[&version, &settings]), || {
            let limit = Duration::from_secs_f64(self.time_limit);
            match code.name() {
                "Makadam" => case.in_makadam(limit),
                name => case.in_peer(code, &self.folder.join("runs").join(&case.name).join(name), limit),
            }
        })
    }
}

/// Frames and time step (s) of a run, or the verdict and the reason for which there are none.
type Run = Result<(Vec<Snapshot>, f64), (Verdict, String)>;

impl Case {
    /// Runs the case in Makadam, on one thread.
    ///
    /// # Errors
    /// [`RunError`] if the scene is wrong or the user asked to stop.
    pub fn in_makadam(&self, limit: Duration) -> Result<Outcome, RunError> {
        let grains = populate(&self.scene, self.scene.seed).map_err(named(&self.name))?;
        let start = Instant::now();
        let run = self.simulate(limit)?;
        Ok(self.judged("Makadam", &grains, run, start))
    }

    fn simulate(&self, limit: Duration) -> Result<Run, RunError> {
        let mut simulation = Simulation::new(&self.scene, self.scene.seed).map_err(named(&self.name))?;
        let time_step = simulation.time_step();
        let steps = steps_in(self.scene.duration, time_step).max(1);
        let mut frames = vec![simulation.snapshot()];
        // The case itself tests where grains go and how deep they overlap.
        let [on_overlap, on_deep_overlap, on_escape, on_stagnation] = [Reaction::Ignore; 4];
        let watch = Watch { on_overlap, on_deep_overlap, on_escape, on_stagnation, ..self.scene.watch.clone() };
        let mut watchdog = Watchdog::new(&watch, &simulation);
        // Walls that close on each other leave a grain no place: the case tests what becomes of it.
        let stepping = Stepping::new(steps, &|_| {})
            .framed(self.scene.measure.interval)
            .watched(&mut watchdog)
            .tolerating(|alarm| matches!(alarm.trouble, Trouble::Crossing { .. }))
            .within(limit);
        let keep = |simulation: &Simulation, taken: &Taken| frames.extend(taken.framed.then(|| simulation.snapshot()));
        match stepping.carry_out(&mut simulation, keep) {
            Ok(_) => Ok(Ok((frames, time_step))),
            Err(Halt::InvalidState(alarm)) => Ok(Err((Verdict::Crashed, alarm.to_string()))),
            Err(Halt::Interrupted) => Err(RunError::Interrupted),
            Err(Halt::OutOfTime(fraction)) => {
                let (seconds, done) = (limit.as_secs_f64(), 100.0 * fraction);
                Ok(Err((Verdict::TookTooLong, format!("stopped after {seconds} s at {done:.0}% of the run"))))
            }
        }
    }

    /// Runs the case in another code; its files go to `folder`.
    fn in_peer(&self, code: &dyn Code, folder: &Path, limit: Duration) -> Result<Outcome, RunError> {
        let grains = populate(&self.scene, self.scene.seed).map_err(named(&self.name))?;
        let rayleigh_step = self.scene.rayleigh_step(&grains);
        let job = Job {
            scene: &self.scene,
            scene_file: Path::new(&self.name),
            purpose: Purpose::Measuring,
            seed: self.scene.seed,
            stiffness_factor: 1.0,
            rayleigh_fraction: self.peer_step.map_or(RAYLEIGH_FRACTION, |step| step / rayleigh_step),
            work_folder: folder,
            time_limit: limit,
            progress: &|_| {},
        };
        let start = Instant::now();
        let run = match code.simulate(&job) {
            Ok(recording) => Ok((recording.frames, recording.time_step)),
            Err(CodeError::Unsupported { reason, .. }) => Err((Verdict::CannotBeExpressed, reason)),
            Err(CodeError::TimedOut { seconds, .. }) => {
                Err((Verdict::TookTooLong, format!("stopped after {seconds} s")))
            }
            Err(CodeError::Crashed { status, tail, .. }) => Err((Verdict::Crashed, format!("{status}: {tail}"))),
            Err(CodeError::Output { problem, .. }) => Err((Verdict::Crashed, problem)),
            Err(error @ CodeError::LongLog { .. }) => Err((Verdict::Crashed, error.to_string())),
            Err(error) => return Err(error.into()),
        };
        Ok(self.judged(code.name(), &grains, run, start))
    }

    fn judged(&self, code: &str, grains: &[Grain], run: Run, start: Instant) -> Outcome {
        let time_step = run.as_ref().ok().map(|(_, step)| *step);
        let measured = run.and_then(|(frames, _)| {
            let evidence = Evidence::new(&self.scene, grains, &frames);
            match evidence.is_finite() {
                true => Ok((self.judge)(&evidence)),
                false => Err((Verdict::Crashed, "a number is not finite".into())),
            }
        });
        let (verdict, findings, reason) = match measured {
            Ok(findings) if findings.iter().all(Finding::holds) => (Verdict::AsStated, findings, None),
            Ok(findings) => (Verdict::NotAsStated, findings, None),
            Err((verdict, reason)) => (verdict, Vec::new(), Some(reason)),
        };
        let wall_seconds = start.elapsed().as_secs_f64();
        Outcome { code: code.into(), verdict, findings, reason, time_step, wall_seconds }
    }
}
