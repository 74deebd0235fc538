//! `makadam tradeoff`: error against wall time.

use super::arguments::{OutputArguments, SourceArguments, bound, positive, time_limit};
use super::beforehand::refuse_time_budget;
use super::compare::installed;
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam_compare::codes::{CodeName, codes_of};
use makadam_compare::compare::FEW_SEEDS;
use makadam_compare::study::RunCache;
use makadam_frames::plan::Scene;
use makadam_frames::provenance::account;
use makadam_measure::observables::catalogue::group_of;
use makadam_studies::tradeoff::{Bound, Campaign, Plan, Progress, QUICK_TIME_LIMIT, STIFFNESS_FACTORS, Study, Terms};
use std::process::ExitCode;
use std::sync::Arc;

#[derive(Debug, Args)]
pub(super) struct TradeoffArguments {
    #[command(flatten)]
    pub source: SourceArguments,
    /// Run few configurations, only at the scene's stiffness: about ten minutes for drum or packing.
    #[arg(long)]
    pub quick: bool,
    /// Number of seeds of each setting, consecutive from 1; if absent, 3.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: Option<u64>,
    /// Codes that take part, separated by commas; the converged references are Makadam's in any case.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "makadam,yade,liggghts")]
    pub codes: Vec<CodeName>,
    /// Factors on every Young's modulus; if absent, 0.5, 1, 10 and 100, or 1 with --quick. 1 is always run.
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    pub stiffness_factors: Option<Vec<f64>>,
    /// Tolerated deviation of an observable from the reference; can be given several times. The defaults are 0.5 degrees for an
    /// angle of repose and 0.002 for packing_fraction.
    #[arg(long, value_name = "OBSERVABLE=VALUE", value_parser = bound)]
    pub bound: Vec<Bound>,
    /// Wall time after which a run is stopped, s, and its wall time extrapolated; if absent, 900, or 60 with --quick.
    #[arg(long, value_parser = time_limit)]
    pub time_limit: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

pub(super) fn tradeoff(arguments: &TradeoffArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = arguments.source.load()?;
    refuse_time_budget(&scene)?;
    refuse_unmeasured(&scene, &arguments.bound)?;
    let wanted = installed(&arguments.codes)?;
    let names: Vec<&str> = wanted.iter().map(|code| code.name()).collect();
    let usual: &[f64] = if arguments.quick { &[1.0] } else { &STIFFNESS_FACTORS };
    let plan = Plan::new(&scene, arguments.quick, &names, arguments.stiffness_factors.as_deref().unwrap_or(usual));
    // The reference is Makadam's, whichever codes take part.
    let runners = codes_of(&[arguments.codes.as_slice(), &[CodeName::Makadam]].concat());
    let terms = Terms {
        quick: arguments.quick,
        seeds: arguments.seeds.unwrap_or(FEW_SEEDS),
        bounds: bounds(&arguments.bound),
        time_limit: arguments.time_limit.unwrap_or(if arguments.quick { QUICK_TIME_LIMIT } else { 900.0 }),
        provenance: account(1, &[&scene]),
    };
    let folder = arguments.output.folder_of("tradeoff", &scene);
    let cache = RunCache::open(&folder.join("runs"), false)?;
    let outcome = {
        let bar = console.bar(&scene.name);
        let progress: Progress = Arc::new(move |label, share| {
            bar.say(label.to_string());
            bar.set(share);
        });
        Campaign {
            scene: &scene,
            scene_file: &file,
            plan: &plan,
            seeds: terms.seeds,
            codes: &runners,
            time_limit: terms.time_limit,
            cache: &cache,
            progress,
        }
        .carry_out()?
    };
    outcome.sentences(&plan).iter().for_each(|note| console.warn(note));
    let found: usize = outcome.runs.iter().map(Vec::len).sum();
    console.note(&format!("{} runs made, {} taken from {}", outcome.made, found - outcome.made, folder.display()));

    let study = Study::new(&scene, &plan, &outcome, terms);
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

/// Refuses scenes that measure nothing, or not what is bounded, and two bounds on one observable.
fn refuse_unmeasured(scene: &Scene, bounds: &[Bound]) -> Result<(), Failure> {
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

/// Returns the default bounds, replaced by given ones.
fn bounds(given: &[Bound]) -> Vec<Bound> {
    let is_given = |bound: &Bound| given.iter().any(|other| other.observable == bound.observable);
    Bound::usual().into_iter().filter(|bound| !is_given(bound)).chain(given.iter().cloned()).collect()
}
