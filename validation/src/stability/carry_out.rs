//! A case in one code: run, measured, judged. A run that fails is an outcome.

use super::{Case, Evidence, Outcome, Verdict};
use crate::output::WriteError;
use crate::peers::{Code, CodeError, Job, Purpose};
use crate::scenes::{SceneError, named};
use crate::stepping::{Halt, Stepping, Taken, steps_in};
use crate::study::Finding;
use makadam::Simulation;
use makadam::scene::{Grain, Reaction, Watch, populate};
use makadam::snapshot::Snapshot;
use makadam::watch::{Trouble, Watchdog};
use std::path::Path;
use std::time::{Duration, Instant};

/// Time step of explicit codes over the Rayleigh step, where a case leaves the step to them.
const RAYLEIGH_FRACTION: f64 = 0.2;

/// Why a case could not be judged at all.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    /// The scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The user asked to stop; what is kept, in words.
    #[error("interrupted; what was computed so far is {0}")]
    Interrupted(String),
    /// The code is not there, or its files cannot be written.
    #[error(transparent)]
    Code(CodeError),
    /// The study cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// What came of a run: its frames, or the verdict and the reason why there are none.
type Run = Result<Frames, (Verdict, String)>;

struct Frames {
    frames: Vec<Snapshot>,
    time_step: f64,
}

impl Case {
    /// Runs the case in Makadam, on one thread.
    ///
    /// # Errors
    /// [`StabilityError`] if the scene is wrong or the user asked to stop.
    pub fn in_makadam(&self, limit: Duration) -> Result<Outcome, StabilityError> {
        let grains = populate(&self.scene, self.scene.seed).map_err(named(&self.name))?;
        let start = Instant::now();
        let run = self.simulate(limit)?;
        Ok(self.outcome("Makadam", &grains, run, start))
    }

    fn simulate(&self, limit: Duration) -> Result<Run, StabilityError> {
        let mut simulation = Simulation::new(&self.scene, self.scene.seed).map_err(named(&self.name))?;
        let time_step = simulation.time_step();
        let steps = steps_in(self.scene.duration, time_step).max(1);
        let mut frames = vec![simulation.snapshot()];
        // Where grains go and how deep they overlap is what the case judges.
        let [on_overlap, on_deep_overlap, on_escape, on_stagnation] = [Reaction::Ignore; 4];
        let watch = Watch { on_overlap, on_deep_overlap, on_escape, on_stagnation, ..self.scene.watch.clone() };
        let mut watchdog = Watchdog::new(&watch, &simulation);
        // Walls that close on each other leave a grain no place: what becomes of it is for the case to judge.
        let stepping = Stepping::new(steps, &|_| {})
            .framed(self.scene.measure.interval)
            .watched(&mut watchdog)
            .tolerating(|alarm| matches!(alarm.trouble, Trouble::Crossing { .. }))
            .within(limit);
        let keep = |simulation: &Simulation, taken: &Taken| frames.extend(taken.framed.then(|| simulation.snapshot()));
        match stepping.carry_out(&mut simulation, keep) {
            Ok(_) => Ok(Ok(Frames { frames, time_step })),
            Err(Halt::Worthless(alarm)) => Ok(Err((Verdict::Crashed, alarm.to_string()))),
            Err(Halt::Interrupted) => Err(StabilityError::Interrupted("nothing".into())),
            Err(Halt::OutOfTime(share)) => {
                let (seconds, done) = (limit.as_secs_f64(), 100.0 * share);
                Ok(Err((Verdict::TookTooLong, format!("stopped after {seconds} s at {done:.0}% of the run"))))
            }
        }
    }

    /// Runs the case in another code; its files go to `folder`.
    ///
    /// # Errors
    /// [`StabilityError`] if the code is not there, its files cannot be written, or the user asked to stop.
    pub fn in_peer(&self, code: &dyn Code, folder: &Path, limit: Duration) -> Result<Outcome, StabilityError> {
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
            Ok(recording) => Ok(Frames { frames: recording.frames, time_step: recording.time_step }),
            Err(CodeError::Interrupted { .. }) => return Err(StabilityError::Interrupted("nothing".into())),
            Err(CodeError::Scene(error)) => return Err(error.into()),
            Err(CodeError::Unsupported { reason, .. }) => Err((Verdict::CannotBeExpressed, reason)),
            Err(CodeError::TimedOut { seconds, .. }) => {
                Err((Verdict::TookTooLong, format!("stopped after {seconds} s")))
            }
            Err(CodeError::Crashed { status, tail, .. }) => Err((Verdict::Crashed, format!("{status}: {tail}"))),
            Err(CodeError::Output { problem, .. }) => Err((Verdict::Crashed, problem)),
            Err(error @ CodeError::LongLog { .. }) => Err((Verdict::Crashed, error.to_string())),
            Err(error) => return Err(StabilityError::Code(error)),
        };
        Ok(self.outcome(code.name(), &grains, run, start))
    }

    fn outcome(&self, code: &str, grains: &[Grain], run: Run, start: Instant) -> Outcome {
        let (verdict, findings, reason, time_step) = match run {
            Err((verdict, reason)) => (verdict, Vec::new(), Some(reason), None),
            Ok(Frames { frames, time_step }) => {
                let evidence = Evidence::new(&self.scene, grains, &frames);
                match evidence.is_finite() {
                    false => {
                        (Verdict::Crashed, Vec::new(), Some("a number is not finite".to_string()), Some(time_step))
                    }
                    true => {
                        let findings = (self.judge)(&evidence);
                        let verdict =
                            if findings.iter().all(Finding::holds) { Verdict::AsStated } else { Verdict::NotAsStated };
                        (verdict, findings, None, Some(time_step))
                    }
                }
            }
        };
        let wall_seconds = start.elapsed().as_secs_f64();
        Outcome { code: code.into(), verdict, findings, reason, time_step, wall_seconds }
    }
}
