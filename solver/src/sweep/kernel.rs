//! One relaxation of one lane group: eight contacts that share no body.
//!
//! For a contact with unit normal n from a to b, relative velocity u at the contact and surface speeds s = r omega,
//!
//! ```text
//! u        = v_b - v_a - (s_a + s_b) x n
//! lambda_n = max(0, lambda_n + w (q - n.u - Sigma' lambda_n) / (S_n + Sigma'))      S_n = 1/m_a + 1/m_b
//! lambda_t = P_{mu lambda_n}[ lambda_t - w u_t / S_t ]                              S_t = 3.5 S_n
//! P        = d(lambda_n) n + d(lambda_t)
//! v_a -= P/m_a   v_b += P/m_b   s_a -= 2.5/m_a n x P   s_b -= 2.5/m_b n x P
//! ```
//!
//! A contact's normal impulse does not change its tangential velocity (spheres), so u is computed once.

// One index runs over several arrays at once: lanes and axes.
#![allow(clippy::needless_range_loop)]

use super::lanes::{Lanes, cross, dot};
use super::residual::GroupResidual;
use crate::effects::friction::disc_shrinkage;
use crate::partition::{ContactLanes, PairGroup, WallGroup};
use crate::world::{Body, LANES};

/// Inverse of `I/(m r^2)` for a solid sphere.
const INVERSE_INERTIA: f64 = 2.5;

/// Eight bodies, transposed.
struct EightBodies {
    velocity: [Lanes; 3],
    inverse_mass: Lanes,
    surface_speed: [Lanes; 3],
}

#[inline(always)]
fn load<const FRICTION: bool>(bodies: &[Body], indices: &[u32; LANES]) -> EightBodies {
    let mut out = EightBodies {
        velocity: [Lanes::default(); 3],
        inverse_mass: Lanes::default(),
        surface_speed: [Lanes::default(); 3],
    };
    for lane in 0..LANES {
        // SAFETY: `partition` writes indices of bodies or of the dummies behind them, and nothing else.
        let body = unsafe { bodies.get_unchecked(indices[lane] as usize) };
        for axis in 0..3 {
            out.velocity[axis].0[lane] = body.velocity[axis];
            if FRICTION {
                out.surface_speed[axis].0[lane] = body.surface_speed[axis];
            }
        }
        out.inverse_mass.0[lane] = body.inverse_mass;
    }
    out
}

#[inline(always)]
fn store<const FRICTION: bool>(bodies: &mut [Body], indices: &[u32; LANES], eight: &EightBodies) {
    for lane in 0..LANES {
        // SAFETY: as in `load`.
        let body = unsafe { bodies.get_unchecked_mut(indices[lane] as usize) };
        for axis in 0..3 {
            body.velocity[axis] = eight.velocity[axis].0[lane];
            if FRICTION {
                body.surface_speed[axis] = eight.surface_speed[axis].0[lane];
            }
        }
    }
}

/// Adds `sign` times an impulse to eight bodies; `lever` is n x P.
#[inline(always)]
fn push<const FRICTION: bool>(eight: &mut EightBodies, sign: f64, impulse: [Lanes; 3], lever: [Lanes; 3]) {
    let spin_factor = eight.inverse_mass * Lanes::splat(-INVERSE_INERTIA);
    let factor = eight.inverse_mass * Lanes::splat(sign);
    for axis in 0..3 {
        eight.velocity[axis] = eight.velocity[axis] + impulse[axis] * factor;
        if FRICTION {
            eight.surface_speed[axis] = eight.surface_speed[axis] + lever[axis] * spin_factor;
        }
    }
}

/// The one-contact solution of eight contacts: updates their impulses and returns the change.
#[inline(always)]
fn relax<const FRICTION: bool, const MEASURE: bool>(
    contacts: &mut ContactLanes,
    velocity: [Lanes; 3],
    inverse_mass: Lanes,
    relaxation: Lanes,
    residual: &mut GroupResidual,
) -> [Lanes; 3] {
    let normal = contacts.normal;
    // Normal impulse, projected onto repulsion.
    let normal_velocity = dot(normal, velocity);
    let operator = inverse_mass + contacts.regularisation;
    let violation = contacts.bias - normal_velocity - contacts.regularisation * contacts.impulse_normal;
    let updated = (contacts.impulse_normal + relaxation * violation / operator).at_least_zero();
    let change = updated - contacts.impulse_normal;
    contacts.impulse_normal = updated;
    if MEASURE {
        residual.add_normal(change * operator);
    }
    let mut impulse = [normal[0] * change, normal[1] * change, normal[2] * change];
    if FRICTION {
        // Tangential impulse, projected onto the Coulomb disc.
        let operator = inverse_mass * Lanes::splat(1.0 + INVERSE_INERTIA);
        let step = -(relaxation / operator);
        let mut target = [Lanes::default(); 3];
        for axis in 0..3 {
            let tangential = velocity[axis] - normal[axis] * normal_velocity;
            target[axis] = contacts.impulse_tangential[axis] + tangential * step;
        }
        let shrinkage = disc_shrinkage(target, contacts.friction * updated);
        let mut change = [Lanes::default(); 3];
        for axis in 0..3 {
            let updated = target[axis] * shrinkage;
            change[axis] = updated - contacts.impulse_tangential[axis];
            contacts.impulse_tangential[axis] = updated;
            impulse[axis] = impulse[axis] + change[axis];
        }
        if MEASURE {
            residual.add_tangential(normal, change.map(|component| component * operator));
        }
    }
    impulse
}

