//! Elastic compliance of the normal contact, and the stabilisation of its overlap.
//!
//! SPOOK (Lacoursière 2007) treats an overlap d as a constraint of compliance eps and damping time tau. With
//! `Y = 1/(1 + 4 tau/h)` a contact gets the regularisation `Sigma' = 4 Y eps/h^2` and the bias
//! `q = (4/h) Y d + Y u_n0`, where u_n0 is the normal velocity at the start of the step.
//!
//! Hertz's potential `2/5 k_H d^(5/2)` equals `g^2/(2 eps)` with `g = d^(5/4)` and `eps = 5/(4 k_H)` (up to the sign of
//! g); dividing the constraint by dg/dd = (5/4) d^(1/4) leaves the overlap 0.8 d and the compliance
//! `1/(1.25 k_H sqrt(d))`. At rest this gives back `force = k_H d^(3/2)`.

use crate::lanes::Number;
use serde::{Deserialize, Serialize};

/// Law of the normal contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum NormalLaw {
    /// No compliance.
    Rigid,
    /// A linear spring.
    Linear {
        /// Stiffness, N/m.
        stiffness: f64,
    },
    /// Hertz's law, from the materials.
    Hertz,
}

/// Overlaps below this share of the effective radius are as stiff as it: the first touch of a Hertzian contact would
/// otherwise have no stiffness at all.
const SMALLEST_RELATIVE_OVERLAP: f64 = 1e-5;

/// Steps shorter than this, times the frequency `sqrt(k/m)` of a contact, resolve its impact whatever its damping: a contact lasts for
/// more than 30 of them.
const SHORT_STEP: f64 = 0.1;

/// Square of the frequency of a contact times h at which an impact goes just as deep as it comes in a step: by Hertz's law it takes 2.9
/// steps. Beyond, no damping resolves it.
const LARGEST_SQUARED_ADVANCE: f64 = 1.5625;

/// Hertz's dF/dd = 3/2 k_H sqrt(d) over the stiffness 5/4 k_H sqrt(d) of the constraint's measure.
const HERTZ_TANGENT: f64 = 1.2;

/// Largest gap of a candidate contact, in distances that gravity makes in a step: a grain at rest falls that far in three.
const MARGIN_IN_FALLS: f64 = 6.0;

/// Discretisation of contacts in the normal direction; the same for all contacts of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalScheme {
    /// Law of the normal contact.
    pub law: NormalLaw,
    /// Time step h, s.
    pub step: f64,
    /// Damping time of the stabilisation over the time step, tau / h.
    pub damping_steps: f64,
    /// Contacts that approach slower than this are at rest, m/s.
    pub restitution_threshold: f64,
    /// Gravity, m/s2.
    pub gravity: f64,
}

impl NormalScheme {
    /// Distance that gravity makes in a step from rest, `g h^2/2`, m.
    #[inline(always)]
    pub fn fall(&self) -> f64 {
        0.5 * self.gravity * self.step * self.step
    }

    /// Gap up to which a contact may still bear something in a step, m, given the stiffest contact that the scene can have.
    ///
    /// A contact that opens by less than a fall in one step closes in the next. Where it is stiff against the step, leaving it
    /// out meanwhile would take its friction away every other step, and beds would creep denser. A contact whose impact the step
    /// resolves needs no such care: it opens and closes as it would.
    pub fn contact_margin(&self, stiffest: &NormalContact<f64>) -> f64 {
        match self.law {
            NormalLaw::Rigid => (self.restitution_threshold + self.gravity * self.step) * self.step,
            _ if stiffest.constraint(self, 0.0).resolves_impact => 0.0,
            _ => MARGIN_IN_FALLS * self.fall(),
        }
    }
}

/// Regularisation and bias of a contact's normal constraint.
#[derive(Clone, Copy, Debug)]
pub struct NormalConstraint<N: Number> {
    /// Sigma', 1/kg.
    pub regularisation: N,
    /// q, m/s.
    pub bias: N,
    /// Stiffness dF/dd at the depth that the constraint goes by, N/m; infinite where it is rigid.
    pub stiffness: N,
    /// True where the step resolves an impact, so that compliance and damping give the restitution.
    pub resolves_impact: N::Mask,
    /// True where the step is long against the contact, so that an impact takes few steps if it takes any.
    pub is_coarse: N::Mask,
    /// Twice the elastic energy that the overlap stores, J; zero where it is rigid.
    pub stored: N,
}

