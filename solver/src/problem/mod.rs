//! Contact problem of one time step as plain data, independent of lane layout and solver.
//!
//! Bodies have the generalised velocities `(v, omega)` and the inverse mass blocks `M^-1` and `I^-1`. A contact has the unit
//! normal n from its first body a to its second body b, or to a wall, and the arms r from each body's centre to the point of
//! contact. The relative velocity and the effect of an impulse P on the second body are
//!
//! ```text
//! u   = v_b + omega_b x r_b - v_a - omega_a x r_a
//! v_b   += M_b^-1 P    omega_b += I_b^-1 (r_b x P + L)
//! v_a   -= M_a^-1 P    omega_a -= I_a^-1 (r_a x P + L)          P = lambda_n n + lambda_t
//! ```
//!
//! A solution is a state whose impulses satisfy the laws of all contacts simultaneously. With the bias q and the compliance Sigma',
//!
//! ```text
//! normal      0 <= lambda_n  _|_  w_n = n.u + Sigma' lambda_n - q >= 0
//! friction    lambda_t in the disc of radius mu lambda_n, and against the sliding w_t = u_t + Sigma_t lambda_t - b:
//!             w_t = 0 inside of it, else lambda_t = -mu lambda_n w_t / |w_t|
//! resistance  the same of the angular impulse L and omega_b - omega_a: a disc across the normal, an interval along it
//! ```
//!
//! The bias q contains the stabilisation of the contact, `(4/h) Y d + Y u_n0`, or the rebound speed `-e u_n0` of an impact (C.
//! Lacoursière, *Ghosts and machines*, Umeå 2007, sections 4 and 10). Sigma_t and b belong to a [tangential
//! spring](crate::effects::spring), zero without a spring. [`sweep`](crate::sweep) relaxes these laws; `docs/problem.md`
//! describes the file format of a problem.
//!
//! Dynamic walls are bodies too. Along an axis a with mass M a wall has `M^-1 = a a^T / M` and a zero inverse inertia. About an
//! axis with the moment of inertia I it has `I^-1 = a a^T / I` and a zero inverse mass.
//!
//! Example: the problem of a simulation's next step, and its solution by the scalar reference:
//!
//! ```
//! use makadam::problem::Reference;
//! # use makadam::{Scene, Simulation};
//! # let scene = Scene::example();
//! let mut simulation = Simulation::builder(&scene).time_step(5e-4).build()?;
//! for _ in 0..600 {
//!     simulation.step();
//! }
//! let problem = simulation.contact_problem();
//! let mut state = problem.start(); // impulses of the last step
//! let ending = problem.solve(&mut state, &Reference { relaxation: 1.0, tolerance: 1e-9, most_sweeps: 100_000 });
//! assert!(ending.converged, "{ending:?}");
//! println!("{} contacts, residual {:.1e} m/s", problem.contacts.len(), problem.residuals(&state).rms());
//! # assert!(problem.contacts.len() > 40 && problem.residuals(&state).rms() < 1e-8);
//! # Ok::<(), makadam::Error>(())
//! ```

mod pose;
mod reference;

pub use pose::{LocalProblem, MatrixBlock};
pub use reference::{Ending, ProblemResiduals, Reference};

use nalgebra::{Matrix3, Vector3};

/// Largest bias that marks inactive contacts, m/s.
const NEVER: f64 = -1e29;

/// Contact problem of one time step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactProblem {
    /// Time at the start of the step, s.
    pub time: f64,
    /// Length h of the step, s.
    pub step: f64,
    /// Velocity scale of residuals, m/s: g h, or 1 without gravity.
    pub unit: f64,
    /// Number of grains, which come first among the bodies, by id; dynamic walls follow in scene order.
    pub grains: usize,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Contacts, in relaxation order.
    pub contacts: Vec<Contact>,
}

/// Body moved by contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// Inverse mass block M^-1, 1/kg: symmetric, positive semidefinite.
    pub inverse_mass: Matrix3<f64>,
    /// Inverse inertia block I^-1 in the world frame, 1/(kg m2): symmetric, positive semidefinite.
    pub inverse_inertia: Matrix3<f64>,
    /// Velocity of the centre before the contacts act, m/s, including gravity and the forces on dynamic walls over the step.
    pub velocity: Vector3<f64>,
    /// Angular velocity before the contacts act, rad/s.
    pub spin: Vector3<f64>,
}

