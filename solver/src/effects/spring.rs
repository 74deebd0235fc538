//! The tangential spring: what a contact gives across its normal before it slides.
//!
//! Without it a contact that sticks is rigid across the normal: within one step friction brings the two surfaces to rest against each
//! other. With it the surfaces are joined by a spring of stiffness k_t, which Coulomb's disc caps. A spring that bore the impulse
//! lambda_p in the last step bears, with the displacement `h u_t` of this one,
//!
//! ```text
//! lambda_t = lambda_p - h^2 k_t u_t      that is      u_t + Sigma_t lambda_t - b = 0
//! Sigma_t  = 1 / (h^2 k_t)                            b = Sigma_t lambda_p
//! ```
//!
//! while it sticks, and the projection onto the disc of radius `mu lambda_n` follows, as without a spring; lambda_n is the whole
//! normal impulse. lambda_p is turned into the new tangent plane. Velocities are those at the end of the step (implicit Euler): where a
//! step is long against the contact, `k_t h^2 >> m`, the spring is damped within it, and the contact sticks as a rigid one does.
//!
//! The stiffness is in proportion to that of the normal contact at its depth. For Hertz's contact R. D. Mindlin, Journal of Applied
//! Mechanics 16 (1949), has
//!
//! ```text
//! k_t / k_n = 8 G* a / (2 E* a) = 4 G* / E*           1/G* = (2 - nu1)/G1 + (2 - nu2)/G2      G = E / (2 (1 + nu))
//! ```
//!
//! with the radius a of the contact: `2 (1 - nu)/(2 - nu)` for two of one material. An impact that the step does not resolve is over
//! within it. It is rigid across the normal too, and what it bore is no load of the spring.

use super::catalogue::{Call, Change, Effect};
use super::compliance::NormalConstraint;
use super::friction::FRICTION;
use crate::lanes::Number;
use crate::scene::{DocumentPath, Material};
use serde::{Deserialize, Serialize};

/// Law of a sticking contact across its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum TangentialLaw {
    /// No compliance.
    #[default]
    Rigid,
    /// Spring capped by Coulomb's law; requires a compliant normal contact, Gauss-Seidel and double precision.
    Spring {
        /// Stiffness over that of the normal contact; default: Mindlin's, from Poisson's ratios.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stiffness_ratio: Option<f64>,
    },
}

/// The tangential spring.
pub static TANGENTIAL_SPRING: Effect = Effect {
    off: Some(Change { words: "off: rigid", apply: |scene| scene.solver.tangential_law = TangentialLaw::Rigid }),
    member: Some(|set| &mut set.spring),
    ..Effect::of_scene("tangential spring", |scene| {
        let why = match scene.solver.tangential_law {
            TangentialLaw::Rigid => return Err("solver.tangential_law is rigid"),
            TangentialLaw::Spring { .. } if FRICTION.called_by(scene).is_err() => {
                return Err("grains are smooth");
            }
            TangentialLaw::Spring { stiffness_ratio: None } => "Mindlin's stiffness".into(),
            TangentialLaw::Spring { stiffness_ratio: Some(ratio) } => format!("{ratio} of the normal stiffness"),
        };
        Ok(Call { why, place: DocumentPath::default().key("solver").key("tangential_law") })
    })
};

impl TangentialLaw {
    /// Stiffness across the normal over that along it, for two materials.
    pub fn stiffness_ratio(self, [first, second]: [&Material; 2]) -> f64 {
        match self {
            TangentialLaw::Spring { stiffness_ratio: Some(ratio) } => ratio,
            _ => mindlin_ratio([first, second]),
        }
    }
}

/// Mindlin's `4 G*/E*`.
fn mindlin_ratio(materials: [&Material; 2]) -> f64 {
    let normal = |one: &Material| (1.0 - one.poisson_ratio * one.poisson_ratio) / one.youngs_modulus;
    let across = |one: &Material| (2.0 - one.poisson_ratio) * 2.0 * (1.0 + one.poisson_ratio) / one.youngs_modulus;
    let sum = |of: fn(&Material) -> f64| materials.into_iter().map(of).sum::<f64>();
    4.0 * sum(normal) / sum(across)
}

/// Sigma_t (1/kg) of contacts whose stiffness is a `ratio` of that along the normal, in a step h (s); zero for an impact that is over
/// within the step, which is infinitely stiff along the normal too.
#[inline(always)]
pub fn tangential_compliance<N: Number>(constraint: &NormalConstraint<N>, ratio: N, step: f64) -> N {
    N::splat(1.0 / (step * step)) / (ratio * constraint.stiffness)
}
