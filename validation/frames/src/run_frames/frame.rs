//! One frame of a run: columns of its grains and contacts, computed from a snapshot and the scene.

use super::columns::{Column, DOUBLES, Number, Part, REAL, Shape, VECTOR, WHOLE, pose_columns};
use super::walls::{Triangles, Walls};
use crate::plan::{GrainField, MeasuredScene, Roster, lasting_number};
use makadam::snapshot::{Particle, Partner, Snapshot};
use nalgebra::Vector3;
use std::cell::OnceCell;
use std::f64::consts::PI;
use std::sync::Arc;

type Vector = Vector3<f64>;

/// Column of grains: name, unit (empty for plain numbers), key in scenes (columns without a key are always present), shape, and function
/// of the values of a grain. The shape gives the number of values in use, from the first.
struct Field(&'static str, &'static str, Option<GrainField>, Shape, fn(&Grain<'_>) -> [f64; 6]);

/// Columns of grains, in the order of the files.
const FIELDS: [Field; 12] = [
    Field("diameter", "m", None, REAL, |grain| one(2.0 * grain.particle.radius)),
    Field("id", "", None, WHOLE, |grain| one(lasting_number(grain.frame.snapshot, grain.particle.id) as f64)),
    Field("material", "", None, (Number::UInt8, 1), |grain| one(f64::from(grain.kind().material))),
    Field("population", "", Some(GrainField::Population), WHOLE, |grain| {
        one(grain.kind().population.map_or(-1.0, f64::from))
    }),
    Field("mass", "kg", Some(GrainField::Mass), REAL, |grain| {
        one(grain.frame.tables.densities[usize::from(grain.kind().material)] * grain.volume())
    }),
    Field("speed", "m/s", Some(GrainField::Speed), REAL, |grain| one(Vector::from(grain.particle.velocity).norm())),
    Field("velocity", "m/s", Some(GrainField::Velocity), VECTOR, |grain| three(grain.particle.velocity)),
    Field("angular_velocity", "rad/s", Some(GrainField::AngularVelocity), VECTOR, |grain| three(grain.particle.spin)),
    Field("force", "N", Some(GrainField::Force), VECTOR, |grain| three(grain.load().force.into())),
    Field("coordination_number", "", Some(GrainField::CoordinationNumber), WHOLE, |grain| {
        one(f64::from(grain.load().contacts))
    }),
    Field("stress", "Pa", Some(GrainField::Stress), (Number::Float32, 6), |grain| {
        grain.load().moments.map(|moment| moment / grain.volume())
    }),
    Field("pressure", "Pa", Some(GrainField::Pressure), REAL, |grain| {
        one(grain.load().moments[..3].iter().sum::<f64>() / 3.0 / grain.volume())
    }),
];

fn one(value: f64) -> [f64; 6] {
    [value, 0.0, 0.0, 0.0, 0.0, 0.0]
}

fn three([x, y, z]: [f64; 3]) -> [f64; 6] {
    [x, y, z, 0.0, 0.0, 0.0]
}

/// Snapshot with derived data, computed on request.
struct Loaded<'a> {
    tables: &'a FrameTables,
    snapshot: &'a Snapshot,
    loads: OnceCell<Vec<Load>>,
}

impl Loaded<'_> {
    fn column(&self, Field(name, _, _, shape, of): &Field) -> Column {
        let particles = self.snapshot.particles.iter().enumerate();
        let values = particles.flat_map(|(place, particle)| {
            let values = of(&Grain { frame: self, place, particle });
            values.into_iter().take(shape.1)
        });
        Column::new(name, *shape, values)
    }
}

/// Grain of a frame.
struct Grain<'a> {
    frame: &'a Loaded<'a>,
    place: usize,
    particle: &'a Particle,
}

impl Grain<'_> {
    fn kind(&self) -> crate::plan::Kind {
        self.frame.tables.roster.kind(self.frame.snapshot, self.particle.id)
    }

    /// Volume, m3.
    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.particle.radius.powi(3)
    }

    fn load(&self) -> &Load {
        &self.frame.loads.get_or_init(|| loads(self.frame.snapshot, &self.frame.tables.scene))[self.place]
    }
}

/// Contact forces on a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Load {
    /// Sum of the contact forces, N.
    force: Vector,
    /// Number of contacts.
    contacts: u32,
    /// Sum of forces times branch vectors, pressure positive, N m: xx, yy, zz, xy, yz, xz.
    moments: [f64; 6],
}

