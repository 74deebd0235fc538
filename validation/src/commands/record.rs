//! `makadam compare --record`: what is missing in a scene's recorded references is measured or run, and taken in.

use super::arguments::CompareArguments;
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, can_record, codes_or_usual};
use crate::compare::Recorder;
use crate::output::cache_folder;
use crate::peers::Code;
use crate::plan::Scene;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Records what is missing of the peers that are asked for.
pub(super) fn record(
    arguments: &CompareArguments,
    scene: &Scene,
    file: &Path,
    console: &Console,
) -> Result<ExitCode, Failure> {
    // What was recorded once is recorded again, so that no code is lost.
    let codes = codes_or_usual(arguments.codes.as_deref(), file, false);
    let peers: Vec<Box<dyn Code>> = codes.into_iter().filter(|code| code.name() != "Makadam").collect();
    if peers.is_empty() {
        let problem =
            "--record keeps what other codes measure, and Makadam is run anew each time: name others with --codes";
        return Err(Failure::Usage(problem.into()));
    }
    record_codes(peers, arguments, scene, file, console)
}

/// Records what is missing of some codes, and says what is recorded now.
fn record_codes(
    peers: Vec<Box<dyn Code>>,
    arguments: &CompareArguments,
    scene: &Scene,
    file: &Path,
    console: &Console,
) -> Result<ExitCode, Failure> {
    can_record(file)?;
    let recorder = Recorder {
        scene,
        scene_file: file,
        seeds: arguments.runs.seeds,
        rayleigh_fraction: arguments.runs.rayleigh_fraction(),
        time_limit: Duration::from_secs_f64(arguments.runs.time_limit),
        again: arguments.restart,
        recordings: match &arguments.recordings {
            Some(folder) => folder.clone(),
            None => cache_folder()?.join("recordings"),
        },
        announce: &announce(console),
        note: &|text| console.note(text),
        warn: &|text| console.warn(text),
    };
    let mut recorded = recorder.record(peers)?;
    let state = if recorded.changed { "" } else { " (unchanged)" };
    recorded.lines.push(format!("references: {}{state}", recorded.folder.display()));
    console.result(&recorded.lines.join("\n"))?;
    match (recorded.failure, recorded.whole) {
        (Some(failure), _) => Err(failure.into()),
        (None, true) => Ok(ExitCode::SUCCESS),
        (None, false) => Ok(ExitCode::from(OUTSIDE_TOLERANCE)),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/commands_record.rs"]
mod tests;
