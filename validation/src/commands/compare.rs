//! `makadam compare`: one scene in several codes, or in a code of the user's own; a table and a verdict.

use super::arguments::CompareArguments;
use super::console::Colour;
use super::record::record;
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, codes_or_usual, json};
use crate::compare::{CodeSummary, Comparison, Row};
use crate::output::{JSON_VERSION, create_folder};
use crate::peers::{Code, CodeError, External, codes_of};
use crate::plan::Scene;
use crate::qualify::{Judged, OneScene, codes_against};
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
        false => validate(arguments, &scene, &file, console),
    }
}

/// Codes that take part, the validated one first.
struct Codes {
    all: Vec<Box<dyn Code>>,
    validated: &'static str,
    /// True if a comparison without a test is no success.
    needs_verdict: bool,
}

impl Codes {
    fn of(arguments: &CompareArguments, file: &Path) -> Result<Codes, Failure> {
        let live = arguments.runs.live;
        let own = match (&arguments.own_code, &arguments.frames[..]) {
            (None, []) => {
                let all = codes_or_usual(arguments.codes.as_deref(), file, live);
                return Ok(Codes { all, validated: "Makadam", needs_verdict: false });
            }
            (Some(description), []) => External::load(description),
            (description, folders) => External::of_frames(description.as_deref(), folders),
        };
        let own = own.map_err(|error| Failure::Usage(error.to_string()))?;
        let validated = own.name();
        let mut all: Vec<Box<dyn Code>> = vec![Box::new(own)];
        all.extend(codes_of(&arguments.codes.clone().unwrap_or_else(|| codes_against(file, live))));
        Ok(Codes { all, validated, needs_verdict: true })
    }
}

fn validate(arguments: &CompareArguments, scene: &Scene, file: &Path, console: &Console) -> Result<ExitCode, Failure> {
    arguments.runs.check()?;
    let Codes { all, validated, needs_verdict } = Codes::of(arguments, file)?;
    let one_scene = OneScene {
        scene,
        scene_file: file,
        changes: &arguments.source.changes,
        codes: all,
        judged: validated,
        live: arguments.runs.live,
        seeds: arguments.runs.seeds,
        rayleigh_fraction: arguments.runs.rayleigh_fraction(),
        time_limit: Duration::from_secs_f64(arguments.runs.time_limit),
        announce: &announce(console),
    };
    let output = arguments.runs.output.as_deref();
    output.map_or(Ok(()), claim)?;
    let Judged { qualification, failure } = one_scene.judge()?;
    let verdict = qualification.verdict();
    let comparison = &qualification.comparisons[0];
    let text = match arguments.runs.json {
        true => json(&document(comparison, &verdict, &qualification.provenance)),
        false => {
            let sentence = console.paint(&verdict.sentence, colour_of(verdict.standing));
            format!("{}\n{sentence}", report::comparison_table(comparison, console.colour()))
        }
    };
    let interrupted = failure.as_ref().is_some_and(CodeError::is_interruption);
    // What was cut short does not replace a report of what was not.
    let stays = output.filter(|folder| interrupted && folder.join("report.json").is_file());
    // Neither is lost if the other cannot be written.
    let told = console.result(&text);
    let output = output.filter(|_| stays.is_none());
    let written = output.map(|folder| report::write(&qualification, folder)).transpose();
    told?;
    let written = written?;
    if let Some(paths) = written.as_ref().filter(|_| !arguments.runs.json) {
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
        (None, Standing::NothingCompared) if !needs_verdict => Ok(ExitCode::SUCCESS),
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
    comparison: &'a Comparison,
    verdict: &'a Verdict,
    provenance: &'a BTreeMap<String, String>,
) -> CompareDocument<'a> {
    CompareDocument {
        version: JSON_VERSION,
        command: "compare",
        scene: &comparison.scene.name,
        verdict,
        rows: &comparison.rows,
        codes: &comparison.codes,
        notes: &comparison.notes,
        provenance,
    }
}
