//! `makadam laws`: published laws of granular matter, measured and compared with their values.

use super::arguments::StudyArguments;
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam_compare::laws::{LAWS, Law, LawResult, Study, run_cases};
use makadam_compare::study::{Document, RunCache, write_scenes};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::provenance::account;
use std::path::Path;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct LawsArguments {
    /// Names of laws; if absent, all.
    pub names: Vec<String>,
    /// Run fewer and smaller cases: results in seconds, with grains that are large for their container.
    #[arg(long)]
    pub quick: bool,
    /// List the laws and their publications; measure none.
    #[arg(long, conflicts_with = "json")]
    pub list: bool,
    /// Seed of the initial positions, the first seed if --seeds takes several.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Number of seeds of each case, consecutive from --seed; figures are tested by their means.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub seeds: u16,
    #[command(flatten)]
    pub study: StudyArguments,
}

/// Measures the laws one after the other, and writes each when finished.
pub(super) fn laws(arguments: &LawsArguments, console: &Console) -> Result<ExitCode, Failure> {
    let laws = chosen(&arguments.names)?;
    if arguments.list {
        let line = |law: &&Law| format!("{}: {}\n  {}", law.name, law.statement, law.source);
        console.result(&laws.iter().map(line).collect::<Vec<_>>().join("\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    arguments.study.jobs.apply()?;
    let folder = arguments.study.output.folder("laws");
    let seeds: Vec<u64> = (arguments.seed..).take(usize::from(arguments.seeds)).collect();
    let study = |laws: Vec<LawResult>| Study {
        version: JSON_VERSION,
        command: "laws",
        hold: laws.iter().all(|law| law.holds),
        quick: arguments.quick,
        seeds: seeds.clone(),
        laws,
        provenance: account(rayon::current_num_threads(), &[]),
    };
    let mut results = Vec::new();
    for law in laws {
        let folder = folder.join(law.name);
        let result = measured(law, arguments, &seeds, &folder, console)?;
        study(vec![result.clone()]).write(&folder)?;
        results.push(result);
    }
    let study = study(results);
    console.document(&study, arguments.study.output.json, || study.report().text())?;
    Ok(within_tolerance(study.hold))
}

/// Returns the laws of these names, or all.
fn chosen(names: &[String]) -> Result<Vec<&'static Law>, Failure> {
    if names.is_empty() {
        return Ok(LAWS.iter().collect());
    }
    let law = |name: &String| {
        LAWS.iter().find(|law| law.name == name).ok_or_else(|| {
            let known = LAWS.each_ref().map(|law| law.name).join(", ");
            Failure::Usage(format!("there is no law '{name}'; name one of: {known}"))
        })
    };
    names.iter().map(law).collect()
}

/// Runs the cases of a law.
fn measured(
    law: &Law,
    arguments: &LawsArguments,
    seeds: &[u64],
    folder: &Path,
    console: &Console,
) -> Result<LawResult, Failure> {
    let cases = (law.cases)(arguments.quick);
    write_scenes(cases.iter().map(|case| &case.scene), folder)?;
    let bar = console.bar(law.name);
    let cache = RunCache::open(&folder.join("runs"), arguments.study.restart)?;
    Ok(LawResult::new(law, run_cases(law, &cases, seeds, &cache, &|fraction| bar.set(fraction))?))
}
