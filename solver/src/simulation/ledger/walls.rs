//! Impulses and work of walls in the last step, per contact.

use crate::Simulation;
use crate::detect::WallCandidate;
use crate::lanes::{Eight, cross, dot, minus, plus, times};
use crate::simulation::Request;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Solved contact with a wall in the last step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct WallContact {
    /// Index of the candidate in the list of its rank.
    pub source: usize,
    pub candidate: WallCandidate,
    /// Unit normal from the grain to the wall.
    pub normal: [f64; 3],
    /// Normal impulse on the wall, and with it that of cohesion, N s.
    pub pressing: f64,
    /// Tangential impulse on the wall, N s.
    pub tangential: [f64; 3],
    /// Energy taken up by the tangential spring, J.
    pub springs: f64,
    /// True if the contact carried nothing in the step before.
    pub begins: bool,
    /// Impulse of cohesion, N s.
    pub pull: f64,
    /// True if the contact is in an impact.
    pub in_impact: bool,
    /// Angular impulse on the wall, N m s.
    pub angular_impulse: [f64; 3],
    /// Velocities of the wall at the contact at the start and at the end of the step, m/s; they differ only for dynamic or turning walls.
    pub velocities: [[f64; 3]; 2],
    /// Angular velocities of the wall at the same times, rad/s.
    pub spins: [[f64; 3]; 2],
}

impl WallContact {
    /// Normal impulse on the wall minus the impulse of cohesion, N s.
    pub fn along(&self) -> f64 {
        self.pressing - self.pull
    }

    /// Impulse on the wall, N s.
    pub fn impulse(&self) -> [f64; 3] {
        plus(times(self.normal, self.along()), self.tangential)
    }

    /// Mean angular velocity of the wall over the step, rad/s.
    pub fn mean_spin(&self) -> [f64; 3] {
        times(plus(self.spins[0], self.spins[1]), 0.5)
    }

    /// Work of the wall on the grain, J.
    pub fn work(&self) -> f64 {
        let velocity = times(plus(self.velocities[0], self.velocities[1]), 0.5);
        -dot(self.impulse(), velocity) - dot(self.angular_impulse, self.mean_spin())
    }
}

/// Impulse of a wall on a grain outside of the solve.
///
/// Velocities are those of the wall's point minus those of the grain's surface at this point.
pub(crate) struct WallImpulse {
    /// Number of the face.
    pub surface: u32,
    /// Mass of the grain, kg.
    pub mass: f64,
    /// Velocity of its centre before the impulse, m/s.
    pub velocity: [f64; 3],
    /// Unit normal from the grain to the wall.
    pub normal: [f64; 3],
    /// Relative velocity before the impulse and after the solve, m/s.
    pub before: [f64; 3],
    /// Relative velocity after the impulse, m/s.
    pub after: [f64; 3],
    /// Impulse on the grain, N s.
    pub impulse: [f64; 3],
    /// Velocity of the wall at the contact, m/s.
    pub wall_velocity: [f64; 3],
    /// Centre of the grain at the start of the step, m.
    pub centre: [f64; 3],
    /// Lever arm of the impulse from the grain's centre, m; zero if the impulse does not turn the grain.
    pub arm: [f64; 3],
}

impl Simulation {
    /// Calls the function for each contact with a wall of the last step, of all ranks.
    pub(crate) fn for_each_wall_contact(&self, mut visit: impl FnMut(&WallContact)) {
        let Some(ranks) = self.together(Request::WallContacts) else {
            return self.for_each_own_wall_contact(|_, one| visit(one));
        };
        let mut own = vec![Vec::new(); self.layout.plan.tasks().len()];
        self.for_each_own_wall_contact(|task, one| own[task].push(*one));
        ranks.merge(own).iter().flatten().for_each(visit);
    }

