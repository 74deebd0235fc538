//! `makadam check`: a run described before it starts.

use super::arguments::{SceneArguments, accuracy};
use super::beforehand::tell_findings;
use super::{Console, Failure};
use crate::forecast::Forecast;
use clap::Args;
use makadam::scene::Accuracy;
use makadam_compare::scenes;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Target accuracy, which replaces the scene's step and stopping rule, as for `makadam run`.
    #[arg(long, value_parser = accuracy)]
    pub accuracy: Option<Accuracy>,
    /// Print the description as JSON.
    #[arg(long)]
    pub json: bool,
}

pub(super) fn check(arguments: &CheckArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, mut scene, seed) = arguments.scene.load()?;
    scene.seed = seed;
    if let Some(accuracy) = arguments.accuracy {
        scene.ask(accuracy);
    }
    let text = scenes::text(&file)?;
    let forecast = Forecast::of(&scene, &text).map_err(scenes::in_file(&file))?;
    if !arguments.json {
        tell_findings(&scene, &file, console);
    }
    console.document(&forecast, arguments.json, || forecast.text())?;
    Ok(ExitCode::SUCCESS)
}