/// Geometry and material of one contact, or of eight.
#[derive(Clone, Copy, Debug)]
pub struct NormalContact<N> {
    /// Overlap d, m; negative where there is a gap.
    pub overlap: N,
    /// Normal velocity at the start of the step, m/s; positive where the two separate.
    pub velocity: N,
    /// Effective modulus E*, Pa.
    pub effective_modulus: N,
    /// Effective radius R*, m.
    pub effective_radius: N,
    /// Inverse of the effective mass, `1/m_a + 1/m_b`, 1/kg.
    pub inverse_mass: N,
    /// Damping of an impact as a share of critical damping: see [`damping_ratio`].
    pub damping_ratio: N,
}

/// Effective radius of two spheres, `a b / (a + b)`, m.
#[inline(always)]
pub(crate) fn effective_radius<N: Number>(first: N, second: N) -> N {
    first * second / (first + second)
}

/// Share of critical damping, in [0, 10], with which an impact that never attracts has the restitution `e`.
///
/// For a linear spring and dashpot whose contact ends when the force vanishes (Schwager & Pöschel, Granular Matter 9, 2007),
/// `ln e = -z/w (pi - atan2(2 z w, 1 - 2 z^2))` with `w = sqrt(1 - z^2)`, continued beyond z = 1. Hertz's law with damping
/// in proportion to `d^(1/4)` has the same restitution at any speed: with `x = d^(5/4)` and the time `ds = d^(1/4) dt` it is
/// a linear oscillator of `w0^2 = 5/4 k_H/m` (after Antypov & Elliott, EPL 94, 2011).
pub fn damping_ratio(restitution: f64) -> f64 {
    // An impact leaves with 0.0025 of its speed then. More damping would make contacts creep: they relax in 2 zeta/w.
    const LARGEST: f64 = 10.0;
    let target = libm::log(restitution.max(1e-300));
    let (mut low, mut high) = (0.0, LARGEST);
    // The logarithm of e falls with z: bisect down to rounding.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if log_restitution(middle) > target {
            low = middle;
        } else {
            high = middle;
        }
    }
    if restitution >= 1.0 { 0.0 } else { 0.5 * (low + high) }
}

fn log_restitution(z: f64) -> f64 {
    let square = 1.0 - z * z;
    if square > 1e-12 {
        let w = square.sqrt();
        -z / w * (std::f64::consts::PI - libm::atan2(2.0 * z * w, 1.0 - 2.0 * z * z))
    } else if square < -1e-12 {
        let w = (-square).sqrt();
        -z / w * libm::log((z + w) / (z - w))
    } else {
        -2.0
    }
}

