//! `makadam effects`: which effects a scene calls for, what each costs, and whether it matters.

use super::arguments::EffectsArguments;
use super::{Console, Failure, OUTSIDE_TOLERANCE, announce, begin, folder_of, json, load, settle, use_threads};
use crate::effects::{Ablation, Costs, Look, Plan, Study, called, markdown, table, warnings};
use crate::execution::Execution;
use crate::output::{JSON_VERSION, create_folder, write_whole};
use crate::prepared::Start;
use crate::provenance::Provenance;
use crate::scenes;
use std::process::ExitCode;
use std::time::Duration;

/// Looks, measures, writes and says what was found.
pub(super) fn effects(arguments: &EffectsArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = load(&arguments.scene)?;
    let text = scenes::text(&file)?;
    if arguments.ablate && scene.compare.iter().all(|expectation| expectation.margin.is_none()) {
        return Err(Failure::Usage(format!(
            "{} has no observable with a margin, so --ablate could judge nothing; give margins under [[compare]]",
            scene.name
        )));
    }
    let seed = arguments.seed.unwrap_or(scene.seed);
    let execution = Execution::serial();
    let (mut simulation, start) = begin(&scene, seed, &file, &execution, console)?;
    if start == Start::Fresh {
        // A lattice gas has hardly a contact to sweep over.
        settle(&mut simulation, arguments.settle, console)?;
    }
    let from = simulation.time();
    simulation.open_ledger();
    settle(&mut simulation, arguments.look, console)?;
    let look = Look::at(&simulation, simulation.time() - from);
    console.detail("timing kernels");
    let costs = Costs::measure(&simulation);
    drop(simulation);
    let folder = folder_of(arguments.output.as_deref(), "effects", &scene);
    let ablation = if arguments.ablate {
        use_threads(arguments.threads)?;
        let seeds: Vec<u64> = (seed..seed + u64::from(arguments.seeds)).collect();
        let plan = Plan {
            scene: &scene,
            scene_file: &file,
            seeds: &seeds,
            time_limit: Duration::from_secs_f64(arguments.time_limit),
            folder: &folder.join("runs"),
            again: arguments.again,
            announce: &announce(console),
        };
        Some(Ablation::run(&plan)?)
    } else {
        None
    };
    let study = Study {
        version: JSON_VERSION,
        command: "effects",
        effects: called(&scene, &text),
        warnings: warnings(&scene, look.as_ref()),
        scene: scene.name.clone(),
        costs,
        look,
        ablation,
        provenance: Provenance::of_run(&scene, &file, seed, &execution),
    };
    create_folder(&folder)?;
    let document = json(&study);
    write_whole(&folder.join("effects.json"), document.as_bytes())?;
    if study.ablation.is_some() {
        write_whole(&folder.join("ablation.md"), markdown(&study).as_bytes())?;
    }
    console.result(&if arguments.json { document } else { table(&study) })?;
    let lacking = study.ablation.iter().flat_map(|ablation| &ablation.rows).find(|row| row.mean.is_none());
    if let Some(row) = lacking {
        console.warn(&format!("{} was not measured in every seed of the scene as it is", row.observable));
        return Ok(ExitCode::from(OUTSIDE_TOLERANCE));
    }
    Ok(ExitCode::SUCCESS)
}
