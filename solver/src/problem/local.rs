//! The problem reduced to its contacts: `w = W lambda + q`, three rows a contact, with the bodies eliminated.

use super::{Contact, ContactImpulse, ContactProblem};
use nalgebra::{Matrix3, Vector3};

/// A contact problem in the frames of its contacts, as FCLIB's `fclib_local` has it:
///
/// ```text
/// w = W lambda + q      W = G M^-1 G^T + Sigma'      q = G v + (velocities of walls) - (biases along the normals)
/// ```
///
/// with v the velocities before the contacts act, pulls included. Sigma' stands on the diagonal in the rows of normals; the compliance of
/// tangential springs stands in the others, and their biases in q. A solution has `0 <= lambda_n _|_ w_n >= 0` and Coulomb's law of w_t and lambda_t at each contact. (V. Acary, M. Brémond, T. Koziara, F.
/// Pérignon, *FCLIB: a collection of discrete 3D frictional contact problems*, Inria technical report 444, 2014.)
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalProblem {
    /// W in blocks of one contact by another, 1/kg, column after column and in each from the first row on.
    pub blocks: Vec<MatrixBlock>,
    /// q, m/s: normal and two tangential components of each contact.
    pub offset: Vec<Vector3<f64>>,
    /// Coefficient of friction of each contact.
    pub friction: Vec<f64>,
    /// Impulses that a solve starts from, N s, in the frames of the contacts.
    pub impulses: Vec<Vector3<f64>>,
    /// Number in the contact problem of each contact; those that bear nothing are left out.
    pub contacts: Vec<usize>,
}

/// What the impulse on one contact changes of the velocity at another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MatrixBlock {
    /// Contact whose velocity changes.
    pub row: usize,
    /// Contact with the impulse.
    pub column: usize,
    /// By how much, 1/kg.
    pub values: Matrix3<f64>,
}

impl ContactProblem {
    /// The problem reduced to the contacts that may bear something. Angular impulses have no place in it.
    pub fn local(&self) -> LocalProblem {
        let bearing: Vec<(usize, &Contact)> =
            self.contacts.iter().enumerate().filter(|(_, contact)| contact.bears()).collect();
        // Contacts of each body.
        let mut touched: Vec<Vec<usize>> = vec![Vec::new(); self.bodies.len()];
        for (row, (_, contact)) in bearing.iter().enumerate() {
            contact.sides().for_each(|(body, ..)| touched[body].push(row));
        }
        let mut blocks = Vec::new();
        for (column, (_, contact)) in bearing.iter().enumerate() {
            let mut rows: Vec<usize> = contact.sides().flat_map(|(body, ..)| touched[body].iter().copied()).collect();
            rows.sort_unstable();
            rows.dedup();
            for row in rows {
                let mut values = self.coupling(bearing[row].1, contact);
                if row == column {
                    values[(0, 0)] += contact.compliance;
                    values[(1, 1)] += contact.tangential_compliance;
                    values[(2, 2)] += contact.tangential_compliance;
                }
                blocks.push(MatrixBlock { row, column, values });
            }
        }
        // Velocities before the contacts act, pulls included.
        let free = self.state_of(&vec![ContactImpulse::default(); self.contacts.len()]);
        let offset = |(_, contact): &(usize, &Contact)| {
            let [u, v] = contact.tangents.map(|tangent| tangent.dot(&contact.tangential_bias));
            contact.frame().transpose() * self.relative_velocity(contact, &free) - Vector3::new(contact.bias, u, v)
        };
        let impulse = |(_, contact): &(usize, &Contact)| self.in_frame(contact, &contact.impulse);
        LocalProblem {
            blocks,
            offset: bearing.iter().map(offset).collect(),
            friction: bearing.iter().map(|(_, contact)| contact.friction).collect(),
            impulses: bearing.iter().map(impulse).collect(),
            contacts: bearing.iter().map(|(number, _)| *number).collect(),
        }
    }

    /// What an impulse on `column` changes of the velocity at `row`, in their frames, 1/kg.
    fn coupling(&self, row: &Contact, column: &Contact) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for (number, arm, sign) in column.sides() {
            let body = &self.bodies[number];
            for (_, other_arm, other_sign) in row.sides().filter(|(other, ..)| *other == number) {
                // v + omega x r of the row, with omega = I^-1 (r' x P) of the column.
                let turns = other_arm.cross_matrix().transpose() * body.inverse_inertia * arm.cross_matrix();
                sum += (body.inverse_mass + turns) * (sign * other_sign);
            }
        }
        // Zeros have no sign: entries that are summed from a file have none either.
        (row.frame().transpose() * sum * column.frame()).map(|entry| entry + 0.0)
    }

    /// An impulse in the frame of its contact: normal and two tangential components, N s.
    pub fn in_frame(&self, contact: &Contact, impulse: &ContactImpulse) -> Vector3<f64> {
        let [u, v] = contact.tangents.map(|tangent| tangent.dot(&impulse.tangential));
        Vector3::new(impulse.normal, u, v)
    }

    /// The impulses of all contacts, from those of the reduced problem in the frames of its contacts.
    pub fn impulses_of(&self, local: &LocalProblem, impulses: &[Vector3<f64>]) -> Vec<ContactImpulse> {
        let mut all = vec![ContactImpulse::default(); self.contacts.len()];
        for (&number, impulse) in local.contacts.iter().zip(impulses) {
            let [u, v] = self.contacts[number].tangents;
            all[number].normal = impulse.x;
            all[number].tangential = u * impulse.y + v * impulse.z;
        }
        all
    }
}

impl LocalProblem {
    /// Velocities `w = W lambda + q`, m/s.
    pub fn velocities(&self, impulses: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut velocities = self.offset.clone();
        for block in &self.blocks {
            velocities[block.row] += block.values * impulses[block.column];
        }
        velocities
    }
}
