//! `makadam stability`: stress tests, in Makadam and in reference codes.

use super::arguments::{StudyArguments, time_limit};
use super::compare::installed;
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam::scene::suggestion;
use makadam_compare::codes::CodeName;
use makadam_compare::stability::{Campaign, Case, catalogue};
use makadam_compare::study::{Document, RunCache};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct StabilityArguments {
    /// Parts of names of cases or groups; if absent, all cases.
    pub cases: Vec<String>,
    /// Leave out the cases that take more than a few seconds.
    #[arg(long)]
    pub quick: bool,
    /// List the cases with the expected outcome and the reason for it; run none.
    #[arg(long, conflicts_with = "json")]
    pub list: bool,
    /// Codes that take part, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "makadam")]
    pub codes: Vec<CodeName>,
    /// Wall time after which a run is stopped, s; if absent, 600, or 60 with --quick.
    #[arg(long, value_parser = time_limit)]
    pub time_limit: Option<f64>,
    #[command(flatten)]
    pub study: StudyArguments,
}

pub(super) fn stability(arguments: &StabilityArguments, console: &Console) -> Result<ExitCode, Failure> {
    let cases = chosen(arguments)?;
    if arguments.list {
        let lines: Vec<String> =
            cases.iter().map(|case| format!("{}: {}\n  because: {}", case.name, case.right, case.source)).collect();
        console.result(&lines.join("\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let codes = installed(&arguments.codes)?;
    arguments.study.jobs.apply()?;
    let folder = arguments.study.output.folder("stability");
    let campaign = Campaign {
        cases: &cases,
        codes: &codes,
        time_limit: arguments.time_limit.unwrap_or(if arguments.quick { 60.0 } else { 600.0 }),
        folder: &folder,
        cache: &RunCache::open(&folder.join("outcomes"), arguments.study.restart)?,
    };
    let bar = console.bar("stress tests");
    let study = campaign.run(
        &|case, outcome| {
            let (words, seconds) = (outcome.verdict.words(), outcome.wall_seconds);
            console.detail(&format!("{} in {}: {words}, {seconds:.1} s", case.name, outcome.code));
        },
        &|fraction| bar.set(fraction),
    )?;
    drop(bar);
    console.document(&study, arguments.study.output.json, || study.report().text())?;
    Ok(within_tolerance(study.as_stated))
}

/// Returns the cases with one of the filters in their name or group, or all.
fn chosen(arguments: &StabilityArguments) -> Result<Vec<Case>, Failure> {
    const ALL: &str = "makadam stability --list shows all";
    let is_short = |case: &Case| !(arguments.quick && case.long);
    let all = catalogue();
    for filter in &arguments.cases {
        let mut matched = all.iter().filter(|case| case.matches(filter)).peekable();
        if matched.peek().is_none() {
            let remedy = suggestion(filter, all.iter().map(|case| case.name.as_str()), ALL);
            return Err(Failure::Usage(format!("no case or group has '{filter}' in its name; {remedy}")));
        }
        if !matched.any(is_short) {
            return Err(Failure::Usage(format!("every case that '{filter}' names is left out by --quick; {ALL}")));
        }
    }
    let filters = &arguments.cases;
    let is_named = |case: &Case| filters.is_empty() || filters.iter().any(|filter| case.matches(filter));
    Ok(all.into_iter().filter(|case| is_named(case) && is_short(case)).collect())
}
