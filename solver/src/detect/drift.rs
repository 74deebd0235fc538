//! How far grains have moved, and how much closer neighbours can have come, since the candidate list was built.
//!
//! In a flowing bed grains move far, but neighbours move alike. So displacements are bounded patch by patch, by a box in
//! the space of displacements; two grains of the same or of adjacent patches have come closer by no more than the largest
//! distance between points of the two boxes. Grains of patches that are not adjacent start a patch apart.

use super::grid::{CellGrid, FORWARD};
use crate::lanes::Number;
use crate::schedule::{Each, Phase, Runs, Team};
use crate::world::Sphere;
use nalgebra::Vector3;

/// Bounds of the displacements in each patch; kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    patches: Vec<Bounds>,
    /// Of each box.
    moved: Vec<Moved>,
}

/// Smallest and largest displacement along each axis, m.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

/// What has moved, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moved {
    /// No grain has moved further.
    pub shift: f64,
    /// No two grains of adjacent patches have come closer by more.
    pub approach: f64,
}

impl Bounds {
    const EMPTY: Bounds = Bounds { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }

    #[inline(always)]
    fn add(&mut self, shift: Vector3<f64>) {
        for axis in 0..3 {
            self.low[axis] = shift[axis].smaller(self.low[axis]);
            self.high[axis] = shift[axis].larger(self.high[axis]);
        }
    }

    /// Largest distance between a point of each, squared; neither may be empty.
    #[inline(always)]
    fn largest_distance_squared(&self, other: &Bounds) -> f64 {
        let mut square = 0.0;
        for axis in 0..3 {
            let span = (self.high[axis] - other.low[axis]).larger(other.high[axis] - self.low[axis]);
            square += span * span;
        }
        square
    }

    /// Largest length, squared.
    #[inline(always)]
    fn largest_squared(&self) -> f64 {
        (0..3).map(|axis| self.low[axis].abs().larger(self.high[axis].abs())).map(|length| length * length).sum()
    }
}

/// Bounds the displacements of a box's grains, patch by patch.
fn bound_box(grid: &CellGrid, number: usize, spheres: &[Sphere], reference: &[Vector3<f64>], patches: &mut [Bounds]) {
    grid.for_each_cell(number, |patch, places| {
        let mut own = patches[patch];
        for (sphere, then) in spheres[places.clone()].iter().zip(&reference[places]) {
            own.add(sphere.centre - then);
        }
        patches[patch] = own;
    });
}

/// Squares of how far grains of a box have moved, and how far towards each other and grains of patches beside theirs.
fn squares_of_box(grid: &CellGrid, number: usize, patches: &[Bounds]) -> Moved {
    let (per_box, around) = (grid.patches_of_box(), grid.boxes().around(number));
    let mut squares = Moved::default();
    for (patch, own) in patches[per_box * number..per_box * (number + 1)].iter().enumerate() {
        if own.is_empty() {
            continue;
        }
        squares.shift = squares.shift.larger(own.largest_squared());
        for step in std::iter::once([0; 3]).chain(FORWARD) {
            let (direction, place) = grid.patch_beside(patch, step);
            let Some(neighbour) = around[direction] else { continue };
            let other = &patches[per_box * neighbour + place];
            if !other.is_empty() {
                squares.approach = squares.approach.larger(own.largest_distance_squared(other));
            }
        }
    }
    squares
}

impl Drift {
    /// Bounds the displacements from `reference` to `spheres`, both in the order of the grid.
    pub fn measure(&mut self, grid: &CellGrid, spheres: &[Sphere], reference: &[Vector3<f64>], team: &Team) -> Moved {
        let (boxes, per_box) = (grid.boxes(), grid.patches_of_box());
        self.patches.clear();
        self.patches.resize(per_box * boxes.boxes(), Bounds::EMPTY);
        let patches_of_boxes = Runs::of(&mut self.patches, per_box);
        team.each_with(Phase::Detect, boxes.boxes(), patches_of_boxes, |number, patches| {
            bound_box(grid, number, spheres, reference, patches);
        });
        self.moved.clear();
        self.moved.resize(boxes.boxes(), Moved::default());
        let patches = &self.patches;
        team.each_with(Phase::Detect, boxes.boxes(), Each::of(&mut self.moved), |number, moved| {
            if !grid.grains_of_box(number).is_empty() {
                *moved = squares_of_box(grid, number, patches);
            }
        });
        let largest = |value: fn(&Moved) -> f64| self.moved.iter().map(value).fold(0.0, f64::max).sqrt();
        Moved { shift: largest(|moved| moved.shift), approach: largest(|moved| moved.approach) }
    }

    pub fn memory_bytes(&self) -> usize {
        self.patches.capacity() * size_of::<Bounds>() + self.moved.capacity() * size_of::<Moved>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(points: &[[f64; 3]]) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        points.iter().for_each(|point| bounds.add(Vector3::from(*point)));
        bounds
    }

    #[test]
    fn bounds_cover_every_pair_of_displacements() {
        let a = bounds(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        let b = bounds(&[[3.0, 4.0, 0.0]]);
        assert_eq!(a.largest_distance_squared(&b), 25.0);
        assert_eq!(a.largest_distance_squared(&a), 1.0);
        assert_eq!(b.largest_distance_squared(&b), 0.0, "what moves together comes no closer");
        assert_eq!(b.largest_squared(), 25.0);
        assert!(Bounds::EMPTY.is_empty() && !a.is_empty());
    }
}
