//! Positions, velocities and spins in memory order, to read and write between steps.

use super::{Booked, Interventions};
use crate::Simulation;
use crate::detect::{Impulse, PairCandidate, WallCandidate};
use crate::lanes::{minus, plus};
use crate::world::{Body, Sphere};
use std::collections::TryReserveError;

/// Grains of a simulation in memory order, to read and write: [`Simulation::states`].
///
/// The row of a grain is its index in memory, which changes when a step rebuilds the candidate list; [`id`](States::id) returns
/// the grain of a row. Written values count from the next step on. The drift check of the candidate list finds moved grains, and
/// the swept search finds grains made fast. Overlaps with other grains or walls are not checked; the next steps resolve them.
#[derive(Debug)]
pub struct States<'a>(&'a mut Simulation);

impl States<'_> {
    /// Number of grains.
    pub fn grains(&self) -> usize {
        self.0.world.grains()
    }

    /// Id of the grain in a row.
    ///
    /// # Panics
    /// If there is no such row; the same holds for the methods below.
    pub fn id(&self, row: usize) -> u32 {
        self.0.world.ids[row]
    }

    /// Radius, m.
    pub fn radius(&self, row: usize) -> f64 {
        self.0.world.spheres[self.inside(row)].radius
    }

    /// Centre, m; with periodic axes the centre may lie outside the domain.
    pub fn position(&mut self, row: usize) -> &mut [f64; 3] {
        let row = self.inside(row);
        &mut self.0.world.spheres[row].centre.data.0[0]
    }

    /// Velocity, m/s.
    pub fn velocity(&mut self, row: usize) -> &mut [f64; 3] {
        let row = self.inside(row);
        &mut self.0.world.bodies[row].velocity
    }

    /// Radius times angular velocity, m/s: the stored form of a spin.
    pub fn scaled_spin(&mut self, row: usize) -> &mut [f64; 3] {
        let row = self.inside(row);
        &mut self.0.world.bodies[row].scaled_spin
    }

    /// Checks the row against the number of grains: padding bodies follow the grains.
    fn inside(&self, row: usize) -> usize {
        assert!(row < self.grains(), "there is no row {row} of {} grains", self.grains());
        row
    }
}

impl Drop for States<'_> {
    fn drop(&mut self) {
        self.0.states_written();
    }
}

impl Simulation {
    /// Returns the grains in memory order, to read and write.
    ///
    /// ```
    /// # use makadam::{GrainEntry, Material, Scene, Simulation};
    /// # let grain = GrainEntry { material: "glass".into(), radius: 0.005, position: [0.0; 3], velocity: [0.0; 3], spin: [0.0; 3] };
    /// # let scene = Scene::builder().material("glass", Material::default()).gravity([0.0; 3]).domain([-1.0; 3], [1.0; 3]);
    /// # let mut simulation = Simulation::builder(&scene.grain(grain).build()?).time_step(1e-3).build()?;
    /// let mut states = simulation.states();
    /// for row in 0..states.grains() {
    ///     states.velocity(row)[2] += 0.1;
    /// }
    /// drop(states);
    /// assert_eq!(simulation.frame().velocities()[0], [0.0, 0.0, 0.1]);
    /// # Ok::<(), makadam::Error>(())
    /// ```
    pub fn states(&mut self) -> States<'_> {
        self.hand_out_states();
        States(self)
    }

    /// Returns spheres, bodies and ids of the grains in memory order, for writes through pointers. Such a caller must call
    /// [`states_written`](Simulation::states_written) before each step.
    #[doc(hidden)]
    pub fn arrays(&mut self) -> (&mut [Sphere], &mut [Body], &[u32]) {
        self.hand_out_states();
        let grains = self.world.grains();
        (&mut self.world.spheres[..grains], &mut self.world.bodies[..grains], &self.world.ids)
    }

    /// Prevents steps from reallocating the arrays of the grains until grains are inserted or removed. A copy of the simulation
    /// has its own arrays, which may move.
    ///
    /// # Errors
    /// If the memory for their growth cannot be allocated.
    #[doc(hidden)]
    pub fn keep_arrays_in_place(&mut self) -> Result<(), TryReserveError> {
        let boxes = self.candidates.most_boxes();
        self.world.keep_in_place(boxes)
    }

    /// Declares that positions, velocities or spins may have been written since the last step.
    #[doc(hidden)]
    pub fn states_written(&mut self) {
        self.interventions.count += 1;
        // Some grains may be fast now.
        self.swept.forget_pace();
        if let Some(before) = self.interventions.known {
            self.note_known_energy();
            self.book_disturbance(&before);
        }
    }

    /// Notes the energy before the caller writes.
    fn hand_out_states(&mut self) {
        self.interventions.handed_out = true;
        if self.ledger.is_some() && self.interventions.known.is_none() {
            self.note_known_energy();
        }
    }

    /// Notes the energy of the unchanged state, if the caller may write.
    pub(crate) fn note_known_energy(&mut self) {
        let watched = self.ledger.is_some() && self.interventions.handed_out;
        self.interventions.known = watched.then(|| Booked::of(self));
    }

    /// Books the changes of energy, momentum and angular momentum by the caller, given their previous values.
    pub(super) fn book_disturbance(&mut self, before: &Booked) {
        let after = Booked::of(self);
        if after == *before {
            return;
        }
        let Interventions { booked, disturbed, .. } = &mut self.interventions;
        booked.energy += after.energy - before.energy;
        booked.impulse = plus(booked.impulse, minus(after.impulse, before.impulse));
        booked.angular_impulse = plus(booked.angular_impulse, minus(after.angular_impulse, before.angular_impulse));
        *disturbed = true;
        if let Some(ledger) = &mut self.ledger {
            ledger.restart_stored(&self.world, &self.candidates, self.constrainer.scheme());
        }
    }
}

