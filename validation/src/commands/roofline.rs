//! `makadam roofline`: the sweep against the processor's arithmetic and its memories.

use super::arguments::RooflineArguments;
use super::{Console, Failure, flowing, load, publish};
use crate::execution::{Execution, cores};
use crate::plan::Scene;
use crate::prepared::is_ready;
use crate::provenance::account;
use crate::roofline::{self, Study};
use makadam::lanes::InstructionSet;
use std::path::PathBuf;
use std::process::ExitCode;

/// Scenes that are taken where none are named, from in cache to far beyond.
const SCENES: [&str; 4] = ["drum", "drum-50k", "drum-100k", "drum-500k"];

/// Measures, writes and says what was found.
pub(super) fn roofline(arguments: &RooflineArguments, console: &Console) -> Result<ExitCode, Failure> {
    let set = arguments.isa.map_or_else(InstructionSet::detect, InstructionSet::from);
    let execution = Execution { threads: cores(), instruction_set: set, ..Execution::serial() };
    let mut scenes: Vec<(PathBuf, Scene)> = Vec::new();
    if arguments.scenes.is_empty() {
        for name in SCENES {
            let (file, scene) = load(name, &arguments.changes)?;
            match is_ready(&scene, scene.seed) {
                true => scenes.push((file, scene)),
                false => console.note(&format!("{name} is left out: name it to have its flowing state prepared")),
            }
        }
    }
    for name in &arguments.scenes {
        scenes.push(load(name, &arguments.changes)?);
    }
    let mut counts = vec![1, cores()];
    counts.dedup();
    console.detail("measuring arithmetic and memories");
    let scene_list: Vec<&Scene> = scenes.iter().map(|(_, scene)| scene).collect();
    let mut study = Study::of_machine(set, cores(), account(cores(), &scene_list));
    for (file, scene) in &scenes {
        let mut simulation = flowing(scene, scene.seed, file, &execution, arguments.settle, console)?;
        if !study.measure(&scene.name, &mut simulation)? {
            return Err(Failure::Usage(format!("{} has no contacts to sweep over; settle it for longer", scene.name)));
        }
    }
    let folder = arguments.output.folder("roofline");
    publish(&study, || roofline::table(&study), &folder, arguments.output.json, console)?;
    Ok(ExitCode::SUCCESS)
}