/// Returns the contact loads on each grain: the sum of forces, and the mean stress times the volume V of the grain,
///
/// ```text
/// V sigma = - sum over contacts of sym(f (x) l)
/// ```
///
/// with the force f on the grain and the branch vector l from its centre to the contact point; pressure is positive. Source: the virial of
/// Love and Weber for one grain, exact for a grain in balance: J. Christoffersen, M. M. Mehrabadi and S. Nemat-Nasser, A micromechanical
/// description of granular material behavior, Journal of Applied Mechanics 48 (1981), 339-344.
fn loads(frame: &Snapshot, scene: &MeasuredScene) -> Vec<Load> {
    let period = scene.domain.period();
    let mut loads = vec![Load::default(); frame.particles.len()];
    let mut add = |id: u32, point: [f64; 3], force: Vector| {
        let branch = period.arm(&frame.particles[id as usize].position.into(), &point.into());
        let load = &mut loads[id as usize];
        load.force += force;
        load.contacts += 1;
        for (moment, [i, j]) in load.moments.iter_mut().zip([[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]]) {
            *moment -= 0.5 * (force[i] * branch[j] + force[j] * branch[i]);
        }
    };
    for contact in &frame.contacts {
        let on_second = contact.force_on_partner();
        add(contact.first, contact.point, -on_second);
        if let Partner::Grain(second) = contact.second {
            add(second, contact.point, on_second);
        }
    }
    loads
}

/// One frame of a run.
#[derive(Clone, Debug)]
pub struct RunFrame {
    /// Simulated time, s.
    pub time: f64,
    /// Grains.
    pub grains: Grains,
    /// Force-carrying contacts; absent if the run has written no contacts.
    pub contacts: Option<Vec<ContactLine>>,
    /// Walls at their pose; absent if the run has written no walls.
    pub walls: Option<Walls>,
    /// Name of the stage; absent for a scene without stages.
    pub stage: Option<String>,
    /// Acceleration of gravity, m/s2.
    pub gravity: [f64; 3],
    /// Lengths of the periodic axes, zero along the others, and their starts, m; absent without periodic axes.
    pub repeats: Option<[[f64; 3]; 2]>,
    pub(crate) tables: Arc<FrameTables>,
    pub(crate) snapshot: Arc<Snapshot>,
}

/// Grains of a frame.
#[derive(Clone, Debug)]
pub struct Grains {
    /// Centres, m.
    pub positions: Vec<[f64; 3]>,
    /// Radii, m.
    pub radii: Vec<f64>,
}

/// Contact as a line to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLine {
    /// Centre of the first grain, and that of the second, or the contact point on a wall, m.
    pub ends: [[f64; 3]; 2],
    /// Normal force, N.
    pub normal_force: f64,
}

/// Quantity with one number per grain, and its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Title, such as "angular velocity".
    pub title: String,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    /// One value per grain.
    pub values: Vec<f64>,
    /// Names of the values, for indices of named items such as materials.
    pub names: Vec<String>,
}

impl RunFrame {
    /// Returns the grains of a state with the walls of its scene; dynamic walls are omitted, since the state does not store their position.
    pub fn of_state(scene: &MeasuredScene, time: f64, particles: &[Particle]) -> RunFrame {
        let is_finite =
            |grain: &&Particle| grain.position.iter().chain(&grain.velocity).all(|number| number.is_finite());
        let particles = particles.iter().filter(is_finite).cloned().collect();
        let snapshot = Arc::new(Snapshot { time, particles, ..Snapshot::default() });
        let mut frame = Arc::new(FrameTables::new(scene)).frame(&snapshot);
        if let Some(walls) = &mut frame.walls {
            let is_known = |wall: &u32| !scene.wall[*wall as usize].motion.is_driven();
            let known: Vec<bool> = walls.wall.iter().map(is_known).collect();
            let mut each = known.iter();
            walls.triangles.retain(|_| each.next() == Some(&true));
            walls.wall.retain(is_known);
        }
        frame
    }

    /// Returns true if another frame has the same grains.
    pub fn has_same_grains(&self, other: &RunFrame) -> bool {
        self.snapshot.origins == other.snapshot.origins && self.grains.radii == other.grains.radii
    }

