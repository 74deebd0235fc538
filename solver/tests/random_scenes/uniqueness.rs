//! When the velocities that a step's contact problem asks for are unique, and how far two inexact solutions can then be apart.
//!
//! Let two solutions differ by `dv` in velocities and `dl` in impulses, and `X^2 = |dv|_M^2 + sum Sigma' dl_n^2`. The normal law
//! is monotone, `sum dl_n (dw_n) <= 0`; Coulomb's is not, as its disc has the radius `mu l_n`: with `l_t . u_t = -mu l_n |u_t|`
//! and `|l_t'| <= mu l_n'` the two laws together give
//!
//! ```text
//! X^2 <= sum mu dl_n (|u_t'| - |u_t|) <= mu |D^1/2 dl_n| |D^-1/2 du_t|          D = 1/m_a + 1/m_b of each contact
//! ```
//!
//! With `|D^-1/2 du_t|^2 <= Lambda |dv|_M^2` and `kappa |D^1/2 dl_n|^2 <= X^2` the velocities are unique if
//! `c = mu sqrt(Lambda / kappa) < 1`: without friction always, with it where normals are not too many for the grains or soft
//! enough. Where solutions hold the laws but for `eta` (J), `X^2 <= eta / (1 - c)`.

use super::contacts::{INERTIA, Inexact, Laws, Touch};
use nalgebra::{DMatrix, Vector3};

/// Tangential over normal operator of solid spheres.
const TANGENTIAL: f64 = 1.0 + 1.0 / INERTIA;

/// The factor f of `X^2 <= f eta` for contacts that bear in either of two solutions; absent where the velocities may not be
/// unique, `c > 0.9`.
pub fn factor(touches: &[Touch], laws: &Laws, friction: f64) -> Option<f64> {
    if touches.iter().any(|touch| touch.law.is_none()) {
        return None;
    }
    if friction == 0.0 {
        return Some(1.0);
    }
    // The normal and tangential impulses of a lone contact of spheres do not act on each other: there X^2 <= eta without
    // friction's part, and then X <= sqrt(eta) + mu sqrt(3.5 eta).
    let alone = |touch: &&Touch| {
        let shares = |other: &&Touch| [Some(other.first), other.second].iter().flatten().any(|grain| touch.has(*grain));
        touches.iter().filter(shares).count() == 1
    };
    let lone = (1.0 + friction * TANGENTIAL.sqrt()).powi(2);
    let joined: Vec<&Touch> = touches.iter().filter(|touch| !alone(touch)).collect();
    if joined.is_empty() {
        return Some(lone);
    }
    let (normal, tangential) = directions(&joined, laws);
    // The largest eigenvalue of D^-1/2 T T' D^-1/2, and of T T' itself the range of T.
    let scale = |index: usize| joined[index].inverse_mass.sqrt();
    let count = joined.len();
    let scaled =
        DMatrix::from_fn(2 * count, tangential.ncols(), |row, column| tangential[(row, column)] / scale(row / 2));
    let products = (&scaled * scaled.transpose()).symmetric_eigen();
    let largest = products.eigenvalues.max();
    // The range of T: what is left of the normals outside it is what tangential impulses cannot undo.
    let mut left = normal.clone();
    for (index, value) in products.eigenvalues.iter().enumerate() {
        if *value > 1e-12 * largest {
            let along = scaled.transpose() * products.eigenvectors.column(index) / value.sqrt();
            let share = &left * &along;
            left -= share * along.transpose();
        }
    }
    let regularisation = |index: usize| joined[index].law.map_or(0.0, |law| law.regularisation);
    let stiff = DMatrix::from_fn(count, count, |row, column| {
        let product = left.row(row).dot(&left.row(column)) / (scale(row) * scale(column));
        product + if row == column { regularisation(row) / joined[row].inverse_mass } else { 0.0 }
    });
    let least = stiff.symmetric_eigenvalues().min().max(0.0);
    let c = friction * (largest / least).sqrt();
    (c < 0.9).then(|| lone.max(1.0 / (1.0 - c)))
}

/// Rows of `G M^-1/2`, along normals and along two tangents a contact, so that products of rows are those of the contact operator.
fn directions(touches: &[&Touch], laws: &Laws) -> (DMatrix<f64>, DMatrix<f64>) {
    let bodies = 1 + touches.iter().flat_map(|touch| [Some(touch.first), touch.second]).flatten().max().unwrap_or(0);
    let mut normal = DMatrix::zeros(touches.len(), 6 * bodies);
    let mut tangential = DMatrix::zeros(2 * touches.len(), 6 * bodies);
    for (row, touch) in touches.iter().enumerate() {
        let helper = Vector3::ith(touch.normal.iamin(), 1.0);
        let u = touch.normal.cross(&helper).normalize();
        let tangents = [u, touch.normal.cross(&u)];
        for (sign, grain) in [(-1.0, Some(touch.first)), (1.0, touch.second)] {
            let Some(grain) = grain else { continue };
            let root = laws.mass(grain).sqrt();
            for axis in 0..3 {
                normal[(row, 6 * grain + axis)] = sign * touch.normal[axis] / root;
                for (number, tangent) in tangents.iter().enumerate() {
                    // u = v_b - v_a - (s_a + s_b) x n: along t a surface speed s gives -(n x t) . s, with inertia 0.4 m.
                    tangential[(2 * row + number, 6 * grain + axis)] = sign * tangent[axis] / root;
                    let lever = touch.normal.cross(tangent)[axis];
                    tangential[(2 * row + number, 6 * grain + 3 + axis)] = -lever / (root * INERTIA.sqrt());
                }
            }
        }
    }
    (normal, tangential)
}

/// By how much two solutions of one problem may miss the laws together, J: the `eta` above. Both list the same contacts.
pub fn miss(friction: f64, [one, other]: [(&[Touch], Inexact); 2]) -> f64 {
    let own = |(touches, inexact): (&[Touch], Inexact)| -> f64 {
        touches.iter().map(|touch| touch.normal_slack(inexact) + touch.friction_slack(friction, inexact)).sum()
    };
    // Impulses of one work on the gap velocities of the other, which its residual lets be negative.
    let load = |touches: &[Touch]| touches.iter().map(|touch| touch.along).sum::<f64>();
    own(one) + own(other) + other.1.normal * load(one.0) + one.1.normal * load(other.0)
}

impl Touch {
    /// Returns true if a grain is one of its sides.
    pub fn has(&self, grain: usize) -> bool {
        self.first == grain || self.second == Some(grain)
    }
}
