//! Stages of a process, one after another: their ends, the settings that they change, and their checks.
//!
//! The settings of a stage hold in this stage alone, and all others are those of the scene. Motions last: a wall moves by the last
//! motion that a stage has given to it. So the scene of one stage is a scene without stages ([`Scene::in_stage`]).

use super::document::{Checked, DocumentPath};
use super::error::Fault;
use super::{Cohesion, GrainEntry, Insertion, Motion, Precision, Scene, SolverMethod, Stop, Wall, check, motion};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::Value;

/// Stage of a process: its end, and the settings that it changes.
///
/// A stage begins between two steps, at the end of the stage before it. Its settings hold in this stage alone; motions last until a
/// later stage names the wall.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Stage {
    /// Name, used in tables and files.
    pub name: String,
    /// Duration, s.
    pub duration: Option<f64>,
    /// Condition of its end, instead of `duration`.
    pub until: Option<StageEnd>,
    /// Shortest time until the condition can end it, s: grains that begin at rest have no kinetic energy either.
    pub at_least: f64,
    /// Longest time until the condition has to hold, s: a run ends with an error if it does not. Required with `until`.
    pub at_most: Option<f64>,
    /// Acceleration of gravity, m/s2; default: that of the scene, with its changes.
    pub gravity: Option<[f64; 3]>,
    /// Coefficients by the name of a material. Those of a `[[pair]]` take precedence, as they do in the scene.
    pub material: BTreeMap<String, StageMaterial>,
    /// New motions by the name of a wall, from the pose that the wall has reached. Times count from the start of the stage.
    pub motion: BTreeMap<String, Motion>,
    /// Settings of the solver.
    pub solver: StageSolver,
    /// Frames on disk.
    pub output: StageOutput,
}

/// Condition that ends a stage: one of these keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StageEnd {
    /// Largest mean kinetic energy, J per grain. It ends no stage without grains, or with a source that has grains to come.
    KineticEnergy(f64),
    /// Least force of the grains on a wall.
    WallForce {
        /// Name of the wall.
        wall: String,
        /// Magnitude of the sum of the contact forces, N.
        force: f64,
    },
    /// Least mass that goes into the sinks in the stage, kg.
    RemovedMass(f64),
}

/// Coefficients of a material in a stage, instead of those of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StageMaterial {
    /// Coulomb friction coefficient.
    pub friction: Option<f64>,
    /// Coulomb friction coefficient of a sliding contact.
    pub kinetic_friction: Option<f64>,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: Option<f64>,
    /// Coefficient of rolling friction.
    pub rolling_friction: Option<f64>,
    /// Coefficient of twisting friction.
    pub twisting_friction: Option<f64>,
    /// Cohesion.
    pub cohesion: Option<Cohesion>,
}

/// Settings of the solver in a stage, instead of those of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StageSolver {
    /// Time step, s.
    pub step: Option<f64>,
    /// Stopping rule of a solve.
    pub stop: Option<Stop>,
    /// Solution method.
    pub method: Option<SolverMethod>,
    /// Precision of the sweeps.
    pub precision: Option<Precision>,
}

/// Frames on disk in a stage; the solver ignores this table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StageOutput {
    /// Time between frames on disk, s; default: that of the scene.
    pub interval: Option<f64>,
}

impl Stage {
    /// Returns the duration, or the limit of a stage that ends by a condition, s.
    pub fn longest(&self) -> f64 {
        self.duration.or(self.at_most).unwrap_or(1.0)
    }
}

