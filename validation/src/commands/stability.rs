//! `makadam stability`: the hard cases, in Makadam and in other codes.

use super::arguments::StabilityArguments;
use super::compare::codes;
use super::{Console, Failure, OUTSIDE_TOLERANCE, json, use_threads};
use crate::nearest::nearest;
use crate::output::{JSON_VERSION, create_folder, write_whole};
use crate::peers::Code;
use crate::provenance::account;
use crate::stability::{Case, CaseResult, StabilityError, Study, catalogue, markdown, table};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Wall time after which a run is stopped where none is given, s: of the quick catalogue, and of all cases.
const TIME_LIMITS: [f64; 2] = [60.0, 600.0];

/// Runs the cases that were asked for, writes what came of them, and says it.
pub(super) fn stability(arguments: &StabilityArguments, console: &Console) -> Result<ExitCode, Failure> {
    let cases = chosen(arguments)?;
    if arguments.list {
        let lines: Vec<String> =
            cases.iter().map(|case| format!("{}: {}\n  because: {}", case.name, case.right, case.source)).collect();
        console.result(&lines.join("\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let codes = codes(&arguments.codes);
    if let Some(code) = codes.iter().find(|code| code.version().is_none()) {
        return Err(Failure::MissingCode(format!(
            "{} is not installed; run scripts/install-peers, or leave it out with --codes",
            code.name()
        )));
    }
    use_threads(arguments.threads)?;
    let [quick, all] = TIME_LIMITS;
    let time_limit = arguments.time_limit.unwrap_or(if arguments.quick { quick } else { all });
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from("results").join("stability"));
    create_folder(&folder.join("scenes"))?;
    for case in &cases {
        let text = toml::to_string(&case.scene).expect("a scene is made of plain tables");
        write_whole(&folder.join("scenes").join(format!("{}.toml", case.name)), text.as_bytes())?;
    }
    let empty = Study {
        version: JSON_VERSION,
        command: "stability",
        as_stated: true,
        cases: Vec::new(),
        unfinished: cases.iter().map(|case| case.name.clone()).collect(),
        codes: codes.iter().filter_map(|code| Some((code.name().to_string(), code.version()?))).collect(),
        time_limit,
        provenance: account(rayon::current_num_threads(), &[]),
    };
    let kept = Kept { folder: folder.clone(), study: Mutex::new(empty) };
    run(&cases, &codes, &folder, &kept, console)?;
    let study = kept.study.into_inner().expect("nothing panics while it holds the lock");
    console.result(&if arguments.json { json(&study) } else { table(&study) })?;
    Ok(if study.as_stated { ExitCode::SUCCESS } else { ExitCode::from(OUTSIDE_TOLERANCE) })
}

/// A study that is written with each case that is finished.
struct Kept {
    folder: PathBuf,
    study: Mutex<Study>,
}

impl Kept {
    /// Takes in a case; `cases` is the catalogue's order.
    fn add(&self, result: CaseResult, cases: &[Case]) -> Result<(), Failure> {
        let mut study = self.study.lock().expect("nothing panics while it holds the lock");
        study.unfinished.retain(|name| *name != result.name);
        study.cases.push(result);
        study.cases.sort_by_key(|result| cases.iter().position(|case| case.name == result.name));
        study.as_stated = Study::all_as_stated(&study.cases);
        write_whole(&self.folder.join("stability.md"), markdown(&study).as_bytes())?;
        Ok(write_whole(&self.folder.join("stability.json"), json(&*study).as_bytes())?)
    }

    /// What an interruption leaves, in words.
    fn words(&self) -> String {
        let study = self.study.lock().expect("nothing panics while it holds the lock");
        match study.cases.len() {
            0 => "nothing: no case was finished".into(),
            count => format!("{count} finished cases in {}", self.folder.join("stability.json").display()),
        }
    }
}

/// The cases of the catalogue whose name or group contains one of the filters; all, if there is none.
fn chosen(arguments: &StabilityArguments) -> Result<Vec<Case>, Failure> {
    let wanted = |case: &Case| {
        let mut filters = arguments.cases.iter();
        let named = arguments.cases.is_empty()
            || filters.any(|filter| case.name.contains(filter.as_str()) || case.group.contains(filter.as_str()));
        named && !(arguments.quick && case.long)
    };
    let all = catalogue();
    for filter in &arguments.cases {
        let mut matched =
            all.iter().filter(|case| case.name.contains(filter.as_str()) || case.group.contains(filter.as_str()));
        let near = || nearest(filter, all.iter().map(|case| case.name.as_str()), 5).join(", ");
        let refuse = |words: String| Err(Failure::Usage(format!("{words}; makadam stability --list shows all")));
        match matched.next() {
            None => return refuse(format!("no case or group has '{filter}' in its name; the nearest are {}", near())),
            Some(first) if arguments.quick && first.long && matched.all(|case| case.long) => {
                return refuse(format!("every case that '{filter}' names is left out by --quick"));
            }
            Some(_) => {}
        }
    }
    Ok(all.into_iter().filter(wanted).collect())
}

/// Runs every case in every code, several side by side, and keeps those that are finished.
fn run(cases: &[Case], codes: &[Box<dyn Code>], folder: &Path, kept: &Kept, console: &Console) -> Result<(), Failure> {
    let limit = kept.study.lock().expect("nothing panics while it holds the lock").time_limit;
    let limit = Duration::from_secs_f64(limit);
    let bar = console.bar("hard cases");
    let (done, runs) = (AtomicUsize::new(0), cases.len() * codes.len());
    let one = |case: &Case, code: &dyn Code| {
        bar.say(format!("{} in {}", case.name, code.name()));
        let outcome = match code.name() {
            "Makadam" => case.in_makadam(limit),
            name => case.in_peer(code, &folder.join("runs").join(&case.name).join(name), limit),
        };
        bar.set((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / runs as f64);
        if let Ok(outcome) = &outcome {
            let words = outcome.verdict.words();
            console.detail(&format!("{} in {}: {words}, {:.1} s", case.name, outcome.code, outcome.wall_seconds));
        }
        outcome
    };
    let finish = |case: &Case| -> Result<(), Failure> {
        let outcomes: Result<Vec<_>, StabilityError> = codes.par_iter().map(|code| one(case, &**code)).collect();
        let outcomes = outcomes.map_err(|error| match error {
            StabilityError::Scene(error) => Failure::Scene(error),
            StabilityError::Interrupted => Failure::Interrupted(kept.words()),
            StabilityError::Code(error) => error.into(),
        })?;
        kept.add(CaseResult::new(case, outcomes), cases)
    };
    cases.par_iter().map(finish).collect()
}