/// Pairs of a candidate list and their impulses of the last step, entry by entry.
#[doc(hidden)]
#[derive(Debug, Default)]
pub struct PairsInList {
    /// Body indices of two grains each.
    pub pairs: Vec<PairCandidate>,
    /// Impulse of each pair, and a final zero; zero without contact.
    pub pair_impulses: Vec<Impulse>,
    /// Body index of a grain, and a face.
    pub walls: Vec<WallCandidate>,
    /// Impulse of each wall candidate, as in `pair_impulses`.
    pub wall_impulses: Vec<Impulse>,
}

impl Simulation {
    /// Returns the candidate pairs and their impulses in memory order.
    #[doc(hidden)]
    pub fn pairs_in_list(&mut self) -> (&[PairCandidate], &[Impulse], &[WallCandidate], &[Impulse]) {
        self.clear_what_was_not_borne();
        let candidates = &self.candidates;
        let impulses = &candidates.impulses;
        (&candidates.pairs, &impulses.pairs.impulses, &candidates.walls, &impulses.walls.impulses)
    }

    /// Hands over these arrays and continues with copies.
    #[doc(hidden)]
    pub fn hand_over_pairs(&mut self) -> PairsInList {
        let candidates = &mut self.candidates;
        let [pairs, walls] = [&mut candidates.impulses.pairs.impulses, &mut candidates.impulses.walls.impulses];
        PairsInList {
            pair_impulses: replaced_by_copy(pairs),
            wall_impulses: replaced_by_copy(walls),
            pairs: replaced_by_copy(&mut candidates.pairs),
            walls: replaced_by_copy(&mut candidates.walls),
        }
    }

    /// Sets the meaningless impulses of inactive pairs to zero.
    fn clear_what_was_not_borne(&mut self) {
        let candidates = &mut self.candidates;
        let mut borne = vec![false; candidates.pairs.len()];
        for task in self.layout.plan.tasks() {
            task.named(&candidates.impulses.borne).for_each(|pair| borne[pair] = true);
        }
        for (impulse, _) in candidates.impulses.pairs.impulses.iter_mut().zip(borne).filter(|(_, borne)| !borne) {
            *impulse = Impulse::default();
        }
    }
}

/// Replaces an array by a copy and returns the original.
fn replaced_by_copy<T: Clone>(array: &mut Vec<T>) -> Vec<T> {
    let copy = array.clone();
    std::mem::replace(array, copy)
}
