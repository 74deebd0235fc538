//! Tangential spring: the tangential force of a contact before it slides.
//!
//! Without the spring, a sticking contact is rigid in the tangential direction: within one step, friction brings the
//! two surfaces to relative rest. With the spring, a stiffness k_t joins the surfaces, and Coulomb's disc limits the
//! force. A spring with the impulse lambda_p in the last step transmits, with the displacement `h u_t` of this step,
//!
//! ```text
//! lambda_t = lambda_p - h^2 k_t u_t      that is      u_t + Sigma_t lambda_t - b = 0
//! Sigma_t  = 1 / (h^2 k_t)                            b = Sigma_t lambda_p
//! ```
//!
//! while the contact sticks, and the projection onto the disc of radius `mu lambda_n` follows, as without a spring; lambda_n is the total normal
//! impulse. lambda_p is rotated into the new tangent plane. Velocities are those at the end of the step (implicit Euler). If the step is long
//! compared with the contact time, `k_t h^2 >> m`, the spring is damped within the step, and the contact sticks as a rigid contact does.
//!
//! The stiffness is in proportion to that of the normal contact at its depth. For Hertz's contact, R. D. Mindlin,
//! Journal of Applied Mechanics 16 (1949), gives
//!
//! ```text
//! k_t / k_n = 8 G* a / (2 E* a) = 4 G* / E*           1/G* = (2 - nu1)/G1 + (2 - nu2)/G2      G = E / (2 (1 + nu))
//! ```
//!
//! with the radius a of the contact: `2 (1 - nu)/(2 - nu)` for two bodies of one material. An unresolved impact ends
//! within the step. Such an impact is also rigid in the tangential direction, and its impulse does not load the spring.

use super::catalogue::{Call, Change, Effect};
use super::friction::{Coulomb, FRICTION, FrictionLanes};
use super::term::{ContactTerm, NormalLoad, Tangential, TangentialTerm, TermStart};
use crate::lanes::{Eight, Number, dot, minus, plus, times};
use crate::laws::compliance::NormalConstraint;
use crate::scene::{DocumentPath, Material, TangentialLaw};

/// Tangential spring.
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
    /// Returns the ratio of tangential to normal stiffness for two materials.
    pub fn stiffness_ratio(self, [first, second]: [&Material; 2]) -> f64 {
        match self {
            TangentialLaw::Spring { stiffness_ratio: Some(ratio) } => ratio,
            _ => mindlin_ratio([first, second]),
        }
    }
}

/// Returns Mindlin's ratio `4 G*/E*`.
fn mindlin_ratio(materials: [&Material; 2]) -> f64 {
    let normal = |one: &Material| (1.0 - one.poisson_ratio * one.poisson_ratio) / one.youngs_modulus;
    let across = |one: &Material| (2.0 - one.poisson_ratio) * 2.0 * (1.0 + one.poisson_ratio) / one.youngs_modulus;
    let sum = |of: fn(&Material) -> f64| materials.into_iter().map(of).sum::<f64>();
    4.0 * sum(normal) / sum(across)
}

/// Returns Sigma_t (1/kg) of contacts with a tangential stiffness of `ratio` times the normal one, in a step h (s);
/// zero for an unresolved impact, which is infinitely stiff in the normal direction too.
#[inline(always)]
pub fn tangential_compliance<N: Number>(constraint: &NormalConstraint<N>, ratio: N, step: f64) -> N {
    N::splat(1.0 / (step * step)) / (ratio * constraint.stiffness)
}

/// Tangential part of contacts with a spring.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct SpringLanes<S = Eight> {
    /// Friction coefficients and tangential impulses.
    pub friction: FrictionLanes<S>,
    /// Spring terms.
    pub spring: SpringTerms<S>,
}

/// Tangential springs of eight contacts.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct SpringTerms<S = Eight> {
    /// Compliances Sigma_t, 1/kg.
    pub compliance: S,
    /// Tangential biases b, m/s.
    pub bias: [S; 3],
}

impl<S: Copy + Default> Tangential<S> for SpringLanes<S> {
    #[inline(always)]
    fn lanes(&self) -> Option<&FrictionLanes<S>> {
        Some(&self.friction)
    }

    #[inline(always)]
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<S>> {
        Some(&mut self.friction)
    }

    #[inline(always)]
    fn spring(&self) -> Option<&SpringTerms<S>> {
        Some(&self.spring)
    }

    /// The impulse of the last step is also the load of the spring.
    #[inline(always)]
    fn fill<N: Number>(&mut self, start: &TermStart<'_, N>, number: impl Fn(N, &mut S)) {
        self.friction.fill(start, &number);
        let Some(ratio) = start.stiffness_ratio else { return };
        let compliance = tangential_compliance(start.constraint, ratio, start.step);
        let held = N::select(start.active, compliance, N::zero());
        number(compliance, &mut self.spring.compliance);
        for (component, lanes) in start.last_impulse.into_iter().zip(&mut self.spring.bias) {
            number(component * held, lanes);
        }
    }

    /// Returns the impulses for the warm start; zero after an unresolved impact, because such an impact does not load the spring.
    #[inline(always)]
    fn remembered<N: Number>(&self, number: impl Fn(&S) -> N) -> [N; 3] {
        let springy = N::zero().below(number(&self.spring.compliance));
        self.friction.impulse.each_ref().map(|component| N::select(springy, number(component), N::zero()))
    }
}

/// Friction with a spring in a kernel.
#[derive(Clone, Copy)]
pub struct Sprung<N>(Coulomb<N, true>, SpringTerms<N>);

impl<N: Number> ContactTerm<N> for Sprung<N> {
    const ACTS: bool = true;

    #[inline(always)]
    fn project(&self, impulse: [N; 3], load: NormalLoad<N>) -> [N; 3] {
        self.0.project(impulse, load)
    }

    #[inline(always)]
    fn operator(&self, rigid: N) -> N {
        rigid + self.1.compliance
    }

    #[inline(always)]
    fn residual(&self, velocity: [N; 3], impulse: [N; 3]) -> [N; 3] {
        plus(velocity, minus(times(impulse, self.1.compliance), self.1.bias))
    }
}

impl<N: Number> TangentialTerm<N> for Sprung<N> {
    #[inline(always)]
    fn read<S>(lanes: &impl Tangential<S>, number: impl Fn(&S) -> N) -> Self {
        let none = SpringTerms { compliance: N::zero(), bias: [N::zero(); 3] };
        let spring = lanes.spring().map_or(none, |terms| SpringTerms {
            compliance: number(&terms.compliance),
            bias: terms.bias.each_ref().map(&number),
        });
        Sprung(Coulomb::read(lanes, number), spring)
    }

    #[inline(always)]
    fn coefficient(&self) -> N {
        self.0.coefficient()
    }
}

impl SpringTerms {
    /// Removes the spring of the contact in a lane for a step.
    pub(crate) fn make_rigid(&mut self, lane: usize) {
        self.compliance.0[lane] = 0.0;
        self.bias.iter_mut().for_each(|component| component.0[lane] = 0.0);
    }

    /// Returns the energy (J) that the spring of the contact in a lane stores in a step with a final impulse (N s).
    pub(crate) fn taken_up(&self, lane: usize, impulse: [f64; 3]) -> f64 {
        let compliance = self.compliance.0[lane];
        let square: f64 = self.bias.iter().map(|component| component.0[lane] * component.0[lane]).sum();
        let held = if compliance > 0.0 { 0.5 * square / compliance } else { 0.0 };
        0.5 * compliance * dot(impulse, impulse) - held
    }
}
