//! The contact problem of a simulation's next step.

use super::{Body, Contact, ContactImpulse, ContactProblem, ContactState, tangents_of};
use crate::Simulation;
use crate::contact::lever_arms;
use crate::effects::drive::Drive;
use crate::groups::{ContactLanes, SpringLanes, TorqueLanes};
use crate::lanes::Eight;
use crate::scene::Stop;
use crate::schedule::Team;
use crate::solve::{SolveReport, residual_unit, solve};
use crate::sweep::INVERSE_INERTIA;
use crate::world;
use nalgebra::{Matrix3, Vector3};

impl Simulation {
    /// The contact problem of the next step, as its solve will find it. The simulation itself stays as it is: a copy poses
    /// the problem.
    ///
    /// Contacts are listed in the order in which a sweep relaxes them, those that neither bear nor pull anything in the step
    /// left out. Bodies are numbered by the ids of the grains; driven walls follow.
    pub fn contact_problem(&self) -> ContactProblem {
        let (mut posed, team) = (self.clone(), Team::default());
        // Bodies as they are before the contacts act, which start from the impulses of the last step.
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
    /// Solves the contact problem of the next step with the simulation's own method and sweeps, until the given rule says stop. The
    /// simulation itself stays as it is: a copy does it.
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

/// The grains by id, then the driven walls, as they move now.
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

/// A driven wall, whose one freedom is along or about its axis.
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

/// Every contact of a posed problem that bears or pulls something.
fn contacts(posed: &Simulation) -> Vec<Contact> {
    let Simulation { world, layout, .. } = posed;
    let radius = |place: u32| world.spheres[place as usize].radius;
    let number = |place: u32| world.ids[place as usize] as usize;
    let mut contacts = Vec::with_capacity(layout.contacts);
    // They are listed in the order in which they come here, and relaxed behind all others.
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
                    // The arm across the axis, whose cross product with the axis is the Jacobian.
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

/// What the lanes of a contact hold, whichever bodies it has.
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
