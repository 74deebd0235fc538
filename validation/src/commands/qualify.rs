//! `makadam qualify`: the reference scenes judged together, one report.

use super::arguments::QualifyArguments;
use super::compare::colour_of;
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, json};
use crate::compare::Comparison;
use crate::output::JSON_VERSION;
use crate::qualify::{QualifyError, Settings, qualify as judge};
use crate::report::{self, Changes, Qualification, Standing, StudySection, Test, Verdict};
use crate::scenes;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// What `makadam qualify --json` prints; its documentation is `validation/docs/json.md`.
#[derive(Serialize)]
struct QualifyDocument<'a> {
    version: u32,
    command: &'static str,
    tier: &'a str,
    passes: bool,
    verdict: &'a Verdict,
    outside_spread: &'a [String],
    unchecked: &'a [String],
    failed: &'a [String],
    studies: &'a [StudySection],
    wall_seconds: f64,
    report: String,
    against: Option<&'a Changes>,
    rows: Vec<&'a crate::compare::Row>,
    codes: BTreeMap<&'a str, &'a [crate::compare::CodeSummary]>,
    notes: &'a [String],
    provenance: &'a BTreeMap<String, String>,
}

/// Judges the reference scenes.
pub(super) fn qualify(arguments: &QualifyArguments, console: &Console) -> Result<ExitCode, Failure> {
    arguments.jobs.apply()?;
    let folder = arguments.output.folder("qualification");
    let extent = arguments.tier.extent();
    // Minutes of work are not begun for a report that cannot be written, or a baseline that cannot be read.
    crate::output::create_folder(&folder)?;
    let read = |file: &Path| Test::read(file, extent.name).map_err(Failure::Usage);
    let baseline = arguments.against.as_deref().map(read).transpose()?;
    let announce = announce(console);
    let settings = Settings {
        roots: scenes::roots(),
        folder: folder.clone(),
        again: arguments.restart,
        live: arguments.live,
        time_limit: Duration::from_secs_f64(arguments.time_limit),
        announce: &announce,
        say: &|text| console.note(text),
    };
    let qualification = judge(&extent, &settings).map_err(|error| failure(error, &folder))?;
    let paths = report::write(&qualification, &folder)?;
    let verdict = qualification.verdict();
    let report = paths.html.display().to_string();
    let changes = baseline.map(|baseline| Changes::between(&baseline, &report::tests(&qualification)));
    let text = match arguments.output.json {
        true => json(&document(&qualification, &verdict, report, changes.as_ref())),
        false => {
            let changed = changes.as_ref().map_or(String::new(), |changes| format!("{}\n", changes.text()));
            changed + &describe(&qualification, &verdict, &report, console)
        }
    };
    console.result(&text)?;
    if !qualification.failed_runs.is_empty() {
        return Err(Failure::Running(qualification.failed_runs.join("; ")));
    }
    let holds = changes.is_none_or(|changes| changes.pass());
    Ok(if passes(&verdict) && holds { ExitCode::SUCCESS } else { ExitCode::from(OUTSIDE_TOLERANCE) })
}

fn document<'a>(
    qualification: &'a Qualification,
    verdict: &'a Verdict,
    report: String,
    against: Option<&'a Changes>,
) -> QualifyDocument<'a> {
    let comparisons: &[Comparison] = &qualification.comparisons;
    QualifyDocument {
        version: JSON_VERSION,
        command: "qualify",
        tier: &qualification.tier,
        passes: passes(verdict),
        verdict,
        outside_spread: &qualification.outside_spread,
        unchecked: &qualification.unchecked,
        failed: &qualification.failed_runs,
        studies: &qualification.studies,
        wall_seconds: qualification.wall_seconds,
        report,
        against,
        rows: comparisons.iter().flat_map(|comparison| &comparison.rows).collect(),
        codes: comparisons
            .iter()
            .map(|comparison| (comparison.scene.name.as_str(), comparison.codes.as_slice()))
            .collect(),
        notes: &qualification.notes,
        provenance: &qualification.provenance,
    }
}

fn describe(qualification: &Qualification, verdict: &Verdict, report: &str, console: &Console) -> String {
    let mut text = String::new();
    for comparison in &qualification.comparisons {
        text += &report::comparison_table(comparison, console.colour());
        text.push('\n');
    }
    for note in &qualification.notes {
        text += &format!("note: {note}\n");
    }
    let word = if passes(verdict) { "pass" } else { "not passed" };
    text += &format!("verdict: {}: {}\n", console.paint(word, colour_of(verdict.standing)), verdict.sentence);
    for sentence in
        qualification.outside_spread.iter().chain(&qualification.unchecked).chain(&qualification.failed_runs)
    {
        text += &format!("         {sentence}\n");
    }
    text + &format!("report:  {report} ({:.0} s of wall time)", qualification.wall_seconds)
}

/// Whether all that was asked for was done and agrees.
fn passes(verdict: &Verdict) -> bool {
    verdict.standing == Standing::Agree
}

/// Why there is no verdict; what is finished lies in the folder.
fn failure(error: QualifyError, folder: &Path) -> Failure {
    match error {
        QualifyError::Scene(error) => Failure::Scene(error),
        QualifyError::Reference(error) => error.into(),
        QualifyError::NotRecorded { .. } => Failure::MissingCode(error.to_string()),
        QualifyError::Code(error) => error.into(),
        QualifyError::Failed(_) => Failure::Running(error.to_string()),
        QualifyError::Write(error) => error.into(),
        QualifyError::Document(error) => error.into(),
        QualifyError::Interrupted => Failure::Interrupted(format!(
            "stored run by run in {}; the same command continues from there",
            folder.display()
        )),
    }
}
