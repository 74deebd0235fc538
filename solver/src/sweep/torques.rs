//! Relaxation of the angular impulse of a contact: see [`resistance`](crate::effects::resistance).

use super::kernel::Bodies;
use super::residual::{LaneResidual, MeasuredLevel};
use crate::effects::term::{NormalLoad, TermState, TorqueTerm};
use crate::lanes::{Number, minus, plus, times};
use crate::world::INVERSE_INERTIA;

impl<N: Number> Bodies<N> {
    /// Angular velocity, rad/s.
    #[inline(always)]
    pub(super) fn spin(&self) -> [N; 3] {
        times(self.scaled_spin, self.inverse_radius)
    }

    /// Adds `sign` times an angular impulse, N m s.
    #[inline(always)]
    pub fn turn(&mut self, sign: f64, impulse: [N; 3]) {
        let factor = self.inverse_mass * self.inverse_radius * N::splat(sign * INVERSE_INERTIA);
        self.scaled_spin = plus(self.scaled_spin, times(impulse, factor));
    }

    /// Inverse moment of inertia, 1/(kg m2).
    #[inline(always)]
    pub(super) fn inverse_inertia(&self) -> N {
        self.inverse_mass * self.inverse_radius * self.inverse_radius * N::splat(INVERSE_INERTIA)
    }
}

/// Relative rotation of the two sides of a contact.
#[derive(Clone, Copy)]
pub(crate) struct Turning<N> {
    /// Angular velocity of the second side minus that of the first, rad/s.
    pub spin: [N; 3],
    /// Sum of the inverse moments of inertia, 1/(kg m2).
    pub operator: N,
    /// Inverse of the smaller radius, 1/m.
    pub inverse_radius: N,
}

impl<N: Number> Turning<N> {
    /// Relative rotation of two grains.
    #[inline(always)]
    pub fn of(first: &Bodies<N>, second: &Bodies<N>) -> Self {
        Self {
            spin: minus(second.spin(), first.spin()),
            operator: first.inverse_inertia() + second.inverse_inertia(),
            inverse_radius: first.inverse_radius.larger(second.inverse_radius),
        }
    }

    /// Relative rotation of a grain and a wall with angular velocity `wall_spin` (rad/s).
    #[inline(always)]
    pub fn with_wall(grain: &Bodies<N>, wall_spin: [N; 3]) -> Self {
        let (spin, operator) = (minus(wall_spin, grain.spin()), grain.inverse_inertia());
        Self { spin, operator, inverse_radius: grain.inverse_radius }
    }

    /// Relaxes a torque and returns the change of its angular impulse. Residuals are surface velocities, m/s.
    #[inline(always)]
    pub fn relax<G: MeasuredLevel>(
        self,
        torque: &mut TermState<N, impl TorqueTerm<N>>,
        load: NormalLoad<N>,
        relaxation: N,
        residual: &mut LaneResidual<N>,
    ) -> [N; 3] {
        let operator = torque.term.operator(self.operator);
        let change = torque.relax(load, self.spin, operator, relaxation);
        if G::ANY {
            residual.add_turning::<G>(times(change, operator / self.inverse_radius));
        }
        change
    }
}
