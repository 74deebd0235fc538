//! Elastic compliance of the normal contact, and the stabilisation of its overlap.
//!
//! SPOOK (Lacoursière 2007) treats an overlap d as a constraint of compliance eps and damping time tau. With
//! `Y = 1/(1 + 4 tau/h)`, the regularisation of a contact is `Sigma' = 4 Y eps/h^2` and its bias is
//! `q = (4/h) Y d + Y u_n0`. The velocity u_n0 is the normal velocity at the start of the step.
//!
//! Hertz's potential `2/5 k_H d^(5/2)` equals `g^2/(2 eps)` with `g = d^(5/4)` and `eps = 5/(4 k_H)` (up to the sign of
//! g). Division of the constraint by dg/dd = (5/4) d^(1/4) leaves the overlap 0.8 d and the compliance
//! `1/(1.25 k_H sqrt(d))`. At rest, the force is again `k_H d^(3/2)`.

use crate::lanes::Number;
use serde::{Deserialize, Serialize};

/// Law of the normal contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum NormalLaw {
    /// No compliance.
    Rigid,
    /// Linear spring.
    Linear {
        /// Stiffness, N/m.
        stiffness: f64,
    },
    /// Hertz's law, from the materials.
    Hertz,
}

/// Smallest overlap for the stiffness, as a fraction of the effective radius: a Hertzian contact would otherwise have
/// zero stiffness at first contact.
const SMALLEST_RELATIVE_OVERLAP: f64 = 1e-5;

/// Steps shorter than this, times the frequency `sqrt(k/m)` of a contact, resolve its impact for any damping: a contact
/// lasts for more than 30 such steps.
const SHORT_STEP: f64 = 0.1;

/// Square of the frequency of a contact times h above which a step does not resolve an impact for any damping. At the
/// limit, the depth of the impact is the approach in one step; by Hertz's law, the impact lasts for 2.9 steps.
const LARGEST_SQUARED_ADVANCE: f64 = 1.5625;

/// Ratio of Hertz's dF/dd = 3/2 k_H sqrt(d) to the stiffness 5/4 k_H sqrt(d) of the constraint function.
const HERTZ_TANGENT: f64 = 1.2;

/// Largest gap of a candidate contact, in free-fall distances of a step: a grain at rest falls that far in three steps.
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
    /// Approach speed below which contacts are at rest, m/s.
    pub restitution_threshold: f64,
    /// Gravity, m/s2.
    pub gravity: f64,
}

impl NormalScheme {
    /// Returns the free-fall distance of a step from rest, `g h^2/2`, m.
    #[inline(always)]
    pub fn fall(&self) -> f64 {
        0.5 * self.gravity * self.step * self.step
    }

    /// Returns the largest gap (m) of a contact that may become active in a step, for the stiffest contact of the scene.
    ///
    /// A contact that opens by less than the free fall of a step closes in the next. If the contact is stiff for the
    /// step, its omission would remove its friction in every other step, and beds would creep to higher density. A
    /// contact with a resolved impact needs no margin: opening and closing are physical.
    pub fn contact_margin(&self, stiffest: &NormalContact<f64>) -> f64 {
        match self.law {
            NormalLaw::Rigid => (self.restitution_threshold + self.gravity * self.step) * self.step,
            _ if stiffest.constraint(self, 0.0).resolves_impact => 0.0,
            _ => MARGIN_IN_FALLS * self.fall(),
        }
    }
}

/// Regularisation and bias of a normal constraint.
#[derive(Clone, Copy, Debug)]
pub struct NormalConstraint<N: Number> {
    /// Sigma', 1/kg.
    pub regularisation: N,
    /// q, m/s.
    pub bias: N,
    /// Stiffness dF/dd at the depth of the constraint, N/m; infinite for a rigid contact.
    pub stiffness: N,
    /// True if the step resolves an impact, so that compliance and damping give the restitution.
    pub resolves_impact: N::Mask,
    /// True if the step is long compared with the contact time, so that an impact lasts for few steps or ends within one.
    pub is_coarse: N::Mask,
    /// Twice the elastic energy of the overlap, J; zero for a rigid contact.
    pub stored: N,
}

/// Geometry and material of one contact, or of eight contacts.
#[derive(Clone, Copy, Debug)]
pub struct NormalContact<N> {
    /// Overlap d, m; negative for a gap.
    pub overlap: N,
    /// Normal velocity at the start of the step, m/s; positive in separation.
    pub velocity: N,
    /// Effective modulus E*, Pa.
    pub effective_modulus: N,
    /// Effective radius R*, m.
    pub effective_radius: N,
    /// Inverse of the effective mass, `1/m_a + 1/m_b`, 1/kg.
    pub inverse_mass: N,
    /// Damping ratio of an impact, relative to critical damping: see [`damping_ratio`].
    pub damping_ratio: N,
}

