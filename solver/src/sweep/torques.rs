//! Relaxation of the angular impulse of a contact: see [`resistance`](crate::effects::resistance).

use super::kernel::Bodies;
use super::residual::{LaneResidual, MeasuredLevel};
use crate::effects::Effects;
use crate::effects::resistance::bearable;
use crate::groups::TorqueLanes;
use crate::lanes::{Number, minus, plus, times};
use crate::world::INVERSE_INERTIA;

/// Levers and angular impulse of one contact, or of eight.
#[derive(Clone, Copy)]
pub(crate) struct Torque<N> {
    /// Largest rolling torque over the normal force, m.
    pub rolling_lever: N,
    /// Largest twisting torque over the normal force, m.
    pub twisting_lever: N,
    /// Angular impulse on the second side, N m s.
    pub impulse: [N; 3],
}

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

impl<N: Number> Torque<N> {
    /// Reads a torque, number by number.
    #[inline(always)]
    pub fn read(torques: &TorqueLanes, number: impl Fn(&crate::lanes::Eight) -> N) -> Self {
        Self {
            rolling_lever: number(&torques.rolling_lever),
            twisting_lever: number(&torques.twisting_lever),
            impulse: torques.impulse.each_ref().map(&number),
        }
    }

    /// Writes its impulse back.
    #[inline(always)]
    pub fn write(&self, torques: &mut TorqueLanes, number: impl Fn(N, &mut crate::lanes::Eight)) {
        for axis in 0..3 {
            number(self.impulse[axis], &mut torques.impulse[axis]);
        }
    }

    /// The one-contact solution: updates the impulse and returns the change. Residuals are surface velocities, m/s.
    #[inline(always)]
    pub(super) fn relax<E: Effects, G: MeasuredLevel>(
        &mut self,
        (normal, normal_impulse): ([N; 3], N),
        spin: [N; 3],
        operator: N,
        inverse_radius: N,
        relaxation: N,
        residual: &mut LaneResidual<N>,
    ) -> [N; 3] {
        let target = minus(self.impulse, times(spin, relaxation / operator));
        let (rolling_cap, twisting_cap) = (self.rolling_lever * normal_impulse, self.twisting_lever * normal_impulse);
        let borne = bearable::<E, N>(target, normal, rolling_cap, twisting_cap);
        let change = minus(borne, self.impulse);
        self.impulse = borne;
        if G::ANY {
            residual.add_turning::<G>(times(change, operator / inverse_radius));
        }
        change
    }

    /// Relaxes the torque of a contact of two grains; `contact` is its normal and normal impulse.
    #[inline(always)]
    pub fn relax_pair<E: Effects, G: MeasuredLevel>(
        &mut self,
        contact: ([N; 3], N),
        first: &mut Bodies<N>,
        second: &mut Bodies<N>,
        relaxation: N,
        residual: &mut LaneResidual<N>,
    ) {
        let spin = minus(second.spin(), first.spin());
        let operator = first.inverse_inertia() + second.inverse_inertia();
        let inverse_radius = first.inverse_radius.larger(second.inverse_radius);
        let change = self.relax::<E, G>(contact, spin, operator, inverse_radius, relaxation, residual);
        first.turn(-1.0, change);
        second.turn(1.0, change);
    }

    /// Relaxes the torque of a contact of a grain with a wall that turns with `wall_spin` (rad/s).
    #[inline(always)]
    pub fn relax_wall<E: Effects, G: MeasuredLevel>(
        &mut self,
        contact: ([N; 3], N),
        grain: &mut Bodies<N>,
        wall_spin: [N; 3],
        relaxation: N,
        residual: &mut LaneResidual<N>,
    ) {
        let spin = minus(wall_spin, grain.spin());
        let operator = grain.inverse_inertia();
        let change = self.relax::<E, G>(contact, spin, operator, grain.inverse_radius, relaxation, residual);
        grain.turn(-1.0, change);
    }
}
