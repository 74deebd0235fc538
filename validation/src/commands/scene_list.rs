//! `makadam scenes`: the scenes that can be named.

use super::arguments::SceneListArguments;
use super::{Console, Failure, json};
use crate::draw::wrapped;
use crate::scenes;
use serde::Serialize;
use std::process::ExitCode;

/// A scene that can be named.
#[derive(Serialize)]
struct Named {
    name: String,
    description: String,
    grains: usize,
    file: String,
}

/// Lists them, each with a line.
pub(super) fn list(arguments: &SceneListArguments, console: &Console) -> Result<ExitCode, Failure> {
    let roots = scenes::roots();
    let mut named = Vec::new();
    for name in scenes::known(&roots) {
        let file = scenes::find(&name, &roots)?;
        let scene = scenes::load(&file)?;
        let grains = scene.grain_count();
        let (description, file) = (scene.description.clone(), file.display().to_string());
        named.push(Named { name, description, grains, file });
    }
    if arguments.json {
        console.result(&json(&named))?;
        return Ok(ExitCode::SUCCESS);
    }
    let rows: Vec<Vec<String>> = named.into_iter().map(|named| vec![named.name, named.description]).collect();
    console.result(&format!("{}\n\n`makadam new` writes a scene to start from to a file.", wrapped(&rows)))?;
    Ok(ExitCode::SUCCESS)
}
