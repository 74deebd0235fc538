//! Cohesion: a constant attractive force between two grains, or a grain and a wall, at gaps below a range.
//!
//! The force `F` acts along the normal at every gap below its range `l`, overlaps included, and is therefore
//! conservative, with the potential `F (gap - l)`. Together with the elastic force of the overlap, it is the contact of
//! Derjaguin, Muller & Toporov (J. Colloid Interface Sci. 53, 1975) with a range. The impulse of a contact is the
//! repulsion alone, so that friction at rest is `mu (N + F)` and a contact resists a net tension of up to `F`.
//!
//! The force is constant over a step, like gravity: it changes velocities before the sweeps, which are independent of
//! cohesion and need no additional time.
//!
//! For a work of adhesion `w` (J/m2), force and range follow from Johnson, Kendall & Roberts (Proc. R. Soc. A 324,
//! 1971): the pull-off force `3/2 pi w R*` and the separation at which a neck breaks, `a0^2 / (2 6^(1/3) R*)` with
//! `a0^3 = 9 pi w R*^2 / (2 E*)` (Chokshi, Tielens & Hollenbach, Astrophys. J. 407, 1993, where the work is 2 gamma).
//! Unlike in their model, the force also acts on approach. With a range of 0, the law is the contact of Derjaguin,
//! Muller & Toporov alone, for a work of adhesion of `3/4 w`: their pull-off force is `2 pi w R*`.

use serde::{Deserialize, Serialize};

/// Gap over the effective radius below which two bodies are in contact: between rigid bodies at rest, rounding leaves gaps and overlaps alike.
const TOUCH: f64 = 1e-6;

/// Cohesion of two materials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Cohesion {
    /// Equal force for all sizes.
    Constant {
        /// Attractive force, N.
        force: f64,
        /// Largest gap at which it acts, m; at least a millionth of the effective radius.
        #[serde(default)]
        range: f64,
    },
    /// Force and range from the work of adhesion.
    SurfaceEnergy {
        /// Work of adhesion, J/m2.
        work: f64,
        /// Largest gap of the force, m; default: the gap at which a neck breaks. 0: the force ends with the contact.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        range: Option<f64>,
    },
}

/// Cohesive force of one contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pull {
    /// Force, N.
    pub force: f64,
    /// Largest gap of the force, m.
    pub range: f64,
}

impl Cohesion {
    /// Returns the cohesive force of a contact with effective radius R* (m) and effective modulus E* (Pa).
    pub fn pull(&self, effective_radius: f64, effective_modulus: f64) -> Pull {
        match *self {
            Cohesion::Constant { force, range } => Pull { force, range: range.max(TOUCH * effective_radius) },
            Cohesion::SurfaceEnergy { work, range } => {
                let torn = || {
                    let cube =
                        4.5 * std::f64::consts::PI * work * effective_radius * effective_radius / effective_modulus;
                    let neck = libm::cbrt(cube);
                    neck * neck / (2.0 * libm::cbrt(6.0) * effective_radius)
                };
                Pull {
                    force: 1.5 * std::f64::consts::PI * work * effective_radius,
                    range: range.map_or_else(torn, |range| range.max(TOUCH * effective_radius)),
                }
            }
        }
    }

    /// Returns the weaker of two cohesions, compared by the force at an effective radius of one metre.
    pub fn weaker(self, other: Cohesion) -> Cohesion {
        let force = |one: &Cohesion| one.pull(1.0, 1.0).force;
        if force(&other) < force(&self) { other } else { self }
    }
}

impl Pull {
    /// Returns the potential energy (J) at a gap (m): zero beyond the range.
    pub fn energy(&self, gap: f64) -> f64 {
        self.force * (gap - self.range).min(0.0)
    }

    /// Returns the impulse (N s) of a step of length `h` (s) at a gap (m).
    pub fn impulse(&self, gap: f64, h: f64) -> f64 {
        if gap <= self.range { self.force * h } else { 0.0 }
    }
}
