//! `makadam laws`: published laws of granular matter, measured and judged.

use super::arguments::LawsArguments;
use super::{Console, Failure, OUTSIDE_TOLERANCE, json};
use crate::laws::{Law, LawError, LawResult, Plan, Study, all, run_cases, table, write, write_scenes};
use crate::output::JSON_VERSION;
use crate::provenance::account;
use std::path::Path;
use std::process::ExitCode;

/// Measures the laws that were asked for, one after the other, writes each as it is done, and says what was found.
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
    console.result(&if arguments.output.json { json(&study) } else { table(&study) })?;
    Ok(if study.hold { ExitCode::SUCCESS } else { ExitCode::from(OUTSIDE_TOLERANCE) })
}

/// The laws of these names; all, if there is none.
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
    let rows = run_cases(law, &cases, &plan, &|share| bar.set(share)).map_err(|error| match error {
        LawError::Scene(error) => Failure::Scene(error),
        LawError::Interrupted => {
            Failure::Interrupted(format!("in {}; the same command continues from there", folder.join("runs").display()))
        }
        other => Failure::Running(other.to_string()),
    })?;
    Ok(LawResult::new(law, rows))
}
