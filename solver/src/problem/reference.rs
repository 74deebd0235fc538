//! Projected Gauss-Seidel on the plain data, one contact after another: the algorithm as it is written down.
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
//! S_n, S_t and S_r are what an impulse on the contact alone changes: the normal element of its operator, the larger eigenvalue of
//! the tangential block, the largest of the sum of the inverse inertias. For spheres they are `1/m_a + 1/m_b`, 3.5 times
//! that, and `1/I_a + 1/I_b`, as in the sweeps over lanes (M. Jean, *The non-smooth contact dynamics method*, Computer Methods in
//! Applied Mechanics and Engineering 177, 1999; C. Lacoursière, *Ghosts and machines*, Umeå 2007, algorithm 1).

use super::residuals::bearable;
use super::{Contact, ContactImpulse, ContactProblem, ContactState};
use nalgebra::{Matrix2, Matrix3, Vector3};

/// How the reference iterates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Over-relaxation omega, above 0 and below 2.
    pub relaxation: f64,
    /// Largest `|change of lambda| S` of a sweep at which it stops, m/s.
    pub tolerance: f64,
    /// Most sweeps.
    pub most_sweeps: u32,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ending {
    /// Sweeps done.
    pub sweeps: u32,
    /// Largest `|change of lambda| S` of the last of them, m/s.
    pub change: f64,
    /// Whether that is within the tolerance.
    pub converged: bool,
}

/// What an impulse on one contact alone changes.
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

    /// Sweeps over a state until the largest change is within the tolerance; the state goes with what it is when this returns.
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

    /// Relaxes one contact; the largest change of an impulse times its operator, m/s.
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
        // Tangential impulse, projected onto the disc at that normal impulse.
        if operator.tangential > 0.0 {
            let velocity = self.relative_velocity(contact, state);
            let sliding = contact.sliding(&velocity, &last.tangential);
            let target = last.tangential - sliding * (relaxation / operator.tangential);
            impulse.tangential = onto_disc(target, contact.friction * impulse.normal);
            let change = impulse.tangential - last.tangential;
            self.push(contact, state, &change, &none);
            largest = largest.max(change.norm() * operator.tangential);
        }
        // Angular impulse, projected onto what the contact can bear.
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

/// The nearest vector that is no longer than the radius.
pub(super) fn onto_disc(vector: Vector3<f64>, radius: f64) -> Vector3<f64> {
    let length = vector.norm();
    if length <= radius { vector } else { vector * (radius / length) }
}

/// Larger eigenvalue of a symmetric matrix.
fn larger_eigenvalue(matrix: &Matrix2<f64>) -> f64 {
    let [mean, half] = [1.0, -1.0].map(|sign| 0.5 * (matrix[(0, 0)] + sign * matrix[(1, 1)]));
    mean + half.hypot(matrix[(0, 1)])
}
