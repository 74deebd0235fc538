//! How far a state is from the solution of its problem.

use super::reference::onto_disc;
use super::{Contact, ContactProblem, ContactState};
use crate::sweep::Residual;
use nalgebra::Vector3;

/// Residuals of a state: what an unrelaxed update of each contact by itself would still change, times the contact's operator,
/// m/s. All are zero at a solution and nowhere else (the natural map; P. Alart and A. Curnier, Computer Methods in Applied Mechanics
/// and Engineering 92, 1991, with the exact disc).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProblemResiduals {
    /// Normal complementarity `|min(lambda_n D_n, w_n)|`.
    pub normal: Residual,
    /// Coulomb's law, the disc and the maximum dissipation in it: `|lambda_t - P[lambda_t - w_t / D_t]| D_t`.
    pub tangential: Residual,
    /// The same of angular impulses, times the first body's arm.
    pub turning: Residual,
    /// By how much impulses attract or leave the disc: `-lambda_n D_n` or `(|lambda_t| - mu lambda_n) D_t`, the larger of the
    /// two, not below zero.
    pub cone: Residual,
}

impl ProblemResiduals {
    /// Root mean square over all directions, m/s.
    pub fn rms(&self) -> f64 {
        self.normal.rms.hypot(self.tangential.rms).hypot(self.turning.rms)
    }

    /// Largest of any direction, m/s.
    pub fn max(&self) -> f64 {
        self.normal.max.max(self.tangential.max).max(self.turning.max)
    }
}

impl ContactProblem {
    /// Residuals of a state.
    pub fn residuals(&self, state: &ContactState) -> ProblemResiduals {
        let mut sums = [Sum::default(); 4];
        for (contact, impulse) in self.contacts.iter().zip(&state.impulses).filter(|(contact, _)| contact.bears()) {
            let operator = self.one_contact(contact);
            let velocity = self.relative_velocity(contact, state);
            let normal_velocity = contact.normal.dot(&velocity);
            let gap_velocity = normal_velocity + contact.compliance * impulse.normal - contact.bias;
            let normal = (impulse.normal - gap_velocity / operator.normal).max(0.0);
            let sliding = contact.sliding(&velocity, &impulse.tangential);
            let target = impulse.tangential - sliding / operator.tangential;
            let tangential = onto_disc(target, contact.friction * normal);
            sums[0].add((normal - impulse.normal) * operator.normal);
            sums[1].add((tangential - impulse.tangential).norm() * operator.tangential);
            if operator.turning > 0.0 {
                let target = impulse.angular - self.relative_spin(contact, state) / operator.turning;
                let change = bearable(contact, &target, normal) - impulse.angular;
                sums[2].add(change.norm() * operator.turning * contact.arms[0].norm());
            }
            let beyond = (impulse.tangential.norm() - contact.friction * impulse.normal) * operator.tangential;
            sums[3].add(beyond.max(-impulse.normal * operator.normal).max(0.0));
        }
        let [normal, tangential, turning, cone] = sums.map(|sum| sum.over(self.contacts.len()));
        ProblemResiduals { normal, tangential, turning, cone }
    }
}

/// What of an angular impulse a contact can bear with a normal impulse: a disc across the normal, an interval along it.
pub(super) fn bearable(contact: &Contact, impulse: &Vector3<f64>, normal_impulse: f64) -> Vector3<f64> {
    let along = contact.normal.dot(impulse);
    let rolling = onto_disc(impulse - contact.normal * along, contact.rolling_lever * normal_impulse);
    let most = contact.twisting_lever * normal_impulse;
    rolling + contact.normal * along.clamp(-most, most)
}

#[derive(Clone, Copy, Default)]
struct Sum {
    squares: f64,
    largest: f64,
}

impl Sum {
    fn add(&mut self, value: f64) {
        self.squares += value * value;
        self.largest = self.largest.max(value.abs());
    }

    fn over(self, count: usize) -> Residual {
        Residual { rms: (self.squares / count.max(1) as f64).sqrt(), max: self.largest }
    }
}
