//! Active effects of a scene, and their costs: every compiled kernel, swept over the same contacts.

use makadam::Simulation;
use makadam::effects::{CATALOGUE, EffectSet};
use makadam::scene::Precision;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::statistics::median;
use serde::Serialize;
use std::time::Instant;

/// One effect: its state in the scene, and the reason.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Called {
    /// Name of the effect.
    pub effect: &'static str,
    /// True if the effect is simulated.
    pub on: bool,
    /// Reason.
    pub why: String,
    /// Line of the scene file, from 1; absent where the file omits it and the default applies.
    pub line: Option<usize>,
}

/// Returns all effects, in the order in which a step applies them. `text` is the scene file's.
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
    /// Effects compiled into the kernel.
    pub effects: &'static str,
    /// True of the kernel of the scene.
    pub called: bool,
    /// Median time of a contact sweep, ns.
    pub nanoseconds: f64,
    /// Median over rounds of its time over that of the kernel with friction alone.
    pub over_friction: f64,
    /// Bytes of a contact in its lane group.
    pub bytes: usize,
}

/// All kernels on the contacts of one state.
#[derive(Clone, Debug, Serialize)]
pub struct Costs {
    /// Number of contacts in a sweep.
    pub contacts: usize,
    /// Instruction set of the run.
    pub instruction_set: &'static str,
    /// One entry per kernel, the simplest first.
    pub kernels: Vec<Cost>,
}

impl Costs {
    /// Times the sweeps of every kernel on the contacts of this state; absent without contacts.
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
