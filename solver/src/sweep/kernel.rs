//! Relaxation of one lane group: eight contacts that share no body.
//!
//! For a contact with unit normal n from a to b, relative velocity u at the contact and scaled spins s = r omega,
//!
//! ```text
//! u        = v_b - v_a - (s_a + s_b) x n
//! lambda_n = max(0, lambda_n + (q - Sigma' lambda_n - n.u) w / (S_n + Sigma'))      S_n = 1/m_a + 1/m_b
//! lambda_t = P_{mu lambda_n}[ lambda_t - w u_t / S_t ]                              S_t = 3.5 S_n
//! P        = d(lambda_n) n + d(lambda_t)
//! v_a -= P/m_a   v_b += P/m_b   s_a -= 2.5/m_a n x P   s_b -= 2.5/m_b n x P
//! ```
//!
//! A contact's normal impulse does not change its tangential velocity (spheres), so u is computed once. The kernel computes the
//! change of the normal impulse, at least -lambda_n: all but one product and one comparison is ready before u is. With resistance
//! to rolling or twisting, the contact's angular impulse follows (`torques`). With a tangential spring, `u_t + Sigma_t lambda_t -
//! b` and `S_t + Sigma_t` replace u_t and S_t ([`spring`](crate::effects::spring)).

use super::residual::{LaneResidual, MeasuredLevel};
use crate::effects::term::{Tangential, TangentialTerm, TermState};
use crate::groups::{ContactLanes, ContactLayout, Effects, PairGroup};
use crate::lanes::{LANES, Lanes, Number, SINGLE_LANES, SingleLanes, Slots, TaskSlots, cross, dot, minus, plus, times};
use crate::partition::SingleBody;
use crate::world::{Body, INVERSE_INERTIA};

/// Velocities and inverse masses of one body, or of eight.
#[derive(Clone, Copy)]
pub(crate) struct Bodies<N> {
    pub velocity: [N; 3],
    pub inverse_mass: N,
    pub scaled_spin: [N; 3],
    pub inverse_radius: N,
}

impl<L: Lanes> Bodies<L> {
    /// Bodies at rest of infinite mass.
    #[inline(always)]
    pub fn zero() -> Self {
        let [inverse_mass, inverse_radius] = [L::zero(); 2];
        Self { velocity: [L::zero(); 3], inverse_mass, scaled_spin: [L::zero(); 3], inverse_radius }
    }

    /// Loads eight bodies of a task; without friction, their spins are not loaded.
    #[inline(always)]
    pub fn load<E: Effects>(bodies: Slots<'_, Body>, places: &[u32; LANES]) -> Self {
        let [[x, y, z, inverse_mass], [along_x, along_y, along_z, inverse_radius]] = match E::FRICTION {
            true => bodies.load_lines(places),
            false => [bodies.load_first_halves(places), [L::zero(); 4]],
        };
        Self { velocity: [x, y, z], inverse_mass, scaled_spin: [along_x, along_y, along_z], inverse_radius }
    }

    /// Stores eight bodies of a task.
    #[inline(always)]
    pub fn store<E: Effects>(self, bodies: TaskSlots<'_, Body>, places: &[u32; LANES]) {
        let ([x, y, z], [along_x, along_y, along_z]) = (self.velocity, self.scaled_spin);
        let [motion, turning] = [[x, y, z, self.inverse_mass], [along_x, along_y, along_z, self.inverse_radius]];
        match E::FRICTION {
            true => bodies.store_lines(places, [motion, turning]),
            false => bodies.store_first_halves(places, motion),
        }
    }
}

impl<S: SingleLanes> Bodies<S> {
    /// Loads sixteen bodies in single precision.
    #[inline(always)]
    pub fn load_single(bodies: Slots<'_, SingleBody>, places: &[u32; SINGLE_LANES]) -> Self {
        let [x, y, z, inverse_mass, along_x, along_y, along_z, inverse_radius] = bodies.load_octets(places);
        Self { velocity: [x, y, z], inverse_mass, scaled_spin: [along_x, along_y, along_z], inverse_radius }
    }

    /// Stores sixteen bodies in single precision.
    #[inline(always)]
    pub fn store_single(self, bodies: TaskSlots<'_, SingleBody>, places: &[u32; SINGLE_LANES]) {
        let ([x, y, z], [along_x, along_y, along_z]) = (self.velocity, self.scaled_spin);
        bodies.store_octets(places, [x, y, z, self.inverse_mass, along_x, along_y, along_z, self.inverse_radius]);
    }
}

