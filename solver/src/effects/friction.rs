//! Coulomb friction: the tangential impulse stays in a disc of radius `mu lambda_n`.
//!
//! For two spheres the tangential operator is isotropic and does not couple with the normal, so the projection of the
//! unconstrained impulse onto the disc is the exact solution of the one-contact problem: no box, no cone of facets.
//!
//! A contact that slides may have a smaller coefficient than one that sticks: Coulomb's `mu_k <= mu_s`. Which of the two it has is
//! decided when it is set up, once a step,
//!
//! ```text
//! mu = mu_k    if |u_t| > g h    with u_t at the start of the step
//! mu = mu_s    otherwise
//! ```
//!
//! so that sweeps know one coefficient and a contact takes no more memory. A contact that stuck in the last step has no speed but
//! what the solve left open, which is measured in g h (g is the largest of the run). So a contact that slides sticks again
//! once friction has slowed it below g h, and one that begins to slide keeps mu_s until its speed is above g h: at an
//! acceleration a that takes g/a steps. Both shrink with h, and the law becomes that of two coefficients. A solve that
//! leaves more than g h open takes sticking contacts for sliding ones.

use super::catalogue::{
    Absent, Call, Ceiling, Change, Coefficient, Combination, Effect, SMALLER, Trigger, change_coefficients,
};
use crate::lanes::{Number, dot};
use crate::scene::{Material, PairRule};

/// Coulomb friction.
pub static FRICTION: Effect = Effect {
    name: "Coulomb friction",
    coefficients: &[Coefficient {
        key: "friction",
        unit: "(no unit)",
        range: [0.0, 1e9],
        ceiling: None,
        absent: Absent::Refused,
        off: Some(0.0),
        of_material: |one| Some(one.friction),
        of_rule: |rule| rule.friction,
    }],
    combination: Some(Combination {
        words: SMALLER,
        combine: |pair, contact| contact.friction = pair.value(|rule| rule.friction, |one| one.friction),
    }),
    trigger: Trigger::Contacts { acts: |contact| contact.friction > 0.0, without: "grains are smooth" },
    off: Some(Change {
        words: "off",
        apply: |scene| {
            change_coefficients(
                scene,
                |one| (one.friction, one.kinetic_friction) = (0.0, None),
                |rule| (rule.friction, rule.kinetic_friction) = (None, None),
            );
        },
    }),
    tried: None,
    member: Some(|set| &mut set.friction),
};

/// Friction that is less while a contact slides.
pub static KINETIC_FRICTION: Effect = Effect {
    name: "kinetic friction",
    coefficients: &[Coefficient {
        key: "kinetic_friction",
        unit: "(no unit)",
        range: [0.0, 1e9],
        ceiling: Some(Ceiling {
            words: "the friction of what sticks",
            of_material: |one| one.friction,
            of_contact: |contact| contact.friction,
        }),
        absent: Absent::SameAs("friction"),
        off: None,
        of_material: |one| one.kinetic_friction,
        of_rule: |rule| rule.kinetic_friction,
    }],
    combination: Some(Combination {
        words: "the same, a pair's own `friction` counting for it; no more than `friction`",
        combine: |pair, contact| {
            let of_rule = |rule: &PairRule| rule.kinetic_friction.or(rule.friction);
            let of_material = |one: &Material| one.kinetic_friction.unwrap_or(one.friction);
            contact.kinetic_friction = pair.value(of_rule, of_material).min(contact.friction);
        },
    }),
    trigger: Trigger::Contacts {
        acts: |contact| contact.kinetic_friction < contact.friction,
        without: "friction is the same for what sticks and what slides",
    },
    off: Some(Change {
        words: "off",
        apply: |scene| {
            change_coefficients(scene, |one| one.kinetic_friction = None, |rule| rule.kinetic_friction = None)
        },
    }),
    tried: None,
    member: Some(|set| &mut set.kinetic_friction),
};

/// Spin of grains: it goes with friction, since nothing else turns a grain.
pub static SPIN: Effect = Effect::of_scene("spin", |scene| match FRICTION.called_by(scene) {
    Ok(call) => Ok(Call { why: "friction turns grains".into(), ..call }),
    Err(_) => Err("without friction nothing turns a grain"),
});

/// Speed (m/s) that rounding may leave to a contact that sticks, where there is no gravity to compare with.
const ROUNDING: f64 = 1e-9;

/// Speed above which a contact slides, m/s, for a gravity (m/s2) and a step (s).
pub fn slip_speed(gravity: f64, step: f64) -> f64 {
    (gravity * step).max(ROUNDING)
}

/// Coefficient of a contact that slides with the tangential velocity `sliding` (m/s), or sticks if that is no more than `slip`.
#[inline(always)]
pub fn while_sliding<N: Number>(sticking: N, kinetic: N, sliding: [N; 3], slip: N) -> N {
    N::select((slip * slip).below(dot(sliding, sliding)), kinetic, sticking)
}

/// Factor by which the impulse (x, y, z) must shrink to lie in a disc of the given radius.
#[inline(always)]
pub fn disc_shrinkage<N: Number>(impulse: [N; 3], radius: N) -> N {
    let square = impulse[0] * impulse[0] + impulse[1] * impulse[1] + impulse[2] * impulse[2];
    let inside = square.at_most(radius * radius);
    // Where it lies inside, the quotient may be 0/0; the selection leaves it out.
    N::select(inside, N::splat(1.0), radius / square.sqrt())
}