    /// Calls the function for each contact with a wall of the last step of this rank, with the index of its task.
    fn for_each_own_wall_contact(&self, mut visit: impl FnMut(usize, &WallContact)) {
        let Simulation { world, candidates, layout, .. } = self;
        // Contacts with dynamic walls are listed in the order of this loop.
        let mut driven = layout.driven.iter().filter(|_| !world.drives.is_empty()).peekable();
        for (place, task) in layout.plan.tasks().iter().enumerate() {
            let groups = &layout.groups[task.number as usize];
            for (number, (group, sources)) in groups.walls.iter().zip(&groups.wall_sources).enumerate() {
                let (pulls, torques) = (groups.wall_pulls.get(number), groups.wall_torques.get(number));
                for (lane, source) in sources.occupied() {
                    let after = std::array::from_fn(|axis| group.wall_velocity[axis].0[lane]);
                    let drift = |lanes: &[Eight; 3]| std::array::from_fn(|axis| lanes[axis].0[lane]);
                    let drift: [f64; 3] = groups.wall_drifts.get(number).map_or([0.0; 3], drift);
                    let spin = torques.map_or([0.0; 3], |lanes| [0, 1, 2].map(|axis| lanes.wall_spin[axis].0[lane]));
                    let own = driven.next_if(|one| {
                        (one.task, one.group as usize, one.lane as usize) == (task.number, number, lane)
                    });
                    // A dynamic wall has another velocity before its impulses; a turning wall moves along the chord of the previous step.
                    let (before, spin_before) = own.map_or((minus(after, times(drift, 2.0)), spin), |one| {
                        let drive = &world.drives[one.drive as usize];
                        let turning = if torques.is_some() { drive.turning() } else { Vector3::zeros() };
                        let before = minus(times(one.jacobian, drive.rate_before), one.drift);
                        (before, (turning * drive.rate_before).into())
                    });
                    let (contacts, tangential) = (&group.contacts, group.contacts.tangential_impulse(lane));
                    let one = WallContact {
                        source,
                        candidate: candidates.walls[source],
                        normal: contacts.normal(lane),
                        pressing: contacts.normal_impulse(lane),
                        tangential,
                        springs: contacts.tangential.spring.taken_up(lane, tangential),
                        begins: contacts.normal_impulse(lane) > 0.0 && !candidates.impulses.walls.is_known(source),
                        pull: pulls.map_or(0.0, |pulls| pulls.0[lane]),
                        in_impact: groups.wall_impacts[number].speed[lane] > 0.0,
                        angular_impulse: torques.map_or([0.0; 3], |lanes| lanes.torques.angular_impulse(lane)),
                        velocities: [before, after],
                        spins: [spin_before, spin],
                    };
                    visit(place, &one);
                }
            }
        }
    }

    /// Work of the walls on the grains in the last step, J.
    pub(crate) fn work_of_walls(&self) -> f64 {
        let mut work = self.work_outside_of_the_solve;
        if self.world.walls.any_works() {
            self.for_each_wall_contact(|contact| work += contact.work());
        }
        work
    }

    /// Books an impulse of a wall on a grain after the ledger has booked the solve and before the grains move: its work, for
    /// ledger and watchdogs, and the parts lost to restitution and friction.
    pub(crate) fn book_wall_impulse(&mut self, one: &WallImpulse) {
        let WallImpulse { normal, before, after, impulse, wall_velocity, centre, arm, .. } = *one;
        let (gravity, h) = (<[f64; 3]>::from(self.world.gravity), self.settings.step);
        let work = dot(impulse, wall_velocity);
        self.work_outside_of_the_solve += work;
        self.note_wall_impulse(one);
        let Some(ledger) = &mut self.ledger else { return };
        let entries = &mut ledger.entries;
        // As for all contacts, the velocity gained from gravity in this step does not count before.
        let mean = times(plus(plus(before, after), times(gravity, h)), 0.5);
        let along = dot(normal, impulse);
        entries.walls += work;
        entries.restitution += along * dot(normal, mean);
        entries.friction += dot(minus(impulse, times(normal, along)), mean);
        entries.wall_impulse = plus(entries.wall_impulse, impulse);
        entries.wall_angular_impulse = plus(entries.wall_angular_impulse, cross(plus(centre, arm), impulse));
    }
}