    /// Returns the names of the scalar and vector fields, in order.
    pub fn quantities(&self) -> Vec<String> {
        let is_quantity = |field: &&Field| matches!(field.3.1, 1 | 3);
        let mut names: Vec<String> = FIELDS.iter().filter(is_quantity).map(|field| field.0.into()).collect();
        names.sort();
        names
    }

    /// Returns a field as one number per grain; for vectors, the magnitude.
    pub fn quantity(&self, name: &str) -> Option<Quantity> {
        let Field(_, unit, ..) = FIELDS.iter().find(|field| field.0 == name)?;
        let length = |vector: &[f64]| vector.iter().map(|component| component * component).sum::<f64>().sqrt();
        let column = self.column(name)?;
        let values = match column.width {
            1 => column.values,
            3 => column.values.chunks_exact(3).map(length).collect(),
            _ => return None,
        };
        let names = if name == "material" { self.tables.materials() } else { Vec::new() };
        Some(Quantity { title: name.replace('_', " "), unit, values, names })
    }

    /// Returns a column of grains by its name.
    pub(crate) fn column(&self, name: &str) -> Option<Column> {
        let field = FIELDS.iter().find(|field| field.0 == name)?;
        Some(self.tables.load(&self.snapshot).column(field))
    }
}

/// Converts snapshots of a scene to frames and to parts of exports.
#[derive(Clone, Debug)]
pub(crate) struct FrameTables {
    pub scene: MeasuredScene,
    /// Density of each material, kg/m3.
    densities: Vec<f64>,
    roster: Roster,
    /// Scenes of the stages.
    stages: Vec<MeasuredScene>,
    /// Triangles of each wall at its pose in the scene; planes are cut again at each new pose.
    pub(super) walls: Vec<Triangles>,
}

impl FrameTables {
    pub fn new(scene: &MeasuredScene) -> FrameTables {
        FrameTables {
            densities: scene.material.values().map(|material| material.density).collect(),
            roster: Roster::new(scene),
            stages: (0..scene.stage.len()).map(|number| scene.in_stage(number)).collect(),
            walls: scene.wall.iter().map(|wall| Triangles::of(&wall.shape, &scene.domain)).collect(),
            scene: scene.clone(),
        }
    }

    /// Returns the scene of the stage of a frame.
    pub fn scene_of(&self, frame: &Snapshot) -> &MeasuredScene {
        frame.stage.and_then(|stage| self.stages.get(stage.number as usize)).unwrap_or(&self.scene)
    }

    /// Returns true if a stage gives a motion to a wall.
    pub fn stages_move(&self) -> bool {
        self.scene.stage.iter().any(|stage| !stage.motion.is_empty())
    }

    fn stage_name(&self, frame: &Snapshot) -> Option<String> {
        Some(self.scene.stage.get(frame.stage?.number as usize)?.name.clone())
    }

    /// Returns the names of the materials, in the order of their numbers.
    pub fn materials(&self) -> Vec<String> {
        self.scene.material.keys().cloned().collect()
    }

    fn load<'a>(&'a self, snapshot: &'a Snapshot) -> Loaded<'a> {
        Loaded { tables: self, snapshot, loads: OnceCell::new() }
    }

    /// Returns the lengths and starts of the periodic axes, zero along the others, m; `None` without periodic axes.
    fn repeats(&self) -> Option<[[f64; 3]; 2]> {
        let domain = &self.scene.domain;
        let mut repeats = [[0.0; 3]; 2];
        for axis in domain.periodic.iter().map(|axis| axis.number()) {
            repeats[0][axis] = domain.max[axis] - domain.min[axis];
            repeats[1][axis] = domain.min[axis];
        }
        (!domain.periodic.is_empty()).then_some(repeats)
    }

    /// Returns a frame with fields computed on request.
    pub fn frame(self: &Arc<Self>, snapshot: &Arc<Snapshot>) -> RunFrame {
        let output = self.scene.output.clone().unwrap_or_default();
        let lines = || {
            let forces = snapshot.contacts.iter().map(|contact| contact.normal_force);
            let ends = self.ends(snapshot).into_iter();
            ends.zip(forces).map(|(ends, normal_force)| ContactLine { ends, normal_force }).collect()
        };
        let walls = || self.walls_at(snapshot);
        RunFrame {
            time: snapshot.time,
            stage: self.stage_name(snapshot),
            gravity: self.scene_of(snapshot).gravity_field().at(snapshot.time).into(),
            grains: Grains {
                positions: snapshot.particles.iter().map(|particle| particle.position).collect(),
                radii: snapshot.particles.iter().map(|particle| particle.radius).collect(),
            },
            contacts: output.contacts.then(lines),
            walls: (output.walls && !self.scene.wall.is_empty()).then(walls),
            repeats: self.repeats(),
            tables: Arc::clone(self),
            snapshot: Arc::clone(snapshot),
        }
    }

