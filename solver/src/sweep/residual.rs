//! How far a sweep still moved the contacts: |delta lambda| S, in m/s, for the normal and two tangential directions.

use super::lanes::{Lanes, dot};
use serde::{Deserialize, Serialize};

/// Root mean square and maximum of a residual over all contacts, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Root mean square, m/s.
    pub rms: f64,
    /// Maximum, m/s.
    pub max: f64,
}

/// Residuals of one sweep, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    /// Normal direction.
    pub normal: Residual,
    /// First tangential direction.
    pub tangential_u: Residual,
    /// Second tangential direction.
    pub tangential_v: Residual,
}

impl Residuals {
    /// Root mean square over the three directions, m/s.
    pub fn rms(&self) -> f64 {
        let square = |residual: &Residual| residual.rms * residual.rms;
        (square(&self.normal) + square(&self.tangential_u) + square(&self.tangential_v)).sqrt()
    }
}

/// Sums over lane groups, still lane by lane, so that their order is fixed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroupResidual {
    squares: [Lanes; 3],
    largest: [Lanes; 3],
}

impl GroupResidual {
    #[inline(always)]
    fn add(&mut self, direction: usize, value: Lanes) {
        self.squares[direction] = self.squares[direction] + value * value;
        self.largest[direction] = self.largest[direction].larger(value.abs());
    }

    /// Adds the normal residuals of a group.
    #[inline(always)]
    pub fn add_normal(&mut self, value: Lanes) {
        self.add(0, value);
    }

    /// Splits the tangential residual vectors of a group along two directions perpendicular to the normal.
    ///
    /// The basis needs no branch and is continuous but for one seam (Duff et al., J. Comput. Graph. Tech. 6(1), 2017).
    #[inline(always)]
    pub fn add_tangential(&mut self, normal: [Lanes; 3], value: [Lanes; 3]) {
        let one = Lanes::splat(1.0);
        let sign = Lanes::select(Lanes::splat(0.0).at_most(normal[2]), one, -one);
        let a = -(one / (sign + normal[2]));
        let b = normal[0] * normal[1] * a;
        let u = [one + sign * normal[0] * normal[0] * a, sign * b, -(sign * normal[0])];
        let v = [b, sign + normal[1] * normal[1] * a, -normal[1]];
        self.add(1, dot(u, value));
        self.add(2, dot(v, value));
    }

    /// Adds the sums of another task; callers keep the order of tasks.
    pub fn merge(&mut self, other: &GroupResidual) {
        for direction in 0..3 {
            self.squares[direction] = self.squares[direction] + other.squares[direction];
            self.largest[direction] = self.largest[direction].larger(other.largest[direction]);
        }
    }

    /// Residuals over `contacts` contacts.
    pub fn finish(&self, contacts: usize) -> Residuals {
        let residual = |direction: usize| Residual {
            rms: (self.squares[direction].sum() / contacts.max(1) as f64).sqrt(),
            max: self.largest[direction].max(),
        };
        Residuals { normal: residual(0), tangential_u: residual(1), tangential_v: residual(2) }
    }
}
