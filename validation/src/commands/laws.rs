//! `makadam laws`: published laws of granular matter, measured and compared with their values.

use super::arguments::{JobArguments, OutputArguments};
use super::{Console, Failure, within_tolerance};
use crate::laws::{Law, LawError, LawResult, Plan, Study, all, run_cases, table, write, write_scenes};
use crate::output::JSON_VERSION;
use crate::provenance::account;
use clap::Args;
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
    /// Seed of the initial positions, the first one where --seeds takes several.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Number of seeds of each case, consecutive from --seed; figures are judged by their means.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub seeds: u16,
    /// Start again: repeat runs whose results are stored.
    #[arg(long)]
    pub restart: bool,
    #[command(flatten)]
    pub jobs: JobArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Measures the laws one after the other, and writes each when it is done.
pub(super) fn laws(arguments: &LawsArguments, console: &Console) -> Result<ExitCode, Failure> {
    let laws = chosen(&arguments.names)?;
    if arguments.list {
        let line = |law: &&dyn Law| format!("{}: {}\n  {}", law.name(), law.statement(), law.source());
        console.result(&laws.iter().map(line).collect::<Vec<_>>().join("\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    arguments.jobs.apply()?;
    let folder = arguments.output.folder("laws");
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
        let result = measured(law, arguments, &seeds, &folder.join(law.name()), console)?;
        write(law, &study(vec![result.clone()]), &folder.join(law.name()))?;
        results.push(result);
    }
    let study = study(results);
    console.document(&study, arguments.output.json, || table(&study))?;
    Ok(within_tolerance(study.hold))
}

/// Returns the laws of these names, or all.
fn chosen(names: &[String]) -> Result<Vec<&'static dyn Law>, Failure> {
    if names.is_empty() {
        return Ok(all().to_vec());
    }
    let known = || all().map(Law::name).join(", ");
    let law = |name: &String| {
        let found = all().into_iter().find(|law| law.name() == name);
        found.ok_or_else(|| Failure::Usage(format!("there is no law '{name}'; name one of: {}", known())))
    };
    names.iter().map(law).collect()
}

/// Runs the cases of a law.
fn measured(
    law: &'static dyn Law,
    arguments: &LawsArguments,
    seeds: &[u64],
    folder: &Path,
    console: &Console,
) -> Result<LawResult, Failure> {
    let cases = law.cases(arguments.quick);
    write_scenes(&cases, folder)?;
    let bar = console.bar(law.name());
    let plan = Plan { seeds, again: arguments.restart, folder };
    let rows = run_cases(law, &cases, &plan, &|fraction| bar.set(fraction)).map_err(|error| match error {
        LawError::Interrupted => {
            let runs = folder.join("runs");
            Failure::interrupted(&format!("in {}; the same command continues from there", runs.display()))
        }
        other => other.into(),
    })?;
    Ok(LawResult::new(law, rows))
}
