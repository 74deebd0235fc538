//! `makadam qualify`: all reference scenes and studies, one report.

use super::arguments::{JobArguments, OutputArguments, time_limit};
use super::compare::colour_of;
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam_compare::compare::{CodeSummary, Row};
use makadam_compare::scenes;
use makadam_compare::study::RunError;
use makadam_frames::output::{JSON_VERSION, create_folder};
use makadam_qualification::qualify::{QualifyError, Settings, Tier, qualify as judge};
use makadam_qualification::report::{self, Changes, Qualification, Standing, StudySection, Test, Verdict};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct QualifyArguments {
    /// Extent of the qualification.
    #[arg(long, value_enum, default_value = "quick")]
    pub tier: Tier,
    /// Baseline (validation/baseline.json, or tests.json of an earlier qualification): lists tests that are missing, new or have another
    /// verdict. A missing test or a worse verdict is exit code 4.
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Start again: repeat runs whose results are stored in the output folder.
    #[arg(long)]
    pub restart: bool,
    /// Require live runs of YADE and LIGGGHTS in addition to the recorded numbers.
    #[arg(long)]
    pub live: bool,
    /// Wall time after which a run is stopped, s; Makadam's own runs have no limit here.
    #[arg(long, default_value_t = 900.0, value_parser = time_limit)]
    pub time_limit: f64,
    #[command(flatten)]
    pub jobs: JobArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Document of `makadam qualify --json`; `validation/docs/json.md` describes it.
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
    report: &'a str,
    against: Option<&'a Changes>,
    rows: Vec<&'a Row>,
    codes: BTreeMap<&'a str, &'a [CodeSummary]>,
    notes: &'a [String],
    provenance: &'a BTreeMap<String, String>,
}

pub(super) fn qualify(arguments: &QualifyArguments, console: &Console) -> Result<ExitCode, Failure> {
    arguments.jobs.apply()?;
    let folder = arguments.output.folder("qualification");
    let extent = arguments.tier.extent();
    // The output folder and the baseline are checked before minutes of work begin.
    create_folder(&folder)?;
    let read = |file: &Path| Test::read(file, extent.name).map_err(Failure::Usage);
    let baseline = arguments.against.as_deref().map(read).transpose()?;
    let settings = Settings {
        roots: scenes::roots(),
        folder: folder.clone(),
        again: arguments.restart,
        live: arguments.live,
        time_limit: Duration::from_secs_f64(arguments.time_limit),
        announce: &console.bars(),
        say: &|text| console.note(text),
    };
    let qualification = judge(&extent, &settings).map_err(|error| match error {
        QualifyError::Run(RunError::Interrupted) => Failure::interrupted(&format!(
            "stored run by run in {}; the same command continues from there",
            folder.display()
        )),
        other => other.into(),
    })?;
    let page = report::write(&qualification, &folder)?;
    let verdict = qualification.verdict();
    let passes = verdict.standing == Standing::Agree;
    let report = page.display().to_string();
    let changes = baseline.map(|baseline| Changes::between(&baseline, &report::tests(&qualification)));
    let Qualification { comparisons, outside_spread, unchecked, failed_runs, notes, .. } = &qualification;
    let document = QualifyDocument {
        version: JSON_VERSION,
        command: "qualify",
        tier: &qualification.tier,
        passes,
        verdict: &verdict,
        outside_spread,
        unchecked,
        failed: failed_runs,
        studies: &qualification.studies,
        wall_seconds: qualification.wall_seconds,
        report: &report,
        against: changes.as_ref(),
        rows: comparisons.iter().flat_map(|comparison| &comparison.rows).collect(),
        codes: comparisons.iter().map(|one| (one.scene.name.as_str(), one.codes.as_slice())).collect(),
        notes,
        provenance: &qualification.provenance,
    };
    console.document(&document, arguments.output.json, || {
        let mut text = changes.as_ref().map_or(String::new(), |changes| format!("{}\n", changes.text()));
        for comparison in comparisons {
            text += &format!("{}\n", report::comparison_table(comparison, console.colour()));
        }
        notes.iter().for_each(|note| text += &format!("note: {note}\n"));
        let word = console.paint(if passes { "pass" } else { "not passed" }, colour_of(verdict.standing));
        text += &format!("verdict: {word}: {}\n", verdict.sentence);
        for sentence in outside_spread.iter().chain(unchecked).chain(failed_runs) {
            text += &format!("         {sentence}\n");
        }
        text + &format!("report:  {report} ({:.0} s of wall time)", qualification.wall_seconds)
    })?;
    if !failed_runs.is_empty() {
        return Err(Failure::Running(failed_runs.join("; ")));
    }
    Ok(within_tolerance(passes && changes.is_none_or(|changes| changes.pass())))
}
