//! Periodic axes: space repeats itself along them, so that what leaves at one end comes in at the other.
//!
//! Grains keep the coordinates that they have come to, however far that is: potential energy stays what it is, and nothing jumps.
//! Only distances and cells are taken between nearest images.

use crate::lanes::Number;
use nalgebra::Vector3;

/// Adding and taking this away rounds to the nearest whole number, ties to even, below 2^51: plain arithmetic that has the same bits
/// on every instruction set.
const ROUNDING: f64 = 1.5 * (1_u64 << 52) as f64;

/// Lengths after which space repeats itself, m; zero along an axis that does not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Period {
    length: [f64; 3],
    inverse: [f64; 3],
}

impl Period {
    /// A space of these lengths (m) that repeats itself along some of its axes.
    pub fn new(lengths: [f64; 3], repeats: [bool; 3]) -> Period {
        let mut period = Period::default();
        for axis in (0..3).filter(|&axis| repeats[axis]) {
            period.length[axis] = lengths[axis];
            period.inverse[axis] = 1.0 / lengths[axis];
        }
        period
    }

    /// Returns true if an axis is periodic.
    #[inline(always)]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.length[axis] > 0.0
    }

    /// Returns true if any axis is.
    #[inline(always)]
    pub fn any(&self) -> bool {
        (0..3).any(|axis| self.is_periodic(axis))
    }

    /// Length along an axis, m; zero if it is not periodic.
    pub fn length(&self, axis: usize) -> f64 {
        self.length[axis]
    }

    /// The shortest of the vectors that lead from the images of one point to those of another, given one of them.
    #[inline(always)]
    pub fn shortest<N: Number>(&self, arm: [N; 3]) -> [N; 3] {
        let rounding = N::splat(ROUNDING);
        std::array::from_fn(|axis| {
            let laps = (arm[axis] * N::splat(self.inverse[axis]) + rounding) - rounding;
            arm[axis] - laps * N::splat(self.length[axis])
        })
    }

    /// The vector from a point to the nearest image of another.
    #[inline]
    pub fn arm(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
        let arm = to - from;
        if self.any() { Vector3::from(self.shortest([arm.x, arm.y, arm.z])) } else { arm }
    }

    /// The image of a point that lies in the domain whose lower corner is `low`, as far as axes are periodic.
    #[inline]
    pub fn wrapped(&self, point: &Vector3<f64>, low: &Vector3<f64>) -> Vector3<f64> {
        let mut image = *point;
        for axis in (0..3).filter(|&axis| self.is_periodic(axis)) {
            let (length, distance) = (self.length[axis], point[axis] - low[axis]);
            // A distance just below zero may round up to the whole length, which is an image of zero.
            let inside = distance - (distance * self.inverse[axis]).floor() * length;
            image[axis] = low[axis] + if inside < length { inside.max(0.0) } else { 0.0 };
        }
        image
    }
}
