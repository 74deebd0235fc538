//! `makadam roofline`: the sweep against the processor's arithmetic and its memories.

use super::arguments::RooflineArguments;
use super::{Console, Failure, begin, load, publish, settle};
use crate::execution::{Execution, cores};
use crate::plan::Scene;
use crate::prepared::{Start, is_ready};
use crate::provenance::account;
use crate::roofline::{self, Kernel, Point, Roofs, Study};
use makadam::lanes::InstructionSet;
use makadam::sweep::Operations;
use std::path::PathBuf;
use std::process::ExitCode;

/// Scenes that are taken where none are named, from in cache to far beyond.
const SCENES: [&str; 4] = ["drum", "drum-50k", "drum-100k", "drum-500k"];
/// Steps that fill caches and buffers first.
const WARM_UP: usize = 3;

/// Measures, writes and says what was found.
pub(super) fn roofline(arguments: &RooflineArguments, console: &Console) -> Result<ExitCode, Failure> {
    let set = arguments.isa.map_or_else(InstructionSet::detect, InstructionSet::from);
    let execution = Execution { threads: cores(), instruction_set: set, ..Execution::serial() };
    let mut scenes: Vec<(PathBuf, Scene)> = Vec::new();
    if arguments.scenes.is_empty() {
        for name in SCENES {
            let (file, scene) = load(name)?;
            match is_ready(&scene, scene.seed) {
                true => scenes.push((file, scene)),
                false => console.note(&format!("{name} is left out: name it to have its flowing state prepared")),
            }
        }
    }
    for name in &arguments.scenes {
        scenes.push(load(name)?);
    }
    let mut counts = vec![1, cores()];
    counts.dedup();
    console.detail("measuring arithmetic and memories");
    let roofs: Vec<Roofs> = if set.is_available() {
        counts.iter().map(|&threads| Roofs::measure(set, threads)).collect()
    } else {
        // The simulation below says which sets there are.
        Vec::new()
    };
    let mut points = Vec::new();
    for (file, scene) in &scenes {
        let (mut simulation, start) = begin(scene, scene.seed, file, &execution, console)?;
        if start == Start::Fresh {
            settle(&mut simulation, arguments.settle, console)?;
        }
        (0..WARM_UP).for_each(|_| {
            simulation.step();
        });
        if simulation.layout().contacts == 0 {
            return Err(Failure::Usage(format!("{} has no contacts to sweep over; settle it for longer", scene.name)));
        }
        for roofs in &roofs {
            for kernel in [Kernel::Scalar, Kernel::Lanes] {
                points.push(Point::measure(&scene.name, &simulation, kernel, set, roofs)?);
                if crate::interrupt::requested() {
                    return Err(Failure::Interrupted("nothing: the measurement was not finished".into()));
                }
            }
        }
    }
    let study = Study {
        version: crate::output::JSON_VERSION,
        command: "roofline".into(),
        instruction_set: set.name().into(),
        pair: Operations::of_pair(),
        wall: Operations::of_wall(),
        roofs,
        points,
        provenance: account(cores(), &scenes.iter().map(|(_, scene)| scene).collect::<Vec<_>>()),
    };
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from("results/roofline"));
    publish(&study, || roofline::table(&study), &folder, arguments.json, console)?;
    Ok(ExitCode::SUCCESS)
}
