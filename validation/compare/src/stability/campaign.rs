//! Runs of stress tests: cases in codes, side by side. Each outcome is stored when its run ends.

use super::{Case, Evidence, Outcome, Verdict, figure};
use crate::codes::{Code, CodeError, Job, Purpose};
use crate::scenes::named;
use crate::study::{
    Answer, Cell, Document, Finding, Key, Medium, Report, RunCache, RunError, Section, Table, run_jobs, write_scenes,
};
use makadam::Simulation;
use makadam::scene::{Grain, Reaction, Watch, populate};
use makadam::snapshot::Snapshot;
use makadam::watch::{Trouble, Watchdog};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::provenance::{account, facts, scene_hash};
use makadam_frames::stepping::{Halt, Stepping, Taken, steps_in};
use makadam_view::draw::numbers::bounds;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// Time step of explicit codes over the Rayleigh step, where a case leaves the choice to them.
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

impl<'a> Campaign<'a> {
    /// Runs every case in every code, and writes scenes and study into the folder. `ended` receives each outcome, `progress` the fraction
    /// of the work that is done.
    ///
    /// # Errors
    /// [`RunError`]; the outcomes of earlier cases are stored.
    pub fn run(
        &self,
        ended: &(dyn Fn(&Case, &Outcome) + Sync),
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Study<'a>, RunError> {
        write_scenes(self.cases.iter().map(|case| &case.scene), self.folder)?;
        let cases: Vec<&'a Case> = self.cases.iter().collect();
        let work = |case: &&Case| (case.scene.grain_count() + 1) as f64 * case.scene.duration / case.scene.solver.step;
        let cases = run_jobs(&cases, work, progress, |&case, _| -> Result<_, RunError> {
            let outcome = |code: &dyn Code| self.outcome(case, code).inspect(|outcome| ended(case, outcome));
            let outcomes = self.codes.par_iter().map(|code| outcome(code.as_ref())).collect::<Result<_, _>>()?;
            Ok(CaseResult { case, scene_hash: format!("{:016x}", scene_hash(&case.scene)), outcomes })
        })?;
        let of_makadam = cases.iter().flat_map(|case| &case.outcomes).filter(|outcome| outcome.code == "Makadam");
        let as_stated = of_makadam.map(|outcome| outcome.verdict).all(|verdict| verdict == Verdict::AsStated);
        let codes = self.codes.iter();
        let study = Study {
            version: JSON_VERSION,
            command: "stability",
            as_stated,
            cases,
            codes: codes.filter_map(|code| Some((code.name().to_string(), code.version()?))).collect(),
            time_limit: self.time_limit,
            provenance: account(rayon::current_num_threads(), &[]),
        };
        study.write(self.folder)?;
        Ok(study)
    }

    /// Returns the outcome of a case in a code, from the cache or from a run.
    ///
    /// # Errors
    /// [`RunError`] if a run is necessary and fails.
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

/// Frames and time step (s) of a run, or the verdict and the reason for their absence.
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
        // The case itself tests positions and overlaps of grains.
        let [on_overlap, on_deep_overlap, on_escape, on_stagnation] = [Reaction::Ignore; 4];
        let watch = Watch { on_overlap, on_deep_overlap, on_escape, on_stagnation, ..self.scene.watch.clone() };
        let mut watchdog = Watchdog::new(&watch, &simulation);
        // Closing walls may leave no space for a grain: the case tests the result.
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

/// A case and its outcomes.
#[derive(Serialize)]
pub struct CaseResult<'a> {
    #[serde(flatten)]
    pub case: &'a Case,
    /// Hash of the scene, 16 hexadecimal digits.
    pub scene_hash: String,
    /// Outcomes by code, in the order of the columns.
    pub outcomes: Vec<Outcome>,
}

/// Content of `stability.json`.
#[derive(Serialize)]
pub struct Study<'a> {
    /// Version of this document.
    pub version: u32,
    /// "stability".
    pub command: &'static str,
    /// True if all cases of Makadam ended as stated.
    pub as_stated: bool,
    /// Cases, in the order of the catalogue.
    pub cases: Vec<CaseResult<'a>>,
    /// Version of each code that ran.
    pub codes: BTreeMap<String, String>,
    /// Wall time after which a run was stopped, s.
    pub time_limit: f64,
    pub provenance: BTreeMap<String, String>,
}

