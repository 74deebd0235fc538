//! The time step.

use super::{Simulation, StepReport};
use crate::detect::MemoryOfTask;
use crate::lanes::Quad;
use crate::schedule::{Phase, StepTrace, Team};
use crate::solve::{StopReason, solve};
use crate::sweep::start_driven;
use crate::world::{World, by_chunk, chunk, chunks};
use std::time::Instant;

impl Simulation {
    /// Advances by one time step. If [interrupted](crate::interrupt), the step restores the state before it, and the report states so.
    pub fn step(&mut self) -> StepReport {
        self.team = self.team.here();
        let team = self.team.clone();
        team.enter(|| self.step_of(&team))
    }

    /// Advances by one time step and reports the time of each task.
    pub fn trace_step(&mut self) -> (StepReport, StepTrace) {
        self.team = self.team.here();
        let team = self.team.traced();
        let report = team.enter(|| self.step_of(&team));
        (report, team.take_trace())
    }

    fn step_of(&mut self, team: &Team) -> StepReport {
        self.begin_step_of_ranks();
        self.work_outside_of_the_solve = 0.0;
        // The contact problem of the step.
        self.pose_problem(team);
        let clock = Clock::start();
        // Iterations until the stop criterion holds.
        let Simulation { world, settings, layout, relaxation, solver, interrupt, .. } = self;
        let solve = solve(world, layout, relaxation, settings, team, solver, interrupt);
        let clock = clock.lap(&mut self.phases.sweep);
        if solve.reason == StopReason::Interrupted {
            self.abandon_step();
            return StepReport { solve, contacts: 0 };
        }
        if let Some(mut ledger) = self.ledger.take() {
            ledger.note(self, self.constrainer.scheme());
            self.ledger = Some(ledger);
        }
        self.note_wall_contacts();
        self.account_for_forces();
        // Contacts of grains that would cross walls or other grains within the step.
        self.stop_ahead(team);
        // Motion with the new velocities.
        self.remember_impulses(team);
        self.move_bodies(team);
        self.judge_stage();
        self.end_step_of_ranks();
        clock.lap(&mut self.phases.integrate);
        let sweeps = u64::from(solve.sweeps) * u64::from(self.settings.sweeps_per_iteration());
        self.contact_sweeps += sweeps * self.layout.contacts as u64;
        StepReport { solve, contacts: self.layout.contacts }
    }

    /// Poses the contact problem of the next step: contacts laid out with their starting impulses, and bodies with the
    /// corresponding velocities.
    pub(crate) fn pose_problem(&mut self, team: &Team) {
        self.set_free(team);
        self.lay_out(team);
    }

    /// Begins the next step, and a stage that is due: finds candidate contacts, and sets bodies to their free velocities, the velocities at the end of a
    /// step without contacts.
    pub(crate) fn set_free(&mut self, team: &Team) {
        self.enter_stage();
        let set = self.relaxation.instruction_set;
        let clock = Clock::start();
        let ranks = self.layout.ranks.as_ref().filter(|ranks| ranks.is_divided());
        let misses = || self.candidates.miss_a_wall(&self.world, ranks, team);
        let unknown = self.may_be_swift() && ranks.map_or_else(misses, |ranks| ranks.any(misses()));
        let stale = unknown || self.candidates.are_stale(&self.world, ranks, team);
        let rebuilt = self.let_flow(stale, team);
        if rebuilt {
            self.candidates.rebuild(&mut self.world, &mut self.layout, set, team);
        }
        let clock = clock.lap(&mut self.phases.detect);
        let disturbed = std::mem::take(&mut self.interventions.disturbed);
        if let Some(ledger) = &mut self.ledger {
            let scheme = self.constrainer.scheme();
            let found = ledger.begin(&self.world, &self.candidates, scheme, [rebuilt, disturbed]);
            self.interventions.booked.energy += found;
        }
        self.apply_gravity(self.settings.step, team);
        self.act_from_outside();
        clock.lap(&mut self.phases.integrate);
    }

