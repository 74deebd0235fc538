//! The active effects of a scene; a look at a stretch of its run: where its energy goes, how deep its grains overlap, and what that says of
//! the effects; and their costs: every compiled kernel, swept over the same contacts.

use makadam::effects::CATALOGUE;
use makadam::effects::EffectSet;
use makadam::effects::catalogue::{Effect, FRICTION, RESTITUTION, ROLLING, TWISTING};
use makadam::scene::{NormalLaw, Precision};
use makadam::{Balance, Simulation};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::statistics::median;
use serde::Serialize;
use std::time::Instant;

/// Overlaps beyond this, over the smaller radius, are no longer those of hard grains.
const DEEP: f64 = 0.01;
/// Shares of the energy lost below this are none, and above [`LARGE`] they call for their effect.
const NONE: f64 = 1e-4;
/// See [`NONE`].
const LARGE: f64 = 0.05;

/// Losses of energy and overlaps over a stretch of the run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Look {
    /// Simulated time that was looked at, s.
    pub seconds: f64,
    /// Energy that was lost, J.
    pub lost: f64,
    /// Share of it that friction took.
    pub friction: f64,
    /// Share of it that resistance to turning took.
    pub resistance: f64,
    /// Share of it that impacts took.
    pub impacts: f64,
    /// Largest overlap of two grains, or of a grain and a wall, at the end, over the smaller radius.
    pub largest_overlap: f64,
}

impl Look {
    /// Reads the ledger of a simulation, opened `seconds` ago; `None` without one.
    pub fn at(simulation: &Simulation, seconds: f64) -> Option<Look> {
        let Balance { friction, resistance, restitution, stabilisation, .. } = simulation.balance()?;
        let lost = friction + resistance + restitution + stabilisation.max(0.0);
        let share = |part: f64| if lost > 0.0 { part / lost } else { 0.0 };
        Some(Look {
            seconds,
            lost,
            friction: share(friction),
            resistance: share(resistance),
            impacts: share(restitution),
            largest_overlap: simulation.largest_overlap(),
        })
    }
}

/// Lists effects that are declared without a use, and absent ones that the numbers suggest.
pub fn warnings(scene: &MeasuredScene, look: Option<&Look>) -> Vec<String> {
    let mut warnings = Vec::new();
    let used = |name: &str| {
        let of_grains = scene.grain.iter().any(|grain| grain.material == name)
            || scene.population.iter().any(|group| group.count > 0 && group.material == name);
        of_grains || scene.wall.iter().any(|wall| wall.material == name)
    };
    for (name, material) in scene.material.iter().filter(|(name, _)| !used(name)) {
        let turning = material.rolling_friction > 0.0 || material.twisting_friction > 0.0;
        let costs = if turning { "; its resistance to turning is compiled in all the same" } else { "" };
        warnings.push(format!("material '{name}' is declared, and neither a grain nor a wall has it{costs}"));
    }
    let on = |effect: &Effect| effect.called_by(scene).is_ok();
    let turning = on(&ROLLING) || on(&TWISTING);
    if turning && !on(&FRICTION) {
        warnings.push("grains resist turning, but without friction nothing makes them turn".into());
    }
    let Some(look) = look else { return warnings };
    let percent = |share: f64| format!("{:.2}%", 100.0 * share);
    if turning && look.resistance < NONE {
        warnings.push(format!(
            "resistance to turning took {} of the energy lost: it hardly matters",
            percent(look.resistance)
        ));
    }
    if on(&RESTITUTION) && look.impacts.abs() < NONE {
        warnings.push("restitution is declared, but nothing collides".into());
    }
    if !on(&RESTITUTION) && look.impacts > LARGE {
        warnings.push(format!("impacts took {} of the energy lost, and every restitution is 0", percent(look.impacts)));
    }
    if scene.solver.normal_law == NormalLaw::Rigid && look.largest_overlap > DEEP {
        warnings.push(format!(
            "grains overlap by {} of a radius, and contacts are rigid: call for compliance, or take smaller steps",
            percent(look.largest_overlap)
        ));
    }
    warnings
}

/// One effect: whether the scene calls for it, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Called {
    /// Name of the effect.
    pub effect: &'static str,
    /// True if it is simulated.
    pub on: bool,
    /// Reason.
    pub why: String,
    /// Line of the scene file, from 1; absent where the file leaves it to the default.
    pub line: Option<usize>,
}

/// All effects, in the order in which a step meets them. `text` is the scene file's.
pub fn called(scene: &MeasuredScene, text: &str) -> Vec<Called> {
    let called = CATALOGUE.iter().map(|effect| match effect.called_by(scene) {
        Ok(call) => Called { effect: effect.name, on: true, why: call.why, line: call.place.line(text) },
        Err(without) => Called { effect: effect.name, on: false, why: without.into(), line: None },
    });
    called.collect()
}

/// Rounds in which all kernels are timed, one after the other; their medians count.
const ROUNDS: usize = 15;
/// Contact sweeps of a kernel in a round, at least.
const CONTACT_SWEEPS: usize = 300_000;

/// One kernel.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// The effects that it is compiled with.
    pub effects: &'static str,
    /// True of the kernel of the scene.
    pub called: bool,
    /// Median time of a contact sweep, ns.
    pub nanoseconds: f64,
    /// Median over rounds of its time over that of the kernel with friction alone.
    pub over_friction: f64,
    /// Bytes that a contact takes in its lane group.
    pub bytes: usize,
}

/// All kernels on the contacts of one state.
#[derive(Clone, Debug, Serialize)]
pub struct Costs {
    /// Contacts that were swept over.
    pub contacts: usize,
    /// Instruction set that ran.
    pub instruction_set: &'static str,
    /// One a kernel, from the barest on.
    pub kernels: Vec<Cost>,
}

impl Costs {
    /// Times the sweeps of every kernel on the contacts of this state; absent where it has none.
    pub fn measure(simulation: &Simulation) -> Option<Costs> {
        let called = simulation.effects().compiled();
        let mut compiled = EffectSet::COMPILED.map(|effects| {
            let mut own = simulation.clone();
            own.use_precision(Precision::Double).expect("every scene goes with double precision");
            own.compile_effects(effects);
            (effects, own)
        });
        let contacts = compiled.iter_mut().map(|(_, own)| own.constrain_once()).min()?;
        if contacts == 0 {
            return None;
        }
        let sweeps = CONTACT_SWEEPS.div_ceil(contacts) as u32;
        let mut times = vec![Vec::with_capacity(ROUNDS); compiled.len()];
        for _ in 0..ROUNDS {
            for ((_, own), times) in compiled.iter_mut().zip(&mut times) {
                let start = Instant::now();
                let done = own.sweep_times(sweeps);
                times.push(1e9 * start.elapsed().as_secs_f64() / done as f64);
            }
        }
        let frictional = EffectSet::COMPILED.iter().position(|effects| effects.friction() && !effects.torques())?;
        let cost = |(number, effects): (usize, &EffectSet)| {
            let ratios = times[number].iter().zip(&times[frictional]).map(|(own, friction)| own / friction);
            Cost {
                effects: effects.name(),
                called: *effects == called,
                nanoseconds: median(times[number].clone()),
                over_friction: median(ratios),
                bytes: effects.bytes_of_contact(),
            }
        };
        Some(Costs {
            contacts,
            instruction_set: simulation.instruction_set().name(),
            kernels: EffectSet::COMPILED.iter().enumerate().map(cost).collect(),
        })
    }
}
