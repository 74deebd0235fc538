//! Elastic compliance of the normal contact, and the stabilisation of its overlap.
//!
//! SPOOK (Lacoursière 2007) treats an overlap d as a constraint of compliance eps and damping time tau. With
//! `Y = 1/(1 + 4 tau/h)` a contact gets the regularisation `Sigma' = 4 Y eps/h^2` and the bias
//! `q = (4/h) Y d + Y u_n0`, where u_n0 is the normal velocity at the start of the step.
//!
//! Hertz's potential `2/5 k_H d^(5/2)` equals `g^2/(2 eps)` with `g = d^(5/4)` and `eps = 5/(4 k_H)` (up to the sign of
//! g); dividing the constraint by dg/dd = (5/4) d^(1/4) leaves the overlap 0.8 d and the compliance
//! `1/(1.25 k_H sqrt(d))`. At rest this gives back `force = k_H d^(3/2)`.

use crate::scene::NormalLaw;

/// Overlaps below this share of the effective radius are as stiff as it: the first touch of a Hertzian contact would
/// otherwise have no stiffness at all.
const SMALLEST_RELATIVE_OVERLAP: f64 = 1e-5;

/// Regularisation and bias of a contact's normal constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalConstraint {
    /// Sigma', 1/kg.
    pub regularisation: f64,
    /// q, m/s.
    pub bias: f64,
}

/// Constraint of one contact.
#[derive(Clone, Copy, Debug)]
pub struct NormalContact {
    /// Overlap d, m; negative where there is a gap.
    pub overlap: f64,
    /// Normal velocity at the start of the step, m/s; positive where the two separate.
    pub velocity: f64,
    /// Effective modulus E*, Pa.
    pub effective_modulus: f64,
    /// Effective radius R*, m.
    pub effective_radius: f64,
}

impl NormalContact {
    /// Hertz's stiffness `k_H = 4/3 E* sqrt(R*)`, N/m^1.5.
    pub fn hertz_stiffness(&self) -> f64 {
        4.0 / 3.0 * self.effective_modulus * self.effective_radius.sqrt()
    }

    /// Regularisation and bias by the scene's law, for a step `h` (s) and a damping time of `damping_steps` steps.
    #[inline]
    pub fn constraint(&self, law: NormalLaw, h: f64, damping_steps: f64) -> NormalConstraint {
        let damping = 1.0 / (1.0 + 4.0 * damping_steps);
        let (compliance, overlap) = match law {
            NormalLaw::Rigid => (0.0, self.overlap),
            NormalLaw::Linear { stiffness } => (1.0 / stiffness, self.overlap),
            NormalLaw::Hertz => {
                let depth = self.overlap.max(SMALLEST_RELATIVE_OVERLAP * self.effective_radius);
                (1.0 / (1.25 * self.hertz_stiffness() * depth.sqrt()), 0.8 * self.overlap)
            }
        };
        NormalConstraint {
            regularisation: 4.0 * damping * compliance / (h * h),
            bias: 4.0 / h * damping * overlap + damping * self.velocity,
        }
    }

    /// Elastic energy stored, J: `1/2 k d^2` or `2/5 k_H d^(5/2)`.
    pub fn elastic_energy(&self, law: NormalLaw) -> f64 {
        let overlap = self.overlap.max(0.0);
        match law {
            NormalLaw::Rigid => 0.0,
            NormalLaw::Linear { stiffness } => 0.5 * stiffness * overlap * overlap,
            NormalLaw::Hertz => 0.4 * self.hertz_stiffness() * overlap * overlap * overlap.sqrt(),
        }
    }
}