/// Contact of two bodies, or of a body with a wall of prescribed motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Number of the first body.
    pub first: usize,
    /// Number of the second body; `None` for a wall.
    pub second: Option<usize>,
    /// Unit normal n from the first body to the second, or to the wall.
    pub normal: Vector3<f64>,
    /// Two unit tangents, which form a right-handed frame with the normal.
    pub tangents: [Vector3<f64>; 2],
    /// Arms from the centres of the first and of the second body to the point of contact, m; zero for a wall.
    pub arms: [Vector3<f64>; 2],
    /// Velocity of the wall at the point, m/s; for a second body, its additional drift due to rotation.
    pub wall_velocity: Vector3<f64>,
    /// Angular velocity of the wall, rad/s; zero for a second body.
    pub wall_spin: Vector3<f64>,
    /// Bias q along the normal, m/s: -1e30 for a contact inactive in this step.
    pub bias: f64,
    /// Compliance Sigma' along the normal, 1/kg.
    pub compliance: f64,
    /// Compliance Sigma_t of the tangential spring, 1/kg; zero for a rigid contact.
    pub tangential_compliance: f64,
    /// Tangential bias b of that spring in the world frame, m/s: Sigma_t times its impulse in the last step.
    pub tangential_bias: Vector3<f64>,
    /// Coefficient of friction mu.
    pub friction: f64,
    /// Largest rolling torque over the normal force, `mu_r R*`, m.
    pub rolling_lever: f64,
    /// Largest twisting torque over the normal force, `mu_t R*`, m.
    pub twisting_lever: f64,
    /// Impulse of cohesion on the two bodies in the step, N s.
    pub pull: f64,
    /// Starting impulse of a solve.
    pub impulse: ContactImpulse,
}

/// Impulse of a contact on its second side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactImpulse {
    /// Normal impulse lambda_n without cohesion, N s.
    pub normal: f64,
    /// Tangential impulse lambda_t in the world frame, N s.
    pub tangential: Vector3<f64>,
    /// Angular impulse L in the world frame, N m s.
    pub angular: Vector3<f64>,
}

/// Impulses and the corresponding velocities.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactState {
    /// Velocity of each body, m/s.
    pub velocities: Vec<Vector3<f64>>,
    /// Angular velocity of each body, rad/s.
    pub spins: Vec<Vector3<f64>>,
    /// Impulse of each contact.
    pub impulses: Vec<ContactImpulse>,
}

impl ContactImpulse {
    /// Returns the impulse P as a vector, N s.
    pub fn vector(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        normal * self.normal + self.tangential
    }
}

impl Contact {
    /// Returns true if the contact may be active in this step.
    pub fn bears(&self) -> bool {
        self.bias > NEVER
    }

    /// Returns true if the contact resists rolling or twisting.
    pub fn resists_turning(&self) -> bool {
        self.rolling_lever != 0.0 || self.twisting_lever != 0.0
    }

    /// Tangential residual w_t of sticking, m/s, given the relative velocity.
    pub fn sliding(&self, velocity: &Vector3<f64>, tangential_impulse: &Vector3<f64>) -> Vector3<f64> {
        let across = velocity - self.normal * self.normal.dot(velocity);
        across + tangential_impulse * self.tangential_compliance - self.tangential_bias
    }

    /// Returns the contact frame: normal and tangents as columns.
    pub fn frame(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&[self.normal, self.tangents[0], self.tangents[1]])
    }

    /// Iterates over the bodies, each with its arm and the sign of an impulse on it.
    pub fn sides(&self) -> impl Iterator<Item = (usize, Vector3<f64>, f64)> {
        [(Some(self.first), self.arms[0], -1.0), (self.second, self.arms[1], 1.0)]
            .into_iter()
            .filter_map(|(body, arm, sign)| Some((body?, arm, sign)))
    }
}

impl ContactProblem {
    /// Returns the state of the given impulses, one per contact: velocities before the contacts act, plus the effect of cohesion and impulses.
    pub fn state_of(&self, impulses: &[ContactImpulse]) -> ContactState {
        let mut state = ContactState {
            velocities: self.bodies.iter().map(|body| body.velocity).collect(),
            spins: self.bodies.iter().map(|body| body.spin).collect(),
            impulses: impulses.to_vec(),
        };
        for (contact, impulse) in self.contacts.iter().zip(impulses) {
            let pulled = ContactImpulse { normal: impulse.normal - contact.pull, ..*impulse };
            self.push(contact, &mut state, &pulled.vector(&contact.normal), &impulse.angular);
        }
        state
    }

    /// Returns the starting state of a solve.
    pub fn start(&self) -> ContactState {
        let impulses: Vec<ContactImpulse> = self.contacts.iter().map(|contact| contact.impulse).collect();
        self.state_of(&impulses)
    }

    /// Relative velocity u at a contact, m/s.
    pub fn relative_velocity(&self, contact: &Contact, state: &ContactState) -> Vector3<f64> {
        let moves = |(body, arm, sign): (usize, Vector3<f64>, f64)| {
            (state.velocities[body] + state.spins[body].cross(&arm)) * sign
        };
        contact.sides().map(moves).fold(contact.wall_velocity, |sum, velocity| sum + velocity)
    }

