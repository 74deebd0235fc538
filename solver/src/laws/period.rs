//! Periodic axes: space repeats along them, and positions are equivalent modulo the period.
//!
//! Grains retain their unwrapped coordinates: potential energy is continuous, and no position jumps. Only distances and
//! cells use nearest images.

use crate::lanes::Number;
use nalgebra::Vector3;

/// Adding and subtracting this constant rounds to the nearest integer, ties to even, below 2^51: plain arithmetic with
/// the same bits on every instruction set.
const ROUNDING: f64 = 1.5 * (1_u64 << 52) as f64;

/// Periods of space, m; zero along an axis that is not periodic.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Period {
    length: [f64; 3],
    inverse: [f64; 3],
}

impl Period {
    /// Creates a space of these lengths (m) that is periodic along the axes marked in `repeats`.
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

    /// Returns true if at least one axis is periodic.
    #[inline(always)]
    pub fn any(&self) -> bool {
        (0..3).any(|axis| self.is_periodic(axis))
    }

    /// Returns the length along an axis, m; zero if the axis is not periodic.
    pub fn length(&self, axis: usize) -> f64 {
        self.length[axis]
    }

    /// Applies the minimum-image convention to a separation vector (m).
    #[inline(always)]
    pub fn shortest<N: Number>(&self, arm: [N; 3]) -> [N; 3] {
        let rounding = N::splat(ROUNDING);
        std::array::from_fn(|axis| {
            let laps = (arm[axis] * N::splat(self.inverse[axis]) + rounding) - rounding;
            arm[axis] - laps * N::splat(self.length[axis])
        })
    }

    /// Returns the vector from a point to the nearest image of another point.
    #[inline]
    pub fn arm(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
        let arm = to - from;
        if self.any() { Vector3::from(self.shortest([arm.x, arm.y, arm.z])) } else { arm }
    }

    /// Returns the image of a point in the domain with the lower corner `low`, along the periodic axes.
    #[inline]
    pub fn wrapped(&self, point: &Vector3<f64>, low: &Vector3<f64>) -> Vector3<f64> {
        let mut image = *point;
        for axis in (0..3).filter(|&axis| self.is_periodic(axis)) {
            let (length, distance) = (self.length[axis], point[axis] - low[axis]);
            // A distance just below zero may round up to the full length, which is an image of zero.
            let inside = distance - (distance * self.inverse[axis]).floor() * length;
            image[axis] = low[axis] + if inside < length { inside.max(0.0) } else { 0.0 };
        }
        image
    }
}