impl<N: Number> NormalContact<N> {
    /// Regularisation and bias by the scheme's law, given the speed of the impact that the contact is in (m/s), or 0.
    ///
    /// An impact is resolved or not by the depth `v0 h` that its speed reaches in a step, as long as it lasts. Of that depth, the
    /// frequency of the contact times h tells the number of steps that the impact takes, whatever the speed: for Hertz's law
    /// `(2.94/n)^(5/4) 5/4`, and `pi/n` for a linear spring. A contact at rest goes by its present depth.
    ///
    /// The damping time is that of the impact law, `c/k`, wherever the step resolves it or is short against the contact, and
    /// `damping_steps h` where it is not: small steps converge to the viscoelastic contact of soft-sphere codes, large ones stay
    /// stable. Across a gap a contact is as stiff as at the depth that it can reach in this step.
    #[inline(always)]
    pub fn constraint(&self, scheme: &NormalScheme, impact_speed: N) -> NormalConstraint<N> {
        // Divisions and roots are what this costs, so there is one of each where there could be several.
        let (h, damping_steps) = (scheme.step, scheme.damping_steps);
        let one = N::splat(1.0);
        let (fall, impact) = (N::splat(scheme.fall()), N::zero().below(impact_speed));
        let ahead = self.overlap.larger(-self.velocity * N::splat(h)).larger(fall);
        let depth = N::select(self.overlap.below(N::zero()), ahead, self.overlap);
        let smallest = N::splat(SMALLEST_RELATIVE_OVERLAP) * self.effective_radius;
        // Stiffness at a depth; overlap in the constraint's measure.
        let modulus = N::splat(5.0 / 3.0) * self.effective_modulus;
        let hertz = |depth: N| modulus * (self.effective_radius * depth.larger(smallest)).sqrt();
        let (stiffness, overlap) = match scheme.law {
            NormalLaw::Rigid => {
                let damping = one / N::splat(1.0 + 4.0 * damping_steps);
                return NormalConstraint {
                    regularisation: N::zero(),
                    bias: N::splat(4.0 / h) * damping * self.overlap + damping * self.velocity,
                    stiffness: N::splat(f64::INFINITY),
                    resolves_impact: one.below(N::zero()),
                    is_coarse: N::zero().below(one),
                    stored: N::zero(),
                };
            }
            NormalLaw::Linear { stiffness } => (N::splat(stiffness), self.overlap),
            NormalLaw::Hertz => (hertz(depth), N::splat(0.8) * self.overlap),
        };
        // c/k over h is 2 zeta / (h sqrt(k/m)); it never falls below `damping_steps` unless the step is short against the contact.
        let critical = N::splat(2.0) * self.damping_ratio;
        let damping_time_squared = N::splat(damping_steps * h * damping_steps * h);
        let short = N::splat(SHORT_STEP * SHORT_STEP / (h * h));
        // Where no lane resolves its impact by far, so that rounding does not matter, that is all there is to know.
        let far = N::splat(1.0 + 1e-9) * critical * critical;
        let stiff = stiffness * self.inverse_mass;
        let unresolved = far.below(stiff * damping_time_squared) & (N::splat(1.0 + 1e-9) * short).below(stiff);
        let (steps, resolves_impact, is_coarse) = if N::all(unresolved & !impact) {
            (N::splat(damping_steps), one.below(N::zero()), N::zero().below(one))
        } else {
            let frequency = stiff.sqrt() * N::splat(h);
            // The depth that the approach reaches decides.
            let reached = N::select(impact, (impact_speed * N::splat(h)).larger(fall), ahead);
            let stiffness_ahead = match scheme.law {
                NormalLaw::Hertz => hertz(reached),
                _ => stiffness,
            };
            let ahead = stiffness_ahead * self.inverse_mass;
            let long = !ahead.below(short);
            let shallow = !(ahead * N::splat(h * h)).below(N::splat(LARGEST_SQUARED_ADVANCE));
            let damped = (ahead * damping_time_squared).below(critical * critical) & !(impact & shallow);
            let unresolved = long & !damped;
            // A step that is short against the contact, or resolves its impact, needs no damping but the contact's own.
            let least = N::select(long & !(impact & !unresolved), N::splat(damping_steps), N::zero());
            ((critical / frequency).larger(least), !unresolved, long)
        };
        let softened = one / ((one + N::splat(4.0) * steps) * stiffness);
        let damping = softened * stiffness;
        NormalConstraint {
            regularisation: N::splat(4.0 / (h * h)) * softened,
            bias: N::splat(4.0 / h) * damping * overlap + damping * self.velocity,
            stiffness: match scheme.law {
                NormalLaw::Hertz => N::splat(HERTZ_TANGENT) * stiffness,
                _ => stiffness,
            },
            resolves_impact,
            is_coarse,
            stored: stiffness * overlap * overlap,
        }
    }
}

impl NormalContact<f64> {
    /// Hertz's stiffness `k_H = 4/3 E* sqrt(R*)`, N/m^1.5; the tangent stiffness of the constraint is `5/4 k_H sqrt(d)`.
    pub fn hertz_stiffness(&self) -> f64 {
        4.0 / 3.0 * self.effective_modulus * self.effective_radius.sqrt()
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
