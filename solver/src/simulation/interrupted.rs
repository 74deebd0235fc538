//! A step that is given up: see [`interrupt`](crate::interrupt).

use super::Simulation;
use crate::interrupt::{Interrupt, is_heeded};
use crate::world::World;

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

    /// Whether its solves may be so long that they look whether they are to stop.
    pub fn heeds_interrupts(&self) -> bool {
        is_heeded(&self.settings)
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
            body.scaled_spin = [x, y, z];
        }
        drives.iter_mut().for_each(|drive| drive.rate = drive.rate_before);
        self.abandon_torques();
        self.layout.contacts = 0;
        self.layout.driven.clear();
        for groups in &mut self.layout.groups {
            groups.empty(self.relaxation.effects);
        }
    }
}
