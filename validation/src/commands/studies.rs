//! `makadam effects`: active effects of a scene, their costs, their influence; `makadam sweep`: a scene over values of some of its keys;
//! `makadam tradeoff`: error against wall time.

use super::arguments::{
    OutputArguments, SceneArguments, SourceArguments, StudyArguments, bound, observable, positive, time_limit,
};
use super::beforehand::{flowing, refuse_time_budget};
use super::compare::installed;
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam_compare::codes::{CodeName, codes_of};
use makadam_compare::compare::FEW_SEEDS;
use makadam_compare::scenes;
use makadam_compare::study::RunCache;
use makadam_frames::execution::Execution;
use makadam_frames::output::FolderLock;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::{Provenance, account};
use makadam_measure::observables::catalogue::group_of;
use makadam_studies::effects::{self, Ablation, Costs};
use makadam_studies::parameter_study;
use makadam_studies::tradeoff::{self, Bound, Campaign, Terms};
use std::path::Path;
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
    let simulation = flowing(&scene, seed, &file, &execution, arguments.settle, console)?;
    console.detail("timing kernels");
    let costs = Costs::measure(&simulation);
    drop(simulation);
    let folder = arguments.study.output.folder_of("effects", &scene);
    let ablation = if arguments.ablate {
        arguments.study.jobs.apply()?;
        let seeds: Vec<u64> = (seed..seed + u64::from(arguments.seeds)).collect();
        let plan = effects::Plan {
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
    let study = effects::Study::new(&scene, &text, costs, ablation, provenance);
    console.publish(&study, &folder, arguments.study.output.json)?;
    let lacking = study.ablation.iter().flat_map(|ablation| &ablation.rows).find(|row| row.mean.is_none());
    if let Some(row) = lacking {
        console.warn(&format!("{} was not measured in every seed of the unchanged scene", row.observable));
    }
    Ok(within_tolerance(lacking.is_none()))
}

#[derive(Debug, Args)]
pub(super) struct SweepArguments {
    #[command(flatten)]
    pub source: SourceArguments,
    /// Key and its values, such as material.grain.friction=0.1,0.3,0.5; if given several times, every combination is run; if
    /// absent, the scene itself.
    #[arg(long, value_name = "KEY=VALUES")]
    pub over: Vec<parameter_study::Range>,
    /// Number of seeds of each combination, consecutive from the scene's own (--set seed=N).
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: u64,
    /// Observables to print; if absent, the compared ones of the scene, or all measured ones. The files contain all.
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
    let plan = parameter_study::Plan {
        file: &file,
        ranges: &arguments.over,
        seeds: &seeds,
        folder: &folder,
        again: arguments.study.restart,
        announce: &console.bars(),
    };
    let _lock = FolderLock::take(&folder)?;
    refuse_other_keys(&folder, arguments)?;
    let compared = || scene.compare.iter().map(|expectation| expectation.observable.clone()).collect();
    let shown = if arguments.observables.is_empty() { compared() } else { arguments.observables.clone() };
    let study = parameter_study::Study::make(&plan, &scene, account(1, &[&scene]), shown)?;
    console.publish(&study, &folder, arguments.study.output.json)?;
    if let [first, others @ ..] = &study.failed[..] {
        let parameter_study::Failed { values, seed, problem } = first;
        let more = if others.is_empty() { String::new() } else { format!("; {} more: see sweep.json", others.len()) };
        return Err(Failure::Running(format!("{}: {problem}{more}", parameter_study::run_name(values, *seed))));
    }
    let lacking = study.points.iter().any(|point| point.observables.is_empty());
    if lacking {
        console.warn("some combinations have no value of any observable: see runs.csv");
    }
    Ok(within_tolerance(!lacking))
}

/// Refuses a folder with the tables of a sweep over other keys, which the new tables would replace.
fn refuse_other_keys(folder: &Path, arguments: &SweepArguments) -> Result<(), Failure> {
    let text = std::fs::read(folder.join("sweep.json")).unwrap_or_default();
    let Ok(earlier) = serde_json::from_slice::<serde_json::Value>(&text) else { return Ok(()) };
    let own: Vec<&str> = arguments.over.iter().map(|range| range.key.as_str()).collect();
    let keys: Vec<&str> = earlier["keys"].as_array().into_iter().flatten().filter_map(|key| key.as_str()).collect();
    if keys == own || arguments.study.restart {
        return Ok(());
    }
    let over = if keys.is_empty() { "no key".into() } else { keys.join(", ") };
    let problem = format!("{} holds the tables of a sweep over {over}", folder.display());
    Err(Failure::Usage(format!("{problem}; give another folder with --output, or replace them with --restart")))
}

#[derive(Debug, Args)]
pub(super) struct TradeoffArguments {
    #[command(flatten)]
    pub source: SourceArguments,
    /// Number of seeds of each setting, consecutive from 1.
    #[arg(long, default_value_t = FEW_SEEDS, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: u64,
    /// Codes that take part, separated by commas; the converged references are Makadam's in any case.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "makadam,yade,liggghts")]
    pub codes: Vec<CodeName>,
    /// Factors on every Young's modulus, separated by commas; 1 is always run.
    #[arg(long, value_delimiter = ',', default_value = "1", value_parser = positive)]
    pub stiffness_factors: Vec<f64>,
    /// Tolerated deviation of an observable from the reference; can be given several times. The defaults are 0.5 degrees for an
    /// angle of repose and 0.002 for packing_fraction.
    #[arg(long, value_name = "OBSERVABLE=VALUE", value_parser = bound)]
    pub bound: Vec<Bound>,
    /// Wall time after which a run of another code than Makadam is stopped, s: its setting is listed without a time or an error.
    #[arg(long, default_value_t = 900.0, value_parser = time_limit)]
    pub time_limit: f64,
    #[command(flatten)]
    pub output: OutputArguments,
}

pub(super) fn tradeoff(arguments: &TradeoffArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = arguments.source.load()?;
    refuse_time_budget(&scene)?;
    refuse_unmeasured(&scene, &arguments.bound)?;
    let wanted = installed(&arguments.codes)?;
    let names: Vec<&str> = wanted.iter().map(|code| code.name()).collect();
    let plan = tradeoff::Plan::new(&scene, &names, &arguments.stiffness_factors);
    // The reference is Makadam's for any selection of codes.
    let runners = codes_of(&[arguments.codes.as_slice(), &[CodeName::Makadam]].concat());
    let terms = Terms {
        seeds: arguments.seeds,
        bounds: bounds(&arguments.bound),
        time_limit: arguments.time_limit,
        provenance: account(1, &[&scene]),
    };
    let folder = arguments.output.folder_of("tradeoff", &scene);
    let cache = RunCache::open(&folder.join("runs"), false)?;
    let campaign = Campaign {
        scene: &scene,
        scene_file: &file,
        plan: &plan,
        seeds: terms.seeds,
        codes: &runners,
        time_limit: terms.time_limit,
        cache: &cache,
        announce: &console.bars(),
    };
    let outcome = campaign.carry_out()?;
    outcome.sentences(&plan).iter().for_each(|note| console.warn(note));
    let [made, taken] = cache.counts();
    console.note(&format!("{made} runs made, {taken} taken from {}", folder.display()));
    let study = tradeoff::Study::new(&scene, &plan, &outcome, terms);
    console.publish(&study, &folder, arguments.output.json)?;
    if !study.complete {
        let stored = format!("stored in {}; the same command continues from there", folder.display());
        return Err(Failure::interrupted(&stored));
    }
    // A given bound on an observable without a reference value was not tested.
    let unmeasured = arguments.bound.iter().find(|bound| study.reference(&bound.observable, 1.0).is_none());
    if let Some(Bound { observable, .. }) = unmeasured {
        console.warn(&format!("{observable} is bounded and was not measured in the reference"));
    }
    Ok(within_tolerance(unmeasured.is_none() && study.reaches_bounds("Makadam") != Some(false)))
}

/// Refuses scenes without measurements, bounds on unmeasured observables, and two bounds on one observable.
fn refuse_unmeasured(scene: &MeasuredScene, bounds: &[Bound]) -> Result<(), Failure> {
    if scene.measure.observables.is_empty() {
        return Err(Failure::Usage(format!(
            "{} measures nothing, so there is no error to show; name observables under [measure]",
            scene.name
        )));
    }
    for (place, Bound { observable, .. }) in bounds.iter().enumerate() {
        if bounds[..place].iter().any(|earlier| earlier.observable == *observable) {
            return Err(Failure::Usage(format!("--bound {observable}: two bounds on one observable; give one")));
        }
        if let Some((group, words)) = group_of(observable)
            && !scene.measure.observables.contains(&group)
        {
            return Err(Failure::Usage(format!(
                "--bound {observable}: {} does not measure it; add \"{words}\" to its measure.observables",
                scene.name
            )));
        }
    }
    Ok(())
}

/// Returns the default bounds, replaced by the given ones.
fn bounds(given: &[Bound]) -> Vec<Bound> {
    let is_given = |bound: &Bound| given.iter().any(|other| other.observable == bound.observable);
    Bound::usual().into_iter().filter(|bound| !is_given(bound)).chain(given.iter().cloned()).collect()
}