    /// Returns the grains of a frame: points with the requested fields of the scene.
    pub fn grains(&self, frame: &Snapshot) -> Part {
        let requested = self.scene.output.as_ref().and_then(|output| output.fields.as_deref());
        let is_requested = |field: &&Field| match (requested, &field.2) {
            (Some(requested), Some(key)) => requested.contains(key),
            _ => true,
        };
        let loaded = self.load(frame);
        let gravity: [f64; 3] = self.scene_of(frame).gravity_field().at(frame.time).into();
        let mut whole = vec![Column::new("gravity", DOUBLES, gravity)];
        let mut texts = vec![("scene_name", vec![self.scene.name.clone()]), ("material_names", self.materials())];
        if let Some(stage) = &frame.stage {
            whole.push(Column::new("stage", WHOLE, [f64::from(stage.number)]));
            texts.push(("stage_names", self.scene.stage.iter().map(|stage| stage.name.clone()).collect()));
        }
        if !frame.driven_walls.is_empty() {
            whole.extend(pose_columns(&frame.driven_walls));
        }
        if let Some([lengths, starts]) = self.repeats() {
            whole.push(Column::new("period", DOUBLES, lengths));
            whole.push(Column::new("period_start", DOUBLES, starts));
        }
        Part {
            corners_per_cell: 1,
            time: frame.time,
            points: coordinates("Points", frame.particles.iter().flat_map(|p| p.position), frame),
            corners: None,
            of_points: FIELDS.iter().filter(is_requested).map(|field| loaded.column(field)).collect(),
            of_cells: Vec::new(),
            whole,
            texts,
        }
    }

    /// Returns the contacts of a frame: lines with forces.
    pub fn contacts(&self, frame: &Snapshot) -> Part {
        let contacts = &frame.contacts;
        let number = |id: u32| lasting_number(frame, id) as f64;
        let grain = |partner| if let Partner::Grain(id) = partner { number(id) } else { -1.0 };
        let wall = |partner| if let Partner::Wall(index) = partner { f64::from(index) } else { -1.0 };
        Part {
            corners_per_cell: 2,
            time: frame.time,
            points: coordinates("Points", self.ends(frame).into_iter().flatten().flatten(), frame),
            corners: None,
            of_points: Vec::new(),
            of_cells: vec![
                Column::new("normal_force", REAL, contacts.iter().map(|c| c.normal_force)),
                Column::new("tangential_force", VECTOR, contacts.iter().flat_map(|c| c.tangential_force)),
                Column::new("normal", VECTOR, contacts.iter().flat_map(|c| c.normal)),
                coordinates("point", contacts.iter().flat_map(|c| c.point), frame),
                Column::new("first", WHOLE, contacts.iter().map(|c| number(c.first))),
                Column::new("second_grain", WHOLE, contacts.iter().map(|c| grain(c.second))),
                Column::new("second_wall", WHOLE, contacts.iter().map(|c| wall(c.second))),
            ],
            whole: Vec::new(),
            texts: Vec::new(),
        }
    }

    /// Returns both ends of the line of each contact, m: the centre of the first grain, and the centre of the second grain or of its nearest
    /// image, or the contact point on a wall.
    pub fn ends(&self, frame: &Snapshot) -> Vec<[[f64; 3]; 2]> {
        let period = self.scene.domain.period();
        let centre = |id: u32| Vector::from(frame.particles[id as usize].position);
        let contacts = frame.contacts.iter();
        let line = contacts.map(|contact| {
            let start = centre(contact.first);
            let end = match contact.second {
                Partner::Grain(id) => centre(id),
                Partner::Wall(_) => contact.point.into(),
            };
            [start, start + period.arm(&start, &end)].map(Into::into)
        });
        line.collect()
    }
}

/// Makes a column of coordinates, with the smallest radius as its resolution.
fn coordinates(name: &str, values: impl Iterator<Item = f64>, frame: &Snapshot) -> Column {
    let smallest = frame.particles.iter().map(|particle| particle.radius).fold(f64::INFINITY, f64::min);
    Column::coordinates(name, values.collect(), smallest)
}
