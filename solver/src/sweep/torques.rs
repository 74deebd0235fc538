//! Relaxation of the angular impulse of a contact: see [`resistance`](crate::effects::resistance).

use super::kernel::Bodies;
use super::residual::{LaneResidual, MeasuredLevel};
use crate::effects::term::{Bearing, TorqueTerm};
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

    /// One over the moment of inertia, 1/(kg m2).
    #[inline(always)]
    pub(super) fn inverse_inertia(&self) -> N {
        self.inverse_mass * self.inverse_radius * self.inverse_radius * N::splat(INVERSE_INERTIA)
    }
}

/// Relaxes the torque of a contact and returns the change of its angular impulse. Residuals are surface velocities, m/s.
#[inline(always)]
pub(super) fn relax<G: MeasuredLevel, N: Number>(
    torque: &mut impl TorqueTerm<N>,
    bearing: Bearing<N>,
    spin: [N; 3],
    (operator, inverse_radius): (N, N),
    relaxation: N,
    residual: &mut LaneResidual<N>,
) -> [N; 3] {
    let change = torque.relax(bearing, spin, operator, relaxation);
    if G::ANY {
        residual.add_turning::<G>(times(change, operator / inverse_radius));
    }
    change
}

/// Relaxes the torque of a contact of two grains.
#[inline(always)]
pub(crate) fn relax_pair<G: MeasuredLevel, N: Number>(
    torque: &mut impl TorqueTerm<N>,
    bearing: Bearing<N>,
    [first, second]: [&mut Bodies<N>; 2],
    relaxation: N,
    residual: &mut LaneResidual<N>,
) {
    let spin = minus(second.spin(), first.spin());
    let operator = torque.operator(first.inverse_inertia() + second.inverse_inertia());
    let inverse_radius = first.inverse_radius.larger(second.inverse_radius);
    let change = relax::<G, N>(torque, bearing, spin, (operator, inverse_radius), relaxation, residual);
    first.turn(-1.0, change);
    second.turn(1.0, change);
}

/// Relaxes the torque of a contact of a grain with a wall that turns with `wall_spin` (rad/s).
#[inline(always)]
pub(crate) fn relax_wall<G: MeasuredLevel, N: Number>(
    torque: &mut impl TorqueTerm<N>,
    bearing: Bearing<N>,
    grain: &mut Bodies<N>,
    wall_spin: [N; 3],
    relaxation: N,
    residual: &mut LaneResidual<N>,
) {
    let spin = minus(wall_spin, grain.spin());
    let operator = torque.operator(grain.inverse_inertia());
    let change = relax::<G, N>(torque, bearing, spin, (operator, grain.inverse_radius), relaxation, residual);
    grain.turn(-1.0, change);
}
