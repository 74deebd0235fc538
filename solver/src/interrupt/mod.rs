//! Asking a simulation to stop inside a step.
//!
//! A step whose solve may be long looks between sweeps whether it was asked to stop. If so it is abandoned: nothing has moved,
//! velocities, spins and driven walls get back what they had when it began, impulses are those that the last step left, and no
//! contacts are laid out, as in a simulation that was resumed from a checkpoint. Later steps, and steps of what is resumed from a
//! checkpoint of that state, have the bits that they would have had.

use crate::Simulation;
use crate::methods::Problem;
use crate::scene::SolverSettings;
use crate::world::World;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request to stop, shared by who asks and who is asked. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<Request>);

#[derive(Debug, Default)]
struct Request {
    made: AtomicBool,
    /// Asks by itself when it is looked at for this time, counted from 1.
    #[cfg(test)]
    by_itself: std::sync::atomic::AtomicU64,
}

impl Interrupt {
    /// One that was not asked for yet.
    pub fn new() -> Interrupt {
        Interrupt::default()
    }

    /// Asks for a stop; whether it had been asked for before.
    pub fn request(&self) -> bool {
        self.0.made.swap(true, Ordering::SeqCst)
    }

    /// Whether a stop was asked for.
    #[inline]
    pub fn is_requested(&self) -> bool {
        #[cfg(test)]
        if self.0.by_itself.fetch_sub(1, Ordering::SeqCst) == 1 {
            self.request();
        }
        self.0.made.load(Ordering::Relaxed)
    }

    /// Takes the request back, between steps.
    pub fn clear(&self) {
        self.0.made.store(false, Ordering::SeqCst);
    }
}

/// Sweeps that a solve may take unasked: so few are over soon, and need nothing kept to go back to.
const UNASKED: u64 = 64;

/// Whether solves look for an interrupt.
pub(crate) fn is_heeded(settings: &SolverSettings) -> bool {
    u64::from(settings.stop.max_sweeps()) * u64::from(settings.inner_sweeps.max(1)) > UNASKED
}

impl Problem<'_> {
    /// Whether the solve has been asked to stop.
    pub fn is_interrupted(&self) -> bool {
        is_heeded(self.settings) && self.interrupt.is_requested()
    }
}

impl Simulation {
    /// What stops a step of this simulation, and of its clones, from another thread: see [`interrupt`](crate::interrupt). Solves of
    /// at most 64 sweeps do not look.
    pub fn interrupt_handle(&self) -> Interrupt {
        self.interrupt.clone()
    }

    /// Stops when this is asked to: one request may stop many simulations.
    pub fn heed(&mut self, interrupt: Interrupt) {
        self.interrupt = interrupt;
    }

    /// Whether spins at the start of a step are kept: friction may go by how contacts slide, and a step may be abandoned.
    pub(crate) fn keeps_spins(&self) -> bool {
        let effects = &self.relaxation.effects;
        effects.kinetic_friction() || (effects.tangential() && is_heeded(&self.settings))
    }

    /// Goes back to the start of a step whose solve was interrupted.
    pub(crate) fn abandon_step(&mut self) {
        let World { bodies, before, spins_before, drives, .. } = &mut self.world;
        for (body, before) in bodies.iter_mut().zip(before) {
            let [x, y, z, _] = before.0;
            body.velocity = [x, y, z];
        }
        for (body, before) in bodies.iter_mut().zip(spins_before) {
            let [x, y, z, _] = before.0;
            body.surface_speed = [x, y, z];
        }
        drives.iter_mut().for_each(|drive| drive.rate = drive.rate_before);
        self.layout.contacts = 0;
        self.layout.driven.clear();
        for groups in &mut self.layout.groups {
            groups.empty(self.relaxation.effects);
        }
    }
}

#[cfg(test)]
mod tests;
