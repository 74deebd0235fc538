//! Progress through the stages of a scene.
//!
//! The end of a stage is judged after each step, and the next stage begins at the start of the next step, so that a frame or a
//! checkpoint between them is one of the stage that ends. If settings or motions change, the simulation restarts at its present
//! time with its grains, in id order, and the impulses of their contacts, as after an insertion; otherwise nothing changes.

use super::Simulation;
use super::checkpoint::state::State;
use super::flow::Flow;
use super::swept::Struck;
use crate::lanes::plus;
use crate::scene::{Scene, Stage, StageEnd};
use crate::schedule::{Phase, Runs, Team};
use crate::wall::Beginning;
use crate::world::{Body, INERTIA, chunk, chunks};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Position in the stages of a scene, which with the scene determines its later stages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct StageState {
    /// Start of each stage so far: time, s, and steps taken before it.
    pub starts: Vec<(f64, u64)>,
    /// Time (s) and steps of the last change of the time step, from which the time is counted.
    pub clock: (f64, u64),
    /// Poses and times at which walls have begun the motion of a stage, by the number of the wall in the scene.
    pub beginnings: BTreeMap<u32, Beginning>,
    /// Mass in the sinks at the start of the stage, kg.
    removed: f64,
    /// True if the stage has reached its end.
    ended: bool,
}

/// Stages of a scene in progress.
#[derive(Clone, Debug)]
pub(crate) struct Stages {
    pub scene: Arc<Scene>,
    pub state: StageState,
    /// Kinetic energy of each chunk of grains, J.
    energies: Vec<f64>,
}

/// Present stage of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PresentStage {
    /// Number in the scene, from 0.
    pub number: usize,
    /// Time of its start, s.
    pub start: f64,
    /// Steps taken in it.
    pub steps: u64,
    /// True if it has reached its end.
    pub ended: bool,
}

/// Stage of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageReport {
    /// Name.
    pub name: String,
    /// Time of its start, s.
    pub start: f64,
    /// Time of its end, or the present time, s.
    pub end: f64,
    /// Steps taken in it.
    pub steps: u64,
    /// True if it has reached its end.
    pub ended: bool,
}

/// Stage that has not ended within its longest time, with the value of its condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overdue {
    /// Number of the stage in the scene, from 0.
    pub stage: u32,
    /// Key of the condition.
    pub key: &'static str,
    /// Present value.
    pub value: f64,
    /// Value at which it ends.
    pub bound: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// Longest time, s.
    pub at_most: f64,
}

impl StageState {
    /// Returns the number of the present stage.
    pub fn number(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Returns the times at which the stages so far have begun, s.
    pub fn times(&self) -> Vec<f64> {
        self.starts.iter().map(|start| start.0).collect()
    }

    /// Returns true if the state is one of this scene.
    pub fn fits(&self, scene: &Scene) -> bool {
        let walls = self.beginnings.keys().all(|&wall| (wall as usize) < scene.wall.len());
        (1..=scene.stage.len()).contains(&self.starts.len()) && walls
    }

    /// Returns true if a run can have this state after the given number of steps.
    pub fn is_sound(&self, steps: u64) -> bool {
        let rises = self.starts.windows(2).all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 <= pair[1].1);
        let last = self.starts.last().is_some_and(|last| last.1 <= steps) && self.clock.1 <= steps;
        let poses = self.beginnings.values().all(|begun| begun.pose.is_sound() && begun.time.is_finite());
        rises && last && poses && self.times().iter().chain([&self.clock.0, &self.removed]).all(|number| number.is_finite())
    }
}

impl Stages {
    /// Returns the first stage of a scene; `None` without stages.
    pub fn of(scene: &Scene) -> Option<Stages> {
        let state = StageState { starts: vec![(0.0, 0)], ..StageState::default() };
        (!scene.stage.is_empty()).then(|| Stages::at(scene, state))
    }

    /// Returns the stages of a scene at a state.
    pub fn at(scene: &Scene, state: StageState) -> Stages {
        Stages { scene: Arc::new(scene.clone()), state, energies: Vec::new() }
    }

