//! The campaign of stress tests: cases in codes, side by side; each outcome is stored as soon as it is there, and the study is written with each
//! case that is finished. A run that fails is an outcome.

use super::{Case, CaseResult, Evidence, Outcome, Study, Verdict, markdown};
use crate::output::{JSON_VERSION, WriteError, create_folder, write_whole};
use crate::peers::{Code, CodeError, Job, Purpose};
use crate::provenance::{JUDGE, account, scene_hash};
use crate::scenes::{SceneError, named};
use crate::stepping::{Halt, Stepping, Taken, steps_in};
use crate::study::{Finding, Key, RunCache};
use makadam::scene::{Grain, Reaction, Watch, populate};
use makadam::snapshot::Snapshot;
use makadam::watch::{Trouble, Watchdog};
use makadam::{BUILD, Simulation};
use rayon::prelude::*;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// What is run.
pub struct Campaign<'a> {
    /// The cases, in the order in which they are shown.
    pub cases: &'a [Case],
    /// The codes.
    pub codes: &'a [Box<dyn Code>],
    /// Wall time after which a run is stopped, s.
    pub time_limit: f64,
    /// Folder of the study.
    pub folder: &'a Path,
    /// Whether cases are run again whose outcomes an earlier start has kept.
    pub again: bool,
    /// Told what begins.
    pub begins: &'a (dyn Fn(&Case, &dyn Code) + Sync),
    /// Told what has ended, and the share of all runs that have, 0 to 1.
    pub ended: &'a (dyn Fn(&Case, &Outcome, f64) + Sync),
}

impl Campaign<'_> {
    /// Runs every case in every code; `scenes`, `stability.md` and `stability.json` are written into the folder.
    ///
    /// # Errors
    /// [`StabilityError`]; what is finished stays written.
    pub fn carry_out(&self) -> Result<Study, StabilityError> {
        self.write_scenes()?;
        let study = Mutex::new(Study {
            version: JSON_VERSION,
            command: "stability",
            as_stated: true,
            cases: Vec::new(),
            unfinished: self.cases.iter().map(|case| case.name.clone()).collect(),
            codes: self.codes.iter().filter_map(|code| Some((code.name().to_string(), code.version()?))).collect(),
            time_limit: self.time_limit,
            provenance: account(rayon::current_num_threads(), &[]),
        });
        let done = AtomicUsize::new(0);
        let finish = |case: &Case| -> Result<(), StabilityError> {
            let outcomes =
                self.codes.par_iter().map(|code| self.run(case, &**code, &done)).collect::<Result<_, _>>()?;
            let mut study = study.lock().expect("nothing panics while it holds the lock");
            Ok(self.add(&mut study, CaseResult::new(case, outcomes))?)
        };
        let ended: Result<(), StabilityError> = self.cases.par_iter().map(finish).collect();
        let study = study.into_inner().expect("nothing panics while it holds the lock");
        match ended {
            Ok(()) => Ok(study),
            Err(StabilityError::Interrupted(_)) => Err(StabilityError::Interrupted(match study.cases.len() {
                0 => "nothing: no case was finished".into(),
                count => format!("{count} finished cases in {}", self.folder.join("stability.json").display()),
            })),
            Err(error) => Err(error),
        }
    }

    fn run(&self, case: &Case, code: &dyn Code, done: &AtomicUsize) -> Result<Outcome, StabilityError> {
        let outcome = self.take(case, code, self.again)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.ended)(case, &outcome, done as f64 / (self.cases.len() * self.codes.len()) as f64);
        Ok(outcome)
    }

    /// How a case ended in a code: the outcome that is kept, unless it is to be made `again`; else that of a run now, which is kept.
    ///
    /// # Errors
    /// [`StabilityError`] if it has to be run and cannot.
    pub fn take(&self, case: &Case, code: &dyn Code, again: bool) -> Result<Outcome, StabilityError> {
        let cache = RunCache::open(&self.folder.join("outcomes"))?;
        cache.take(&self.key(case, code), again, || {
            (self.begins)(case, code);
            let limit = Duration::from_secs_f64(self.time_limit);
            match code.name() {
                "Makadam" => case.in_makadam(limit),
                name => case.in_peer(code, &self.folder.join("runs").join(&case.name).join(name), limit),
            }
        })
    }

    /// What an outcome follows from: the case, the code, how long it may take, the build, and the sources that judge.
    fn key(&self, case: &Case, code: &dyn Code) -> Key {
        let parts = [
            format!("{:016x}", scene_hash(&case.scene)),
            format!("{:?}", case.peer_step),
            format!("{} {}, {}", code.name(), code.version().unwrap_or_default(), code.contact_law()),
            self.time_limit.to_string(),
            BUILD.to_string(),
            JUDGE.to_string(),
        ];
        let name = format!("{}-{}", case.name, code.name().to_lowercase());
        Key::new(name, &parts.each_ref().map(String::as_str))
    }

    /// Takes in a case and writes the study.
    fn add(&self, study: &mut Study, result: CaseResult) -> Result<(), WriteError> {
        study.unfinished.retain(|name| *name != result.name);
        study.cases.push(result);
        study.cases.sort_by_key(|result| self.cases.iter().position(|case| case.name == result.name));
        study.as_stated = Study::all_as_stated(&study.cases);
        write_whole(&self.folder.join("stability.md"), markdown(study).as_bytes())?;
        let json = serde_json::to_vec_pretty(study).expect("a study holds only numbers, plain text and lists");
        write_whole(&self.folder.join("stability.json"), &json)
    }

    /// Writes the scene of each case to `scenes/CASE.toml`, to be run by hand.
    fn write_scenes(&self) -> Result<(), WriteError> {
        let folder = self.folder.join("scenes");
        create_folder(&folder)?;
        self.cases.iter().try_for_each(|case| {
            let text = toml::to_string(&case.scene).expect("a scene is made of plain tables");
            write_whole(&folder.join(format!("{}.toml", case.name)), text.as_bytes())
        })
    }
}

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
