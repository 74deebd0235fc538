//! `makadam effects`: active effects of a scene, their costs, their influence.

use super::arguments::{SceneArguments, StudyArguments, positive, time_limit};
use super::beforehand::{flowing, settle};
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam_compare::scenes;
use makadam_compare::study::RunCache;
use makadam_frames::execution::Execution;
use makadam_frames::provenance::Provenance;
pub use makadam_studies::effects::{Ablation, Costs, Look, Plan, Study};
use std::process::ExitCode;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct EffectsArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Run the scene with each effect off or on, and report which of its observables depend on it.
    #[arg(long)]
    pub ablate: bool,
    /// Number of seeds of each variation, consecutive from --seed.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub seeds: u16,
    /// Simulated time before kernels are timed, if the scene prepares no flowing state, s.
    #[arg(long, default_value_t = 0.5, value_parser = positive)]
    pub settle: f64,
    /// Simulated time after it over which the energy loss is measured, s.
    #[arg(long, default_value_t = 0.2, value_parser = positive)]
    pub look: f64,
    /// Wall time after which a run of --ablate is stopped, s.
    #[arg(long, default_value_t = 3600.0, value_parser = time_limit)]
    pub time_limit: f64,
    #[command(flatten)]
    pub study: StudyArguments,
}

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
    let folder = arguments.study.output.folder_of("effects", &scene);
    let ablation = if arguments.ablate {
        arguments.study.jobs.apply()?;
        let seeds: Vec<u64> = (seed..seed + u64::from(arguments.seeds)).collect();
        let plan = Plan {
            scene: &scene,
            scene_file: &file,
            seeds: &seeds,
            time_limit: Duration::from_secs_f64(arguments.time_limit),
            cache: &RunCache::open(&folder.join("runs"), arguments.study.restart)?,
            announce: &console.bars(),
        };
        Some(Ablation::run(&plan)?)
    } else {
        None
    };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    let study = Study::new(&scene, &text, (look, costs), ablation, provenance);
    console.publish(&study, &folder, arguments.study.output.json)?;
    let lacking = study.ablation.iter().flat_map(|ablation| &ablation.rows).find(|row| row.mean.is_none());
    if let Some(row) = lacking {
        console.warn(&format!("{} was not measured in every seed of the unchanged scene", row.observable));
    }
    Ok(within_tolerance(lacking.is_none()))
}
