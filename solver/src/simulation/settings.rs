//! Settings of later steps, and interrupts. An invalid setting is refused, and nothing changes.

use super::Simulation;
use crate::interrupt::{Interrupt, polls_interrupt};
use crate::lanes::InstructionSet;
use crate::methods::Solver;
use crate::partition::Portion;
use crate::scene::{Obstacle, Precision, SettingError, SolverMethod, Stop, method_goes_with, precision_goes_with};
use crate::schedule::{Scheduler, Team};
use crate::world::World;

impl Simulation {
    /// Selects an instruction set other than the detected one; all give the same bits.
    ///
    /// # Errors
    /// [`SettingError::NoInstructionSet`] if the processor lacks it.
    pub fn use_instruction_set(&mut self, instruction_set: InstructionSet) -> Result<(), SettingError> {
        self.relaxation.instruction_set = instruction_set.on_this_processor().ok_or_else(|| {
            let available = InstructionSet::ALL.into_iter().filter(|set| set.is_available());
            SettingError::NoInstructionSet { wanted: instruction_set, available: available.collect() }
        })?;
        Ok(())
    }

    /// Returns the property of the scene that only Gauss-Seidel in double precision supports.
    fn obstacle(&self) -> Option<Obstacle> {
        let effects = &self.relaxation.effects;
        Obstacle::of_scene(effects.torques(), !self.world.drives.is_empty(), effects.spring())
    }

    /// Sets the precision of sweeps from the next step on; this changes the result.
    ///
    /// # Errors
    /// [`SettingError::SinglePrecision`] if contacts transmit torques, walls are dynamic or the method is not Gauss-Seidel: all
    /// three require double precision.
    pub fn use_precision(&mut self, precision: Precision) -> Result<(), SettingError> {
        precision_goes_with(precision, self.settings.method, || self.obstacle())?;
        self.settings.precision = precision;
        Ok(())
    }

    /// Prefetches bodies the given number of lane groups before a sweep needs them; 0 leaves prefetching to the processor. `None`
    /// selects the distance by size: zero if a step fits into the cache.
    pub fn use_prefetch(&mut self, groups: Option<usize>) {
        self.prefetch = groups;
        self.choose_prefetch();
    }

    /// Sets the task granularity of threads; the bits stay the same.
    pub fn use_portion(&mut self, portion: Portion) {
        self.layout.plan.set_portion(portion);
    }

    /// Sets the solver method of later steps.
    ///
    /// # Errors
    /// [`SettingError::Method`] if contacts transmit torques, walls are dynamic or sweeps are in single precision: all three
    /// require Gauss-Seidel.
    pub fn use_method(&mut self, method: SolverMethod) -> Result<(), SettingError> {
        self.goes_with(method)?;
        self.settings.method = method;
        self.solver = Solver::new(method);
        Ok(())
    }

    /// Checks that a method can solve later steps.
    ///
    /// # Errors
    /// Same as [`use_method`](Simulation::use_method).
    pub fn goes_with(&self, method: SolverMethod) -> Result<(), SettingError> {
        method_goes_with(method, self.settings.precision, || self.obstacle())
    }

    /// Sets the stop criterion of later solves.
    pub fn use_stop(&mut self, stop: Stop) {
        self.settings.stop = stop;
    }

    /// Sets the scheduler and the number of threads; any choice gives the same bits.
    ///
    /// # Errors
    /// [`SettingError::NoThreads`] if the system provides no more threads.
    pub fn use_team(&mut self, scheduler: Scheduler, threads: usize) -> Result<(), SettingError> {
        let refused =
            |error: rayon::ThreadPoolBuildError| SettingError::NoThreads { threads, reason: error.to_string() };
        self.team = Team::new(scheduler, threads).map_err(refused)?;
        Ok(())
    }

    /// Returns a handle that stops a step of this simulation, and of its clones, from another thread: see
    /// [`interrupt`](crate::interrupt). Solves of at most 64 sweeps do not poll.
    pub fn interrupt_handle(&self) -> Interrupt {
        self.interrupt.clone()
    }

    /// Sets the interrupt to poll: one request may stop many simulations.
    pub fn set_interrupt(&mut self, interrupt: Interrupt) {
        self.interrupt = interrupt;
    }

    /// Returns true if solves may be long enough to poll the interrupt.
    pub fn polls_interrupt(&self) -> bool {
        polls_interrupt(&self.settings)
    }

    /// Returns true if spins at the start of a step are stored: friction may depend on the slip velocity, and a step may be abandoned.
    pub(crate) fn keeps_spins(&self) -> bool {
        let effects = &self.relaxation.effects;
        effects.kinetic_friction() || (effects.tangential() && polls_interrupt(&self.settings))
    }

    /// Restores the start of a step with an interrupted solve.
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
        // The step is repeated with the same torques.
        for (body, spin) in bodies.iter_mut().zip(&self.interventions.spins_before) {
            body.scaled_spin = *spin;
        }
        self.layout.driven.clear();
        self.empty_layout();
    }

    /// Discards the contacts of the layout.
    pub(crate) fn empty_layout(&mut self) {
        self.layout.contacts = 0;
        for groups in &mut self.layout.groups {
            groups.empty(self.relaxation.effects);
        }
    }
}
