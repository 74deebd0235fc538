//! `makadam judge`: a code of the user's own against Makadam and its peers, by the same measures and margins.

use super::arguments::JudgeArguments;
use super::compare::{Wanted, tell};
use super::{Console, Failure, announce};
use crate::peers::{Code, External, codes_of};
use crate::qualify::{OneScene, codes_against};
use std::process::ExitCode;
use std::time::Duration;

/// Runs the code and says whether it agrees with the others.
pub(super) fn judge(arguments: &JudgeArguments, console: &Console) -> Result<ExitCode, Failure> {
    arguments.runs.jobs.apply()?;
    arguments.runs.check()?;
    let external = match (&arguments.code, &arguments.frames[..]) {
        (Some(file), []) => External::load(file),
        (file, folders) => External::of_frames(file.as_deref(), folders),
    };
    let external = external.map_err(|error| Failure::Usage(error.to_string()))?;
    let (file, scene) = arguments.source.load()?;
    let judged = external.name();
    let mut all: Vec<Box<dyn Code>> = vec![Box::new(external)];
    let against = arguments.codes.clone().unwrap_or_else(|| codes_against(&file, arguments.runs.live));
    all.extend(codes_of(&against));
    let one_scene = OneScene {
        scene: &scene,
        scene_file: &file,
        changes: &arguments.source.changes,
        codes: all,
        judged,
        live: arguments.runs.live,
        seeds: arguments.runs.seeds,
        rayleigh_fraction: arguments.runs.rayleigh_fraction(),
        time_limit: Duration::from_secs_f64(arguments.runs.time_limit),
        announce: &announce(console),
    };
    tell(
        one_scene,
        &Wanted {
            command: "judge",
            json: arguments.runs.json,
            output: arguments.runs.output.as_deref(),
            needs_verdict: true,
        },
        console,
    )
}
