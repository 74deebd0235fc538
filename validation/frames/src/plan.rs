//! Scene of the validation suite: the simulated scene, and its measurements and comparisons.
//!
//! One TOML document holds both parts, for two readers. The solver reads the simulated scene and skips the tables `prepare`, `measure`,
//! `output` and `compare`. This module reads these tables, and writes the whole document.

mod expectation;
mod hashes;
mod region;
mod roster;
mod stages;

pub use expectation::{Expectation, moment, observable_name};
pub use hashes::{physics_hash, scene_hash, setup_hash};
pub use region::CountedRegion;
pub use roster::{Alike, Kind, Roster, lasting_number};

use makadam::Simulation;
use makadam::scene::{Beforehand, Checked, Document, DocumentPath, Finding, Motion, SceneError, SceneFileError};
use makadam::wall::first_that_jumps_back;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ops::{Deref, DerefMut};
use std::path::Path;

/// Largest number of seeds of a comparison.
pub const MOST_SEEDS: u64 = 1000;

const MOST_FRAMES: f64 = 1e6;

/// Scene with its measurements; dereferences to the simulated scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredScene {
    /// The simulated scene.
    #[serde(flatten)]
    pub simulated: makadam::scene::Scene,
    /// Simulation before the run, for a start from a flowing state.
    pub prepare: Option<Prepare>,
    /// Observables and times of measurement.
    #[serde(default)]
    pub measure: Measure,
    /// Content and interval of the frames on disk; all content at the interval of `measure`, if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output: Option<Output>,
    /// Observables for the comparison of codes, with margins of equivalence.
    #[serde(default)]
    pub compare: Vec<Expectation>,
}

impl Deref for MeasuredScene {
    type Target = makadam::scene::Scene;

    fn deref(&self) -> &makadam::scene::Scene {
        &self.simulated
    }
}

impl DerefMut for MeasuredScene {
    fn deref_mut(&mut self) -> &mut makadam::scene::Scene {
        &mut self.simulated
    }
}

/// The judge's tables of a document.
#[derive(Deserialize, JsonSchema)]
pub struct Tables {
    /// Simulation before the run, for a start from a flowing state.
    #[serde(default)]
    prepare: Option<Prepare>,
    /// Observables and times of measurement.
    #[serde(default)]
    measure: Measure,
    /// Content and interval of the frames on disk.
    #[serde(default)]
    output: Option<Output>,
    /// Observables for the comparison of codes, with margins of equivalence.
    #[serde(default)]
    compare: Vec<Expectation>,
}

/// Schema of the simulated scene, with the tables of the validation suite.
impl JsonSchema for MeasuredScene {
    fn schema_name() -> Cow<'static, str> {
        "Scene".into()
    }

    fn schema_id() -> Cow<'static, str> {
        concat!(module_path!(), "::Scene").into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut scene = makadam::scene::Scene::json_schema(generator);
        let tables = Tables::json_schema(generator).to_value();
        let more = tables["properties"].as_object().cloned().unwrap_or_default();
        if let Some(properties) = scene.get_mut("properties").and_then(|properties| properties.as_object_mut()) {
            properties.extend(more);
        }
        // Keys with their default value are omitted.
        let is_left_out = |key: &serde_json::Value| {
            [
                "gravity_changes",
                "largest_start_overlap",
                "unusual_values",
                "watch",
                "insert",
                "remove",
                "stage",
                "gauge",
            ]
            .iter()
            .any(|known| key == known)
        };
        if let Some(required) = scene.get_mut("required").and_then(|required| required.as_array_mut()) {
            required.retain(|key| !is_left_out(key));
            if generator.contract().is_serialize() {
                required.extend(["prepare", "measure", "compare"].map(serde_json::Value::from));
            }
        }
        scene
    }
}

impl MeasuredScene {
    /// Reads and checks the text of a scene.
    pub fn parse(text: &str) -> Result<MeasuredScene, SceneError> {
        MeasuredScene::parse_in(text, Path::new(""))
    }

    /// Reads and checks the text of a scene; `folder` is the folder of the files that the text names by relative paths.
    pub fn parse_in(text: &str, folder: &Path) -> Result<MeasuredScene, SceneError> {
        MeasuredScene::read(&Document::parse(text)?.in_folder(folder))
    }

