//! Contact problem of a simulation's next step.

use super::{Body, Contact, ContactImpulse, ContactProblem, ContactState, tangents_of};
use crate::Simulation;
use crate::contact::lever_arms;
use crate::effects::drive::Drive;
use crate::effects::resistance::TorqueLanes;
use crate::effects::spring::SpringLanes;
use crate::groups::ContactLanes;
use crate::lanes::Eight;
use crate::scene::Stop;
use crate::schedule::Team;
use crate::solve::{SolveReport, residual_unit, solve};
use crate::world::{self, INVERSE_INERTIA};
use nalgebra::{Matrix3, Vector3};

impl Simulation {
    /// Returns the contact problem of the next step's solve. The simulation stays unchanged: a copy poses the problem.
    ///
    /// Contacts are listed in relaxation order, without contacts that are inactive and not cohesive in the step. Bodies are
    /// numbered by grain ids; dynamic walls follow.
    pub fn contact_problem(&self) -> ContactProblem {
        let (mut posed, team) = (self.clone(), Team::default());
        // Bodies before the contacts act; the contacts start from the impulses of the last step.
        posed.set_free(&team);
        let bodies = bodies(&posed);
        posed.lay_out(&team);
        let (world, step) = (&self.world, self.settings.step);
        ContactProblem {
            time: world.time,
            step,
            unit: residual_unit(world, step),
            grains: world.grains(),
            bodies,
            contacts: contacts(&posed),
        }
    }
}

impl Simulation {
    /// Solves the contact problem of the next step with the simulation's own method and sweeps, until the given stop criterion.
    /// The simulation stays unchanged: a copy runs the solve.
    pub fn solution_in_lanes(&self, stop: Stop) -> (ContactState, SolveReport) {
        let (mut copy, team) = (self.clone(), Team::default());
        copy.settings.stop = stop;
        copy.pose_problem(&team);
        let Simulation { world, settings, layout, relaxation, solver, interrupt, .. } = &mut copy;
        let report = solve(world, layout, relaxation, settings, &team, solver, interrupt);
        let (found, bodies) = (contacts(&copy), bodies(&copy));
        let state = ContactState {
            velocities: bodies.iter().map(|body| body.velocity).collect(),
            spins: bodies.iter().map(|body| body.spin).collect(),
            impulses: found.iter().map(|contact| contact.impulse).collect(),
        };
        (state, report)
    }
}

/// Returns the grains by id, then the dynamic walls, with their present motion.
fn bodies(simulation: &Simulation) -> Vec<Body> {
    let world = &simulation.world;
    let grains = simulation.places_by_id().into_iter().map(|place| grain(&world.bodies[place as usize]));
    grains.chain(world.drives.iter().map(wall)).collect()
}

fn grain(body: &world::Body) -> Body {
    let inverse_inertia = INVERSE_INERTIA * body.inverse_mass * body.inverse_radius * body.inverse_radius;
    Body {
        inverse_mass: Matrix3::from_diagonal_element(body.inverse_mass),
        inverse_inertia: Matrix3::from_diagonal_element(inverse_inertia),
        velocity: body.velocity.into(),
        spin: Vector3::from(body.scaled_spin) * body.inverse_radius,
    }
}

/// Returns a dynamic wall as a body with one degree of freedom, along or about its axis.
fn wall(drive: &Drive) -> Body {
    let (axis, turning) = (drive.axis(), drive.turning());
    let along = if turning == Vector3::zeros() { axis } else { Vector3::zeros() };
    Body {
        inverse_mass: along * along.transpose() * drive.inverse_inertia,
        inverse_inertia: turning * turning.transpose() * drive.inverse_inertia,
        velocity: along * drive.rate,
        spin: turning * drive.rate,
    }
}

