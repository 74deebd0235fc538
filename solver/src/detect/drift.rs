//! How far grains have moved, and how much closer neighbours can have come, since the candidate list was built.
//!
//! In a flowing bed grains move far, but neighbours move alike. So displacements are bounded patch by patch, by a box in
//! the space of displacements; two grains of the same or of adjacent patches have come closer by no more than the largest
//! distance between points of the two boxes. Grains of patches that are not adjacent start a patch apart.

use super::CellGrid;
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
    low: Vector3<f64>,
    high: Vector3<f64>,
}

/// What has moved, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moved {
    /// No grain has moved further.
    pub shift: f64,
    /// No two grains of adjacent patches have come closer by more.
    pub approach: f64,
}

/// The neighbours of a patch that come after it, and itself.
const AHEAD: [[i32; 3]; 14] = [
    [0, 0, 0],
    [1, 0, 0],
    [-1, 1, 0],
    [0, 1, 0],
    [1, 1, 0],
    [-1, -1, 1],
    [0, -1, 1],
    [1, -1, 1],
    [-1, 0, 1],
    [0, 0, 1],
    [1, 0, 1],
    [-1, 1, 1],
    [0, 1, 1],
    [1, 1, 1],
];

impl Bounds {
    const EMPTY: Bounds = Bounds {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Largest distance between a point of each, squared; negative infinity where one is empty.
    #[inline]
    fn largest_distance_squared(&self, other: &Bounds) -> f64 {
        let span = (self.high - other.low).sup(&(other.high - self.low));
        if span.x < 0.0 { f64::NEG_INFINITY } else { span.norm_squared() }
    }

    /// Largest length, squared.
    fn largest_squared(&self) -> f64 {
        if self.low.x > self.high.x { 0.0 } else { self.low.abs().sup(&self.high.abs()).norm_squared() }
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
                for (sphere, then) in spheres[places.clone()].iter().zip(&reference[places]) {
                    let shift = sphere.centre - then;
                    bounds.low = bounds.low.inf(&shift);
                    bounds.high = bounds.high.sup(&shift);
                }
            });
        });
        self.layers.resize(layers, Moved::default());
        let (patches, parts) = (&self.patches, Disjoint::new(&mut self.layers));
        team.each(Phase::Detect, layers, |layer| {
            let mut squares = Moved::default();
            for row in 0..rows {
                for column in 0..columns {
                    let own = &patches[(layer * rows + row) * columns + column];
                    if own.low.x > own.high.x {
                        continue;
                    }
                    squares.shift = squares.shift.max(own.largest_squared());
                    for step in AHEAD {
                        let at = [column as i32 + step[0], row as i32 + step[1], layer as i32 + step[2]];
                        if (0..3).all(|axis| at[axis] >= 0 && at[axis] < counts[axis] as i32) {
                            let other = (at[2] as usize * rows + at[1] as usize) * columns + at[0] as usize;
                            squares.approach = squares.approach.max(own.largest_distance_squared(&patches[other]));
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
        points.iter().fold(Bounds::EMPTY, |bounds, point| Bounds {
            low: bounds.low.inf(&Vector3::from(*point)),
            high: bounds.high.sup(&Vector3::from(*point)),
        })
    }

    #[test]
    fn bounds_cover_every_pair_of_displacements() {
        let a = bounds(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        let b = bounds(&[[3.0, 4.0, 0.0]]);
        assert_eq!(a.largest_distance_squared(&b), 25.0);
        assert_eq!(a.largest_distance_squared(&a), 1.0);
        assert_eq!(b.largest_distance_squared(&b), 0.0, "what moves together comes no closer");
        assert_eq!(b.largest_squared(), 25.0);
        assert_eq!(a.largest_distance_squared(&Bounds::EMPTY), f64::NEG_INFINITY);
        assert_eq!(Bounds::EMPTY.largest_squared(), 0.0);
    }
}