    /// Reads and checks a document.
    pub fn read(document: &Document<'_>) -> Result<MeasuredScene, SceneError> {
        let simulated = makadam::scene::Scene::read(document)?;
        let Tables { prepare, measure, output, compare } = document.read()?;
        let mut scene = MeasuredScene { simulated, prepare, measure, output, compare };
        scene.check()?;
        scene.compare = scene.compare.iter().flat_map(Expectation::each).collect();
        Ok(scene)
    }

    /// Reads and checks a scene file.
    pub fn load(file: &Path) -> Result<MeasuredScene, SceneFileError> {
        let missing = |source| SceneFileError::Missing { file: file.to_path_buf(), source };
        let text = std::fs::read_to_string(file).map_err(missing)?;
        let scene = MeasuredScene::parse_in(&text, file.parent().unwrap_or(Path::new("")));
        scene.map_err(|error| error.in_file(file, Some(&text)))
    }

    /// Checks all keys of the scene.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first error.
    pub fn check(&self) -> Result<(), SceneError> {
        self.check_tables()?;
        match self.beforehand() {
            Some(beforehand) => self.simulated.check_after(beforehand)?,
            None => self.simulated.check()?,
        }
        Ok(self.check_walls_at_start()?)
    }

    /// Returns preflight warnings; `text` is the text of the scene file, for line numbers.
    pub fn findings(&self, text: Option<&str>) -> Vec<Finding> {
        self.simulated.findings_after(self.beforehand(), text)
    }

    /// Returns the scene with every Young's modulus multiplied by `factor`.
    pub fn with_stiffness_factor(&self, factor: f64) -> MeasuredScene {
        MeasuredScene { simulated: self.simulated.with_stiffness_factor(factor), ..self.clone() }
    }

    /// Returns the scene with walls that stand alone, each with its motion and that of the walls that carry it.
    pub fn with_own_motions(&self) -> MeasuredScene {
        let mut own = self.clone();
        for (index, wall) in own.simulated.wall.iter_mut().enumerate() {
            (wall.motion, wall.parent) = (self.course(index), None);
        }
        own
    }

    /// Lets a simulation record the loads and the wear of walls, if they are measured.
    pub fn record_walls(&self, simulation: &mut Simulation) {
        let asks = |group: Observable| self.measure.observables.contains(&group);
        if asks(Observable::Walls) || asks(Observable::Wear) {
            simulation.record_walls(asks(Observable::Wear));
        }
    }

    /// Returns the time between frames on disk, s.
    pub fn output_interval(&self) -> f64 {
        self.output.as_ref().and_then(|output| output.interval).unwrap_or(self.measure.interval)
    }

    fn beforehand(&self) -> Option<Beforehand> {
        self.prepare.as_ref().map(|prepare| Beforehand { duration: prepare.duration, step: prepare.step })
    }

    /// Refuses walls that would jump at the start of the run, where the clock restarts at zero.
    fn check_walls_at_start(&self) -> Checked {
        let Some(Prepare { duration, step }) = self.prepare else { return Ok(()) };
        let until = (duration / step).round() * step;
        match first_that_jumps_back(&self.wall, &self.domain, until) {
            None => Ok(()),
            Some(index) => {
                let problem = format!(
                    "wall '{}' moves in the {duration} s of [prepare], and would jump back as the run begins at time 0",
                    self.wall[index].name
                );
                let whole = match self.wall[index].motion {
                    Motion::Vibrating { .. } => "let prepare.duration be a whole number of periods from start = 0, ",
                    Motion::Rotating { .. } => "let prepare.duration be a whole number of turns, ",
                    _ => "",
                };
                let remedy =
                    format!("{whole}give start = {duration} or later (of the run's clock too), or leave out [prepare]");
                Err(DocumentPath::default().key("wall").index(index).key("motion").fault(problem, &remedy))
            }
        }
    }

