//! Projected conjugate gradients. A historical baseline.
//!
//! Method of M. Renouf and P. Alart, *Conjugate gradient type algorithms for frictional multi-contact problems: applications to
//! granular materials*, Computer Methods in Applied Mechanics and Engineering 194 (2005), preconditioned by the operator's
//! diagonal D. With the operator S, the residual `r = b - S lambda` and projections T onto the directions that do not leave the
//! cones (each disc at its present radius),
//!
//! ```text
//! alpha    = r.p / p.S p
//! lambda  <- P(lambda + alpha p)       first the normal impulse, then the disc at that impulse
//! w, z     = T(D^-1 r), T(p)           both at the new lambda
//! p       <- w - (w.S p / p.S p) z
//! ```
//!
//! If the set of sliding and open contacts keeps changing, directions are not conjugate and nothing ensures progress: the method
//! may stall or cycle.

use super::group::{Block, ContactPass, Group, add, load, store};
use super::passes::natural_map;
use super::problem::{Tally, fit, for_each_group, part};
use super::{Method, Problem};
use crate::groups::Effects;
use crate::lanes::{Lanes, Slots, TaskSlots, dot, minus, plus, times};
use crate::partition::{ByBodies, ByStarts};
use crate::sweep::kernel::Contact;
use crate::sweep::{ResidualLevel, Residuals};
use crate::world::Body;

/// Fraction of the Coulomb disc's radius above which a contact counts as sliding.
const SLIDING: f64 = 1.0 - 1e-12;

/// Projected conjugate gradients.
#[derive(Clone, Debug, Default)]
pub(super) struct ProjectedConjugateGradients {
    /// Search direction p, then z.
    direction: Vec<Block>,
    /// Projected gradient w.
    gradient: Vec<Block>,
    /// Velocities that correspond to p.
    velocities: Vec<Body>,
    beta: f64,
    /// Descent r.p.
    descent: f64,
}

impl ProjectedConjugateGradients {
    /// Computes residual and direction at the present state. `curvature` is p.S p of the last direction.
    fn turn(&mut self, problem: &mut Problem<'_>, curvature: f64) -> Residuals {
        let workspace = &mut *problem.workspace;
        let tallies = Tally::of_tasks(&mut workspace.tallies, problem.layout);
        let vectors = [&mut self.direction, &mut self.gradient].map(|vector| ByStarts::of(vector, &workspace.starts));
        let (bodies, velocities) = (Slots::of(problem.bodies), Slots::of(&self.velocities));
        let shares = (vectors, tallies);
        for_each_group(
            problem.layout,
            problem.relaxation,
            problem.team,
            shares,
            |_, ([direction, gradient], tally)| Turn { bodies, velocities, direction, gradient, tally },
        );
        let total = Tally::total(&workspace.tallies);
        let [conjugate, along_gradient, along_direction] = total.sums();
        self.beta = if curvature > 0.0 { -conjugate / curvature } else { 0.0 };
        self.descent = along_gradient + self.beta * along_direction;
        if self.descent <= 0.0 {
            (self.beta, self.descent) = (0.0, along_gradient);
        }
        total.residual.finish(problem.layout.contacts)
    }

    /// Computes p = w + beta z and the corresponding velocities; returns p.S p.
    fn aim(&mut self, problem: &mut Problem<'_>) -> f64 {
        for body in &mut self.velocities {
            (body.velocity, body.scaled_spin) = ([0.0; 3], [0.0; 3]);
        }
        let workspace = &mut *problem.workspace;
        let (gradient, starts, beta) = (&self.gradient, &workspace.starts, self.beta);
        let tallies = Tally::of_tasks(&mut workspace.tallies, problem.layout);
        let shares = (ByBodies::of(&mut self.velocities), ByStarts::of(&mut self.direction, starts), tallies);
        for_each_group(
            problem.layout,
            problem.relaxation,
            problem.team,
            shares,
            |place, (velocities, direction, tally)| Aim {
                velocities,
                direction,
                gradient: &gradient[part(starts, place)],
                beta,
                tally,
            },
        );
        let velocities = &*self.velocities;
        problem.products(velocities, &[velocities])[0] + Tally::total(&problem.workspace.tallies).sums()[0]
    }

    /// Computes lambda = P(lambda + alpha p).
    fn advance(&mut self, problem: &mut Problem<'_>, alpha: f64) {
        let (bodies, direction, starts) = (ByBodies::of(problem.bodies), &self.direction, &problem.workspace.starts);
        for_each_group(problem.layout, problem.relaxation, problem.team, bodies, |place, bodies| Advance {
            bodies,
            direction: &direction[part(starts, place)],
            alpha,
        });
    }
}

impl Method for ProjectedConjugateGradients {
    fn begin(&mut self, problem: &mut Problem<'_>) {
        problem.number_groups();
        fit(&mut self.direction, problem);
        fit(&mut self.gradient, problem);
        self.direction.fill(Block::default());
        self.velocities.clear();
        self.velocities.extend_from_slice(problem.bodies);
        self.turn(problem, 0.0);
    }

    fn iterate(&mut self, problem: &mut Problem<'_>, _: ResidualLevel) -> Option<Residuals> {
        let curvature = self.aim(problem);
        if curvature > 0.0 {
            self.advance(problem, self.descent / curvature);
        }
        Some(self.turn(problem, curvature))
    }

