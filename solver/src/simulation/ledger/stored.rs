//! What contacts store, and what the ledger expects them to store once a step's velocities have moved them.

use crate::detect::Candidates;
use crate::effects::cohesion::Pull;
use crate::effects::compliance::{NormalContact, NormalLaw};
use crate::simulation::energy::ContactEnergy;
use crate::wall::Pose;
use crate::world::World;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Energy that contacts store, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Stored {
    pub elastic: f64,
    pub cohesive: f64,
}

impl Stored {
    /// Of one contact.
    pub fn of(contact: &NormalContact<f64>, pull: &Pull, law: NormalLaw) -> Stored {
        Stored { elastic: contact.elastic_energy(law), cohesive: pull.energy(-contact.overlap) }
    }

    /// Of all that a candidate list knows.
    pub fn of_all(world: &World, candidates: &Candidates, law: NormalLaw) -> Stored {
        let ContactEnergy { elastic, cohesive, .. } = ContactEnergy::of(world, candidates, law);
        Stored { elastic, cohesive }
    }

    pub fn total(&self) -> f64 {
        self.elastic + self.cohesive
    }
}

/// What one contact should store at the end of a step, J; absent where nothing worked for it, because nothing acted at the start.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Expected {
    pub elastic: Option<f64>,
    pub cohesive: Option<f64>,
}

/// What came otherwise, J: see the entries of [`Balance`](super::Balance).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Differences {
    pub first_touch: f64,
    pub turning: f64,
    pub let_go: f64,
    pub wall_paths: f64,
}

impl Differences {
    fn add_pair(&mut self, stored: f64, expected: Option<f64>) {
        match expected {
            Some(expected) => self.turning += stored - expected,
            None => self.first_touch += stored,
        }
    }

    /// `beside` is what it would store if the wall had gone on straight along the normal; absent where the contact is no more.
    fn add_wall(&mut self, stored: f64, beside: Option<f64>, expected: Option<f64>) {
        match (expected, beside) {
            (Some(expected), Some(beside)) => {
                self.turning += beside - expected;
                self.wall_paths += stored - beside;
            }
            (Some(expected), None) => self.let_go += expected - stored,
            (None, _) => self.first_touch += stored,
        }
    }
}

/// What the candidates of a step are expected to store at its end; its buffers are kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Expectations {
    /// By candidate.
    pub pairs: Vec<Expected>,
    /// By candidate.
    pub walls: Vec<Expected>,
    /// How far the walls should advance along the normals, m, by candidate.
    pub advances: Vec<[f64; 3]>,
    /// Walls at the start of the step.
    pub poses: Vec<Pose>,
}

impl Expectations {
    /// Expects nothing yet of a step of length `h`, s.
    pub fn restart(&mut self, world: &World, candidates: &Candidates, h: f64) {
        self.pairs.clear();
        self.pairs.resize(candidates.pairs.len(), Expected::default());
        self.walls.clear();
        self.walls.resize(candidates.walls.len(), Expected::default());
        self.advances.clear();
        self.advances.resize(candidates.walls.len(), [0.0; 3]);
        self.poses.clear();
        self.poses.extend(world.walls.poses_over(world.time, h));
    }

    /// Compares with the state that the step has led to; returns what is stored.
    pub fn compare(
        &self,
        world: &World,
        candidates: &Candidates,
        law: NormalLaw,
        differences: &mut Differences,
    ) -> Stored {
        let mut sum = Stored::default();
        for (pair, expected) in candidates.pairs.iter().zip(&self.pairs) {
            let (contact, pull) = world.pair_contact(pair);
            let stored = Stored::of(&contact, &pull, law);
            differences.add_pair(stored.elastic, expected.elastic);
            differences.add_pair(stored.cohesive, expected.cohesive);
            sum = sum.plus(stored);
        }
        let poses: Vec<_> = world.walls.poses(world.time).collect();
        let (before, after) = (world.walls.placed(&self.poses), world.walls.placed(&poses));
        for ((wall, expected), advance) in candidates.walls.iter().zip(&self.walls).zip(&self.advances) {
            let centre = &world.spheres[wall.body as usize].centre;
            let distance = after.face(wall.surface).distance(centre);
            let beside = before.face(wall.surface).distance(&(centre - Vector3::from(*advance)));
            let at = |distance: f64| {
                let (contact, pull) = world.wall_contact(wall, distance);
                Stored::of(&contact, &pull, law)
            };
            let stored = at(distance);
            let beside = (distance.is_finite() && beside.is_finite()).then(|| at(beside));
            differences.add_wall(stored.elastic, beside.map(|one| one.elastic), expected.elastic);
            differences.add_wall(stored.cohesive, beside.map(|one| one.cohesive), expected.cohesive);
            sum = sum.plus(stored);
        }
        sum
    }
}

impl Stored {
    fn plus(self, other: Stored) -> Stored {
        Stored { elastic: self.elastic + other.elastic, cohesive: self.cohesive + other.cohesive }
    }
}

#[cfg(test)]
mod tests {
    use super::Differences;

    #[test]
    fn each_cause_has_its_entry() {
        let mut differences = Differences::default();
        differences.add_pair(3.0, None);
        differences.add_pair(3.0, Some(1.0));
        differences.add_wall(3.0, Some(2.5), Some(1.0));
        differences.add_wall(0.0, None, Some(4.0));
        differences.add_wall(5.0, None, None);
        let Differences { first_touch, turning, let_go, wall_paths } = differences;
        assert_eq!([first_touch, turning, let_go, wall_paths], [8.0, 3.5, 4.0, 0.5]);
    }
}