impl Bodies<f64> {
    /// One body.
    pub fn of(body: &Body) -> Self {
        let Body { velocity, inverse_mass, scaled_spin, inverse_radius } = *body;
        Self { velocity, inverse_mass, scaled_spin, inverse_radius }
    }

    /// Writes the velocities to a body; without friction, its spin stays unchanged.
    #[inline(always)]
    pub fn put<E: Effects>(&self, body: &mut Body) {
        body.velocity = self.velocity;
        if E::FRICTION {
            body.scaled_spin = self.scaled_spin;
        }
    }
}

impl<N: Number> Bodies<N> {
    /// Adds `sign` times an impulse; `lever` is n x P.
    #[inline(always)]
    pub fn push<E: Effects>(&mut self, sign: f64, impulse: [N; 3], lever: [N; 3]) {
        self.velocity = plus(self.velocity, times(impulse, self.inverse_mass * N::splat(sign)));
        if E::FRICTION {
            let factor = self.inverse_mass * N::splat(-INVERSE_INERTIA);
            self.scaled_spin = plus(self.scaled_spin, times(lever, factor));
        }
    }
}

/// Relative motion of the two sides of a contact.
#[derive(Clone, Copy)]
pub(crate) struct Pair<N> {
    /// Velocity of the second side minus that of the first, m/s.
    pub velocity: [N; 3],
    /// Sum of their inverse masses, 1/kg.
    pub inverse_mass: N,
    /// Sum of their scaled spins, m/s.
    pub scaled_spin: [N; 3],
}

impl<N: Number> Pair<N> {
    /// Relative motion of two bodies.
    #[inline(always)]
    pub fn of(first: &Bodies<N>, second: &Bodies<N>) -> Self {
        Self {
            velocity: minus(second.velocity, first.velocity),
            inverse_mass: first.inverse_mass + second.inverse_mass,
            scaled_spin: plus(first.scaled_spin, second.scaled_spin),
        }
    }

    /// Relative motion of a grain and a wall with velocity `wall_velocity` (m/s) at their contact.
    #[inline(always)]
    pub fn with_wall(grain: &Bodies<N>, wall_velocity: [N; 3]) -> Self {
        let Bodies { velocity, inverse_mass, scaled_spin, .. } = *grain;
        Self { velocity: minus(wall_velocity, velocity), inverse_mass, scaled_spin }
    }
}

impl<L: Lanes> Pair<L> {
    /// Loads eight pairs.
    #[inline(always)]
    pub fn load<E: Effects>(bodies: Slots<'_, Body>, group: &PairGroup<E::Tangential>) -> Self {
        let (first, second) = (&group.first, &group.second);
        let [[x, y, z, inverse_mass], [along_x, along_y, along_z, _]] = match E::FRICTION {
            true => bodies.load_pairs(first, second),
            false => [bodies.load_differences_of_halves(first, second), [L::zero(); 4]],
        };
        Self { velocity: [x, y, z], inverse_mass, scaled_spin: [along_x, along_y, along_z] }
    }

    /// Loads eight pairs without spin, and returns the bodies.
    #[inline(always)]
    pub fn load_keeping<T>(bodies: Slots<'_, Body>, group: &PairGroup<T>) -> (Self, [L::Kept; 2]) {
        let ([x, y, z, inverse_mass], kept) = bodies.load_keeping::<L>(&group.first, &group.second);
        (Self { velocity: [x, y, z], inverse_mass, scaled_spin: [L::zero(); 3] }, kept)
    }

    /// Applies an impulse without spin to loaded bodies that have not changed in memory since.
    #[inline(always)]
    pub fn push_kept<T>(bodies: TaskSlots<'_, Body>, group: &PairGroup<T>, kept: [L::Kept; 2], impulse: [L; 3]) {
        bodies.add_to_kept(&group.first, kept[0], impulse, -1.0);
        bodies.add_to_kept(&group.second, kept[1], impulse, 1.0);
    }

    /// Applies impulses to the bodies of eight contacts: P, and its lever n x P.
    #[inline(always)]
    pub fn push<E: Effects>(bodies: TaskSlots<'_, Body>, group: &PairGroup<E::Tangential>, push: [[L; 3]; 2]) {
        push_each::<L, E>(bodies, &group.first, -1.0, push);
        push_each::<L, E>(bodies, &group.second, 1.0, push);
    }
}

