//! Projected Gauss-Seidel on the plain data, one contact after another: the textbook algorithm.
//!
//! ```text
//! for each sweep
//!   for each contact
//!     lambda_n <- max(0, lambda_n + omega (q - Sigma' lambda_n - n.u) / (S_n + Sigma'))
//!     lambda_t <- P[ lambda_t - omega (u_t + Sigma_t lambda_t - b) / (S_t + Sigma_t) ]    P: onto the disc of radius mu lambda_n
//!     L        <- P[ L - omega (omega_b - omega_a) / S_r ]    P: disc mu_r R* lambda_n across the normal, interval along it
//!     and the bodies take each change at once
//! ```
//!
//! S_n, S_t and S_r form the operator of a single contact: the normal element, the larger eigenvalue of the tangential block, the
//! largest eigenvalue of the sum of the inverse inertias. For spheres they are `1/m_a + 1/m_b`, 3.5 times that, and `1/I_a +
//! 1/I_b`, as in the lane sweeps (M. Jean, *The non-smooth contact dynamics method*, Computer Methods in Applied Mechanics and
//! Engineering 177, 1999; C. Lacoursière, *Ghosts and machines*, Umeå 2007, algorithm 1).

use super::{Contact, ContactImpulse, ContactProblem, ContactState};
use crate::sweep::Residual;
use nalgebra::{Matrix2, Matrix3, Vector3};

/// Settings of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Over-relaxation omega, above 0 and below 2.
    pub relaxation: f64,
    /// Largest `|change of lambda| S` of the final sweep, m/s.
    pub tolerance: f64,
    /// Maximum number of sweeps.
    pub most_sweeps: u32,
}

/// Result of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ending {
    /// Sweeps done.
    pub sweeps: u32,
    /// Largest `|change of lambda| S` of the last sweep, m/s.
    pub change: f64,
    /// True if the change is within the tolerance.
    pub converged: bool,
}

/// Diagonal of the operator at one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OneContact {
    /// S_n + Sigma', 1/kg.
    pub normal: f64,
    /// S_t + Sigma_t, 1/kg.
    pub tangential: f64,
    /// S_r, 1/(kg m2).
    pub turning: f64,
}

impl ContactProblem {
    pub(super) fn one_contact(&self, contact: &Contact) -> OneContact {
        let operator = self.own_operator(contact);
        let inertias: Matrix3<f64> = contact.sides().map(|(body, ..)| self.bodies[body].inverse_inertia).sum();
        OneContact {
            normal: operator[(0, 0)] + contact.compliance,
            tangential: larger_eigenvalue(&operator.fixed_view::<2, 2>(1, 1).into_owned())
                + contact.tangential_compliance,
            turning: if contact.resists_turning() { inertias.symmetric_eigenvalues().max() } else { 0.0 },
        }
    }

    /// Sweeps over a state until the largest change is within the tolerance; on return, velocities and impulses of the state are consistent.
    pub fn solve(&self, state: &mut ContactState, reference: &Reference) -> Ending {
        let operators: Vec<OneContact> = self.contacts.iter().map(|contact| self.one_contact(contact)).collect();
        let mut ending = Ending::default();
        while ending.sweeps < reference.most_sweeps && !ending.converged {
            ending.change = 0.0;
            for (number, (contact, operator)) in self.contacts.iter().zip(&operators).enumerate() {
                let change = self.relax(number, contact, operator, state, reference.relaxation);
                ending.change = ending.change.max(change);
            }
            ending.sweeps += 1;
            ending.converged = ending.change <= reference.tolerance;
        }
        ending
    }

    /// Relaxes one contact; returns the largest change of an impulse times its operator, m/s.
    fn relax(
        &self,
        number: usize,
        contact: &Contact,
        operator: &OneContact,
        state: &mut ContactState,
        relaxation: f64,
    ) -> f64 {
        let (none, last) = (Vector3::zeros(), state.impulses[number]);
        let mut impulse: ContactImpulse = last;
        // Normal impulse, projected onto repulsion.
        let normal_velocity = contact.normal.dot(&self.relative_velocity(contact, state));
        let violation = contact.bias - contact.compliance * impulse.normal - normal_velocity;
        impulse.normal = (last.normal + relaxation * violation / operator.normal).max(0.0);
        let change = impulse.normal - last.normal;
        self.push(contact, state, &(contact.normal * change), &none);
        let mut largest = change.abs() * operator.normal;
        // Tangential impulse, projected onto the disc at the new normal impulse.
        if operator.tangential > 0.0 {
            let velocity = self.relative_velocity(contact, state);
            let sliding = contact.sliding(&velocity, &last.tangential);
            let target = last.tangential - sliding * (relaxation / operator.tangential);
            impulse.tangential = onto_disc(target, contact.friction * impulse.normal);
            let change = impulse.tangential - last.tangential;
            self.push(contact, state, &change, &none);
            largest = largest.max(change.norm() * operator.tangential);
        }
        // Angular impulse, projected onto the limit of the contact.
        if operator.turning > 0.0 {
            let target = last.angular - self.relative_spin(contact, state) * (relaxation / operator.turning);
            impulse.angular = bearable(contact, &target, impulse.normal);
            let change = impulse.angular - last.angular;
            self.push(contact, state, &none, &change);
            largest = largest.max(change.norm() * operator.turning * contact.arms[0].norm());
        }
        state.impulses[number] = impulse;
        largest
    }
}

/// Projects a vector onto the disc of the given radius.
pub(super) fn onto_disc(vector: Vector3<f64>, radius: f64) -> Vector3<f64> {
    let length = vector.norm();
    if length <= radius { vector } else { vector * (radius / length) }
}

/// Larger eigenvalue of a symmetric matrix.
fn larger_eigenvalue(matrix: &Matrix2<f64>) -> f64 {
    let [mean, half] = [1.0, -1.0].map(|sign| 0.5 * (matrix[(0, 0)] + sign * matrix[(1, 1)]));
    mean + half.hypot(matrix[(0, 1)])
}

/// Residuals of a state: the change by an unrelaxed update of each contact by itself, times the contact's operator, m/s. All are
/// zero at a solution only (the natural map; P. Alart and A. Curnier, Computer Methods in Applied Mechanics and Engineering 92,
/// 1991, with the exact disc).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProblemResiduals {
    /// Normal complementarity `|min(lambda_n D_n, w_n)|`.
    pub normal: Residual,
    /// Coulomb's law, the disc and its maximum dissipation: `|lambda_t - P[lambda_t - w_t / D_t]| D_t`.
    pub tangential: Residual,
    /// Residual of angular impulses, times the first body's arm.
    pub turning: Residual,
    /// Excess of impulses over the cone: the larger of `-lambda_n D_n` and `(|lambda_t| - mu lambda_n) D_t`, not below zero.
    pub cone: Residual,
}

impl ProblemResiduals {
    crate::getters! {
        /// Root mean square over all directions, m/s.
        pub rms: f64 = |residuals| residuals.normal.rms.hypot(residuals.tangential.rms).hypot(residuals.turning.rms);
        /// Largest residual of any direction, m/s.
        pub max: f64 = |residuals| residuals.normal.max.max(residuals.tangential.max).max(residuals.turning.max);
    }
}

impl ContactProblem {
    /// Returns the residuals of a state.
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

/// Projects an angular impulse onto the admissible set at a normal impulse: a disc across the normal, an interval along it.
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
