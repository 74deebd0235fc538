//! `makadam lab scaling`: how a scene's step scales, measured on the cores at hand and replayed beyond them.

use super::arguments::ScalingArguments;
use super::{Console, Failure, can_record, flowing, publish, refuse_time_budget};
use crate::execution::{Execution, cores};
use crate::output::record_folder;
use crate::provenance::Provenance;
use crate::scaling::{Plan, Study};
use crate::study::Document;
use makadam::lanes::InstructionSet;
use makadam::schedule::Scheduler;
use std::process::ExitCode;

/// Measures, replays, writes and says what was found; different bits are a failure.
pub(super) fn scaling(arguments: &ScalingArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene, seed) = arguments.scene.load()?;
    if arguments.record {
        can_record(&file)?;
    }
    refuse_time_budget(&scene)?;
    let cores = cores();
    let plan = plan(arguments, cores);
    if plan.traced_steps < arguments.traced_steps {
        console.note(&format!(
            "{} steps are traced, because there are no more, not {}",
            plan.traced_steps, arguments.traced_steps
        ));
    }
    if plan.threads.iter().any(|&threads| threads > cores) {
        console.warn(&format!("more threads than the {cores} available cores: such times are not meaningful"));
    }
    let widest = plan.instruction_sets.last().copied().unwrap_or_else(InstructionSet::detect);
    let most = plan.threads.iter().copied().max().unwrap_or(1);
    let execution =
        Execution { scheduler: Scheduler::WorkStealing, threads: most, instruction_set: widest, ..Execution::serial() };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    let simulation = flowing(&scene, seed, &file, &execution, arguments.settle, console)?;
    let study = {
        let bar = console.bar(&scene.name);
        let tell = |words: &str| console.detail(words);
        let memory = arguments.memory_bandwidth.map(|gigabytes| 1e9 * gigabytes);
        Study::measure(&scene.name, simulation, &plan, memory, provenance, &tell, &|share| bar.set(share))?
    };
    let folder = arguments.output.folder_of("scaling", &scene);
    publish(&study, &folder, arguments.output.json, console)?;
    if arguments.record {
        let folder = record_folder(
            "scaling",
            &file,
            &study.provenance.build.processor,
            study.widest(),
            Some(study.machine.cores),
        );
        study.write_tables(&folder)?;
        console.note(&format!("tables: {}", folder.display()));
    }
    match study.same_bits {
        true => Ok(ExitCode::SUCCESS),
        false => Err(Failure::Running(format!("not the same bits: {}", study.differing.join("; ")))),
    }
}

/// What is measured: by default 1, 2, 4, ... threads and all cores.
fn plan(arguments: &ScalingArguments, cores: usize) -> Plan {
    let mut threads: Vec<usize> = match &arguments.threads_list {
        Some(list) => list.iter().map(|&threads| usize::from(threads)).collect(),
        None => (0..).map(|k| 1 << k).take_while(|&threads| threads < cores).chain([cores]).collect(),
    };
    threads.sort_unstable();
    threads.dedup();
    let mut instruction_sets = match &arguments.isa {
        Some(list) => list.iter().map(|&name| InstructionSet::from(name)).collect(),
        None => InstructionSet::ALL.into_iter().filter(|set| set.is_available()).collect::<Vec<_>>(),
    };
    // Narrowest first: the last is the one that stands for all of them.
    instruction_sets.sort_by_key(|set| InstructionSet::ALL.iter().position(|known| known == set));
    instruction_sets.dedup();
    Plan {
        instruction_sets,
        threads,
        steps: arguments.steps,
        traced_steps: arguments.traced_steps.min(arguments.steps),
        repetitions: arguments.repetitions as usize,
    }
}