impl Scene {
    /// Returns the scene of one stage, without stages: its gravity, materials, solver settings, and the last motion of each wall.
    /// `starts` are the times (s) at which this stage and those before it have begun; a source or sink of a stage acts in it alone.
    ///
    /// The motions are those of the text: a motion of a stage counts its time from the start of its stage, and begins at the
    /// pose that the wall has reached.
    pub fn in_stage(&self, number: usize, starts: &[f64]) -> Scene {
        let mut scene = Scene { stage: Vec::new(), ..self.clone() };
        let Some(stage) = self.stage.get(number) else { return scene };
        if let Some(gravity) = stage.gravity {
            scene.gravity = gravity;
            scene.gravity_changes.clear();
        }
        for (name, own) in &stage.material {
            let Some(material) = scene.material.get_mut(name) else { continue };
            material.friction = own.friction.unwrap_or(material.friction);
            material.kinetic_friction = own.kinetic_friction.or(material.kinetic_friction);
            material.restitution = own.restitution.unwrap_or(material.restitution);
            material.rolling_friction = own.rolling_friction.unwrap_or(material.rolling_friction);
            material.twisting_friction = own.twisting_friction.unwrap_or(material.twisting_friction);
            material.cohesion = own.cohesion.or(material.cohesion);
        }
        for wall in &mut scene.wall {
            let given = self.stage[..=number].iter().rev().find_map(|stage| stage.motion.get(&wall.name));
            wall.motion = given.unwrap_or(&wall.motion).clone();
        }
        let (own, solver) = (&stage.solver, &mut scene.solver);
        solver.step = own.step.unwrap_or(solver.step);
        solver.stop = own.stop.unwrap_or(solver.stop);
        solver.method = own.method.unwrap_or(solver.method);
        solver.precision = own.precision.unwrap_or(solver.precision);
        let start = starts.get(number).copied().unwrap_or_default();
        let sources = scene.insert.iter_mut().map(|source| (&mut source.stage, &mut source.from, &mut source.until));
        let sinks = scene.remove.iter_mut().map(|sink| (&mut sink.stage, &mut sink.from, &mut sink.until));
        for (of, from, until) in sources.chain(sinks) {
            if let Some(name) = of.take() {
                *from = if name == stage.name { *from + start } else { f64::INFINITY };
                *until = until.map(|until| until + start);
            }
        }
        scene
    }

    /// Returns the scenes of all stages in order, as if each began after the longest time of those before; the scene itself if
    /// it has none.
    pub fn stage_scenes(&self) -> Vec<Scene> {
        let mut starts = Vec::new();
        let of_stage = |(number, stage): (usize, &Stage)| {
            starts.push(self.stage[..number].iter().map(Stage::longest).sum());
            Scene { duration: stage.longest(), ..self.in_stage(number, &starts) }
        };
        match self.stage.is_empty() {
            true => vec![self.clone()],
            false => self.stage.iter().enumerate().map(of_stage).collect(),
        }
    }

    /// Returns the largest number of steps of a run.
    pub fn most_steps(&self) -> u64 {
        let steps = |scene: &Scene| (scene.duration / scene.solver.step).round() as u64;
        self.stage_scenes().iter().map(steps).sum()
    }

    /// Returns a fault of the scene of a stage, with the path of the value in the stage if the stage gives it.
    pub(super) fn fault_in_stage(&self, number: usize, fault: Fault) -> Fault {
        let root = DocumentPath::default();
        let (at, stage) = (root.key("stage").index(number), &self.stage[number]);
        let own = Value::try_from(stage);
        let longest = if stage.duration.is_some() { "duration" } else { "at_most" };
        let motion = |(index, wall): (usize, &Wall)| {
            let given = stage.motion.contains_key(&wall.name);
            given.then(|| (root.key("wall").index(index).key("motion"), at.key("motion").name(&wall.name)))
        };
        let motions = self.wall.iter().enumerate().filter_map(motion);
        let fault = [(root.key("duration"), at.key(longest))].into_iter().chain(motions).fold(fault, Fault::moved);
        if own.is_ok_and(|own| fault.path.is_in(&own)) { fault.moved((root, at)) } else { fault }
    }

    /// Returns the longest time of all stages, s; `None` without stages.
    pub(super) fn longest_of_stages(&self) -> Option<f64> {
        (!self.stage.is_empty()).then(|| self.stage.iter().map(Stage::longest).sum())
    }
}

/// Checks the stages.
pub(super) fn check(scene: &Scene) -> Checked {
    let root = DocumentPath::default();
    check::own_names(&root.key("stage"), "stage", scene.stage.iter().map(|stage| &*stage.name))?;
    for (number, (stage, own)) in scene.stage.iter().zip(scene.stage_scenes()).enumerate() {
        let at = root.key("stage").index(number);
        end(scene, &at, stage)?;
        stage
            .material
            .keys()
            .try_for_each(|name| check::known_material(scene, &at.key("material").name(name), name))?;
        stage.motion.keys().try_for_each(|name| known_wall(scene, &at.key("motion").name(name), name))?;
        motion::check_parents_in_stage(scene, &at.key("motion"), &stage.motion)?;
        let checks = [check::gravity, check::materials, check::walls, check::solver];
        checks.iter().try_for_each(|check| check(&own)).map_err(|fault| scene.fault_in_stage(number, fault))?;
        if let Some(interval) = stage.output.interval {
            at.key("output").key("interval").usual(interval, [1e-6, 1e5], [1e-15, 1e5], scene.unusual_values, "s")?;
        }
    }
    let Some(sum) = scene.longest_of_stages().filter(|sum| *sum != scene.duration) else { return Ok(()) };
    let problem = format!("{} s, in addition to the stages, which last {sum} s at most", scene.duration);
    Err(root.key("duration").fault(problem, "leave it out: the durations of the stages give it"))
}