    /// Relative angular velocity at a contact, rad/s.
    pub fn relative_spin(&self, contact: &Contact, state: &ContactState) -> Vector3<f64> {
        contact.sides().fold(contact.wall_spin, |sum, (body, _, sign)| sum + state.spins[body] * sign)
    }

    /// Applies an impulse, N s, and an angular impulse, N m s, to the bodies of a contact, on its second side.
    pub fn push(
        &self,
        contact: &Contact,
        state: &mut ContactState,
        impulse: &Vector3<f64>,
        angular_impulse: &Vector3<f64>,
    ) {
        for (number, arm, sign) in contact.sides() {
            let body = &self.bodies[number];
            state.velocities[number] += body.inverse_mass * impulse * sign;
            state.spins[number] += body.inverse_inertia * (arm.cross(impulse) + angular_impulse) * sign;
        }
    }

    /// Operator of one contact in its own frame, 1/kg: the change of its relative velocity per unit impulse, without compliance.
    pub fn own_operator(&self, contact: &Contact) -> Matrix3<f64> {
        let frame = contact.frame();
        let side = |(number, arm, _): (usize, Vector3<f64>, f64)| {
            let (body, lever) = (&self.bodies[number], arm.cross_matrix());
            body.inverse_mass + lever.transpose() * body.inverse_inertia * lever
        };
        frame.transpose() * contact.sides().map(side).sum::<Matrix3<f64>>() * frame
    }

    /// Returns true if some contact resists rolling or twisting.
    pub fn resists_turning(&self) -> bool {
        self.contacts.iter().any(Contact::resists_turning)
    }

    /// Checks the data: finite numbers, existing bodies, orthonormal frames, nonnegative coefficients.
    ///
    /// # Errors
    /// Message of the first violation.
    pub fn check(&self) -> Result<(), String> {
        let finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
        if !finite(&[self.time, self.step, self.unit]) || self.step <= 0.0 || self.unit <= 0.0 {
            return Err("time, step and unit have to be finite numbers, and the last two positive".into());
        }
        if self.grains > self.bodies.len() {
            return Err(format!("{} grains among {} bodies", self.grains, self.bodies.len()));
        }
        for (number, body) in self.bodies.iter().enumerate() {
            let blocks = [&body.inverse_mass, &body.inverse_inertia];
            let vectors = [body.velocity.as_slice(), body.spin.as_slice()];
            if !blocks.iter().all(|block| finite(block.as_slice())) || !vectors.into_iter().all(finite) {
                return Err(format!("body {number} has a number that is not finite"));
            }
            let lopsided = |block: &&Matrix3<f64>| (*block - block.transpose()).amax() > 1e-9 * block.amax();
            if blocks.iter().any(lopsided) || blocks.iter().any(|block| block.diagonal().min() < 0.0) {
                return Err(format!("body {number} has a mass or inertia block that is not symmetric, or negative"));
            }
        }
        for (number, contact) in self.contacts.iter().enumerate() {
            self.check_contact(contact).map_err(|words| format!("contact {number} {words}"))?;
        }
        Ok(())
    }

    fn check_contact(&self, contact: &Contact) -> Result<(), String> {
        if let Some((body, ..)) = contact.sides().find(|(body, ..)| *body >= self.bodies.len()) {
            return Err(format!("names body {body} of {}", self.bodies.len()));
        }
        if contact.second == Some(contact.first) {
            return Err("is of a body with itself".into());
        }
        let Contact { arms, wall_velocity, wall_spin, impulse, tangential_bias, .. } = contact;
        let vectors =
            [&arms[0], &arms[1], wall_velocity, wall_spin, &impulse.tangential, &impulse.angular, tangential_bias];
        let magnitudes = [
            contact.compliance,
            contact.tangential_compliance,
            contact.friction,
            contact.rolling_lever,
            contact.twisting_lever,
            impulse.normal,
        ];
        let numbers = [contact.bias, contact.pull].into_iter().chain(magnitudes);
        let all = vectors.into_iter().flat_map(|vector| vector.iter().copied()).chain(numbers);
        if !all.chain(contact.frame().iter().copied()).all(f64::is_finite) {
            return Err("has a number that is not finite".into());
        }
        if magnitudes.into_iter().any(|magnitude| magnitude < 0.0) {
            return Err("has a coefficient, a compliance or a normal impulse below zero".into());
        }
        let frame = contact.frame();
        if (frame.transpose() * frame - Matrix3::identity()).amax() > 1e-9 {
            return Err("has a frame that is not orthonormal".into());
        }
        if contact.bears() && self.own_operator(contact)[(0, 0)] + contact.compliance <= 0.0 {
            return Err("cannot move: its bodies have no mobility along the normal".into());
        }
        Ok(())
    }
}

/// Two unit tangents, which form a right-handed frame with a unit normal.
pub(crate) fn tangents_of(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let one = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    [one, normal.cross(&one)]
}
