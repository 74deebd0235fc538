//! `makadam compare`: one scene in several codes, or in a code of the user's own; and `--record`, which stores references.

use super::arguments::{JobArguments, SourceArguments, rayleigh_fraction, time_limit};
use super::beforehand::refuse_without_folder;
use super::console::Colour;
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam::scene::StageSolver;
use makadam_compare::codes::{Code, CodeError, CodeName, External, absent, codes_of};
use makadam_compare::compare::{CodeSummary, Row, Runs};
use makadam_frames::output::{JSON_VERSION, cache_folder, create_folder};
use makadam_frames::plan::MeasuredScene;
use makadam_qualification::qualify::{Judged, OneScene, codes_against, usual_codes};
use makadam_qualification::report::{self, Standing, Verdict};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    #[command(flatten)]
    pub source: SourceArguments,
    /// Codes that take part, separated by commas; if absent, makadam and the codes recorded on the scene, or with --live
    /// makadam,yade,liggghts.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub codes: Option<Vec<CodeName>>,
    /// Validate your own code instead of Makadam: TOML file with its name, version, command and output files (docs/own-code.md).
    #[arg(long, value_name = "FILE", conflicts_with = "record")]
    pub own_code: Option<PathBuf>,
    /// Folders of existing frames of your own code, one per seed, with names that end in the seed: 'seed*/'. The code is not run;
    /// without --own-code each folder is a run of Makadam, or all its files hold grains.
    #[arg(long, num_args = 1.., value_name = "FOLDERS", conflicts_with_all = ["seeds", "record"])]
    pub frames: Vec<String>,
    /// Record results of the other codes as the scene's references, replacing earlier ones. Raw recordings of the same scene,
    /// version and time step are measured again; other seeds are run.
    #[arg(long, conflicts_with_all = ["json", "output", "live"])]
    pub record: bool,
    /// Folder of raw recordings that --record reads and writes; if absent, in the user's cache.
    #[arg(long, requires = "record")]
    pub recordings: Option<PathBuf>,
    /// Number of seeds, counted from 1; if absent, the scene's registered number (measure.seeds), or the recorded number, or 3.
    /// Unregistered seeds are exploratory: exit code 4.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: Option<u64>,
    /// Run the other codes now instead of reading recorded numbers.
    #[arg(long)]
    pub live: bool,
    /// Time step of explicit codes, as a fraction of the Rayleigh step; 0.1 if absent.
    #[arg(long, value_parser = rayleigh_fraction)]
    pub rayleigh_fraction: Option<f64>,
    /// Wall time after which a run is stopped, s; Makadam's own runs have no limit here.
    #[arg(long, default_value_t = 7200.0, value_parser = time_limit)]
    pub time_limit: f64,
    #[command(flatten)]
    pub jobs: JobArguments,
    /// Folder for report.html, report.json, rows.csv, and the CSV files that figures link to; if absent, nothing is written.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the comparison as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Document of `makadam compare --json`; `validation/docs/json.md` describes it.
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

pub(super) fn compare(arguments: &CompareArguments, console: &Console) -> Result<ExitCode, Failure> {
    arguments.jobs.apply()?;
    let (file, mut scene) = arguments.source.load()?;
    // The other codes know no stages, and all codes run one scene.
    if !scene.stage.is_empty() {
        if let Some(stage) = scene.stage.iter().find(|stage| stage.solver != StageSolver::default()) {
            return Err(Failure::Usage(format!(
                "stage '{}' has a solver table of its own, and a comparison runs one scene without stages; give [solver] the settings that \
                 the whole process needs, and leave that table out",
                stage.name
            )));
        }
        scene = scene.without_stages().map_err(Failure::Usage)?;
    }
    match arguments.record {
        true => record(arguments, &scene, &file, console),
        false => validate(arguments, &scene, &file, console),
    }
}

/// Returns the codes of these names; all must be installed.
pub(super) fn installed(names: &[CodeName]) -> Result<Vec<Box<dyn Code>>, Failure> {
    let codes = codes_of(names);
    match codes.iter().find(|code| code.version().is_none()) {
        None => Ok(codes),
        Some(missing) => Err(Failure::MissingCode(format!("{}, or leave it out with --codes", absent(missing.name())))),
    }
}

/// Returns the codes of these names, or the default codes of a scene's comparison.
fn codes_or_usual(names: Option<&[CodeName]>, scene_file: &Path, live: bool) -> Vec<Box<dyn Code>> {
    names.map_or_else(|| codes_of(&usual_codes(scene_file, live)), codes_of)
}

/// Codes that take part, the code under test first.
struct Codes {
    all: Vec<Box<dyn Code>>,
    validated: &'static str,
    /// True if a comparison without a test is not a success.
    needs_verdict: bool,
}

