//! Kernels shared by several methods, each written for one lane group.

use super::group::{Block, ContactPass, Group, add, load, store};
use super::problem::Tally;
use super::velocities::{Coefficients, MOST, combined};
use crate::groups::Effects;
use crate::lanes::{Lanes, Slots, TaskSlots, dot, minus, times};
use crate::sweep::kernel::Contact;
use crate::sweep::{Directions, LaneResidual, Off};
use crate::world::Body;

/// Copies impulses into a vector.
pub(crate) struct Keep<'a> {
    pub to: &'a mut [Block],
}

impl ContactPass for Keep<'_> {
    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G) {
        store(group.read::<L>().impulse(), &mut self.to[number]);
    }
}

/// Replaces impulses by a combination of vectors.
pub(crate) struct Combine<'a> {
    pub coefficients: &'a [f64],
    pub from: [&'a [Block]; MOST],
    pub count: usize,
}

impl ContactPass for Combine<'_> {
    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G) {
        let mut sum = [L::zero(); 3];
        for (coefficient, from) in self.coefficients.iter().zip(&self.from[..self.count]) {
            let own = load::<L>(&from[number]);
            for axis in 0..3 {
                sum[axis] = sum[axis] + L::splat(*coefficient) * own[axis];
            }
        }
        put::<L, G, E>(sum, group);
    }
}

/// Writes impulses given as vectors.
#[inline(always)]
fn put<L: Lanes, G: Group<E>, E: Effects>(impulse: [L; 3], group: &mut G) {
    let mut contact = group.read::<L>();
    contact.set_impulse(impulse);
    group.write(&contact);
}

/// Replaces impulses and two vectors by combinations of the three.
pub(crate) struct Transform<'a> {
    pub coefficients: &'a Coefficients,
    pub second: &'a mut [Block],
    pub third: &'a mut [Block],
}

impl ContactPass for Transform<'_> {
    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G) {
        let [to_first, to_second, to_third] = self.coefficients;
        let first = group.read::<L>().impulse();
        let (second, third) = (load::<L>(&self.second[number]), load::<L>(&self.third[number]));
        let mut impulse = first;
        for axis in 0..3 {
            let old = [first[axis], second[axis], third[axis]];
            impulse[axis] = combined(to_first, old);
            combined(to_second, old).store(&mut self.second[number][axis]);
            combined(to_third, old).store(&mut self.third[number][axis]);
        }
        put::<L, G, E>(impulse, group);
    }
}

/// Projected step along the scaled gradient, from a point with its own velocities.
///
/// Sums: `d.D d` of the change d, its compliant part `Sigma' d_n^2`, and gradient times the displacement from `last`.
pub(crate) struct Step<'a> {
    /// Velocities at the point.
    pub ahead: Slots<'a, Body>,
    /// Velocities that receive the change.
    pub bodies: TaskSlots<'a, Body>,
    pub from: &'a [Block],
    pub last: &'a [Block],
    pub step: f64,
    pub tally: &'a mut Tally,
}

impl ContactPass for Step<'_> {
    #[inline(always)]
    fn bodies(&self) -> Option<Slots<'_, Body>> {
        Some(self.ahead)
    }

    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G) {
        let mut contact = group.read::<L>();
        contact.set_impulse(load(&self.from[number]));
        let normal = contact.normal;
        let (velocity, inverse_mass) = group.velocity(self.ahead, &contact, 1.0);
        // Gradient before the impulse changes.
        let along = dot(normal, velocity);
        let slack = along + contact.regularisation * contact.impulse_normal - contact.bias;
        natural_map::<L, E>(contact, velocity, inverse_mass, self.tally);
        let mut unused = LaneResidual::zero();
        let step = L::splat(self.step);
        let change = contact.relax::<Off>(velocity, inverse_mass, step, &mut unused);
        group.push(self.bodies, normal, change);
        group.write(&contact);
        // Length of the step in the metric of the diagonal.
        let change_normal = dot(normal, change);
        let compliant = contact.regularisation * change_normal * change_normal;
        let mut scaled = inverse_mass * change_normal * change_normal + compliant;
        let way = minus(contact.impulse(), load(&self.last[number]));
        let way_normal = dot(normal, way);
        let mut slope = slack * way_normal;
        if E::FRICTION {
            let change_tangential = minus(change, times(normal, change_normal));
            let operator = contact.tangential_operator(inverse_mass);
            scaled = scaled + operator * dot(change_tangential, change_tangential);
            slope = slope + dot(velocity, way) - along * way_normal;
        }
        let [scaled_sum, compliant_sum, slope_sum] = &mut self.tally.sums;
        add(scaled_sum, scaled);
        add(compliant_sum, compliant);
        add(slope_sum, slope);
    }
}

/// Adds the change by one unrelaxed update of each contact by itself, m/s: zero only at the solution.
#[inline(always)]
pub(crate) fn natural_map<L: Lanes, E: Effects>(
    mut contact: Contact<L, E>,
    velocity: [L; 3],
    inverse_mass: L,
    tally: &mut Tally,
) {
    let mut residual = LaneResidual::<L>::read(&tally.residual);
    contact.relax::<Directions>(velocity, inverse_mass, L::splat(1.0), &mut residual);
    residual.write(&mut tally.residual);
}

/// Measures the distance of a state from the solution.
pub(crate) struct Measure<'a> {
    pub bodies: Slots<'a, Body>,
    pub tally: &'a mut Tally,
}

impl ContactPass for Measure<'_> {
    #[inline(always)]
    fn bodies(&self) -> Option<Slots<'_, Body>> {
        Some(self.bodies)
    }

    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, _: usize, group: &mut G) {
        let contact = group.read::<L>();
        let (velocity, inverse_mass) = group.velocity(self.bodies, &contact, 1.0);
        natural_map::<L, E>(contact, velocity, inverse_mass, self.tally);
        // Attraction, or tangential impulse outside the disc.
        let mut excess = -contact.impulse_normal * (inverse_mass + contact.regularisation);
        if E::FRICTION {
            let tangential = contact.tangential.impulse;
            let beyond = dot(tangential, tangential).sqrt() - contact.disc();
            excess = excess.larger(beyond * contact.tangential_operator(inverse_mass));
        }
        let mut cone = LaneResidual::<L>::read(&self.tally.cone);
        cone.add_normal::<Directions>(excess.larger(L::zero()));
        cone.write(&mut self.tally.cone);
    }
}
