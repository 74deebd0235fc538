//! `makadam stability`: the hard cases, in Makadam and in other codes.

use super::arguments::StabilityArguments;
use super::{Console, Failure, OUTSIDE_TOLERANCE, installed, json};
use crate::stability::{Campaign, Case, catalogue, table};
use makadam::scene::suggestion;
use std::process::ExitCode;

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
    let codes = installed(&arguments.codes)?;
    arguments.jobs.apply()?;
    let [quick, all] = TIME_LIMITS;
    let time_limit = arguments.time_limit.unwrap_or(if arguments.quick { quick } else { all });
    let folder = arguments.output.folder("stability");
    let bar = console.bar("hard cases");
    let study = Campaign {
        cases: &cases,
        codes: &codes,
        time_limit,
        folder: &folder,
        again: arguments.restart,
        begins: &|case, code| bar.say(format!("{} in {}", case.name, code.name())),
        ended: &|case, outcome, share| {
            bar.set(share);
            let (words, seconds) = (outcome.verdict.words(), outcome.wall_seconds);
            console.detail(&format!("{} in {}: {words}, {seconds:.1} s", case.name, outcome.code));
        },
    }
    .carry_out()?;
    drop(bar);
    console.result(&if arguments.output.json { json(&study) } else { table(&study) })?;
    Ok(if study.as_stated { ExitCode::SUCCESS } else { ExitCode::from(OUTSIDE_TOLERANCE) })
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
        let known = || all.iter().map(|case| case.name.as_str());
        const ALL: &str = "makadam stability --list shows all";
        let refuse = |words: String| Err(Failure::Usage(words));
        match matched.next() {
            None => {
                let remedy = suggestion(filter, known(), ALL);
                return refuse(format!("no case or group has '{filter}' in its name; {remedy}"));
            }
            Some(first) if arguments.quick && first.long && matched.all(|case| case.long) => {
                return refuse(format!("every case that '{filter}' names is left out by --quick; {ALL}"));
            }
            Some(_) => {}
        }
    }
    Ok(all.into_iter().filter(wanted).collect())
}