    /// Lays out the active candidates as constraints in boxes, stages and lane groups; they start from their last impulses.
    pub(crate) fn lay_out(&mut self, team: &Team) {
        let clock = Clock::start();
        self.constrain(team);
        start_driven(&self.layout, &mut self.world.drives);
        clock.lap(&mut self.phases.constrain);
    }

    /// Stores the velocities, and the spins if requested, at the start of a step of length `h` (s). Then applies gravity to the
    /// grains and the drives to the dynamic walls.
    pub(crate) fn apply_gravity(&mut self, h: f64, team: &Team) {
        let change = self.world.gravity * h;
        let (time, gravity) = (self.world.time, self.world.gravity);
        self.world.drives.iter_mut().for_each(|drive| drive.begin(time, h, &gravity));
        let spins = self.keeps_spins();
        let (grains, count) = (self.world.grains(), self.world.bodies.len());
        let World { bodies, before, spins_before, .. } = &mut self.world;
        before.resize(count, Quad::default());
        spins_before.resize(if spins { count } else { 0 }, Quad::default());
        let shares = (by_chunk(bodies), [by_chunk(before), by_chunk(spins_before)]);
        team.each_with(Phase::Integrate, chunks(count), shares, |number, (bodies, [before, spins_before])| {
            let places = chunk(number, count);
            let falling = places.start..places.end.min(grains).max(places.start);
            for (body, spin) in bodies.iter().zip(spins_before) {
                let [x, y, z] = body.scaled_spin;
                *spin = Quad([x, y, z, 0.0]);
            }
            for (body, before) in bodies.iter().zip(before) {
                let [x, y, z] = body.velocity;
                *before = Quad([x, y, z, body.inverse_mass]);
            }
            for body in &mut bodies[..falling.len()] {
                for axis in 0..3 {
                    body.velocity[axis] += change[axis];
                }
            }
        });
    }

    pub(crate) fn constrain(&mut self, team: &Team) {
        // Bodies, and about as many contacts as in the last step.
        self.constrainer.fetches = self.layout.prefetch(self.world.bodies.len()) > 0;
        let Simulation { world, candidates, relaxation, constrainer, layout, .. } = self;
        constrainer.constrain(world, candidates, relaxation, team, layout);
        self.choose_prefetch();
    }

    /// Sets the prefetch distance: the given one, or the default for the size of the layout.
    pub(super) fn choose_prefetch(&mut self) {
        let pays = self.layout.prefetch(self.world.bodies.len());
        self.relaxation.prefetch = self.prefetch.unwrap_or(pays);
    }

    fn move_bodies(&mut self, team: &Team) {
        let h = self.settings.step;
        self.note_passages(team);
        self.move_grains(team);
        self.world.drives.iter_mut().for_each(|drive| drive.advance(h));
        self.world.place_driven_walls();
        self.world.walls.advance_steered(h);
        self.steps += 1;
        let (time, gravity) = (self.world_time_after(self.steps), self.world.gravity);
        self.world.set_time(time);
        if let Some(ledger) = &mut self.ledger {
            ledger.settle(&self.world, &self.candidates, self.constrainer.scheme());
            ledger.change_gravity(&self.world, gravity, h);
            self.note_known_energy();
        }
    }

    /// Returns the time after a number of steps as a product, which accumulates no rounding error.
    pub(crate) fn world_time_after(&self, steps: u64) -> f64 {
        let (time, before) = self.stages.as_ref().map_or((0.0, 0), |stages| stages.state.clock);
        time + (steps - before) as f64 * self.settings.step
    }

    fn remember_impulses(&mut self, team: &Team) {
        let (relaxation, layout) = (&self.relaxation, &self.layout);
        let (impulses, _) = self.candidates.impulses.shares();
        layout.plan.run_all(team, Phase::Integrate, impulses, |_, task, impulses| {
            relaxation.remember(&layout.groups[task.number as usize], impulses.map(MemoryOfTask::from));
        });
    }
}

/// Lap timer of wall time.
struct Clock(Instant);

impl Clock {
    fn start() -> Clock {
        Clock(Instant::now())
    }

    fn lap(self, sum: &mut f64) -> Clock {
        let now = Instant::now();
        *sum += (now - self.0).as_secs_f64();
        Clock(now)
    }
}