/// Returns every active or cohesive contact of a posed problem.
fn contacts(posed: &Simulation) -> Vec<Contact> {
    let Simulation { world, layout, .. } = posed;
    let radius = |place: u32| world.spheres[place as usize].radius;
    let number = |place: u32| world.ids[place as usize] as usize;
    let mut contacts = Vec::with_capacity(layout.contacts);
    // Contacts with dynamic walls are listed in the order of this loop, and relaxed after all others.
    let (mut driven, mut last) = (layout.driven.iter(), Vec::new());
    for (_, task) in layout.tasks() {
        for (index, (group, sources)) in task.pairs.iter().zip(&task.pair_sources).enumerate() {
            for (lane, _) in sources.occupied() {
                let [first, second] = [group.first[lane], group.second[lane]];
                let mut contact = read(&group.contacts, lane);
                contact.first = number(first);
                contact.second = Some(number(second));
                contact.arms = lever_arms(&contact.normal, [radius(first), radius(second)]);
                contact.pull = task.pair_pulls.get(index).map_or(0.0, |pulls| pulls.0[lane]);
                if let Some(torques) = task.pair_torques.get(index) {
                    read_torques(torques, lane, &mut contact);
                }
                contacts.push(contact);
            }
        }
        for (index, (group, sources)) in task.walls.iter().zip(&task.wall_sources).enumerate() {
            for (lane, _) in sources.occupied() {
                let place = group.body[lane];
                let mut contact = read(&group.contacts, lane);
                contact.first = number(place);
                contact.arms[0] = lever_arms(&contact.normal, [radius(place), 0.0])[0];
                contact.pull = task.wall_pulls.get(index).map_or(0.0, |pulls| pulls.0[lane]);
                if let Some(lanes) = task.wall_torques.get(index) {
                    read_torques(&lanes.torques, lane, &mut contact);
                    contact.wall_spin = Vector3::from_fn(|axis, _| lanes.wall_spin[axis].0[lane]);
                }
                if index < task.prescribed_walls() {
                    contact.wall_velocity = Vector3::from_fn(|axis, _| group.wall_velocity[axis].0[lane]);
                    contacts.push(contact);
                    continue;
                }
                contact.wall_spin = Vector3::zeros();
                if let Some(one) = driven.next() {
                    contact.second = Some(world.grains() + one.drive as usize);
                    // Arm across the axis, whose cross product with the axis is the Jacobian.
                    let axis = world.drives[one.drive as usize].turning();
                    contact.arms[1] = Vector3::from(one.jacobian).cross(&axis);
                    contact.wall_velocity = one.drift.into();
                }
                last.push(contact);
            }
        }
    }
    contacts.append(&mut last);
    contacts.retain(|contact| contact.bears() || contact.pull != 0.0);
    contacts
}

/// Reads the values of a contact from its lanes.
fn read(lanes: &ContactLanes<Eight, SpringLanes>, lane: usize) -> Contact {
    let normal = Vector3::from(lanes.normal(lane));
    Contact {
        normal,
        tangents: tangents_of(&normal),
        bias: lanes.bias.0[lane],
        compliance: lanes.regularisation.0[lane],
        tangential_compliance: lanes.tangential.spring.compliance.0[lane],
        tangential_bias: Vector3::from_fn(|axis, _| lanes.tangential.spring.bias[axis].0[lane]),
        friction: lanes.friction(lane),
        impulse: ContactImpulse {
            normal: lanes.normal_impulse(lane),
            tangential: lanes.tangential_impulse(lane).into(),
            angular: Vector3::zeros(),
        },
        ..Contact::default()
    }
}

fn read_torques(torques: &TorqueLanes, lane: usize, contact: &mut Contact) {
    contact.rolling_lever = torques.rolling_lever.0[lane];
    contact.twisting_lever = torques.twisting_lever.0[lane];
    contact.impulse.angular = torques.angular_impulse(lane).into();
}

/// Contact problem in the frames of its contacts, as in FCLIB's `fclib_local`:
///
/// ```text
/// w = W lambda + q      W = G M^-1 G^T + Sigma'      q = G v + (velocities of walls) - (biases along the normals)
/// ```
///
/// with v the velocities before the contacts act, cohesion included. Sigma' is on the diagonal in normal rows, and the spring compliance in
/// tangential rows, with its bias in q. A solution has `0 <= lambda_n _|_ w_n >= 0` and Coulomb's law of w_t and lambda_t. (V. Acary, M.
/// Brémond, T. Koziara, F. Pérignon, *FCLIB: a collection of discrete 3D frictional contact problems*, Inria technical report 444, 2014.)
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalProblem {
    /// Matrix W in blocks of one contact by another, 1/kg, by columns and within each by rows.
    pub blocks: Vec<MatrixBlock>,
    /// Offset q, m/s: normal and two tangential components of each contact.
    pub offset: Vec<Vector3<f64>>,
    /// Coefficient of friction of each contact.
    pub friction: Vec<f64>,
    /// Starting impulses of a solve, N s, in the contact frames.
    pub impulses: Vec<Vector3<f64>>,
    /// Number of each contact in the full problem; inactive contacts are omitted.
    pub contacts: Vec<usize>,
}

