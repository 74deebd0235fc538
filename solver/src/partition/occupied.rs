//! Boxes of a domain that is mostly empty or that grains have left: those that hold grains are numbered, and nothing else costs time or
//! memory.
//!
//! Pairs and lane groups of a box are stored by its number, and a number that has had a full box once keeps that memory. So full boxes have
//! the low numbers: a lone grain that flies off takes a number behind them, and moves none of theirs.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Number of directions from a box to those around it, itself among them: `(dx + 1) + 3 (dy + 1) + 9 (dz + 1)`.
pub(crate) const DIRECTIONS: usize = 27;

/// Direction of a box to itself.
pub(crate) const SAME_BOX: usize = 13;

/// Marks a box that is not numbered.
const NOWHERE: u32 = u32::MAX;

/// Boxes with grains, and those that tasks between them belong to: numbered by the power of two of their grains, the fullest first, and
/// among these in the order in which all boxes of the domain would be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Occupied {
    at: Vec<[i32; 3]>,
    numbers: HashMap<[i32; 3], u32, BuildHasherDefault<CoordinateHasher>>,
    /// Grains of each box, in the order in which boxes were found.
    grains: Vec<u32>,
    /// Numbers of the boxes around each, by direction.
    around: Vec<[u32; DIRECTIONS]>,
    /// Numbers of the boxes in the order in which they were found.
    found: Vec<u32>,
}

impl Occupied {
    /// Numbers the boxes that grains lie in, given by their coordinates one after the other, unless these are more than `most`;
    /// leaves each grain's in `number_of`. `step` tells which box lies beside one.
    ///
    /// Returns whether it did.
    pub fn number(
        &mut self,
        grains: impl Iterator<Item = [i32; 3]>,
        number_of: &mut [u32],
        most: usize,
        step: impl Fn([i32; 3], [i32; 3]) -> [i32; 3],
    ) -> bool {
        let Occupied { at, numbers, grains: counts, around, found } = self;
        at.clear();
        numbers.clear();
        counts.clear();
        // Grains lie in memory in the order of the last boxes: mostly it is the one before.
        let mut last = None;
        for (grain, number_of) in grains.zip(&mut *number_of) {
            let number = match last {
                Some((before, number)) if before == grain => number,
                _ => *numbers.entry(grain).or_insert_with(|| {
                    at.push(grain);
                    counts.push(0);
                    at.len() as u32 - 1
                }),
            };
            counts[number as usize] += 1;
            last = Some((grain, number));
            *number_of = number;
            if at.len() > most {
                return false;
            }
        }
        let count = at.len();
        // A task belongs to the lowest corner of its two boxes, which may be empty.
        for place in 0..count {
            let own = at[place];
            // The box on the other side finds the same.
            for direction in 0..SAME_BOX {
                let towards = towards(direction);
                if numbers.get(&step(own, towards)).is_some_and(|&other| (other as usize) < count) {
                    let home = step(own, towards.map(|along| along.min(0)));
                    numbers.entry(home).or_insert_with(|| {
                        at.push(home);
                        at.len() as u32 - 1
                    });
                }
            }
        }
        found.clear();
        found.resize(at.len(), 0);
        counts.resize(at.len(), 0);
        at.sort_unstable_by_key(|own| {
            let (grains, [x, y, z]) = (counts[numbers[own] as usize], *own);
            (Reverse(grains.checked_ilog2()), [z, y, x])
        });
        for (number, own) in at.iter().enumerate() {
            if let Some(known) = numbers.get_mut(own) {
                found[*known as usize] = number as u32;
                *known = number as u32;
            }
        }
        number_of.iter_mut().for_each(|number| *number = found[*number as usize]);
        around.clear();
        around.extend(at.iter().map(|&own| {
            std::array::from_fn(|direction| *numbers.get(&step(own, towards(direction))).unwrap_or(&NOWHERE))
        }));
        true
    }

    /// Number of numbered boxes.
    pub fn boxes(&self) -> usize {
        self.at.len()
    }

    /// Number of the box in a direction from another, if it has one.
    #[inline]
    pub fn neighbour(&self, number: usize, direction: usize) -> Option<usize> {
        let neighbour = self.around[number][direction];
        (neighbour != NOWHERE).then_some(neighbour as usize)
    }

    pub fn memory_bytes(&self) -> usize {
        self.at.capacity() * size_of::<[i32; 3]>()
            + self.numbers.capacity() * size_of::<([i32; 3], u32)>()
            + self.grains.capacity() * size_of::<u32>()
            + self.around.capacity() * size_of::<[u32; DIRECTIONS]>()
            + self.found.capacity() * size_of::<u32>()
    }
}

/// Hashes the coordinates of boxes: a multiplication for each, since no one chooses them to collide.
#[derive(Clone, Debug, Default)]
struct CoordinateHasher(u64);

impl Hasher for CoordinateHasher {
    fn write(&mut self, bytes: &[u8]) {
        for word in bytes.chunks(size_of::<u32>()) {
            let value = word.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte));
            self.0 = (self.0.rotate_left(26) ^ value).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }

    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }
}

/// Steps along the axes that a direction names.
#[inline]
pub(crate) fn towards(direction: usize) -> [i32; 3] {
    [direction % 3, direction / 3 % 3, direction / 9].map(|step| step as i32 - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_boxes_are_numbered_first() {
        let step = |at: [i32; 3], towards: [i32; 3]| std::array::from_fn(|axis| at[axis] + towards[axis]);
        // Two boxes that share an edge, whose task belongs to an empty one, and one far away.
        let grains = [[1, 0, 0], [900_000, -7, -5], [0, 1, 0], [1, 0, 0]];
        let (mut occupied, mut numbers) = (Occupied::default(), [0; 4]);
        assert!(occupied.number(grains.into_iter(), &mut numbers, 3, step));
        assert_eq!(occupied.at, [[1, 0, 0], [900_000, -7, -5], [0, 1, 0], [0, 0, 0]]);
        assert_eq!(numbers, [0, 1, 2, 0]);
        let direction = |[x, y, z]: [i32; 3]| ((x + 1) + 3 * (y + 1) + 9 * (z + 1)) as usize;
        assert_eq!(occupied.neighbour(0, direction([-1, 1, 0])), Some(2));
        assert_eq!(occupied.neighbour(0, direction([-1, 0, 0])), Some(3), "home of the task between the two");
        assert_eq!(occupied.neighbour(1, direction([1, 0, 0])), None);
        assert_eq!(occupied.neighbour(1, SAME_BOX), Some(1));
        assert!(!occupied.number(grains.into_iter(), &mut numbers, 2, step), "more boxes than were asked for");
    }
}
