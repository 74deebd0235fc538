//! `makadam compare`: one scene in several codes, a table, a verdict.

use super::arguments::{CodeRunArguments, CompareArguments};
use super::console::Colour;
use super::record::record;
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, codes_or_usual, json};
use crate::compare::{CodeSummary, Comparison, Row};
use crate::output::{JSON_VERSION, create_folder};
use crate::peers::CodeError;
use crate::plan::Scene;
use crate::qualify::{Judged, OneScene};
use crate::report::{self, Standing, Verdict};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// What `makadam compare --json` prints; its documentation is `validation/docs/json.md`.
#[derive(Serialize)]
struct CompareDocument<'a> {
    version: u32,
    command: &'static str,
    scene: &'a str,
    verdict: &'a Verdict,
    rows: &'a [Row],
    codes: &'a [CodeSummary],
    notes: &'a [String],
    provenance: &'a BTreeMap<String, String>,
}

/// Compares codes on a scene, or records references.
pub(super) fn compare(arguments: &CompareArguments, console: &Console) -> Result<ExitCode, Failure> {
    arguments.runs.jobs.apply()?;
    let (file, scene) = arguments.source.load()?;
    match arguments.record {
        true => record(arguments, &scene, &file, console),
        false => judge(arguments, &scene, &file, console),
    }
}

fn judge(arguments: &CompareArguments, scene: &Scene, file: &Path, console: &Console) -> Result<ExitCode, Failure> {
    let CodeRunArguments { json, output, live, .. } = &arguments.runs;
    arguments.runs.check()?;
    let one_scene = OneScene {
        scene,
        scene_file: file,
        changes: &arguments.source.changes,
        codes: codes_or_usual(arguments.codes.as_deref(), file, *live),
        judged: "Makadam",
        live: *live,
        seeds: arguments.runs.seeds,
        rayleigh_fraction: arguments.runs.rayleigh_fraction(),
        time_limit: Duration::from_secs_f64(arguments.runs.time_limit),
        announce: &announce(console),
    };
    tell(
        one_scene,
        &Wanted { command: "compare", json: *json, output: output.as_deref(), needs_verdict: false },
        console,
    )
}

/// How a judgement is told.
pub(super) struct Wanted<'a> {
    /// The command.
    pub command: &'static str,
    /// Whether as JSON.
    pub json: bool,
    /// Folder of the report, if one is written.
    pub output: Option<&'a Path>,
    /// Whether a comparison in which nothing is tested is no success.
    pub needs_verdict: bool,
}

/// Judges and tells.
pub(super) fn tell(one_scene: OneScene<'_>, wanted: &Wanted<'_>, console: &Console) -> Result<ExitCode, Failure> {
    wanted.output.map_or(Ok(()), claim)?;
    let Judged { qualification, failure } = one_scene.judge()?;
    let verdict = qualification.verdict();
    let comparison = &qualification.comparisons[0];
    let text = match wanted.json {
        true => json(&document(wanted.command, comparison, &verdict, &qualification.provenance)),
        false => {
            let sentence = console.paint(&verdict.sentence, colour_of(verdict.standing));
            format!("{}\n{sentence}", report::comparison_table(comparison, console.colour()))
        }
    };
    let interrupted = failure.as_ref().is_some_and(CodeError::is_interruption);
    // What was cut short does not replace a report of what was not.
    let stays = wanted.output.filter(|folder| interrupted && folder.join("report.json").is_file());
    // Neither is lost if the other cannot be written.
    let told = console.result(&text);
    let output = wanted.output.filter(|_| stays.is_none());
    let written = output.map(|folder| report::write(&qualification, folder)).transpose();
    told?;
    let written = written?;
    if let Some(paths) = written.as_ref().filter(|_| !wanted.json) {
        console.result(&format!("report: {}", paths.html.display()))?;
    }
    match (failure, verdict.standing) {
        (Some(_), _) if interrupted => Err(Failure::Interrupted(match (stays, written) {
            (Some(folder), _) => format!("not stored, the earlier report stays in {}", folder.display()),
            (None, Some(paths)) => format!("{}", paths.html.display()),
            (None, None) => "not stored".into(),
        })),
        (Some(failure), _) => Err(failure.into()),
        (None, Standing::Agree) => Ok(ExitCode::SUCCESS),
        (None, Standing::NothingCompared) if !wanted.needs_verdict => Ok(ExitCode::SUCCESS),
        (None, _) => Ok(ExitCode::from(OUTSIDE_TOLERANCE)),
    }
}

/// Colour of a verdict.
pub(super) fn colour_of(standing: Standing) -> Colour {
    match standing {
        Standing::Agree => Colour::Green,
        Standing::Disagree => Colour::Red,
        Standing::Undecided | Standing::Exploratory | Standing::NotMeasured | Standing::NothingCompared => {
            Colour::Yellow
        }
    }
}

/// Makes the folder of a report before anything runs.
fn claim(folder: &Path) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        return Err(Failure::Usage(format!(
            "{} is a file, and a report takes a folder; give another path with --output",
            folder.display()
        )));
    }
    Ok(create_folder(folder)?)
}

fn document<'a>(
    command: &'static str,
    comparison: &'a Comparison,
    verdict: &'a Verdict,
    provenance: &'a BTreeMap<String, String>,
) -> CompareDocument<'a> {
    CompareDocument {
        version: JSON_VERSION,
        command,
        scene: &comparison.scene.name,
        verdict,
        rows: &comparison.rows,
        codes: &comparison.codes,
        notes: &comparison.notes,
        provenance,
    }
}
