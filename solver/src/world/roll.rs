//! Identity of grains over a run in which grains come and go.
//!
//! The id of a grain is its row in a frame: contiguous from 0, in the order of the permanent numbers. Permanent numbers are never
//! reused: the grains of the scene in the order of placement, then all others in the order in which they come.

use super::World;
use serde::{Deserialize, Serialize};

/// Mark of a grain that is gone, in a map of indices.
pub(crate) const GONE: u32 = u32::MAX;

/// Upper bound of permanent numbers: all are exact as floating-point numbers.
const LARGEST_NUMBER: u64 = 1 << 53;

/// Permanent numbers and sources of the grains, by id; empty lists if the grains are those of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Roll {
    /// True if grains have come or gone.
    pub changed: bool,
    /// Permanent numbers, ascending.
    pub numbers: Vec<u64>,
    /// Source of each grain: its index in the scene plus 1, or 0 for grains without one.
    pub sources: Vec<u16>,
    /// Next free number.
    pub next: u64,
}

impl Roll {
    /// Returns the permanent number of a grain, by its id.
    pub fn number(&self, id: u32) -> u64 {
        self.numbers.get(id as usize).copied().unwrap_or(u64::from(id))
    }

    /// Returns true if the lists belong to this number of grains, and numbers are unique and below the next free number.
    pub fn is_sound(&self, grains: usize) -> bool {
        let rises = self.numbers.windows(2).all(|pair| pair[0] < pair[1]);
        let below = self.numbers.last().is_none_or(|last| *last < self.next) && self.next < LARGEST_NUMBER;
        let listed = self.numbers.len() == grains && self.sources.len() == grains;
        if self.changed { listed && rises && below } else { *self == Roll::default() }
    }

    /// Removes the grains without a new id, given the new id of each old id, and appends grains of the given sources.
    pub fn change(&mut self, new_ids: &[Option<u32>], come: impl ExactSizeIterator<Item = u16>) {
        if !self.changed {
            let grains = new_ids.len();
            let (numbers, sources) = ((0..grains as u64).collect(), vec![0; grains]);
            *self = Roll { changed: true, numbers, sources, next: grains as u64 };
        }
        let stays = |index: &mut usize| {
            *index += 1;
            new_ids[*index - 1].is_some()
        };
        let (mut of_numbers, mut of_sources) = (0, 0);
        self.numbers.retain(|_| stays(&mut of_numbers));
        self.sources.retain(|_| stays(&mut of_sources));
        self.numbers.extend(self.next..self.next + come.len() as u64);
        self.next += come.len() as u64;
        self.sources.extend(come);
    }
}

/// Grain to add.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewGrain {
    pub body: super::Body,
    pub sphere: super::Sphere,
    pub material: u8,
    /// As in [`Roll::sources`].
    pub source: u16,
}

/// New places and ids after grains have come and gone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Moves {
    /// New place of each old place, or [`GONE`].
    pub places: Vec<u32>,
    /// New id of each old id; none for grains that are gone.
    pub ids: Vec<Option<u32>>,
}

impl World {
    /// Removes the grains at these ascending places, and appends new ones; the others keep their order in memory and of ids.
    /// Padding bodies are removed.
    pub(crate) fn change(&mut self, gone: &[u32], come: &[NewGrain]) -> Moves {
        assert!(!self.kept.0, "arrays that are kept in place hold the same grains");
        let grains = self.grains();
        let mut moves = Moves { places: Vec::with_capacity(grains), ids: vec![Some(0); grains] };
        let (mut left, mut next) = (gone.iter().peekable(), 0);
        for place in 0..grains {
            let goes = left.next_if(|&&one| one as usize == place).is_some();
            if goes {
                moves.ids[self.ids[place] as usize] = None;
                moves.places.push(GONE);
                continue;
            }
            let to = next as usize;
            (self.bodies[to], self.spheres[to]) = (self.bodies[place], self.spheres[place]);
            (self.materials[to], self.ids[to]) = (self.materials[place], self.ids[place]);
            moves.places.push(next);
            next += 1;
        }
        (0..).zip(moves.ids.iter_mut().flatten()).for_each(|(id, new_id)| *new_id = id);
        let stay = next as usize;
        self.ids.truncate(stay);
        self.ids.iter_mut().for_each(|id| *id = moves.ids[*id as usize].unwrap_or(GONE));
        self.bodies.truncate(stay);
        self.spheres.truncate(stay);
        self.materials.truncate(stay);
        self.bodies.extend(come.iter().map(|grain| grain.body));
        self.spheres.extend(come.iter().map(|grain| grain.sphere));
        self.materials.extend(come.iter().map(|grain| grain.material));
        self.ids.extend(next..next + come.len() as u32);
        self.roll.change(&moves.ids, come.iter().map(|grain| grain.source));
        moves
    }
}