/// Block of W: velocity at one contact per unit impulse on another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MatrixBlock {
    /// Contact with the velocity.
    pub row: usize,
    /// Contact with the impulse.
    pub column: usize,
    /// Velocity per impulse, 1/kg.
    pub values: Matrix3<f64>,
}

impl ContactProblem {
    /// Reduces the problem to the active contacts, without angular impulses.
    pub fn local(&self) -> LocalProblem {
        let bearing: Vec<(usize, &Contact)> =
            self.contacts.iter().enumerate().filter(|(_, contact)| contact.bears()).collect();
        // Contacts of each body.
        let mut touched: Vec<Vec<usize>> = vec![Vec::new(); self.bodies.len()];
        for (row, (_, contact)) in bearing.iter().enumerate() {
            contact.sides().for_each(|(body, ..)| touched[body].push(row));
        }
        let mut blocks = Vec::new();
        for (column, (_, contact)) in bearing.iter().enumerate() {
            let mut rows: Vec<usize> = contact.sides().flat_map(|(body, ..)| touched[body].iter().copied()).collect();
            rows.sort_unstable();
            rows.dedup();
            for row in rows {
                let mut values = self.coupling(bearing[row].1, contact);
                if row == column {
                    values[(0, 0)] += contact.compliance;
                    values[(1, 1)] += contact.tangential_compliance;
                    values[(2, 2)] += contact.tangential_compliance;
                }
                blocks.push(MatrixBlock { row, column, values });
            }
        }
        // Velocities before the contacts act, cohesion included.
        let free = self.state_of(&vec![ContactImpulse::default(); self.contacts.len()]);
        let offset = |(_, contact): &(usize, &Contact)| {
            let [u, v] = contact.tangents.map(|tangent| tangent.dot(&contact.tangential_bias));
            contact.frame().transpose() * self.relative_velocity(contact, &free) - Vector3::new(contact.bias, u, v)
        };
        let impulse = |(_, contact): &(usize, &Contact)| self.in_frame(contact, &contact.impulse);
        LocalProblem {
            blocks,
            offset: bearing.iter().map(offset).collect(),
            friction: bearing.iter().map(|(_, contact)| contact.friction).collect(),
            impulses: bearing.iter().map(impulse).collect(),
            contacts: bearing.iter().map(|(number, _)| *number).collect(),
        }
    }

    /// Velocity at `row` per unit impulse on `column`, in their frames, 1/kg.
    fn coupling(&self, row: &Contact, column: &Contact) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for (number, arm, sign) in column.sides() {
            let body = &self.bodies[number];
            for (_, other_arm, other_sign) in row.sides().filter(|(other, ..)| *other == number) {
                // v + omega x r of the row, with omega = I^-1 (r' x P) of the column.
                let turns = other_arm.cross_matrix().transpose() * body.inverse_inertia * arm.cross_matrix();
                sum += (body.inverse_mass + turns) * (sign * other_sign);
            }
        }
        // Negative zeros become positive: sums of entries from a file have no negative zeros either.
        (row.frame().transpose() * sum * column.frame()).map(|entry| entry + 0.0)
    }

    /// Returns an impulse in its contact frame: normal and two tangential components, N s.
    pub fn in_frame(&self, contact: &Contact, impulse: &ContactImpulse) -> Vector3<f64> {
        let [u, v] = contact.tangents.map(|tangent| tangent.dot(&impulse.tangential));
        Vector3::new(impulse.normal, u, v)
    }

    /// Returns the impulses of all contacts, from those of the reduced problem in contact frames.
    pub fn impulses_of(&self, local: &LocalProblem, impulses: &[Vector3<f64>]) -> Vec<ContactImpulse> {
        let mut all = vec![ContactImpulse::default(); self.contacts.len()];
        for (&number, impulse) in local.contacts.iter().zip(impulses) {
            let [u, v] = self.contacts[number].tangents;
            all[number].normal = impulse.x;
            all[number].tangential = u * impulse.y + v * impulse.z;
        }
        all
    }
}

impl LocalProblem {
    /// Returns the velocities `w = W lambda + q`, m/s.
    pub fn velocities(&self, impulses: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut velocities = self.offset.clone();
        for block in &self.blocks {
            velocities[block.row] += block.values * impulses[block.column];
        }
        velocities
    }
}