    fn check_tables(&self) -> Checked {
        let root = DocumentPath::default();
        if self.prepare.is_some() && self.flows() {
            let problem = "given where grains come or go, whose times would begin twice".into();
            return Err(root.key("prepare").fault(problem, "leave [prepare] out, or [[insert]] and [[remove]]"));
        }
        if let Some(prepare) = &self.prepare {
            root.key("prepare").key("duration").range(prepare.duration, 0.0, 1e5, "s")?;
            let at = root.key("prepare").key("step");
            at.usual(prepare.step, [1e-9, 0.1], [1e-15, 0.1], self.unusual_values, "s")?;
        }
        if self.prepare.is_some() && !self.stage.is_empty() {
            let problem = "given in addition to stages".into();
            return Err(root.key("prepare").fault(problem, "leave [prepare] out, and let the first stage do it"));
        }
        let (at, measured) = (root.key("measure"), self.measured_stage());
        if let Some(name) = self.measure.stage.as_ref().filter(|_| measured.is_none()) {
            let names: Vec<&str> = self.stage.iter().map(|stage| stage.name.as_str()).collect();
            let remedy = match names.is_empty() {
                true => "leave it out".into(),
                false => format!("name one of: {}", names.join(", ")),
            };
            return Err(at.key("stage").fault(format!("there is no stage '{name}'"), &remedy));
        }
        let duration = measured.map_or(self.duration, |(_, stage)| stage.longest());
        let Measure { interval, from, .. } = self.measure;
        at.key("from").range(from.unwrap_or(0.0), 0.0, duration, "s")?;
        for (table, interval) in [("measure", interval), ("output", self.output_interval())] {
            let at = root.key(table).key("interval");
            at.usual(interval, [1e-6, 1e5], [1e-15, 1e5], self.unusual_values, "s")?;
            few_frames(&at, interval, self.duration)?;
        }
        for (number, stage) in self.stage.iter().enumerate() {
            let at = root.key("stage").index(number).key("output").key("interval");
            few_frames(&at, self.output_interval_in(Some(number)), stage.longest())?;
        }
        at.key("seeds").range(self.measure.seeds.unwrap_or(2) as f64, 2.0, MOST_SEEDS as f64, "seeds")?;
        at.key("rest_energy").range(self.measure.rest_energy.unwrap_or(1.0), 1e-30, 1e6, "J per grain")?;
        if self.measure.lacks_energy() {
            let problem = "runs at rest are known by their kinetic energy, and balances are not measured".into();
            return Err(at.key("rest_energy").fault(problem, "add balances to measure.observables"));
        }
        region::check(self)?;
        expectation::check(self)?;
        Ok(())
    }
}

/// Refuses an interval (s) with too many frames in a time, s.
fn few_frames(at: &DocumentPath, interval: f64, duration: f64) -> Checked {
    match duration / interval > MOST_FRAMES {
        false => Ok(()),
        true => {
            let problem = format!("{interval} s within {duration} s are too many frames");
            Err(at.fault(problem, &format!("give one that leaves at most {MOST_FRAMES:e}")))
        }
    }
}

/// Times of frames, and observables averaged over them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Measure {
    /// Time between frames, s.
    pub interval: f64,
    /// Frames from this time on are measured, s. If absent, only the last frame is.
    pub from: Option<f64>,
    /// Name of the stage whose frames alone are measured; `from` then counts from its start. Default: all frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// Groups of observables.
    pub observables: Vec<Observable>,
    /// Regions whose grains are counted (observable `grain_count(region)`).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub region: Vec<CountedRegion>,
    /// Registered number of seeds: only seeds 1 to this number can agree. Without it none can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<u64>,
    /// Largest kinetic energy per grain of a run at rest, J: a comparison excludes runs above it. Default: all runs count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_energy: Option<f64>,
}

/// Tolerance of frame times over the interval: times are sums of steps, and the steps of other codes
/// are longer.
const OFF_DUE: f64 = 0.01;

impl Measure {
    /// Returns the tolerance of frame times, s.
    pub fn slack(&self) -> f64 {
        OFF_DUE * self.interval
    }

    /// Returns true if a rest energy is set and the energy is not measured.
    fn lacks_energy(&self) -> bool {
        self.rest_energy.is_some() && !self.observables.contains(&Observable::Balances)
    }

    /// Returns true for a frame at or after `from`, by its time (s).
    fn covers(&self, time: f64) -> bool {
        self.from.is_some_and(|from| time >= from - self.slack())
    }
}

impl Default for Measure {
    fn default() -> Self {
        Self {
            interval: 0.05,
            from: None,
            stage: None,
            observables: Vec::new(),
            region: Vec::new(),
            seeds: None,
            rest_energy: None,
        }
    }
}