/// Checks the end of a stage.
fn end(scene: &Scene, at: &DocumentPath, stage: &Stage) -> Checked {
    let refuse = |key: &'static str, problem: &str, remedy: &str| Err(at.key(key).fault(problem.into(), remedy));
    at.key(if stage.duration.is_some() { "duration" } else { "at_most" }).range(stage.longest(), 1e-15, 1e5, "s")?;
    at.key("at_least").range(stage.at_least, 0.0, stage.longest(), "s, the longest time of the stage")?;
    let Some(until) = &stage.until else {
        return match (stage.duration, stage.at_most.is_some() || stage.at_least != 0.0) {
            (Some(_), false) => Ok(()),
            (Some(_), true) => refuse("duration", "given with limits, which are those of until", "leave them out"),
            (None, _) => Err(at.fault("has no end".into(), "give duration (s), or until and at_most (s)")),
        };
    };
    if stage.duration.is_some() {
        return refuse("until", "given in addition to duration", "leave one out, and give at_most with until");
    }
    if stage.at_most.is_none() {
        let remedy = "give the time (s) after which a run ends with an error";
        return refuse("at_most", "missing where until is given", remedy);
    }
    let (key, acts) = (at.key("until"), |of: &Option<String>| of.as_ref().is_none_or(|of| *of == stage.name));
    match until {
        StageEnd::KineticEnergy(bound) => {
            let at = key.key("kinetic_energy");
            at.range(*bound, 1e-30, 1e6, "J per grain")?;
            let endless = |source: &Insertion| acts(&source.stage) && source.total.is_none() && source.until.is_none();
            let words = |index| format!("never ends the stage: insert[{index}] gives grains without an end");
            at.refuse(scene.insert.iter().position(endless).map(words), "give the source a total or until")?;
            let rests = scene.grain.iter().all(|grain: &GrainEntry| grain.velocity == [0.0; 3])
                && scene.population.iter().all(|group| group.agitation == 0.0);
            let is_first = scene.grain_count() > 0 && scene.stage.first() == Some(stage);
            let problem = || "holds at the start, where all grains are at rest".into();
            let remedy = "give at_least, such as the time (s) in which the grains fall to their bed";
            at.require(!(rests && is_first && stage.at_least == 0.0), problem, remedy)
        }
        StageEnd::WallForce { wall, force } => {
            let at = key.key("wall_force");
            known_wall(scene, &at.key("wall"), wall)?;
            at.key("force").range(*force, 1e-30, 1e12, "N")
        }
        StageEnd::RemovedMass(_) if !scene.remove.iter().any(|sink| acts(&sink.stage)) => Err(key
            .key("removed_mass")
            .fault("no sink acts in this stage".into(), "add a [[remove]] with the region of one")),
        StageEnd::RemovedMass(mass) => key.key("removed_mass").range(*mass, 1e-30, 1e12, "kg"),
    }
}

fn known_wall(scene: &Scene, at: &DocumentPath, name: &str) -> Checked {
    let names: Vec<&str> = scene.wall.iter().map(|wall| wall.name.as_str()).collect();
    let remedy = format!("name one of: {}", names.join(", "));
    at.require(names.contains(&name), || format!("there is no wall '{name}'"), &remedy)
}

/// Checks the stage that a source or a sink names.
pub(super) fn known_stage(scene: &Scene, at: &DocumentPath, name: Option<&String>) -> Checked {
    let Some(name) = name.filter(|name| scene.stage.iter().all(|stage| stage.name != **name)) else { return Ok(()) };
    let names: Vec<&str> = scene.stage.iter().map(|stage| stage.name.as_str()).collect();
    let remedy = if names.is_empty() { "leave it out".into() } else { format!("name one of: {}", names.join(", ")) };
    Err(at.key("stage").fault(format!("there is no stage '{name}'"), &remedy))
}