    /// Returns the scene of the present stage. Limits of later stages have no influence on it.
    pub fn present(&self) -> Scene {
        Scene { duration: f64::INFINITY, ..self.scene.in_stage(self.state.number(), &self.state.times()) }
    }

    fn stage(&self) -> &Stage {
        &self.scene.stage[self.state.number()]
    }

    fn steps(&self, taken: u64) -> u64 {
        taken - self.state.starts[self.state.number()].1
    }
}

impl Simulation {
    /// Returns the stages that have begun, the present one last; none for a scene without stages.
    pub fn stages(&self) -> Vec<StageReport> {
        let Some(Stages { scene, state, .. }) = &self.stages else { return Vec::new() };
        let now = (self.world.time, self.steps);
        let ends = state.starts.iter().skip(1).chain([&now]);
        let each = scene.stage.iter().zip(&state.starts).zip(ends).enumerate();
        let report = |(number, ((stage, start), end)): (usize, ((&Stage, &(f64, u64)), &(f64, u64)))| StageReport {
            name: stage.name.clone(),
            start: start.0,
            end: end.0,
            steps: end.1 - start.1,
            ended: number < state.number() || state.ended,
        };
        each.map(report).collect()
    }

    /// Returns the present stage: the stage of the last step; `None` for a scene without stages.
    pub fn stage(&self) -> Option<PresentStage> {
        let stages = self.stages.as_ref()?;
        let number = stages.state.number();
        let (start, steps) = (stages.state.starts[number].0, stages.steps(self.steps));
        Some(PresentStage { number, start, steps, ended: stages.state.ended })
    }

    /// Returns the beginnings of the motions that stages have given to walls, by the number of the wall.
    pub(crate) fn beginnings(&self) -> Vec<(u32, Beginning)> {
        let known = self.stages.iter().flat_map(|stages| &stages.state.beginnings);
        known.map(|(wall, beginning)| (*wall, *beginning)).collect()
    }

    /// Returns true once the last stage of the scene has reached its end; later steps belong to it too.
    pub fn has_ended(&self) -> bool {
        self.stages.as_ref().is_some_and(|stages| stages.state.ended && stages.state.number() + 1 == stages.scene.stage.len())
    }

    /// Returns the present stage if its condition has not held within its longest time: a run should end then.
    pub fn overdue(&self) -> Option<Overdue> {
        let stages = self.stages.as_ref()?;
        let (stage, until) = (stages.stage(), stages.stage().until.as_ref()?);
        let is_late = !stages.state.ended && stages.steps(self.steps) >= stage.most_steps(self.settings.step);
        let (value, (key, bound, unit)) = (self.present_value(until), match until {
            StageEnd::KineticEnergy(bound) => ("kinetic_energy", *bound, "J per grain"),
            StageEnd::WallForce { force, .. } => ("wall_force", *force, "N"),
            StageEnd::RemovedMass(mass) => ("removed_mass", *mass, "kg"),
        });
        let number = stages.state.number() as u32;
        is_late.then(|| Overdue { stage: number, key, value, bound, unit, at_most: stage.longest() })
    }

    /// Value of a condition: kinetic energy per grain, J, force, N, or mass, kg.
    fn present_value(&self, until: &StageEnd) -> f64 {
        let Some(stages) = &self.stages else { return 0.0 };
        match until {
            StageEnd::KineticEnergy(_) => stages.energies.iter().sum::<f64>() / self.world.grains() as f64,
            StageEnd::WallForce { wall, .. } => {
                let wall = stages.scene.wall.iter().position(|one| one.name == *wall);
                self.force_on(wall.unwrap_or_default() as u32).norm()
            }
            StageEnd::RemovedMass(_) => self.passed()[1].mass - stages.state.removed,
        }
    }

    /// Sum of the contact forces of the last step on a wall, N.
    fn force_on(&self, wall: u32) -> Vector3<f64> {
        let (mut impulse, wall_of) = ([0.0; 3], |face: u32| self.world.walls.wall_of(face));
        self.for_each_wall_contact(|one| {
            if wall_of(one.candidate.surface) == wall {
                impulse = plus(impulse, one.impulse());
            }
        });
        for strike in &self.swept.strikes {
            if matches!(strike.struck, Struck::Face(face) if wall_of(face) == wall) {
                impulse = plus(impulse, (strike.normal * strike.along + strike.tangential).into());
            }
        }
        Vector3::from(impulse) / self.settings.step
    }