impl Codes {
    fn of(arguments: &CompareArguments, file: &Path) -> Result<Codes, Failure> {
        let live = arguments.live;
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

fn validate(
    arguments: &CompareArguments,
    scene: &MeasuredScene,
    file: &Path,
    console: &Console,
) -> Result<ExitCode, Failure> {
    if arguments.rayleigh_fraction.is_some() && !arguments.live {
        return Err(Failure::Usage(
            "--rayleigh-fraction is of runs, and recorded numbers have their own: add --live or --record (of 'makadam compare')"
                .into(),
        ));
    }
    let Codes { all, validated, needs_verdict } = Codes::of(arguments, file)?;
    let one_scene = OneScene {
        scene,
        scene_file: file,
        changes: &arguments.source.changes,
        codes: all,
        judged: validated,
        live: arguments.live,
        seeds: arguments.seeds,
        rayleigh_fraction: arguments.rayleigh_fraction.unwrap_or(0.1),
        time_limit: Duration::from_secs_f64(arguments.time_limit),
        announce: &console.bars(),
    };
    let output = arguments.output.as_deref();
    output.map_or(Ok(()), claim)?;
    let Judged { qualification, failure } = one_scene.judge()?;
    let verdict = qualification.verdict();
    let comparison = &qualification.comparisons[0];
    let document = CompareDocument {
        version: JSON_VERSION,
        command: "compare",
        scene: &comparison.scene.name,
        verdict: &verdict,
        rows: &comparison.rows,
        codes: &comparison.codes,
        notes: &comparison.notes,
        provenance: &qualification.provenance,
    };
    let printed = console.document(&document, arguments.json, || {
        let sentence = console.paint(&verdict.sentence, colour_of(verdict.standing));
        format!("{}\n{sentence}", report::comparison_table(comparison, console.colour()))
    });
    let interrupted = failure.as_ref().is_some_and(CodeError::is_interruption);
    // An incomplete report does not replace a complete one.
    let stays = output.filter(|folder| interrupted && folder.join("report.json").is_file());
    // The report is written even if printing fails; a failure to print is reported afterwards.
    let written = output.filter(|_| stays.is_none()).map(|folder| report::write(&qualification, folder)).transpose();
    printed?;
    let written = written?;
    if let Some(page) = written.as_ref().filter(|_| !arguments.json) {
        console.result(&format!("report: {}", page.display()))?;
    }
    if interrupted {
        return Err(Failure::interrupted(&match (stays, written) {
            (Some(folder), _) => format!("not stored, the earlier report stays in {}", folder.display()),
            (None, Some(page)) => page.display().to_string(),
            (None, None) => "not stored".into(),
        }));
    }
    match failure {
        Some(failure) => Err(failure.into()),
        None => Ok(within_tolerance(match verdict.standing {
            Standing::Agree => true,
            Standing::NothingCompared => !needs_verdict,
            _ => false,
        })),
    }
}

/// Returns the colour of a verdict.
pub(super) fn colour_of(standing: Standing) -> Colour {
    match standing {
        Standing::Agree => Colour::Green,
        Standing::Disagree => Colour::Red,
        Standing::Undecided | Standing::Exploratory | Standing::NotMeasured | Standing::NothingCompared => {
            Colour::Yellow
        }
    }
}

/// Creates the folder of a report before anything runs.
fn claim(folder: &Path) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        return Err(Failure::Usage(format!(
            "{} is a file, and a report takes a folder; give another path with --output",
            folder.display()
        )));
    }
    Ok(create_folder(folder)?)
}

/// Records missing references of the codes.
fn record(
    arguments: &CompareArguments,
    scene: &MeasuredScene,
    file: &Path,
    console: &Console,
) -> Result<ExitCode, Failure> {
    // Recorded codes are recorded again, so that no record is lost.
    let codes = codes_or_usual(arguments.codes.as_deref(), file, false);
    let reference_codes: Vec<Box<dyn Code>> = codes.into_iter().filter(|code| code.name() != "Makadam").collect();
    if reference_codes.is_empty() {
        let problem =
            "--record keeps what other codes measure, and Makadam is run anew each time: name others with --codes";
        return Err(Failure::Usage(problem.into()));
    }
    record_codes(reference_codes, arguments, scene, file, console)
}

fn record_codes(
    reference_codes: Vec<Box<dyn Code>>,
    arguments: &CompareArguments,
    scene: &MeasuredScene,
    file: &Path,
    console: &Console,
) -> Result<ExitCode, Failure> {
    refuse_without_folder(file)?;
    let recordings = match &arguments.recordings {
        Some(folder) => folder.clone(),
        None => cache_folder()?.join("recordings"),
    };
    let bars = console.bars();
    let runs = Runs {
        rayleigh_fraction: arguments.rayleigh_fraction.unwrap_or(0.1),
        recordings: Some(recordings),
        ..Runs::of_one_seed(scene, file, 1, Duration::from_secs_f64(arguments.time_limit), &bars)
    };
    let warn = |text: &str| console.warn(text);
    let mut recorded = makadam_compare::compare::record(&reference_codes, &runs, arguments.seeds, &warn)?;
    let state = if recorded.changed { "" } else { " (unchanged)" };
    recorded.lines.push(format!("references: {}{state}", recorded.folder.display()));
    console.result(&recorded.lines.join("\n"))?;
    match (recorded.failure, recorded.whole) {
        (Some(failure), _) => Err(failure.into()),
        (None, whole) => Ok(within_tolerance(whole)),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/commands_record.rs"]
mod tests;
