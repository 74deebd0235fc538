//! Scenes: the TOML file as typed data, in SI units, with range checks of all values.
//!
//! [`Scene::load`] is the entry point. An invalid file yields a [`SceneFileError`] that states the file, the line, the
//! problem and the remedy. An invalid text or a scene made in code yields a [`SceneError`] that names the value by its
//! path. [`populate`](populate()) generates the initial grains from a scene and a seed, the same for every code;
//! [`Scene::findings`] runs the preflight checks.
//!
//! ```
//! use makadam::{Scene, Simulation};
//!
//! let text = r#"
//!     name = "marble"
//!     description = "one grain that rolls down an incline"
//!     duration = 0.5
//!     domain = { min = [-1.0, -0.1, -1.0], max = [1.0, 0.1, 0.1] }
//!     [material.glass]
//!     density = 2500.0           # kg/m3
//!     youngs_modulus = 1e7       # Pa
//!     poisson_ratio = 0.3
//!     friction = 0.5
//!     restitution = 0.3
//!     [[wall]]
//!     name = "incline"
//!     material = "glass"
//!     shape = { kind = "plane", point = [0.0, 0.0, 0.0], normal = [0.5, 0.0, 1.0] }
//!     [[grain]]
//!     material = "glass"
//!     radius = 0.005             # m
//!     position = [0.0, 0.0, 0.0056]
//! "#;
//! let scene = Scene::parse(text)?;
//! let mut simulation = Simulation::new(&scene, 1)?;
//! while simulation.time() < scene.duration {
//!     simulation.step();
//! }
//! let [x, _, z] = simulation.frame().positions()[0];
//! assert!(x > 0.0 && z < 0.0, "it is at {x}, {z}");
//!
//! let wrong = text.replace("friction = 0.5", "friction = -0.5");
//! let error = Scene::parse(&wrong).unwrap_err();
//! assert!(error.to_string().contains("friction"), "{error}");
//! # Ok::<(), makadam::Error>(())
//! ```

mod accuracy;
mod builder;
mod check;
pub(crate) mod coefficients;
mod document;
mod error;
mod flow;
mod gauge;
mod motion;
mod periodic;
mod populate;
mod preflight;
mod radii;
mod settings;
mod stages;
mod start;
mod suggestions;
mod types;

pub use crate::laws::cohesion::Cohesion;
pub use crate::laws::compliance::NormalLaw;
pub use crate::surface::{MeshRotation, Revolution, Shape, TriangleMesh};
pub use accuracy::Accuracy;
pub use builder::{Face, SceneBuilder};
pub(crate) use check::MOST_GRAINS;
use coefficients::Meeting;
pub use coefficients::{ContactCoefficients, Material, PairRule};
pub use document::{Checked, Document, DocumentPath};
pub use error::{Fault, SceneError, SceneFileError, line_of};
pub use gauge::Gauge;
pub(crate) use motion::course;
pub use motion::{Motion, PoseTable};
use nalgebra::Vector3;
pub(crate) use periodic::REACHES;
pub(crate) use populate::Neighbours;
pub use populate::populate;
pub use preflight::{Beforehand, Finding, Severity};
pub use radii::RadiusDistribution;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
pub use settings::{
    MOST_MEMORY, Obstacle, Precision, Reaction, SettingError, SolverMethod, SolverSettings, Stop, TangentialLaw, Watch,
};
pub(crate) use settings::{method_goes_with, precision_goes_with};
pub use stages::{Stage, StageEnd, StageMaterial, StageOutput, StageSolver};
pub use start::Start;
use std::collections::BTreeMap;
use std::path::Path;
pub use suggestions::{nearest, suggestion, wish};
/// Initial state of a grain, listed or placed by rule.
pub use types::GrainEntry as Grain;
pub(crate) use types::sphere_volume;
pub use types::{Axis, Domain, GrainEntry, GravityChange, Insertion, Placement, Population, Region, Removal, Wall};

/// Tables of a scene file that describe measurements; the solver ignores these tables.
pub const TABLES_OF_WHO_MEASURES: [&str; 4] = ["prepare", "measure", "output", "compare"];

