//! One frame of a run in memory.

use crate::output::vtk::{Array, Cells, PolyData};
use crate::output::{GrainTable, WallMesh, repeats};
use crate::plan::Scene;
use makadam::effects::gravity::Field;
use makadam::snapshot::{DrivenWall, Particle, Snapshot};

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
    /// Poses of the walls that forces drive.
    pub driven_walls: Vec<DrivenWall>,
    /// Periodic axes of the domain; none without such axes.
    pub repeats: Option<Repeats>,
}

/// Periodic axes of a domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// Length of the period along each axis, m; zero along the other axes.
    pub lengths: [f64; 3],
    /// Start of the period, m.
    pub starts: [f64; 3],
}

/// The grains of a frame.
#[derive(Clone, Debug)]
pub struct Grains {
    /// Centres, m.
    pub positions: Vec<[f64; 3]>,
    /// Radii, m.
    pub radii: Vec<f64>,
    /// Further arrays, each with a tuple per grain.
    pub(crate) fields: Vec<Array>,
    /// Names of the materials, by their numbers; empty where they are not known.
    pub materials: Vec<String>,
}

/// A contact as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLine {
    /// Centre of the first grain, and that of the second, or the contact point on a wall, m.
    pub ends: [[f64; 3]; 2],
    /// Normal force, N.
    pub normal_force: f64,
}

/// Walls as triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Walls {
    /// Corners, m.
    pub points: Vec<[f64; 3]>,
    /// Triangles, by the numbers of their corners.
    pub triangles: Vec<[u32; 3]>,
    /// Number of the wall that a triangle belongs to.
    pub wall: Vec<u32>,
    /// Names of the walls, by their numbers.
    pub names: Vec<String>,
    /// Kinds of their shapes, as the scene calls them, by their numbers; empty where they are not known.
    pub shapes: Vec<String>,
    /// Unit vectors along the axes that walls turn about, by their numbers; zero for those that do not turn.
    pub axes: Vec<[f64; 3]>,
}

impl RunFrame {
    /// Returns the grains of a state with the walls of its scene, but for walls that a force drives: their position is not stored.
    pub(crate) fn of_state(scene: &Scene, time: f64, particles: &[Particle]) -> RunFrame {
        let is_finite =
            |grain: &&Particle| grain.position.iter().chain(&grain.velocity).all(|number| number.is_finite());
        let grains: Vec<&Particle> = particles.iter().filter(is_finite).collect();
        let walls = surfaces(WallMesh::new(scene).at(time, &[]));
        let walls = {
            let is_known = |(_, wall): &([u32; 3], u32)| !scene.wall[*wall as usize].motion.is_driven();
            let (triangles, wall) = walls.triangles.into_iter().zip(walls.wall).filter(is_known).unzip();
            Walls { triangles, wall, ..walls }
        };
        let velocities = grains.iter().flat_map(|grain| grain.velocity).collect::<Vec<f64>>();
        RunFrame {
            time,
            gravity: scene.gravity,
            grains: Grains {
                positions: grains.iter().map(|grain| grain.position).collect(),
                radii: grains.iter().map(|grain| grain.radius).collect(),
                fields: vec![Array::floats("velocity", 3, velocities.into_iter())],
                materials: Vec::new(),
            },
            contacts: None,
            walls: Some(walls),
            driven_walls: Vec::new(),
            repeats: None,
        }
    }
}

/// Converts snapshots of a scene to frames.
#[derive(Clone, Debug)]
pub(crate) struct FrameTables {
    scene: Scene,
    /// Grains with the fields that the scene requests.
    requested: GrainTable,
    /// Grains with all fields.
    all: GrainTable,
    walls: WallMesh,
    gravity: Field,
    repeats: Option<Repeats>,
}

impl FrameTables {
    /// Tables of the frames of a scene.
    pub(crate) fn new(scene: &Scene) -> FrameTables {
        FrameTables {
            requested: GrainTable::new(scene, scene.output.as_ref().and_then(|output| output.fields.as_deref())),
            all: GrainTable::new(scene, None),
            walls: WallMesh::new(scene),
            gravity: scene.gravity_field(),
            repeats: Repeats::of(scene),
            scene: scene.clone(),
        }
    }

    /// Returns the scene.
    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns true if a wall moves, within its own surface included.
    pub(crate) fn walls_move(&self) -> bool {
        self.walls.moves()
    }

    /// Returns the grains, contacts or walls of a frame as polygonal data.
    pub(crate) fn poly_data(&self, frame: &Snapshot, kind: Kind) -> PolyData {
        match kind {
            Kind::Grains => self.requested.grains(frame),
            Kind::Contacts => self.all.contacts(frame),
            Kind::Walls => self.walls.at(frame.time, &frame.driven_walls),
        }
    }

    /// Returns a frame with all its fields.
    pub(crate) fn frame(&self, frame: &Snapshot) -> RunFrame {
        let grains = self.all.grains(frame);
        let output = self.scene.output.clone().unwrap_or_default();
        let lines = || {
            let forces = frame.contacts.iter().map(|contact| contact.normal_force);
            let ends = self.all.ends(frame).into_iter();
            ends.zip(forces).map(|(ends, normal_force)| ContactLine { ends, normal_force }).collect()
        };
        let walls = || surfaces(self.walls.at(frame.time, &frame.driven_walls));
        RunFrame {
            time: frame.time,
            gravity: self.gravity.at(frame.time).into(),
            grains: Grains {
                positions: frame.particles.iter().map(|particle| particle.position).collect(),
                radii: frame.particles.iter().map(|particle| particle.radius).collect(),
                materials: self.scene.material.keys().cloned().collect(),
                fields: grains.point_data,
            },
            contacts: output.contacts.then(lines),
            walls: (output.walls && !self.scene.wall.is_empty()).then(walls),
            driven_walls: frame.driven_walls.clone(),
            repeats: self.repeats,
        }
    }
}

impl Repeats {
    fn of(scene: &Scene) -> Option<Repeats> {
        let [lengths, starts] = repeats(scene);
        (!scene.domain.periodic.is_empty()).then_some(Repeats { lengths, starts })
    }
}

fn surfaces(walls: PolyData) -> Walls {
    let array = |arrays: &[Array], name: &str| arrays.iter().find(|array| array.name == name).cloned();
    let wall = array(&walls.cell_data, "wall").map_or(Vec::new(), |array| array.values());
    Walls {
        points: triples(&walls.points),
        wall: wall.into_iter().map(|number| number as u32).collect(),
        axes: array(&walls.field_data, "wall_axes").map_or(Vec::new(), |axes| triples(&axes)),
        names: texts(&walls, "wall_names"),
        shapes: texts(&walls, "wall_shapes"),
        triangles: match walls.cells {
            Cells::Triangles(triangles) => triangles,
            Cells::Vertices | Cells::Lines => Vec::new(),
        },
    }
}

fn triples(array: &Array) -> Vec<[f64; 3]> {
    array.values().as_chunks::<3>().0.to_vec()
}

fn texts(data: &PolyData, name: &str) -> Vec<String> {
    data.texts.iter().find(|(of, _)| of == name).map_or(Vec::new(), |(_, texts)| texts.clone())
}
