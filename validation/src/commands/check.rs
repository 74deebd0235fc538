//! `makadam check`: what will run, before it does.

use super::arguments::CheckArguments;
use super::beforehand::tell_findings;
use super::{Console, Failure, json};
use crate::forecast::Forecast;
use crate::scenes::{self, Change};
use std::process::ExitCode;

/// Says what will run.
pub(super) fn check(arguments: &CheckArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, mut scene, seed) = arguments.scene.load()?;
    scene.seed = seed;
    if let Some(accuracy) = arguments.accuracy {
        scene.ask(accuracy);
    }
    let text = scenes::text(&file)?;
    let mut forecast = Forecast::of(&scene, &text).map_err(scenes::in_file(&file))?;
    for setting in &mut forecast.settings {
        let is_set = |change: &Change| format!("{}.", change.key()).starts_with(&format!("{}.", setting.key));
        if arguments.scene.source.changes.iter().any(is_set) {
            setting.why = "given by --set".into();
        }
    }
    if !arguments.json {
        tell_findings(&scene, &file, console);
    }
    console.result(&if arguments.json { json(&forecast) } else { forecast.text() })?;
    Ok(ExitCode::SUCCESS)
}