/// Relaxes the contacts of pairs of grains, group after group.
#[inline(always)]
pub(super) fn sweep_pairs<const FRICTION: bool, const MEASURE: bool>(
    bodies: &mut [Body],
    groups: &mut [PairGroup],
    relaxation: f64,
    residual: &mut GroupResidual,
) {
    let relaxation = Lanes::splat(relaxation);
    for group in groups {
        let mut first = load::<FRICTION>(bodies, &group.first);
        let mut second = load::<FRICTION>(bodies, &group.second);
        // Relative velocity at the contact.
        let mut velocity = [Lanes::default(); 3];
        for axis in 0..3 {
            velocity[axis] = second.velocity[axis] - first.velocity[axis];
        }
        if FRICTION {
            let mut rolling = [Lanes::default(); 3];
            for axis in 0..3 {
                rolling[axis] = first.surface_speed[axis] + second.surface_speed[axis];
            }
            let rolling = cross(rolling, group.contacts.normal);
            for axis in 0..3 {
                velocity[axis] = velocity[axis] - rolling[axis];
            }
        }
        let impulse = relax::<FRICTION, MEASURE>(
            &mut group.contacts,
            velocity,
            first.inverse_mass + second.inverse_mass,
            relaxation,
            residual,
        );
        // Both bodies take the impulse; their spins change alike.
        let lever = cross(group.contacts.normal, impulse);
        push::<FRICTION>(&mut first, -1.0, impulse, lever);
        push::<FRICTION>(&mut second, 1.0, impulse, lever);
        store::<FRICTION>(bodies, &group.first, &first);
        store::<FRICTION>(bodies, &group.second, &second);
    }
}

/// Relaxes the contacts of grains with walls, group after group.
#[inline(always)]
pub(super) fn sweep_walls<const FRICTION: bool, const MEASURE: bool>(
    bodies: &mut [Body],
    groups: &mut [WallGroup],
    relaxation: f64,
    residual: &mut GroupResidual,
) {
    let relaxation = Lanes::splat(relaxation);
    for group in groups {
        let mut grain = load::<FRICTION>(bodies, &group.body);
        // Relative velocity of the wall at the contact.
        let mut velocity = [Lanes::default(); 3];
        for axis in 0..3 {
            velocity[axis] = group.wall_velocity[axis] - grain.velocity[axis];
        }
        if FRICTION {
            let rolling = cross(grain.surface_speed, group.contacts.normal);
            for axis in 0..3 {
                velocity[axis] = velocity[axis] - rolling[axis];
            }
        }
        let impulse =
            relax::<FRICTION, MEASURE>(&mut group.contacts, velocity, grain.inverse_mass, relaxation, residual);
        let lever = cross(group.contacts.normal, impulse);
        push::<FRICTION>(&mut grain, -1.0, impulse, lever);
        store::<FRICTION>(bodies, &group.body, &grain);
    }
}

/// Gives the bodies of pairs the impulses that their contacts start from.
pub(super) fn apply_pairs<const FRICTION: bool>(bodies: &mut [Body], groups: &[PairGroup]) {
    for group in groups {
        let mut first = load::<FRICTION>(bodies, &group.first);
        let mut second = load::<FRICTION>(bodies, &group.second);
        let impulse = total_impulse(&group.contacts);
        let lever = cross(group.contacts.normal, impulse);
        push::<FRICTION>(&mut first, -1.0, impulse, lever);
        push::<FRICTION>(&mut second, 1.0, impulse, lever);
        store::<FRICTION>(bodies, &group.first, &first);
        store::<FRICTION>(bodies, &group.second, &second);
    }
}

/// Gives the bodies at walls the impulses that their contacts start from.
pub(super) fn apply_walls<const FRICTION: bool>(bodies: &mut [Body], groups: &[WallGroup]) {
    for group in groups {
        let mut grain = load::<FRICTION>(bodies, &group.body);
        let impulse = total_impulse(&group.contacts);
        push::<FRICTION>(&mut grain, -1.0, impulse, cross(group.contacts.normal, impulse));
        store::<FRICTION>(bodies, &group.body, &grain);
    }
}

/// Normal and tangential impulses of eight contacts as vectors.
#[inline(always)]
fn total_impulse(contacts: &ContactLanes) -> [Lanes; 3] {
    let mut impulse = contacts.impulse_tangential;
    for axis in 0..3 {
        impulse[axis] = impulse[axis] + contacts.normal[axis] * contacts.impulse_normal;
    }
    impulse
}