/// Adds `sign` times an impulse to eight bodies in memory: [`Bodies::push`] without a prior load.
#[inline(always)]
pub(super) fn push_each<L: Lanes, E: Effects>(
    bodies: TaskSlots<'_, Body>,
    places: &[u32; LANES],
    sign: f64,
    push: [[L; 3]; 2],
) {
    let factors = [sign, -INVERSE_INERTIA];
    match E::FRICTION {
        true => bodies.add_shares::<L, true>(places, push, factors),
        false => bodies.add_shares::<L, false>(places, push, factors),
    }
}

/// Constraint data and impulses of one contact, or of eight, in a kernel compiled for effects `E`.
pub(crate) type Contact<N, E> = ContactLanes<N, TermState<N, <<E as Effects>::Tangential as ContactLayout>::Term<N>>>;

impl<N: Number, T: TangentialTerm<N>> ContactLanes<N, TermState<N, T>> {
    /// Reads a contact, number by number.
    #[inline(always)]
    pub(crate) fn read<S>(contacts: &ContactLanes<S, impl Tangential<S>>, number: impl Fn(&S) -> N) -> Self {
        ContactLanes {
            normal: contacts.normal.each_ref().map(&number),
            bias: number(&contacts.bias),
            regularisation: number(&contacts.regularisation),
            impulse_normal: number(&contacts.impulse_normal),
            tangential: TermState::across(&contacts.tangential, number),
        }
    }

    /// Writes the impulses back.
    #[inline(always)]
    pub(crate) fn write<S>(&self, contacts: &mut ContactLanes<S, impl Tangential<S>>, number: impl Fn(N, &mut S)) {
        number(self.impulse_normal, &mut contacts.impulse_normal);
        if T::ACTS
            && let Some(lanes) = contacts.tangential.lanes_mut()
        {
            self.tangential.write(&mut lanes.impulse, number);
        }
    }

    /// Returns the impulse as a vector.
    #[inline(always)]
    pub(crate) fn impulse(&self) -> [N; 3] {
        plus(self.tangential.impulse, times(self.normal, self.impulse_normal))
    }

    /// Radius of the Coulomb disc, N s.
    #[inline(always)]
    pub(crate) fn disc(&self) -> N {
        self.tangential.term.coefficient() * self.impulse_normal
    }

    /// Tangential operator: `S_t = 3.5 S_n` for solid spheres, plus the tangential term.
    #[inline(always)]
    pub(crate) fn tangential_operator(&self, inverse_mass: N) -> N {
        self.tangential.term.operator(inverse_mass * N::splat(1.0 + INVERSE_INERTIA))
    }

    /// The one-contact solution: updates the impulses and returns the change.
    #[inline(always)]
    pub(crate) fn relax<G: MeasuredLevel>(
        &mut self,
        velocity: [N; 3],
        inverse_mass: N,
        relaxation: N,
        residual: &mut LaneResidual<N>,
    ) -> [N; 3] {
        let normal = self.normal;
        // Normal impulse, projected onto repulsion.
        let normal_velocity = dot(normal, velocity);
        let operator = inverse_mass + self.regularisation;
        let target = self.bias - self.regularisation * self.impulse_normal;
        let change = ((target - normal_velocity) * (relaxation / operator)).larger(-self.impulse_normal);
        let updated = self.impulse_normal + change;
        self.impulse_normal = updated;
        if G::ANY {
            residual.add_normal::<G>(change * operator);
        }
        let mut impulse = times(normal, change);
        if T::ACTS {
            // Tangential impulse.
            let operator = self.tangential_operator(inverse_mass);
            let across = minus(velocity, times(normal, normal_velocity));
            let change = self.tangential.relax((normal, updated), across, operator, relaxation);
            impulse = plus(impulse, change);
            if G::ANY {
                residual.add_tangential::<G>(normal, times(change, operator));
            }
        }
        impulse
    }

    /// Relative velocity at the contact of two sides with the given motion.
    #[inline(always)]
    pub(crate) fn velocity(&self, pair: &Pair<N>) -> [N; 3] {
        if !T::ACTS {
            return pair.velocity;
        }
        minus(pair.velocity, cross(pair.scaled_spin, self.normal))
    }

    /// Relaxes the contact of two sides with the given motion: returns the impulse P on the second side, and its lever n x P.
    #[inline(always)]
    pub(crate) fn relax_with_lever<G: MeasuredLevel>(
        &mut self,
        pair: &Pair<N>,
        relaxation: N,
        residual: &mut LaneResidual<N>,
    ) -> [[N; 3]; 2] {
        let impulse = self.relax::<G>(self.velocity(pair), pair.inverse_mass, relaxation, residual);
        [impulse, cross(self.normal, impulse)]
    }
}