    /// Judges after a step whether the stage has reached its end.
    pub(super) fn judge_stage(&mut self, team: &Team) {
        let Some(stages) = &mut self.stages else { return };
        if let Some(StageEnd::KineticEnergy(_)) = stages.stage().until {
            let mut energies = std::mem::take(&mut stages.energies);
            self.kinetic_energies(&mut energies, team);
            self.stages.iter_mut().for_each(|stages| stages.energies = std::mem::take(&mut energies));
        }
        let meets = self.meets_end();
        self.stages.iter_mut().for_each(|stages| stages.state.ended |= meets);
    }

    fn meets_end(&self) -> bool {
        let Some(stages) = &self.stages else { return false };
        let (stage, steps, h) = (stages.stage(), stages.steps(self.steps), self.settings.step);
        let Some(until) = &stage.until else { return steps >= stage.most_steps(h) };
        if steps < (stage.at_least / h).round() as u64 {
            return false;
        }
        let value = self.present_value(until);
        match until {
            StageEnd::KineticEnergy(bound) => {
                let to_come = self.flow.as_ref().is_some_and(Flow::has_grains_to_come);
                value <= *bound && self.world.grains() > 0 && !to_come
            }
            StageEnd::WallForce { force: least, .. } | StageEnd::RemovedMass(least) => value >= *least,
        }
    }

    /// Sums the kinetic energy of each chunk of grains, J: the same bits on any number of threads.
    fn kinetic_energies(&self, energies: &mut Vec<f64>, team: &Team) {
        let grains = self.world.grains();
        energies.resize(chunks(grains), 0.0);
        team.each_with(Phase::Integrate, chunks(grains), Runs::of(energies, 1), |number, energy| {
            let square = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
            let bodies = self.world.bodies[chunk(number, grains)].iter();
            let of_body = |body: &Body| {
                0.5 / body.inverse_mass * (square(&body.velocity) + INERTIA * square(&body.scaled_spin))
            };
            energy[0] = bodies.map(of_body).sum();
        });
    }

    /// Begins the next stage, if the present one has ended.
    pub(super) fn enter_stage(&mut self) {
        let is_due = |stages: &&mut Stages| stages.state.ended && stages.state.number() + 1 < stages.scene.stage.len();
        let (now, removed) = ((self.world.time, self.steps), self.passed()[1].mass);
        let Some(stages) = self.stages.as_mut().filter(is_due) else { return };
        let before = stages.present();
        (stages.state.ended, stages.state.removed) = (false, removed);
        stages.state.starts.push(now);
        let after = stages.present();
        let motions = stages.stage().motion.clone();
        let mut settings = after.solver.clone();
        // Settings of the caller hold in all stages.
        if self.settings.stop != before.solver.stop {
            settings.stop = self.settings.stop;
        }
        if self.settings.method != before.solver.method {
            settings.method = self.settings.method;
        }
        if self.settings.precision != before.solver.precision {
            settings.precision = self.settings.precision;
        }
        if settings.step != self.settings.step {
            stages.state.clock = now;
        }
        let is_same = (&before.gravity, &before.gravity_changes, &before.material, &self.settings)
            == (&after.gravity, &after.gravity_changes, &after.material, &settings);
        if !(is_same && motions.is_empty()) {
            let beginnings = &mut stages.state.beginnings;
            let mut world = self.world.without_grains();
            world.set_scene(&after);
            world.set_time(now.0);
            for (number, wall) in (0..).zip(&after.wall).filter(|(_, wall)| motions.contains_key(&wall.name)) {
                let beginning = world.walls.reached(number, now.0);
                world.begin_motion(number, &wall.motion, &beginning);
                beginnings.insert(number, beginning);
            }
            let ids: Vec<Option<u32>> = (0..self.world.grains() as u32).map(Some).collect();
            self.begin_anew(world, &settings, &State::of(self), &ids, self.world.grains());
        }
        if let Some(flow) = &mut self.flow {
            flow.enter(&after, &self.world);
        }
    }
}
