//! One frame of a run in memory.

use crate::output::vtk::PolyData;
use crate::output::{GrainTable, WallMesh, Walls};
use crate::plan::Scene;
use makadam::snapshot::{Particle, Snapshot};
use std::sync::Arc;

/// Part of a frame that is a file of its own in exports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Points.
    Grains,
    /// Lines.
    Contacts,
    /// Triangles.
    Walls,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Grains, Kind::Contacts, Kind::Walls];

    /// Returns the name, which begins the names of files.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Grains => "grains",
            Kind::Contacts => "contacts",
            Kind::Walls => "walls",
        }
    }
}

/// One frame of a run.
#[derive(Clone, Debug)]
pub struct RunFrame {
    /// Simulated time, s.
    pub time: f64,
    /// Its grains.
    pub grains: Grains,
    /// Contacts that bear a force; none where the run has written none.
    pub contacts: Option<Vec<ContactLine>>,
    /// Walls where they stand; none where the run has written none.
    pub walls: Option<Walls>,
    /// Acceleration of gravity, m/s2.
    pub gravity: [f64; 3],
    /// Lengths of the periodic axes, zero along the others, and their starts, m; none without such axes.
    pub repeats: Option<[[f64; 3]; 2]>,
    pub(crate) table: Arc<GrainTable>,
    pub(crate) snapshot: Arc<Snapshot>,
}

/// The grains of a frame.
#[derive(Clone, Debug)]
pub struct Grains {
    /// Centres, m.
    pub positions: Vec<[f64; 3]>,
    /// Radii, m.
    pub radii: Vec<f64>,
}

/// A contact as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLine {
    /// Centre of the first grain, and that of the second, or the contact point on a wall, m.
    pub ends: [[f64; 3]; 2],
    /// Normal force, N.
    pub normal_force: f64,
}

/// A number of every grain, with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Its name in words, such as "angular velocity".
    pub title: String,
    /// Its unit; empty for plain numbers.
    pub unit: &'static str,
    /// One value per grain.
    pub values: Vec<f64>,
    /// Names of the values where they number something that has names.
    pub names: Vec<String>,
}

/// Returns the unit of a field, by its name; empty for numbers.
pub fn unit_of(name: &str) -> &'static str {
    match name {
        "diameter" => "m",
        "mass" => "kg",
        "speed" | "velocity" => "m/s",
        "angular_velocity" => "rad/s",
        "force" => "N",
        "stress" | "pressure" => "Pa",
        _ => "",
    }
}

impl RunFrame {
    /// Returns the grains of a state with the walls of its scene, but for walls that a force drives: their position is not stored.
    pub fn of_state(scene: &Scene, time: f64, particles: &[Particle]) -> RunFrame {
        let is_finite =
            |grain: &&Particle| grain.position.iter().chain(&grain.velocity).all(|number| number.is_finite());
        let particles = particles.iter().filter(is_finite).cloned().collect();
        let mut frame = FrameTables::new(scene).frame(&Arc::new(Snapshot { time, particles, ..Snapshot::default() }));
        if let Some(walls) = &mut frame.walls {
            let is_known = |wall: &u32| !scene.wall[*wall as usize].motion.is_driven();
            let known: Vec<bool> = walls.wall.iter().map(is_known).collect();
            let mut each = known.iter();
            walls.triangles.retain(|_| each.next() == Some(&true));
            walls.wall.retain(is_known);
        }
        frame
    }

    /// Returns the names of the fields that are one number per grain, or that have a length, in order.
    pub fn quantities(&self) -> Vec<String> {
        let mut names: Vec<String> = GrainTable::names().filter(|name| *name != "stress").map(String::from).collect();
        names.sort();
        names
    }

    /// Returns a field as one number per grain: of vectors the length.
    pub fn quantity(&self, name: &str) -> Option<Quantity> {
        let array = self.table.field(&self.snapshot, name)?;
        let length = |vector: &[f64]| vector.iter().map(|component| component * component).sum::<f64>().sqrt();
        let values = match array.components {
            1 => array.values(),
            3 => array.values().chunks_exact(3).map(length).collect(),
            _ => return None,
        };
        let names = if name == "material" { self.table.materials.clone() } else { Vec::new() };
        Some(Quantity { title: name.replace('_', " "), unit: unit_of(name), values, names })
    }
}

/// Converts snapshots of a scene to frames.
#[derive(Clone, Debug)]
pub(crate) struct FrameTables {
    scene: Scene,
    grains: Arc<GrainTable>,
    walls: WallMesh,
}

impl FrameTables {
    pub(crate) fn new(scene: &Scene) -> FrameTables {
        let grains = Arc::new(GrainTable::new(scene));
        FrameTables { grains, walls: WallMesh::new(scene), scene: scene.clone() }
    }

    /// Returns the scene.
    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns true if a wall moves, within its own surface included.
    pub(crate) fn walls_move(&self) -> bool {
        self.walls.moves()
    }

    /// Returns the grains with the requested fields, the contacts or the walls of a frame as polygonal data.
    pub(crate) fn poly_data(&self, frame: &Snapshot, kind: Kind) -> PolyData {
        let fields = self.scene.output.as_ref().and_then(|output| output.fields.as_deref());
        match kind {
            Kind::Grains => self.grains.grains(frame, fields),
            Kind::Contacts => self.grains.contacts(frame),
            Kind::Walls => self.walls.poly_data(frame.time, &frame.driven_walls),
        }
    }

    /// Returns a frame; its fields are computed on request.
    pub(crate) fn frame(&self, snapshot: &Arc<Snapshot>) -> RunFrame {
        let output = self.scene.output.clone().unwrap_or_default();
        let lines = || {
            let forces = snapshot.contacts.iter().map(|contact| contact.normal_force);
            let ends = self.grains.ends(snapshot).into_iter();
            ends.zip(forces).map(|(ends, normal_force)| ContactLine { ends, normal_force }).collect()
        };
        let walls = || self.walls.at(snapshot.time, &snapshot.driven_walls);
        RunFrame {
            time: snapshot.time,
            gravity: self.grains.gravity_at(snapshot.time),
            grains: Grains {
                positions: snapshot.particles.iter().map(|particle| particle.position).collect(),
                radii: snapshot.particles.iter().map(|particle| particle.radius).collect(),
            },
            contacts: output.contacts.then(lines),
            walls: (output.walls && !self.scene.wall.is_empty()).then(walls),
            repeats: self.grains.repeats,
            table: Arc::clone(&self.grains),
            snapshot: Arc::clone(snapshot),
        }
    }
}
