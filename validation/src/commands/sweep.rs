//! `makadam sweep`: a scene over values of some of its keys.

use super::arguments::{SourceArguments, StudyArguments, observable};
use super::beforehand::refuse_time_budget;
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam_frames::provenance::account;
use makadam_measure::observables::catalogue::group_of;
use makadam_studies::parameter_study::{Failed, Plan, Range, Study, take};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct SweepArguments {
    #[command(flatten)]
    pub source: SourceArguments,
    /// A key and its values, such as material.grain.friction=0.1,0.3,0.5; if given several times, every combination is run.
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub over: Vec<Range>,
    /// Number of seeds of each combination, consecutive from the scene's own (--set seed=N).
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: u64,
    /// Observables to print; if absent, those that the scene compares, or all that it measures. The files contain all.
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = observable)]
    pub observables: Vec<String>,
    #[command(flatten)]
    pub study: StudyArguments,
}

pub(super) fn sweep(arguments: &SweepArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = arguments.source.load()?;
    refuse_time_budget(&scene)?;
    if scene.measure.observables.is_empty() {
        return Err(Failure::Usage(format!(
            "{} measures nothing, so there is nothing to put into a table; name observables under [measure], or with \
             --set 'measure.observables=[\"packing-fraction\"]'",
            scene.name
        )));
    }
    let measured = |name: &&String| group_of(name).is_some_and(|(group, _)| scene.measure.observables.contains(&group));
    if let Some(name) = arguments.observables.iter().find(|name| !measured(name)) {
        return Err(Failure::Usage(format!(
            "{} does not measure '{name}'; name its group under measure.observables (`makadam print observables` lists them)",
            scene.name
        )));
    }
    arguments.study.jobs.apply()?;
    let folder = arguments.study.output.folder_of("sweep", &scene);
    let seeds: Vec<u64> = (scene.seed..scene.seed.saturating_add(arguments.seeds)).collect();
    let plan = Plan {
        file: &file,
        ranges: &arguments.over,
        seeds: &seeds,
        folder: &folder,
        again: arguments.study.restart,
        announce: &console.bars(),
    };
    let _lock = take(&plan, &scene)?;
    let compared = || scene.compare.iter().map(|expectation| expectation.observable.clone()).collect();
    let shown = if arguments.observables.is_empty() { compared() } else { arguments.observables.clone() };
    let study = Study::make(&plan, &scene, account(1, &[&scene]), shown)?;
    console.publish(&study, &folder, arguments.study.output.json)?;
    for point in &study.points {
        for (run, alarm) in point.runs.iter().flat_map(|run| run.alarms.iter().map(move |alarm| (run, alarm))) {
            console.warn(&format!("{}, seed {}: {}", point.values.join(", "), run.seed, alarm.words()));
        }
    }
    if let [first, others @ ..] = &study.failed[..] {
        let Failed { values, seed, problem } = first;
        let more = if others.is_empty() { String::new() } else { format!("; {} more: see sweep.json", others.len()) };
        return Err(Failure::Running(format!("{}, seed {seed}: {problem}{more}", values.join(", "))));
    }
    let lacking = study.points.iter().any(|point| point.observables.is_empty());
    if lacking {
        console.warn("some combinations have no value of any observable: see runs.csv");
    }
    Ok(within_tolerance(!lacking))
}
