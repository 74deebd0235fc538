//! The form of a scene's file: which keys there are, and what stands for those that are left out.

use super::types::{earth_gravity, first_seed, slight_overlap};
use super::{
    Accuracy, Domain, GrainEntry, GravityChange, Material, PairRule, Population, Scene, SolverSettings, Wall, Watch,
};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;

/// Tables of a scene's file that say nothing of what is simulated: who measures the scene reads them.
pub const TABLES_OF_WHO_MEASURES: [&str; 4] = ["prepare", "measure", "output", "compare"];

/// All keys, in the order in which messages list them.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    name: String,
    #[serde(default)]
    description: String,
    duration: f64,
    #[serde(default = "earth_gravity")]
    gravity: [f64; 3],
    #[serde(default)]
    gravity_changes: Vec<GravityChange>,
    #[serde(default = "first_seed")]
    seed: u64,
    domain: Domain,
    #[serde(default = "slight_overlap")]
    largest_start_overlap: f64,
    #[serde(default)]
    unusual_values: bool,
    material: BTreeMap<String, Material>,
    #[serde(default)]
    pair: Vec<PairRule>,
    #[serde(default)]
    wall: Vec<Wall>,
    #[serde(default)]
    population: Vec<Population>,
    #[serde(default)]
    grain: Vec<GrainEntry>,
    #[serde(default, rename = "prepare")]
    #[cfg_attr(feature = "schema", schemars(skip))]
    _prepare: IgnoredAny,
    #[serde(default)]
    accuracy: Option<Accuracy>,
    #[serde(default)]
    solver: SolverSettings,
    #[serde(default)]
    watch: Watch,
    #[serde(default, rename = "measure")]
    #[cfg_attr(feature = "schema", schemars(skip))]
    _measure: IgnoredAny,
    #[serde(default, rename = "output")]
    #[cfg_attr(feature = "schema", schemars(skip))]
    _output: IgnoredAny,
    #[serde(default, rename = "compare")]
    #[cfg_attr(feature = "schema", schemars(skip))]
    _compare: IgnoredAny,
}

impl From<Document> for Scene {
    fn from(document: Document) -> Scene {
        Scene {
            name: document.name,
            description: document.description,
            duration: document.duration,
            gravity: document.gravity,
            gravity_changes: document.gravity_changes,
            seed: document.seed,
            domain: document.domain,
            largest_start_overlap: document.largest_start_overlap,
            unusual_values: document.unusual_values,
            material: document.material,
            pair: document.pair,
            wall: document.wall,
            population: document.population,
            grain: document.grain,
            accuracy: document.accuracy,
            solver: document.solver,
            watch: document.watch,
        }
    }
}
