//! The candidate list with what its pairs bore, handed out without copying.

use crate::Simulation;
use crate::detect::{Impulse, PairCandidate, WallCandidate};
use crate::groups::ImpactMemory;

/// Pairs of a candidate list and what they bore in the last step, entry by entry.
#[doc(hidden)]
#[derive(Debug, Default)]
pub struct PairsInList {
    /// Two grains each, by place.
    pub pairs: Vec<PairCandidate>,
    /// Impulse of each, and one of zero behind them; zero where two did not touch.
    pub pair_impulses: Vec<Impulse>,
    /// A grain, by place, and a face.
    pub walls: Vec<WallCandidate>,
    /// As `pair_impulses`.
    pub wall_impulses: Vec<Impulse>,
}

/// Memory of a contact from one step to the next.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct KeptContact {
    /// Id of the first grain.
    pub first: u32,
    /// Id of the second one, or none for a wall.
    pub second: Option<u32>,
    /// Number of the face, for a wall.
    pub face: Option<u32>,
    /// The impact that it is in.
    pub impact: ImpactMemory,
    /// Normal impulse of the last step, N s.
    pub impulse: f64,
}

impl Simulation {
    /// Memories of the contacts of the last step, for the next one.
    #[doc(hidden)]
    pub fn kept_contacts(&self) -> Vec<KeptContact> {
        let (candidates, ids) = (&self.candidates, &self.world.ids);
        let (impulses, id) = (&candidates.impulses, |place: u32| ids[place as usize]);
        let named = self.layout.plan.tasks().iter().flat_map(|task| task.named(&impulses.borne));
        let pairs = named.map(|candidate| {
            let PairCandidate { first, second } = candidates.pairs[candidate];
            let (impact, impulse) = (impulses.pair_impacts[candidate], impulses.pairs[candidate].normal);
            KeptContact { first: id(first), second: Some(id(second)), face: None, impact, impulse }
        });
        let walls = candidates.walls.iter().enumerate().map(|(candidate, wall)| {
            let (impact, impulse) = (impulses.wall_impacts[candidate], impulses.walls[candidate].normal);
            KeptContact { first: id(wall.body), second: None, face: Some(wall.surface), impact, impulse }
        });
        pairs.chain(walls).collect()
    }

    /// The pairs that may touch, and the impulses that they bore, as they lie in memory.
    #[doc(hidden)]
    pub fn pairs_in_list(&mut self) -> (&[PairCandidate], &[Impulse], &[WallCandidate], &[Impulse]) {
        self.clear_what_was_not_borne();
        let candidates = &self.candidates;
        let impulses = &candidates.impulses;
        (&candidates.pairs, &impulses.pairs, &candidates.walls, &impulses.walls)
    }

    /// Gives these arrays away, as they lie in memory, and goes on with copies.
    #[doc(hidden)]
    pub fn hand_over_pairs(&mut self) -> PairsInList {
        let candidates = &mut self.candidates;
        let [pairs, walls] = [&mut candidates.impulses.pairs, &mut candidates.impulses.walls];
        PairsInList {
            pair_impulses: replaced_by_copy(pairs),
            wall_impulses: replaced_by_copy(walls),
            pairs: replaced_by_copy(&mut candidates.pairs),
            walls: replaced_by_copy(&mut candidates.walls),
        }
    }

    /// Impulses of pairs that bore none mean nothing: makes them zero.
    fn clear_what_was_not_borne(&mut self) {
        let candidates = &mut self.candidates;
        let mut borne = vec![false; candidates.pairs.len()];
        for task in self.layout.plan.tasks() {
            task.named(&candidates.impulses.borne).for_each(|pair| borne[pair] = true);
        }
        for (impulse, _) in candidates.impulses.pairs.iter_mut().zip(borne).filter(|(_, borne)| !borne) {
            *impulse = Impulse::default();
        }
    }
}

/// Leaves a copy in the place of an array.
fn replaced_by_copy<T: Clone>(array: &mut Vec<T>) -> Vec<T> {
    let copy = array.clone();
    std::mem::replace(array, copy)
}
