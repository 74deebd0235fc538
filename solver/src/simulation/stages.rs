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
use crate::scene::{Scene, SolverSettings, Stage, StageEnd};
use crate::wall::Beginning;
use crate::world::MaterialTable;
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
}

/// Present stage of a simulation, or stage of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PresentStage {
    /// Number in the scene, from 0.
    pub number: u32,
    /// Time of its start, s.
    pub start: f64,
    /// Steps taken before its start.
    pub before: u64,
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

impl StageState {
    /// Returns the number of the present stage.
    pub fn number(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Returns the times at which the stages so far have begun, s.
    pub fn times(&self) -> Vec<f64> {
        self.starts.iter().map(|start| start.0).collect()
    }

    /// Returns true if a run of the scene can have this state after the given number of steps.
    pub fn is_sound(&self, scene: &Scene, steps: u64) -> bool {
        let rises = self.starts.is_sorted_by(|a, b| a.0 <= b.0 && a.1 <= b.1);
        let walls = self.beginnings.iter().all(|(&wall, begun)| {
            (wall as usize) < scene.wall.len() && begun.pose.is_sound() && begun.time.is_finite()
        });
        let numbers = self.starts.iter().copied().chain([self.clock, (self.removed, 0)]);
        let finite = { numbers }.all(|(number, before)| number.is_finite() && before <= steps);
        (1..=scene.stage.len()).contains(&self.starts.len()) && rises && walls && finite
    }
}

impl Stages {
    /// Returns the first stage of a scene; `None` without stages.
    pub fn of(scene: &Scene) -> Option<Stages> {
        let state = StageState { starts: vec![(0.0, 0)], ..StageState::default() };
        (!scene.stage.is_empty()).then(|| Stages { scene: Arc::new(scene.clone()), state })
    }

    /// Returns the scene of the present stage. Limits of later stages have no influence on it.
    pub fn present(&self) -> Scene {
        Scene { duration: f64::INFINITY, ..self.scene.in_stage(self.state.number(), &self.state.times()) }
    }

    fn stage(&self) -> &Stage {
        &self.scene.stage[self.state.number()]
    }
}

impl Simulation {
    /// Returns the stages that have begun, the present one last; none for a scene without stages.
    pub fn stages(&self) -> Vec<StageReport> {
        let Some(Stages { scene, state, .. }) = &self.stages else { return Vec::new() };
        let now = (self.world.time, self.steps);
        let ends = state.starts.iter().skip(1).chain([&now]);
        let each = scene.stage.iter().zip(&state.starts).zip(ends).enumerate();
        let report = |(number, ((stage, start), end))| {
            let (stage, &(start, before), &(end, steps)): (&Stage, &(f64, u64), &(f64, u64)) = (stage, start, end);
            let ended = number < state.number() || state.ended;
            StageReport { name: stage.name.clone(), start, end, steps: steps - before, ended }
        };
        each.map(report).collect()
    }

    /// Returns the present stage: the stage of the last step; `None` for a scene without stages.
    pub fn stage(&self) -> Option<PresentStage> {
        let state = &self.stages.as_ref()?.state;
        let (start, before) = state.starts[state.number()];
        let (number, steps) = (state.number() as u32, self.steps - before);
        Some(PresentStage { number, start, before, steps, ended: state.ended })
    }

    /// Returns the beginnings of the motions that stages have given to walls, by the number of the wall.
    pub(crate) fn beginnings(&self) -> Vec<(u32, Beginning)> {
        let known = self.stages.iter().flat_map(|stages| &stages.state.beginnings);
        known.map(|(wall, beginning)| (*wall, *beginning)).collect()
    }

    /// Returns true once the last stage of the scene has reached its end; later steps belong to it too.
    pub fn has_ended(&self) -> bool {
        let is_last = |Stages { scene, state }: &Stages| state.number() + 1 == scene.stage.len();
        self.stages.as_ref().is_some_and(|stages| stages.state.ended && is_last(stages))
    }

    /// Returns the value of the condition of the present stage and its bound (J per grain, N or kg), if it has not held within the longest
    /// time of the stage: a run should end then.
    pub fn overdue(&self) -> Option<[f64; 2]> {
        let (stage, present) = (self.stages.as_ref()?.stage(), self.stage()?);
        let late = !present.ended && present.steps >= steps_of(stage.longest(), self.settings.step);
        stage.until.as_ref().filter(|_| late).map(|until| self.condition(until))
    }

    /// Value of a condition and its bound: kinetic energy per grain, J, force, N, or mass, kg.
    fn condition(&self, until: &StageEnd) -> [f64; 2] {
        match until {
            StageEnd::KineticEnergy(bound) => [self.energy_of_grains().kinetic / self.grains() as f64, *bound],
            StageEnd::WallForce { wall, force } => {
                let walls = self.stages.iter().flat_map(|stages| &stages.scene.wall);
                let number = walls.map(|one| &one.name).position(|name| name == wall).unwrap_or_default();
                [self.force_on(number as u32).norm(), *force]
            }
            StageEnd::RemovedMass(mass) => {
                let before = self.stages.as_ref().map_or(0.0, |stages| stages.state.removed);
                [self.passed()[1].mass - before, *mass]
            }
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
    pub(super) fn judge_stage(&mut self) {
        let (Some(stages), Some(present)) = (&self.stages, self.stage()) else { return };
        let (stage, h) = (stages.stage(), self.settings.step);
        let limit = if stage.until.is_some() { stage.at_least } else { stage.longest() };
        let to_come = || self.flow.as_ref().is_some_and(Flow::has_grains_to_come);
        let holds = |until: &StageEnd| match (until, self.condition(until)) {
            (StageEnd::KineticEnergy(_), [value, bound]) => value <= bound && !to_come(),
            (_, [value, bound]) => value >= bound,
        };
        let ended = present.steps >= steps_of(limit, h) && stage.until.as_ref().is_none_or(holds);
        self.stages.iter_mut().for_each(|stages| stages.state.ended |= ended);
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
        let (own, old) = (&self.settings, &before.solver);
        // Settings of the caller hold in all stages.
        let settings = SolverSettings {
            stop: unless_changed(own.stop, old.stop, after.solver.stop),
            method: unless_changed(own.method, old.method, after.solver.method),
            precision: unless_changed(own.precision, old.precision, after.solver.precision),
            ..after.solver.clone()
        };
        if settings.step != self.settings.step {
            stages.state.clock = now;
        }
        let is_same = (&before.gravity, &before.gravity_changes, &before.material, &self.settings)
            == (&after.gravity, &after.gravity_changes, &after.material, &settings);
        if !(is_same && motions.is_empty()) {
            let beginnings = &mut stages.state.beginnings;
            let mut world = self.world.without_grains();
            (world.table, world.field) = (MaterialTable::new(&after), after.gravity_field());
            world.gravity = world.field.at(now.0);
            for (number, _) in (0..).zip(&after.wall).filter(|(_, wall)| motions.contains_key(&wall.name)) {
                let beginning = world.walls.reached(number, now.0);
                world.begin_motion(number, &after.course(number as usize), &beginning);
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

/// Returns the value of the next stage, unless the caller has changed that of the present one.
fn unless_changed<T: PartialEq>(own: T, before: T, after: T) -> T {
    if own == before { after } else { own }
}

fn steps_of(time: f64, step: f64) -> u64 {
    (time / step).round() as u64
}