/// Returns the effective radius (m) of two spheres, `a b / (a + b)`.
#[inline(always)]
pub(crate) fn effective_radius<N: Number>(first: N, second: N) -> N {
    first * second / (first + second)
}

/// Returns the damping ratio, in [0, 10], of an impact without attraction and with the restitution `e`.
///
/// A linear spring and dashpot with a contact that ends at zero force (Schwager & Pöschel, Granular Matter 9, 2007) has
/// `ln e = -z/w (pi - atan2(2 z w, 1 - 2 z^2))` with `w = sqrt(1 - z^2)`, continued beyond z = 1. Hertz's law with
/// damping in proportion to `d^(1/4)` has the same restitution at any speed. With `x = d^(5/4)` and the time
/// `ds = d^(1/4) dt`, the law is a linear oscillator of `w0^2 = 5/4 k_H/m` (after Antypov & Elliott, EPL 94, 2011).
pub fn damping_ratio(restitution: f64) -> f64 {
    // At this limit, the restitution is 0.0025. More damping would make contacts creep: their relaxation time is 2 zeta/w.
    const LARGEST: f64 = 10.0;
    let target = libm::log(restitution.max(1e-300));
    let (mut low, mut high) = (0.0, LARGEST);
    // The logarithm of e decreases with z: bisection down to rounding.
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
    /// Returns regularisation and bias by the law of the scheme, from the speed of the impact in progress (m/s), or 0.
    ///
    /// The depth `v0 h` of the approach in one step decides, for the duration of the impact, whether the step resolves the
    /// impact. At this depth, the frequency of the contact times h gives the number of steps n of the impact at any speed: for
    /// Hertz's law `(2.94/n)^(5/4) 5/4`, and `pi/n` for a linear spring. For a contact at rest, the present depth is used.
    ///
    /// The damping time is that of the impact law, `c/k`, if the step resolves the impact or is short compared with the contact
    /// time, and `damping_steps h` otherwise: small steps converge to the viscoelastic contact of soft-sphere codes, large steps
    /// remain stable. Across a gap, the stiffness of a contact is that at its largest possible depth in this step.
    #[inline(always)]
    pub fn constraint(&self, scheme: &NormalScheme, impact_speed: N) -> NormalConstraint<N> {
        // Divisions and roots dominate the cost, so several are combined into one of each.
        let (h, damping_steps) = (scheme.step, scheme.damping_steps);
        let one = N::splat(1.0);
        let (fall, impact) = (N::splat(scheme.fall()), N::zero().below(impact_speed));
        let ahead = self.overlap.larger(-self.velocity * N::splat(h)).larger(fall);
        let depth = N::select(self.overlap.below(N::zero()), ahead, self.overlap);
        let smallest = N::splat(SMALLEST_RELATIVE_OVERLAP) * self.effective_radius;
        // Stiffness at a depth; overlap in the constraint function.
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
        // c/k over h is 2 zeta / (h sqrt(k/m)); `damping_steps` is its lower bound unless the step is short compared with the contact time.
        let critical = N::splat(2.0) * self.damping_ratio;
        let damping_time_squared = N::splat(damping_steps * h * damping_steps * h);
        let short = N::splat(SHORT_STEP * SHORT_STEP / (h * h));
        // If no lane is near the limit of resolution, so that rounding is irrelevant, the result is complete.
        let far = N::splat(1.0 + 1e-9) * critical * critical;
        let stiff = stiffness * self.inverse_mass;
        let unresolved = far.below(stiff * damping_time_squared) & (N::splat(1.0 + 1e-9) * short).below(stiff);
        let (steps, resolves_impact, is_coarse) = if N::all(unresolved & !impact) {
            (N::splat(damping_steps), one.below(N::zero()), N::zero().below(one))
        } else {
            let frequency = stiff.sqrt() * N::splat(h);
            // The depth of the approach decides.
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
            // A step that is short compared with the contact time, or resolves the impact, needs only the damping of the contact law.
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
    /// Returns Hertz's stiffness `k_H = 4/3 E* sqrt(R*)`, N/m^1.5; the tangent stiffness of the constraint is `5/4 k_H sqrt(d)`.
    pub fn hertz_stiffness(&self) -> f64 {
        4.0 / 3.0 * self.effective_modulus * self.effective_radius.sqrt()
    }

    /// Returns the stored elastic energy, J: `1/2 k d^2` or `2/5 k_H d^(5/2)`.
    pub fn elastic_energy(&self, law: NormalLaw) -> f64 {
        let overlap = self.overlap.max(0.0);
        match law {
            NormalLaw::Rigid => 0.0,
            NormalLaw::Linear { stiffness } => 0.5 * stiffness * overlap * overlap,
            NormalLaw::Hertz => 0.4 * self.hertz_stiffness() * overlap * overlap * overlap.sqrt(),
        }
    }
}
