//! Single phases of a step, for benchmarks and the cost of effects, not for simulation.
//!
//! A phase is repeated on the state after the last step, at constant time. Use a clone: later steps of a probed simulation differ
//! from those of an unprobed one.

use crate::Simulation;
use crate::effects::EffectSet;
use crate::partition::TaskGroups;
use crate::scene::Precision;
use crate::sweep::{ResidualLevel, SweepBytes, SweepOperands, SweepPass, start_driven};
use crate::world::Body;

impl Simulation {
    /// Returns the memory traffic of a sweep over the contacts of the last step.
    pub fn sweep_bytes(&self) -> SweepBytes {
        let effects = self.effects();
        let bodies = self.world.grains() * size_of::<Body>();
        let groups = |of: fn(&TaskGroups) -> usize| self.layout.tasks().map(|(_, task)| of(task)).sum();
        let (pairs, walls): (usize, usize) = (groups(|task| task.pairs.len()), groups(|task| task.walls.len()));
        let read = pairs * effects.bytes_of_pairs() + walls * effects.bytes_of_walls();
        let written = (pairs + walls) * effects.bytes_written();
        SweepBytes { touched: read + bodies, moved: read + written + 2 * bodies }
    }

    /// Rebuilds the candidate list even if it is valid. The layout is discarded: call [`Self::constrain_once`] before the next
    /// sweep.
    pub fn detect_once(&mut self) {
        let (set, team) = (self.relaxation.instruction_set, self.team.here());
        // The groups refer to body indices that are about to change.
        self.empty_layout();
        team.enter(|| self.candidates.rebuild(&mut self.world, &mut self.layout, set, &team));
    }

    /// Returns true if the candidate list is stale: the first check of a step.
    pub fn is_stale_once(&mut self) -> bool {
        let team = self.team.here();
        team.enter(|| self.candidates.are_stale(&self.world, None, &team))
    }

    /// Lays out the contacts of the present positions as constraints, and applies the starting impulses of the last step to the
    /// bodies; each call applies them again. Returns the number of contacts.
    pub fn constrain_once(&mut self) -> usize {
        let team = self.team.here();
        if self.steps == 0 {
            // A first step requires a candidate list.
            self.detect_once();
        }
        team.enter(|| {
            self.apply_gravity(0.0, &team);
            self.constrain(&team);
            start_driven(&self.layout, &mut self.world.drives);
        });
        self.layout.contacts
    }

    /// Compiles in other effects than the scene's, to measure their cost; missing coefficients are zero. Call
    /// [`Self::constrain_once`] before the next sweep.
    pub fn compile_effects(&mut self, effects: EffectSet) {
        self.relaxation.effects = effects;
        self.constrainer.compile_effects(effects);
        self.candidates.bear_torques(effects.torques());
        self.empty_layout();
    }

    /// Relaxes the laid out contacts the given number of times, without over-relaxation and residuals. Returns the number of
    /// contact sweeps.
    pub fn sweep_times(&mut self, sweeps: u32) -> u64 {
        let team = self.team.here();
        let Simulation { world, layout, solver, relaxation, settings, .. } = self;
        let (single, mut nowhere) = (&mut solver.workspace.single, Vec::new());
        team.enter(|| {
            if settings.precision == Precision::Single {
                single.take(&world.bodies, layout, relaxation.instruction_set, &team);
            }
            for _ in 0..sweeps {
                let operands = match settings.precision {
                    Precision::Double => {
                        SweepOperands::Double { bodies: &mut world.bodies, groups: &mut layout.groups }
                    }
                    Precision::Single => SweepOperands::Single(single),
                };
                let pass = SweepPass { factor: 1.0, inner: 1, stops: || false, level: ResidualLevel::Off };
                relaxation.sweep_all((&layout.plan, None), operands, &pass, &mut nowhere, &team);
                if !world.drives.is_empty() {
                    relaxation.sweep_driven(&mut world.bodies, layout, &mut world.drives, 1.0, ResidualLevel::Off);
                }
            }
        });
        u64::from(sweeps) * self.layout.contacts as u64
    }
}