/// Scene: materials, walls, grains, gravity, duration and solver settings.
///
/// The tables `prepare`, `measure`, `output` and `compare` of a scene file are for measurement tools; the solver ignores these tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Short name, used in tables and file names.
    pub name: String,
    /// One-sentence description; empty if absent.
    #[serde(default)]
    pub description: String,
    /// Simulated time, seconds; required without stages, which give it.
    #[serde(default = "types::not_given")]
    pub duration: f64,
    /// Acceleration of gravity, m/s2.
    #[serde(default = "types::earth_gravity")]
    pub gravity: [f64; 3],
    /// Later values of gravity, linearly interpolated; none if constant.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub gravity_changes: Vec<GravityChange>,
    /// Default seed.
    #[serde(default = "types::first_seed")]
    pub seed: u64,
    /// Box that no grain may leave, metres.
    pub domain: Domain,
    /// Largest accepted overlap at the start, between grains or with a wall, over the smaller radius.
    #[serde(default = "types::slight_overlap", skip_serializing_if = "types::is_slight")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub largest_start_overlap: f64,
    /// Accepts values that are a mistake in most scenes: steps and intervals of frames down to 1e-15 s, densities from 1e-6 to
    /// 1e9 kg/m3.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub unusual_values: bool,
    /// Materials by name.
    pub material: BTreeMap<String, Material>,
    /// Friction and restitution of particular pairs of materials.
    #[serde(default)]
    pub pair: Vec<PairRule>,
    /// Walls, in the order in which contacts number them.
    #[serde(default)]
    pub wall: Vec<Wall>,
    /// Groups of grains placed by rule.
    #[serde(default)]
    pub population: Vec<Population>,
    /// Grains placed one by one.
    #[serde(default)]
    pub grain: Vec<GrainEntry>,
    /// Grains of a CSV file, after those placed one by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Start>,
    /// Sources: grains that come during the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub insert: Vec<Insertion>,
    /// Sinks: regions whose grains leave the simulation.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub remove: Vec<Removal>,
    /// Stages of a process, one after another; their longest times give `duration`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub stage: Vec<Stage>,
    /// Gauges: surfaces that count the grains that pass.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub gauge: Vec<Gauge>,
    #[serde(default, rename = "prepare", skip_serializing)]
    #[cfg_attr(feature = "schema", schemars(skip))]
    #[doc(hidden)]
    pub _prepare: IgnoredAny,
    /// Target accuracy of the result, which then sets the solver's `step` and `stop`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Settings of the solver.
    #[serde(default)]
    pub solver: SolverSettings,
    /// Settings of the watchdogs.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    #[cfg_attr(feature = "schema", schemars(!skip_serializing_if))]
    pub watch: Watch,
    #[serde(default, rename = "measure", skip_serializing)]
    #[cfg_attr(feature = "schema", schemars(skip))]
    #[doc(hidden)]
    pub _measure: IgnoredAny,
    #[serde(default, rename = "output", skip_serializing)]
    #[cfg_attr(feature = "schema", schemars(skip))]
    #[doc(hidden)]
    pub _output: IgnoredAny,
    #[serde(default, rename = "compare", skip_serializing)]
    #[cfg_attr(feature = "schema", schemars(skip))]
    #[doc(hidden)]
    pub _compare: IgnoredAny,
}

impl Scene {
    /// Parses and checks the text of a scene.
    ///
    /// # Errors
    /// [`SceneError`] if the text is not TOML, has unknown keys, has a value out of range, or prescribes a motion that
    /// the step does not resolve.
    pub fn parse(text: &str) -> Result<Scene, SceneError> {
        Scene::read(&Document::parse(text)?)
    }

    /// Parses and checks the text of a scene; `folder` is the folder of the files that the text names by relative paths.
    ///
    /// # Errors
    /// [`SceneError`] as [`Scene::parse`], or if such a file cannot be read.
    pub fn parse_in(text: &str, folder: impl AsRef<Path>) -> Result<Scene, SceneError> {
        Scene::read(&Document::parse(text)?.in_folder(folder.as_ref()))
    }

    /// Reads and checks a document.
    ///
    /// # Errors
    /// [`SceneError`] as [`Scene::parse`].
    pub fn read(document: &Document<'_>) -> Result<Scene, SceneError> {
        let mut scene: Scene = document.read()?;
        if scene.duration.is_nan() {
            let remedy = "give the simulated time, s, or stages with theirs";
            let missing = || Fault::new(DocumentPath::default(), "missing field `duration`".into(), remedy);
            scene.duration = scene.longest_of_stages().ok_or_else(missing)?;
        }
        document.first_unread(&scene).map_or(Ok(()), Err)?;
        scene.read_files(document)?;
        scene.read_start(document)?;
        if !document.has("solver", "step") {
            scene.solver.step = scene.default_step();
        }
        check::check(&scene)?;
        if let Some(accuracy) = scene.accuracy {
            check::chosen_twice(document)?;
            scene.ask(accuracy);
        }
        scene.check_motion(None)?;
        Ok(scene)
    }

    /// Reads the files of meshes and of tables of poses, unless the scene holds their content.
    fn read_files(&mut self, document: &Document<'_>) -> Checked {
        for (number, stage) in self.stage.iter_mut().enumerate() {
            let at = DocumentPath::default().key("stage").index(number).key("motion");
            stage.motion.iter_mut().try_for_each(|(wall, motion)| motion.read_tables(&at.name(wall), document))?;
        }
        for (index, wall) in self.wall.iter_mut().enumerate() {
            wall.motion.read_tables(&DocumentPath::default().key("wall").index(index).key("motion"), document)?;
            let Shape::Mesh { file, content, .. } = &mut wall.shape else { continue };
            if content.is_empty() {
                let at = DocumentPath::default().key("wall").index(index).key("shape").key("file");
                let (path, bytes) = document.file(file, "an STL or OBJ", &at)?;
                *content = TriangleMesh::read(&bytes).map_err(|problem| {
                    let (problem, remedy) = problem.split_once("; ").unwrap_or((&problem, "export it again"));
                    at.fault(format!("'{path}' {problem}"), remedy)
                })?;
            }
        }
        Ok(())
    }

