//! Check of the candidate list: displacements since the build bound the distances of missing pairs.
//!
//! In a flowing bed grains move far, but neighbours move alike. So displacements are bounded patch by patch, by a box in
//! displacement space. Two grains of the same or of adjacent patches approach by at most the largest distance between points of
//! the two boxes. Grains of other patches start a patch apart.
//!
//! Bounds of a whole grid box contain those of its patches, and bounds of all boxes contain everything. If coarse bounds pass,
//! finer bounds are skipped; the result is the same.

use super::grid::{CellGrid, FORWARD};
use crate::lanes::Number;
use crate::partition::DIRECTIONS;
use crate::schedule::{Each, Phase, Runs, Team};
use crate::world::Sphere;
use nalgebra::Vector3;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bounds of displacements, with buffers reused over the steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    /// Bounds of each patch, box after box.
    patches: Vec<Bounds>,
    /// Bounds of each box.
    boxes: Vec<Bounds>,
}

/// Smallest and largest displacement along each axis, m.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

/// Displacement, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moved {
    /// Upper bound on the displacement of a grain.
    pub shift: f64,
    /// Upper bound on the approach of two grains of adjacent patches.
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

    /// Returns the union of two bounds.
    #[inline(always)]
    fn with(self, other: &Bounds) -> Bounds {
        Bounds {
            low: std::array::from_fn(|axis| self.low[axis].smaller(other.low[axis])),
            high: std::array::from_fn(|axis| self.high[axis].larger(other.high[axis])),
        }
    }

    /// Returns the largest displacements: of grains within these bounds, and towards each other and grains within neighbour bounds.
    #[inline(always)]
    fn moved<'a>(&self, beside: impl Iterator<Item = &'a Bounds>) -> Moved {
        if self.is_empty() {
            return Moved::default();
        }
        let others = beside.filter(|other| !other.is_empty()).map(|other| self.largest_distance_squared(other));
        let approach = others.fold(self.largest_distance_squared(self), |largest, square| largest.larger(square));
        Moved { shift: self.largest_squared().sqrt(), approach: approach.sqrt() }
    }

    /// Largest distance between points of the two bounds, squared; neither may be empty.
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

/// Bounds the displacements of a box's grains, per patch and in total.
fn bound_box(
    grid: &CellGrid,
    number: usize,
    spheres: &[Sphere],
    reference: &[Vector3<f64>],
    patches: &mut [Bounds],
) -> Bounds {
    grid.for_each_run(number, |patch, places| {
        let mut own = patches[patch];
        for (sphere, then) in spheres[places.clone()].iter().zip(&reference[places]) {
            own.add(sphere.centre - then);
        }
        patches[patch] = own;
    });
    patches.iter().fold(Bounds::EMPTY, Bounds::with)
}

impl Drift {
    /// Returns true if the motion from `reference` to `spheres`, both in grid order, is `too_far` in the boxes of a condition; `too_far` must
    /// be monotonic in the motion.
    pub fn is_too_far(
        &mut self,
        grid: &CellGrid,
        spheres: &[Sphere],
        reference: &[Vector3<f64>],
        team: &Team,
        is_checked: impl Fn(usize) -> bool + Sync,
        too_far: impl Fn(Moved) -> bool + Sync,
    ) -> bool {
        let (boxes, per_box) = (grid.boxes().boxes(), grid.patches_of_box());
        self.patches.clear();
        self.patches.resize(per_box * boxes, Bounds::EMPTY);
        self.boxes.resize(boxes, Bounds::EMPTY);
        let shares = (Runs::of(&mut self.patches, per_box), Each::of(&mut self.boxes));
        team.each_with(Phase::Detect, boxes, shares, |number, (patches, bounds)| {
            // A box is checked against its neighbours.
            let is_needed =
                is_checked(number) || grid.boxes().around(number).iter().flatten().any(|&beside| is_checked(beside));
            *bounds = if is_needed { bound_box(grid, number, spheres, reference, patches) } else { Bounds::EMPTY };
        });
        let all = self.boxes.iter().fold(Bounds::EMPTY, Bounds::with);
        if !too_far(all.moved(std::iter::empty())) {
            return false;
        }
        let found = AtomicBool::new(false);
        team.each(Phase::Detect, boxes, |number| {
            if !is_checked(number) {
                return;
            }
            let around = grid.boxes().around(number);
            let beside = around.iter().flatten().map(|&neighbour| &self.boxes[neighbour]);
            if too_far(self.boxes[number].moved(beside)) && self.is_patch_too_far(grid, number, &around, &too_far) {
                found.store(true, Ordering::Relaxed);
            }
        });
        found.into_inner()
    }

    /// Checks the patches of a box, given its neighbour boxes.
    fn is_patch_too_far(
        &self,
        grid: &CellGrid,
        number: usize,
        around: &[Option<usize>; DIRECTIONS],
        too_far: impl Fn(Moved) -> bool,
    ) -> bool {
        let per_box = grid.patches_of_box();
        self.patches[per_box * number..per_box * (number + 1)].iter().enumerate().any(|(patch, own)| {
            let beside = FORWARD.iter().filter_map(|&step| {
                let (direction, place) = grid.patch_beside(patch, step);
                around[direction].map(|neighbour| &self.patches[per_box * neighbour + place])
            });
            too_far(own.moved(beside))
        })
    }

    pub fn memory_bytes(&self) -> usize {
        (self.patches.capacity() + self.boxes.capacity()) * size_of::<Bounds>()
    }
}
