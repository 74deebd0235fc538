//! `makadam compare`: one scene in several codes, a table, a verdict.

use super::arguments::{CodeName, CompareArguments};
use super::record::record;
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, json, load, use_threads};
use crate::compare::{CodeRuns, CodeSummary, Comparison, Reference, Row, Runs, comparison};
use crate::output::JSON_VERSION;
use crate::peers::{Code, CodeError, Liggghts, Makadam, Yade};
use crate::plan::Scene;
use crate::provenance::account;
use crate::report::{self, Qualification, Standing, Verdict};
use crate::scenes;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Seeds where nothing is recorded and none are asked for.
pub(super) const FEW_SEEDS: u64 = 3;

/// What `makadam compare --json` prints; its documentation is `validation/docs/json.md`.
#[derive(Serialize)]
struct CompareDocument<'a> {
    version: u32,
    command: &'static str,
    scene: &'a str,
    verdict: &'a Verdict,
    rows: &'a [Row],
    codes: &'a [CodeSummary],
    soft_bias: &'a [Row],
    notes: &'a [String],
    provenance: &'a BTreeMap<String, String>,
}

/// Compares codes on a scene, or records references.
pub(super) fn compare(arguments: &CompareArguments, console: &Console) -> Result<ExitCode, Failure> {
    use_threads(arguments.threads)?;
    let (file, scene) = load(&arguments.scene)?;
    match arguments.record {
        true => record(arguments, &scene, &file, console),
        false => judge(arguments, &scene, &file, console),
    }
}

fn judge(arguments: &CompareArguments, scene: &Scene, file: &Path, console: &Console) -> Result<ExitCode, Failure> {
    if scene.compare.is_empty() {
        return Err(Failure::Usage(format!(
            "{} names nothing to compare; add observables under [[compare]], or measure it with 'makadam run'",
            scene.name
        )));
    }
    let clock = Instant::now();
    let reference = scenes::reference(file)?;
    let seeds = arguments.seeds.or_else(|| reference.as_ref().map(Reference::seeds)).unwrap_or(FEW_SEEDS);
    let announce = announce(console);
    let runs = Runs {
        scene,
        scene_file: file,
        seeds: (1..=seeds).collect(),
        rayleigh_fraction: arguments.rayleigh_fraction,
        stiffness_factor: 1.0,
        time_limit: Duration::from_secs_f64(arguments.time_limit),
        recordings: None,
        announce: &announce,
    };
    let (mut notes, mut recorded) = (Vec::new(), Vec::new());
    let mut live: Vec<Box<dyn Code>> = Vec::new();
    for code in codes(&arguments.codes) {
        if code.name() == "Makadam" || arguments.live {
            if code.version().is_none() {
                return Err(CodeError::Missing { code: code.name() }.into());
            }
            live.push(code);
        } else {
            recorded.push(from_reference(code.name(), reference.as_ref(), scene, &mut notes)?);
        }
    }
    let simulated: Vec<_> = live.par_iter().map(|code| (code.name(), runs.simulate(code.as_ref()))).collect();
    let side_by_side = rayon::current_num_threads().min(live.len() * runs.seeds.len());
    let (mut measured, mut failure) = (Vec::new(), None);
    for (code, simulated) in simulated {
        for (seed, error) in simulated.failures {
            let note = format!("{code}, seed {seed}: {error}");
            if !matches!(error, CodeError::Interrupted { .. }) {
                notes.push(note);
            }
            failure = failure.or(Some(Failure::from(error)));
        }
        measured.push(CodeRuns::live(code, side_by_side, simulated.harvests));
    }
    if let Some(Failure::Scene(error)) = failure {
        return Err(Failure::Scene(error));
    }
    measured.extend(recorded);
    let comparison = comparison(scene, &measured, notes);
    let threads = rayon::current_num_threads();
    let qualification = Qualification {
        title: format!("Comparison of codes on the scene {}", scene.name),
        tier: "compare".into(),
        wall_seconds: clock.elapsed().as_secs_f64(),
        comparisons: vec![comparison],
        provenance: account(threads, &[scene]),
        notes: Vec::new(),
        outside_spread: Vec::new(),
        unchecked: Vec::new(),
        laws: Vec::new(),
    };
    let verdict = qualification.verdict();
    let comparison = &qualification.comparisons[0];
    let mut text = match arguments.json {
        true => json(&document(comparison, &verdict, &qualification.provenance)),
        false => format!("{}\n{}", report::comparison_table(comparison, console.colour()), verdict.sentence),
    };
    if let Some(folder) = &arguments.output {
        let paths = report::write(&qualification, folder)?;
        if !arguments.json {
            text += &format!("\nreport: {}", paths.html.display());
        }
    }
    console.result(&text)?;
    match (failure, verdict.standing) {
        (Some(failure), _) => Err(failure),
        (None, Standing::Agree | Standing::NothingCompared) => Ok(ExitCode::SUCCESS),
        (None, Standing::Disagree | Standing::Undecided | Standing::NotMeasured) => {
            Ok(ExitCode::from(OUTSIDE_TOLERANCE))
        }
    }
}

/// What is recorded of a code, or an error that says how to get it.
fn from_reference(
    code: &str,
    reference: Option<&Reference>,
    scene: &Scene,
    notes: &mut Vec<String>,
) -> Result<CodeRuns, Failure> {
    let Some(runs) = reference.and_then(|reference| reference.code(code)) else {
        return Err(Failure::MissingCode(format!(
            "nothing is recorded of {code} on the scene {}; run it with --live (scripts/install-peers installs it), or \
             leave it out with --codes",
            scene.name
        )));
    };
    notes.push(format!("{code} was not run: its numbers are the recorded references ({})", runs.provenance));
    if reference.and_then(|reference| reference.is_current(code, scene)) == Some(false) {
        notes.push(format!("the scene has changed since {code} was recorded: record anew with --record"));
    }
    Ok(runs)
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
        soft_bias: &comparison.soft_bias,
        notes: &comparison.notes,
        provenance,
    }
}

/// The codes that are asked for, each once, Makadam first.
pub(super) fn codes(names: &[CodeName]) -> Vec<Box<dyn Code>> {
    let all: [(CodeName, Box<dyn Code>); 3] = [
        (CodeName::Makadam, Box::new(Makadam)),
        (CodeName::Yade, Box::new(Yade::default())),
        (CodeName::Liggghts, Box::new(Liggghts::default())),
    ];
    all.into_iter().filter(|(name, _)| names.contains(name)).map(|(_, code)| code).collect()
}
