//! `makadam effects`: which effects a scene calls for, what each costs, and whether it matters.

use super::arguments::EffectsArguments;
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, flowing, json, settle};
use crate::compare::KeptRuns;
use crate::effects::{Ablation, Costs, Look, Plan, Study, table};
use crate::execution::Execution;
use crate::provenance::Provenance;
use crate::scenes;
use std::process::ExitCode;
use std::time::Duration;

/// Looks, measures, writes and says what was found.
pub(super) fn effects(arguments: &EffectsArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene, seed) = arguments.scene.load()?;
    let text = scenes::text(&file)?;
    if arguments.ablate && scene.compare.iter().all(|expectation| expectation.margin.is_none()) {
        return Err(Failure::Usage(format!(
            "{} has no observable with a margin, so --ablate has nothing to judge; give margins under [[compare]]",
            scene.name
        )));
    }
    let execution = Execution::serial();
    let mut simulation = flowing(&scene, seed, &file, &execution, arguments.settle, console)?;
    let from = simulation.time();
    simulation.open_ledger();
    settle(&mut simulation, arguments.look, console)?;
    let look = Look::at(&simulation, simulation.time() - from);
    console.detail("timing kernels");
    let costs = Costs::measure(&simulation);
    drop(simulation);
    let folder = arguments.output.folder_of("effects", &scene);
    let ablation = if arguments.ablate {
        arguments.jobs.apply()?;
        let seeds: Vec<u64> = (seed..seed + u64::from(arguments.seeds)).collect();
        let plan = Plan {
            scene: &scene,
            scene_file: &file,
            seeds: &seeds,
            time_limit: Duration::from_secs_f64(arguments.time_limit),
            kept: &KeptRuns::open(&folder.join("runs"), arguments.restart)?,
            announce: &announce(console),
        };
        Some(Ablation::run(&plan)?)
    } else {
        None
    };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    let study = Study::new(&scene, &text, (look, costs), ablation, provenance);
    study.write(&folder)?;
    console.result(&if arguments.output.json { json(&study) } else { table(&study) })?;
    let lacking = study.ablation.iter().flat_map(|ablation| &ablation.rows).find(|row| row.mean.is_none());
    if let Some(row) = lacking {
        console.warn(&format!("{} was not measured in every seed of the unchanged scene", row.observable));
        return Ok(ExitCode::from(OUTSIDE_TOLERANCE));
    }
    Ok(ExitCode::SUCCESS)
}