impl<'a> Study<'a> {
    /// Codes of the columns.
    fn columns(&self) -> Vec<&str> {
        self.cases.first().map_or(Vec::new(), |case| case.outcomes.iter().map(|one| one.code.as_str()).collect())
    }

    /// Returns the number of cases by verdict in the code of a column, as a sentence.
    fn count(&self, column: usize, code: &str) -> String {
        let count =
            |wanted: &Verdict| self.cases.iter().filter(|case| case.outcomes[column].verdict == *wanted).count();
        let [as_stated, others @ ..] = Verdict::ALL;
        let others = others.iter().filter(|verdict| count(verdict) > 0);
        let others: String = others.map(|verdict| format!(", {} {}", count(verdict), verdict.words())).collect();
        format!("{code}: {} of {} as stated{others}.", count(&as_stated), self.cases.len())
    }
}

impl Document for Study<'_> {
    const NAME: &'static str = "stability";

    fn report(&self) -> Report {
        let columns = self.columns();
        let heads = |words: [&'static str; 2]| [words.as_slice(), &columns].concat();
        let mut short = Table::new(&heads(["group", "case"]), &[]);
        let mut sections = Vec::new();
        for cases in self.cases.chunk_by(|one, next| one.case.group == next.case.group) {
            short.group(cases[0].case.group, cases, |case| {
                [case.case.name.as_str().into()]
                    .into_iter()
                    .chain(case.outcomes.iter().map(|one| cell(one, false)))
                    .collect()
            });
            let table = Table::new(&heads(["case", "what is right"]), &[]).of(cases, |case| {
                let name = [&case.case.name, &case.case.right].map(Cell::from);
                name.into_iter().chain(case.outcomes.iter().map(|one| cell(one, true))).collect()
            });
            sections.push(Section::new(title(cases[0].case.group), "", table).only(Medium::Page));
        }
        sections.push(Section::new("Verdicts", "", short).only(Medium::Terminal));
        let codes = self.codes.iter().map(|(name, version)| format!("{name} {version}"));
        let counts: Vec<String> = columns.iter().enumerate().map(|(column, code)| self.count(column, code)).collect();
        let word = if self.as_stated { "As stated." } else { "Not as stated." };
        Report {
            kind: "Makadam, stress tests",
            title: "Stress tests".into(),
            facts: codes
                .chain([format!("limit {} s per run", self.time_limit)])
                .chain(facts(&self.provenance))
                .collect(),
            answer: Answer::of(self.as_stated, word.into(), counts.join(" ")),
            findings: Vec::new(),
            sections,
            notes: self.cases.iter().flat_map(remarks).collect(),
            limits: vec!["Bounds follow from closed forms, conservation laws and the geometry of containers.".into()],
            provenance: self.provenance.clone().into_iter().collect(),
            files: "stability.json",
        }
    }
}

/// Verdict of an outcome and its decisive figure, with the figure's name where space permits.
fn cell(outcome: &Outcome, named: bool) -> Cell {
    let text = match outcome.telling() {
        Some(finding) if !named => format!("{} ({})", outcome.verdict.words(), figure(finding.value, &finding.unit)),
        _ => outcome.text(),
    };
    Cell::from(text).strong(named && outcome.verdict == Verdict::NotAsStated)
}

/// Deviations of a case from its expected outcome, one per code, with figures and bounds.
fn remarks<'r>(CaseResult { case, outcomes, .. }: &'r CaseResult<'_>) -> impl Iterator<Item = String> + 'r {
    let sentence = |finding: &Finding| {
        let number = |value: f64| figure(value, &finding.unit);
        format!("{} {}, right is {}", finding.what, number(finding.value), bounds([finding.low, finding.high], number))
    };
    let deviating = outcomes.iter().filter(|outcome| outcome.verdict != Verdict::AsStated);
    deviating.map(move |outcome| {
        let outside = outcome.findings.iter().filter(|finding| !finding.holds()).map(sentence);
        let why = outcome.reason.clone().unwrap_or_else(|| outside.collect::<Vec<_>>().join("; "));
        format!("{} in {}: {}: {why}", case.name, outcome.code, outcome.verdict.words())
    })
}

/// Name of a group with a capital.
fn title(group: &str) -> String {
    let mut letters = group.chars();
    letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default() + letters.as_str()
}