    /// Requests an accuracy, which sets the step and stop of the solver by the law of [`Accuracy`].
    pub fn ask(&mut self, accuracy: Accuracy) {
        self.accuracy = Some(accuracy);
        let of_stages = self.stage_scenes().into_iter().map(|scene| accuracy.settings(&scene));
        let shortest = of_stages.min_by(|a, b| a.0.total_cmp(&b.0));
        (self.solver.step, self.solver.stop) = shortest.expect("a scene has at least one stage, itself");
    }

    /// Checks that the scene can be solved with a method and a precision. Most methods, and single precision, have no
    /// equations for torques and dynamic walls.
    ///
    /// # Errors
    /// [`SettingError::SinglePrecision`] or [`SettingError::Method`] with the incompatible setting or effect.
    pub fn goes_with(&self, method: SolverMethod, precision: Precision) -> Result<(), SettingError> {
        precision_goes_with(precision, method, || self.obstacle())?;
        method_goes_with(method, precision, || self.obstacle())
    }

    /// Returns the setting or effect that requires Gauss-Seidel in double precision, if the scene has one.
    fn obstacle(&self) -> Option<Obstacle> {
        let mut contacts = self.possible_contacts();
        let torques = contacts.any(|contact| contact.rolling_friction > 0.0 || contact.twisting_friction > 0.0);
        let driven = self.wall.iter().any(|wall| wall.motion.is_driven());
        let spring = self.solver.tangential_law != TangentialLaw::Rigid;
        Obstacle::of_scene(torques, driven, spring)
    }

    /// Returns the initial number of grains: listed grains, those of the start file, and those of the populations.
    pub fn grain_count(&self) -> usize {
        self.population.iter().fold(self.listed().count(), |all, population| all.saturating_add(population.count))
    }

    /// Returns true if the scene can be solved with these settings and all settings are in range.
    pub fn accepts(&self, settings: &SolverSettings) -> bool {
        check::solver(&Scene { solver: settings.clone(), ..self.clone() }).is_ok()
    }

    /// Returns the scene with every Young's modulus multiplied by `factor` (for the bias of soft grains).
    pub fn with_stiffness_factor(&self, factor: f64) -> Scene {
        let mut scene = self.clone();
        for material in scene.material.values_mut() {
            material.youngs_modulus *= factor;
        }
        scene
    }

    /// Returns the largest magnitude of gravity at any time (m/s2); linear interpolation has its maximum at a listed value.
    pub(crate) fn largest_gravity(&self) -> f64 {
        let norm = |gravity: [f64; 3]| Vector3::from(gravity).norm();
        self.gravity_changes.iter().map(|change| norm(change.gravity)).fold(norm(self.gravity), f64::max)
    }

    /// Returns the coefficients of a contact between two materials; `wall` if the second material is that of a wall.
    ///
    /// A `[[pair]]` rule takes precedence. Without a rule, a wall contact takes the values of the wall, and two grains
    /// take the smaller of each of the two values.
    ///
    /// # Panics
    /// Panics if the scene lacks one of the materials. A [checked](Scene::check) scene has the materials of all its grains, walls and pairs.
    pub fn contact_coefficients(&self, first: &str, second: &str, wall: bool) -> ContactCoefficients {
        let rule = self.pair.iter().find(|rule| {
            let [a, b] = &rule.between;
            (a == first && b == second) || (a == second && b == first)
        });
        Meeting { first: &self.material[first], second: &self.material[second], rule, wall }.coefficients()
    }

    /// Returns the coefficients of all contacts between declared materials, first between grains, then with walls.
    pub fn possible_contacts(&self) -> impl Iterator<Item = ContactCoefficients> + '_ {
        let pairs = move |wall: bool| {
            let names = self.material.keys();
            names.flat_map(move |a| self.material.keys().map(move |b| self.contact_coefficients(a, b, wall)))
        };
        pairs(false).chain(pairs(true))
    }

    /// Returns the Rayleigh time step of explicit codes (s): the smallest over `grains` of
    /// `pi r sqrt(rho/G) / (0.1631 nu + 0.8766)`, with `G = E / (2 (1 + nu))`.
    ///
    /// # Panics
    /// Panics if the material of a grain is not in the scene.
    pub fn rayleigh_step(&self, grains: &[Grain]) -> f64 {
        let step = |grain: &Grain| {
            let Material { youngs_modulus, poisson_ratio, density, .. } = self.material[&grain.material];
            let shear = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
            std::f64::consts::PI * grain.radius * (density / shear).sqrt() / (0.1631 * poisson_ratio + 0.8766)
        };
        grains.iter().map(step).fold(f64::INFINITY, f64::min)
    }
}

/// Returns the JSON Schema (draft 2020-12) of a scene file for the solver: keys with types, defaults and meanings, and
/// the tables under `$defs`.
#[cfg(feature = "schema")]
pub fn schema() -> schemars::Schema {
    schemars::generate::SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Scene>()
}
