//! How far grains have moved, and how much closer neighbours can have come, since the candidate list was built.
//!
//! In a flowing bed grains move far, but neighbours move alike. So displacements are bounded patch by patch, by a box in
//! the space of displacements; two grains of the same or of adjacent patches have come closer by no more than the largest
//! distance between points of the two boxes. Grains of patches that are not adjacent start a patch apart.

use super::grid::{CellGrid, FORWARD, around};
use crate::lanes::Number;
use crate::partition::BoxGrid;
use crate::schedule::{Disjoint, Phase, Team};
use crate::world::Sphere;
use nalgebra::Vector3;

/// Bounds of the displacements in each patch; kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    patches: Vec<Bounds>,
    layers: Vec<Moved>,
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

impl Drift {
    /// Bounds the displacements from `reference` to `spheres`, both in the order of the grid.
    pub fn measure(
        &mut self,
        grid: &CellGrid,
        boxes: &BoxGrid,
        spheres: &[Sphere],
        reference: &[Vector3<f64>],
        team: &Team,
    ) -> Moved {
        let counts = grid.patch_counts();
        let [columns, rows, layers] = counts.map(|count| count as usize);
        self.patches.clear();
        self.patches.resize(columns * rows * layers, Bounds::EMPTY);
        let patches = Disjoint::new(&mut self.patches);
        team.each(Phase::Detect, boxes.boxes(), |number| {
            grid.for_each_cell(number, |patch, places| {
                // SAFETY: a patch belongs to one box.
                let bounds = unsafe { patches.at(patch) };
                let mut own = *bounds;
                for (sphere, then) in spheres[places.clone()].iter().zip(&reference[places]) {
                    own.add(sphere.centre - then);
                }
                *bounds = own;
            });
        });
        self.layers.resize(layers, Moved::default());
        let (patches, parts) = (&self.patches, Disjoint::new(&mut self.layers));
        team.each(Phase::Detect, layers, |layer| {
            let mut squares = Moved::default();
            for row in 0..rows {
                for column in 0..columns {
                    let own = &patches[(layer * rows + row) * columns + column];
                    if own.is_empty() {
                        continue;
                    }
                    squares.shift = squares.shift.larger(own.largest_squared());
                    for step in std::iter::once([0; 3]).chain(FORWARD) {
                        let at = [column as i32 + step[0], row as i32 + step[1], layer as i32 + step[2]];
                        if let Some(at) = around(at, counts.map(|count| count as i32), boxes.period()) {
                            let other = (at[2] as usize * rows + at[1] as usize) * columns + at[0] as usize;
                            if !patches[other].is_empty() {
                                squares.approach =
                                    squares.approach.larger(own.largest_distance_squared(&patches[other]));
                            }
                        }
                    }
                }
            }
            // SAFETY: each layer has its own entry.
            *unsafe { parts.at(layer) } = squares;
        });
        let largest = |value: fn(&Moved) -> f64| self.layers.iter().map(value).fold(0.0, f64::max).sqrt();
        Moved { shift: largest(|moved| moved.shift), approach: largest(|moved| moved.approach) }
    }

    pub fn memory_bytes(&self) -> usize {
        self.patches.capacity() * size_of::<Bounds>()
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