/// Group of observables; underscores are read as hyphens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Observable {
    /// Angle of the flowing surface in a rotating drum.
    #[serde(alias = "dynamic_angle_of_repose")]
    DynamicAngleOfRepose,
    /// Angle of a heap at rest.
    #[serde(alias = "static_angle_of_repose")]
    StaticAngleOfRepose,
    /// Solid volume over volume in the bulk.
    #[serde(alias = "packing_fraction")]
    PackingFraction,
    /// Contacts per grain in the bulk.
    #[serde(alias = "coordination_number")]
    CoordinationNumber,
    /// Shape of the distribution of normal forces.
    #[serde(alias = "contact_forces")]
    ContactForces,
    /// Wall forces over weight, energy, overlap, Coulomb excess.
    Balances,
    /// Velocity profile, layer thickness, shell slip, wall torque.
    #[serde(alias = "drum_flow")]
    DrumFlow,
    /// Mixing and segregation by size.
    #[serde(alias = "size_mixing")]
    SizeMixing,
    /// Displacement of the first dynamic wall.
    #[serde(alias = "driven_wall")]
    DrivenWall,
    /// Force, torque and power of each wall.
    Walls,
    /// Wear of each wall by sliding and by impacts, which the solver sums while the scene measures it.
    Wear,
    /// Mass that goes into the sinks or, without sinks, passes through the hole of a disc, such as the floor of a silo.
    Discharge,
    /// Mass and grains through each gauge per time.
    Gauges,
    /// Height and speed of the first listed grain, such as a projectile.
    Intruder,
    /// Grains in each region of `measure.region`.
    Regions,
}

/// Simulation before the run, as the start instead of the jittered lattice. The clock of the run then starts at zero. Prescribed walls
/// stand at their position at time zero, dynamic walls stay. A wall that would jump is refused: its motion must start after `duration`, or
/// lead back to the same surface (a drum about its own axis, whole turns, whole periods).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Prepare {
    /// Time simulated beforehand, s.
    pub duration: f64,
    /// Time step used for it, s.
    pub step: f64,
}

/// Content, interval and export of frames: the table `output` of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between frames on disk, s; default: that of `measure`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// Fields of grains in exported frames, in addition to number, diameter and material; default: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<Vec<GrainField>>,
    /// Writes contacts.
    pub contacts: bool,
    /// Writes walls.
    pub walls: bool,
    /// Formats in which the frames of a complete run are exported into its folder, as `makadam export` does.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub formats: Vec<FrameFormat>,
}

/// Evaluates a macro with the table of formats: variant, module of [`export`](crate::export) and name in scenes and commands, program.
/// A new format takes one line here and its module.
macro_rules! with_frame_formats {
    ($table:ident) => {
        $table! {
            Vtp vtp "ParaView: one file per frame, and a script that opens them.",
            Vtkhdf vtkhdf "ParaView: one file for all frames of grains, contacts or walls.",
            Gsd gsd "OVITO and HOOMD-blue: grains over time.",
            Csv csv "Tables of the grains, for the start of a scene.",
            Fields fields "ParaView: coarse-grained fields of density, velocity and stress on a grid.",
        }
    };
}

macro_rules! declare_formats {
    ($($variant:ident $module:ident $program:literal,)*) => {
        /// A format of frames for other programs.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "kebab-case")]
        pub enum FrameFormat {
            $(#[doc = $program] $variant,)*
        }

        impl FrameFormat {
            /// All formats.
            pub const ALL: [FrameFormat; [$($program),*].len()] = [$(FrameFormat::$variant),*];

            /// Returns the name in commands and scenes.
            pub fn name(self) -> &'static str {
                match self {
                    $(FrameFormat::$variant => stringify!($module),)*
                }
            }
        }
    };
}

with_frame_formats!(declare_formats);
pub(crate) use with_frame_formats;

impl Default for Output {
    fn default() -> Self {
        Self { interval: None, fields: None, contacts: true, walls: true, formats: Vec::new() }
    }
}

/// A quantity of grains in the frames of a run; hyphens are read as underscores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GrainField {
    /// Index of the grain's population, or that of its source after all populations; -1 for a grain listed by itself.
    Population,
    /// Mass, kg.
    Mass,
    /// Magnitude of the velocity, m/s.
    Speed,
    /// Velocity, m/s.
    Velocity,
    /// Angular velocity, rad/s.
    #[serde(alias = "angular-velocity")]
    AngularVelocity,
    /// Sum of the contact forces on the grain, N.
    Force,
    /// Number of force-carrying contacts.
    #[serde(alias = "coordination-number")]
    CoordinationNumber,
    /// Symmetric part of the mean stress of the grain, pressure positive, Pa: xx, yy, zz, xy, yz, xz.
    Stress,
    /// A third of the trace of the stress, Pa.
    Pressure,
}