    fn memory_bytes(&self) -> usize {
        (self.direction.capacity() + self.gradient.capacity()) * size_of::<Block>()
            + self.velocities.capacity() * size_of::<Body>()
    }
}

/// Kernel with the sums w.S p, r.w, r.z.
struct Turn<'a> {
    bodies: Slots<'a, Body>,
    velocities: Slots<'a, Body>,
    direction: &'a mut [Block],
    gradient: &'a mut [Block],
    tally: &'a mut Tally,
}

impl ContactPass for Turn<'_> {
    #[inline(always)]
    fn bodies(&self) -> Option<Slots<'_, Body>> {
        Some(self.bodies)
    }

    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G) {
        let contact = group.read::<L>();
        let normal = contact.normal;
        let (velocity, inverse_mass) = group.velocity(self.bodies, &contact, 1.0);
        let (across, _) = group.velocity(self.velocities, &contact, 0.0);
        natural_map::<L, E>(contact, velocity, inverse_mass, self.tally);
        // Residual r and S p, with normal and tangential parts.
        let direction = load::<L>(&self.direction[number]);
        let (along, along_direction, across_normal) =
            (dot(normal, velocity), dot(normal, direction), dot(normal, across));
        let residual_normal = contact.bias - along - contact.regularisation * contact.impulse_normal;
        let operated_normal = across_normal + contact.regularisation * along_direction;
        let (mut residual, mut operated) = (times(normal, residual_normal), times(normal, operated_normal));
        let operator = inverse_mass + contact.regularisation;
        let mut scaled = times(normal, residual_normal / operator);
        if E::FRICTION {
            let tangential = minus(times(normal, along), velocity);
            residual = plus(residual, tangential);
            operated = plus(operated, minus(across, times(normal, across_normal)));
            scaled = plus(scaled, times(tangential, L::splat(1.0) / contact.tangential_operator(inverse_mass)));
        }
        let gradient = along_cone::<L, E>(&contact, scaled);
        let direction = along_cone::<L, E>(&contact, direction);
        store(gradient, &mut self.gradient[number]);
        store(direction, &mut self.direction[number]);
        let [conjugate, with_gradient, with_direction] = &mut self.tally.sums;
        add(conjugate, dot(gradient, operated));
        add(with_gradient, dot(residual, gradient));
        add(with_direction, dot(residual, direction));
    }
}

/// Projects a direction so that it leaves neither repulsion nor the Coulomb disc of the present normal impulse.
///
/// The disc counts as fixed: a direction that shrinks the disc with the normal impulse would oppose the residual of a sliding
/// contact, and `r.w` could become negative.
#[inline(always)]
fn along_cone<L: Lanes, E: Effects>(contact: &Contact<L, E>, direction: [L; 3]) -> [L; 3] {
    let zero = L::zero();
    let along = dot(contact.normal, direction);
    let open = contact.impulse_normal.at_most(zero);
    let mut result = times(contact.normal, L::select(open, along.larger(zero), along));
    if E::FRICTION {
        let tangential = minus(direction, times(contact.normal, along));
        let impulse = contact.tangential.impulse;
        let (length, radius) = (dot(impulse, impulse).sqrt(), contact.disc());
        // On the rim, no radial part points outwards; a disc of radius zero has no directions.
        let outwards = (dot(impulse, tangential) / length).larger(zero) / length;
        let correction = L::select(length.below(radius * L::splat(SLIDING)), zero, outwards);
        let point = radius.at_most(zero);
        for axis in 0..3 {
            let rim = tangential[axis] - impulse[axis] * correction;
            result[axis] = result[axis] + L::select(point, zero, rim);
        }
    }
    result
}

/// Kernel with the sum of the compliant part of p.S p.
struct Aim<'a> {
    velocities: TaskSlots<'a, Body>,
    direction: &'a mut [Block],
    gradient: &'a [Block],
    beta: f64,
    tally: &'a mut Tally,
}

impl ContactPass for Aim<'_> {
    #[inline(always)]
    fn bodies(&self) -> Option<Slots<'_, Body>> {
        Some(self.velocities.to_read())
    }

    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G) {
        let contact = group.read::<L>();
        let old = load::<L>(&self.direction[number]);
        let direction = plus(load(&self.gradient[number]), times(old, L::splat(self.beta)));
        store(direction, &mut self.direction[number]);
        group.push(self.velocities, contact.normal, direction);
        let along = dot(contact.normal, direction);
        add(&mut self.tally.sums[0], contact.regularisation * along * along);
    }
}

struct Advance<'a> {
    bodies: TaskSlots<'a, Body>,
    direction: &'a [Block],
    alpha: f64,
}

impl ContactPass for Advance<'_> {
    #[inline(always)]
    fn bodies(&self) -> Option<Slots<'_, Body>> {
        Some(self.bodies.to_read())
    }

    #[inline(always)]
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G) {
        let mut contact = group.read::<L>();
        let before = contact.impulse();
        contact.set_impulse(plus(before, times(load(&self.direction[number]), L::splat(self.alpha))));
        contact.project();
        let change = minus(contact.impulse(), before);
        group.push(self.bodies, contact.normal, change);
        group.write(&contact);
    }
}
