//! Data for measures in addition to a frame: of the scene, and of the scene at the frame's time.

use super::drum::Drum;
use makadam::scene::ContactCoefficients;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam_frames::plan::{MeasuredScene, Roster};
use nalgebra::Vector3;
use std::borrow::Cow;

/// Density, friction and cohesion of a scene's grains and contacts.
pub struct Properties<'a> {
    /// Scene, or the scene of one of its stages.
    pub scene: Cow<'a, MeasuredScene>,
    /// Materials and populations of grains by their numbers.
    pub roster: Roster,
    density: Vec<f64>,
    grain_contacts: Vec<Vec<ContactCoefficients>>,
    wall_contacts: Vec<Vec<ContactCoefficients>>,
    /// Properties in each stage.
    stages: Vec<Properties<'a>>,
}

impl<'a> Properties<'a> {
    /// Reads a checked scene.
    pub fn new(scene: &'a MeasuredScene) -> Self {
        let of_stage = |number| Properties::of(Cow::Owned(scene.in_stage(number)));
        Properties { stages: (0..scene.stage.len()).map(of_stage).collect(), ..Properties::of(Cow::Borrowed(scene)) }
    }

    fn of(scene: Cow<'a, MeasuredScene>) -> Self {
        let is_carried = scene.wall.iter().any(|wall| wall.parent.is_some());
        let scene = if is_carried { Cow::Owned(scene.with_own_motions()) } else { scene };
        let names: Vec<&String> = scene.material.keys().collect();
        let of_pairs = |a: &&String| names.iter().map(|b| scene.contact_coefficients(a, b, false)).collect();
        let of_walls =
            |a: &&String| scene.wall.iter().map(|wall| scene.contact_coefficients(a, &wall.material, true)).collect();
        let (grain_contacts, wall_contacts) =
            (names.iter().map(of_pairs).collect(), names.iter().map(of_walls).collect());
        let (roster, density) = (Roster::new(&scene), names.iter().map(|name| scene.material[*name].density).collect());
        Self { roster, density, grain_contacts, wall_contacts, stages: Vec::new(), scene }
    }

    /// Returns the properties in the stage of a frame.
    fn at(&self, frame: &Snapshot) -> &Properties<'a> {
        frame.stage.and_then(|stage| self.stages.get(stage.number as usize)).unwrap_or(self)
    }

    /// Returns true if the scene has friction between grains.
    pub fn frictional(&self) -> bool {
        let materials = || {
            let names = self.scene.grain_kinds().map(|(name, _)| name);
            names.filter_map(|name| self.scene.material.keys().position(|known| known == name))
        };
        materials().any(|a| materials().any(|b| self.grain_contacts[a][b].friction > 0.0))
    }

    /// Returns true if the direction of gravity, or its absence, may change over time.
    pub fn gravity_changes(&self) -> bool {
        !self.scene.gravity_changes.is_empty() || self.scene.stage.iter().any(|stage| stage.gravity.is_some())
    }
}

/// Returns true if two directions against gravity are the same to a millionth of a radian, or both absent.
pub fn is_one_direction(one: Option<Vector3<f64>>, other: Option<Vector3<f64>>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => (one - other).norm() < SAME_DIRECTION,
        (one, other) => one.is_none() && other.is_none(),
    }
}

/// Scene at the time of a frame, for measures of this frame.
pub struct Setting<'a> {
    /// Scene, and data that follow from it alone.
    pub properties: &'a Properties<'a>,
    /// Unit vector against gravity at the frame's time; absent without gravity.
    pub up: Option<Vector3<f64>>,
    /// Magnitude of gravity at the frame's time, m/s2.
    pub gravity: f64,
    /// Mean grain diameter of the frame, m.
    pub diameter: f64,
    /// Drum of the scene, if any, with its rotation at the frame's time.
    pub drum: Option<Drum>,
}

impl<'a> Setting<'a> {
    /// Makes the setting from gravity at the frame's time and the mean diameter of its grains.
    pub fn new(properties: &'a Properties<'a>, frame: &Snapshot) -> Self {
        let properties = properties.at(frame);
        let gravity = properties.scene.gravity_field().at(frame.time);
        let count = frame.particles.len().max(1) as f64;
        Self {
            properties,
            up: gravity.try_normalize(WEIGHTLESS).map(|down| -down),
            gravity: gravity.norm(),
            diameter: 2.0 * frame.particles.iter().map(|grain| grain.radius).sum::<f64>() / count,
            drum: Drum::find(&properties.scene, gravity).map(|drum| drum.at(&properties.scene, frame)),
        }
    }

    /// Returns the scene.
    pub fn scene(&self) -> &'a MeasuredScene {
        &self.properties.scene
    }

    /// Returns the middle of the domain, m: the origin of grids, so that a shifted scene has the same cells.
    pub fn middle(&self) -> Vector3<f64> {
        let domain = &self.properties.scene.domain;
        0.5 * (Vector3::from(domain.min) + Vector3::from(domain.max))
    }

    /// Returns the sense of rotation of the drum: 1, -1, or 0 without rotation or without a drum.
    pub fn sense(&self) -> f64 {
        self.drum.as_ref().map_or(0.0, Drum::sense)
    }

    /// Returns the mass of a grain of the frame, kg.
    pub fn mass(&self, frame: &Snapshot, grain: &Particle) -> f64 {
        self.properties.density[self.material(frame, grain.id)] * super::sphere_volume::sphere(grain.radius)
    }

    /// Returns the name of the material of a grain of the frame; empty for a frame of another scene.
    pub fn material_name(&self, frame: &Snapshot, id: u32) -> &'a str {
        self.scene().material.keys().nth(self.material(frame, id)).map_or("", String::as_str)
    }

    fn material(&self, frame: &Snapshot, id: u32) -> usize {
        let material = usize::from(self.properties.roster.kind(frame, id).material);
        // Readers refuse frames of a scene with more materials.
        material.min(self.properties.density.len().saturating_sub(1))
    }

    /// Returns the largest tangential forces of a contact, N: sticking, and sliding; `None` if the scene has no coefficients of the
    /// contact, or if cohesion adds a force that the two tables of a frame do not state.
    pub fn coulomb_bounds(&self, frame: &Snapshot, contact: &Contact) -> Option<[f64; 2]> {
        let first = self.material(frame, contact.first);
        let coefficients = match contact.second {
            Partner::Grain(id) => self.properties.grain_contacts[first].get(self.material(frame, id)),
            Partner::Wall(wall) => self.properties.wall_contacts[first].get(wall as usize),
        }?;
        let bound = |friction: f64| friction * contact.normal_force;
        coefficients.cohesion.is_none().then_some([coefficients.friction, coefficients.kinetic_friction].map(bound))
    }
}

/// Smallest gravity with a direction, m/s2.
const WEIGHTLESS: f64 = 1e-12;

/// Largest difference of unit vectors with equal directions.
const SAME_DIRECTION: f64 = 1e-6;
