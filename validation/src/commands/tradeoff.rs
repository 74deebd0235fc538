//! `makadam tradeoff`: what accuracy costs in time.

use super::arguments::{BoundArgument, TradeoffArguments};
use super::{Console, Failure, OUTSIDE_TOLERANCE, installed, publish, refuse_time_budget};
use crate::compare::FEW_SEEDS;
use crate::observables::catalogue::group_of;
use crate::peers::{CodeName, codes_of};
use crate::plan::Scene;
use crate::provenance::account;
use crate::study::RunCache;
use crate::tradeoff::{Bound, Campaign, Plan, Progress, QUICK_TIME_LIMIT, STIFFNESS_FACTORS, Scope, Study, Terms};
use std::process::ExitCode;
use std::sync::Arc;

/// Wall time at which a run is cut short, s, where none is given: for few configurations, and for all.
const TIME_LIMITS: [f64; 2] = [QUICK_TIME_LIMIT, 900.0];

/// Runs what is missing, then writes and says what all runs tell.
pub(super) fn tradeoff(arguments: &TradeoffArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = arguments.source.load()?;
    refuse_time_budget(&scene)?;
    refuse_unmeasured(&scene, &arguments.bound)?;
    let wanted = installed(&arguments.codes)?;
    let names: Vec<&str> = wanted.iter().map(|code| code.name()).collect();
    let scope = match (arguments.quick, arguments.variations) {
        (false, _) => Scope::Full,
        (true, false) => Scope::Quick,
        (true, true) => Scope::QuickAndVaried,
    };
    let plan = Plan::new(&scene, scope, &names, &stiffness_factors(arguments));
    // The reference is Makadam's, whichever codes are asked for.
    let runners = codes_of(&[arguments.codes.as_slice(), &[CodeName::Makadam]].concat());
    let [quick, full] = TIME_LIMITS;
    let terms = Terms {
        quick: arguments.quick,
        seeds: arguments.seeds.unwrap_or(FEW_SEEDS),
        bounds: bounds(&arguments.bound),
        time_limit: arguments.time_limit.unwrap_or(if arguments.quick { quick } else { full }),
        provenance: account(1, &[&scene]),
    };
    let folder = arguments.output.folder_of("tradeoff", &scene);
    let cache = RunCache::open(&folder.join("runs"))?;
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
    publish(&study, &folder, arguments.output.json, console)?;
    // A bound that was asked for and that no reference has a value for was kept by nothing.
    let unmeasured = arguments.bound.iter().find(|bound| study.reference(&bound.observable, 1.0).is_none());
    match (study.complete, study.reaches_bounds("Makadam")) {
        (true, _) if unmeasured.is_some() => {
            console.warn(&format!(
                "{} is bounded and was not measured in the reference",
                unmeasured.map_or("", |bound| &bound.observable)
            ));
            Ok(ExitCode::from(OUTSIDE_TOLERANCE))
        }
        (false, _) => {
            Err(Failure::Interrupted(format!("stored in {}; the same command continues from there", folder.display())))
        }
        (true, Some(false)) => Ok(ExitCode::from(OUTSIDE_TOLERANCE)),
        (true, _) => Ok(ExitCode::SUCCESS),
    }
}

/// Refuses scenes that measure nothing, or not what is bounded, and two bounds on one observable.
fn refuse_unmeasured(scene: &Scene, bounds: &[BoundArgument]) -> Result<(), Failure> {
    if scene.measure.observables.is_empty() {
        return Err(Failure::Usage(format!(
            "{} measures nothing, so there is no error to show; name observables under [measure]",
            scene.name
        )));
    }
    for (place, BoundArgument { observable, .. }) in bounds.iter().enumerate() {
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

fn stiffness_factors(arguments: &TradeoffArguments) -> Vec<f64> {
    match &arguments.stiffness_factors {
        Some(factors) => factors.clone(),
        None if arguments.quick => vec![1.0],
        None => STIFFNESS_FACTORS.to_vec(),
    }
}

/// The default bounds with those that were given in their place.
fn bounds(given: &[BoundArgument]) -> Vec<Bound> {
    let mut bounds = Bound::usual();
    for BoundArgument { observable, value } in given {
        bounds.retain(|bound| bound.observable != *observable);
        bounds.push(Bound { observable: observable.clone(), value: *value });
    }
    bounds
}
