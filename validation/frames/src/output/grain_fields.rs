//! Tables of grains and contacts, computed from a snapshot and the scene.

use super::vtk::{Array, Cells, Kind, PolyData};
use crate::plan::{GrainField, Roster, Scene};
use makadam::effects::gravity::Field;
use makadam::effects::period::Period;
use makadam::snapshot::{DrivenWall, Particle, Partner, Snapshot};
use nalgebra::Vector3;
use std::cell::OnceCell;
use std::f64::consts::PI;

type Vector = Vector3<f64>;

/// Arrays of a frame that hold the poses of driven walls, a tuple per wall: number in the scene, displacement (m or rad), and rate (m/s or
/// rad/s).
pub(crate) const DRIVEN_WALLS: [&str; 3] = ["driven_wall", "driven_wall_displacement", "driven_wall_rate"];

/// Poses of driven walls from the values of these arrays: none where one of them is absent.
///
/// # Errors
/// The problem, in names of the arrays.
pub(crate) fn driven_walls(values: impl Fn(&str) -> Option<Vec<f64>>) -> Result<Vec<DrivenWall>, String> {
    let [Some(walls), Some(displacements), Some(rates)] = DRIVEN_WALLS.map(values) else { return Ok(Vec::new()) };
    let all = walls.iter().chain(&displacements).chain(&rates);
    if [displacements.len(), rates.len()] != [walls.len(); 2] || !all.into_iter().all(|number| number.is_finite()) {
        return Err(format!("{} are not as many finite numbers each", DRIVEN_WALLS.join(", ")));
    }
    let poses = walls.iter().zip(displacements.iter().zip(&rates));
    Ok(poses.map(|(&wall, (&displacement, &rate))| DrivenWall { wall: wall as u32, displacement, rate }).collect())
}

/// Fields of grains in the order of files, with the key by which a scene requests one; the first three are always there.
const FIELDS: [(&str, Option<GrainField>); 12] = [
    ("diameter", None),
    ("id", None),
    ("material", None),
    ("population", Some(GrainField::Population)),
    ("mass", Some(GrainField::Mass)),
    ("speed", Some(GrainField::Speed)),
    ("velocity", Some(GrainField::Velocity)),
    ("angular_velocity", Some(GrainField::AngularVelocity)),
    ("force", Some(GrainField::Force)),
    ("coordination_number", Some(GrainField::CoordinationNumber)),
    ("stress", Some(GrainField::Stress)),
    ("pressure", Some(GrainField::Pressure)),
];

/// Tables of the grains and contacts of frames of a scene.
#[derive(Clone, Debug)]
pub(crate) struct GrainTable {
    /// Names of the materials, in the order of their numbers.
    pub materials: Vec<String>,
    /// Density of each material, kg/m3.
    densities: Vec<f64>,
    roster: Roster,
    period: Period,
    /// Lengths of the periodic axes, zero for the others, and their starts, m; none without such axes.
    pub repeats: Option<[[f64; 3]; 2]>,
    gravity: Field,
    scene: String,
}

/// Contact forces on a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Loads {
    /// Sum of their forces, N.
    force: Vector,
    /// Their number.
    contacts: i32,
    /// Sum of forces times branch vectors, pressure positive, N m: xx, yy, zz, xy, yz, xz.
    moments: [f64; 6],
}

impl GrainTable {
    pub fn new(scene: &Scene) -> GrainTable {
        let repeats = || {
            let mut repeats = [[0.0; 3]; 2];
            for axis in scene.domain.periodic.iter().map(|axis| axis.number()) {
                repeats[0][axis] = scene.domain.max[axis] - scene.domain.min[axis];
                repeats[1][axis] = scene.domain.min[axis];
            }
            repeats
        };
        GrainTable {
            densities: scene.material.values().map(|material| material.density).collect(),
            materials: scene.material.keys().cloned().collect(),
            roster: Roster::new(scene),
            period: scene.domain.period(),
            repeats: (!scene.domain.periodic.is_empty()).then(repeats),
            gravity: scene.gravity_field(),
            scene: scene.name.clone(),
        }
    }

    /// Names of all fields.
    pub fn names() -> impl Iterator<Item = &'static str> {
        FIELDS.iter().map(|(name, _)| *name)
    }

    /// Returns a field of a frame, by its name.
    pub fn field(&self, frame: &Snapshot, name: &str) -> Option<Array> {
        let name = GrainTable::names().find(|known| *known == name)?;
        Some(self.array(frame, name, &OnceCell::new()))
    }

    fn array(&self, frame: &Snapshot, name: &str, loads: &OnceCell<Vec<Loads>>) -> Array {
        let particles = &frame.particles;
        let kind = |particle: &Particle| self.roster.kind(frame, particle.id);
        let loads = || loads.get_or_init(|| self::loads(frame, self.period)).iter();
        let each = || loads().zip(particles);
        match name {
            "diameter" => Array::floats(name, 1, particles.iter().map(|p| 2.0 * p.radius)),
            "id" => Array::integers(name, particles.iter().map(|p| p.id as i32)),
            "material" => {
                let bytes = particles.iter().map(|p| kind(p).material).collect();
                Array { name: name.into(), components: 1, kind: Kind::UInt8, bytes }
            }
            "population" => {
                let population = |p: &Particle| kind(p).population.map_or(-1, |place| place as i32);
                Array::integers(name, particles.iter().map(population))
            }
            "mass" => {
                let mass = |p: &Particle| self.densities[usize::from(kind(p).material)] * volume(p);
                Array::floats(name, 1, particles.iter().map(mass))
            }
            "speed" => Array::floats(name, 1, particles.iter().map(|p| Vector::from(p.velocity).norm())),
            "velocity" => Array::floats(name, 3, particles.iter().flat_map(|p| p.velocity)),
            "angular_velocity" => Array::floats(name, 3, particles.iter().flat_map(|p| p.spin)),
            "force" => Array::floats(name, 3, loads().flat_map(|load| <[f64; 3]>::from(load.force))),
            "coordination_number" => Array::integers(name, loads().map(|load| load.contacts)),
            "stress" => {
                Array::floats(name, 6, each().flat_map(|(load, p)| load.moments.map(|moment| moment / volume(p))))
            }
            _ => {
                let pressure = |load: &Loads, p| load.moments[..3].iter().sum::<f64>() / 3.0 / volume(p);
                Array::floats(name, 1, each().map(|(load, p)| pressure(load, p)))
            }
        }
    }

    /// The grains of a frame: points with the requested fields, or all.
    pub fn grains(&self, frame: &Snapshot, fields: Option<&[GrainField]>) -> PolyData {
        let loads = OnceCell::new();
        let is_requested = |field: &Option<GrainField>| match (fields, field) {
            (Some(fields), Some(field)) => fields.contains(field),
            _ => true,
        };
        let requested = FIELDS.iter().filter(|(_, field)| is_requested(field));
        PolyData {
            time: frame.time,
            points: coordinates("Points", frame.particles.iter().flat_map(|p| p.position), frame),
            cells: Cells::Vertices,
            point_data: requested.map(|(name, _)| self.array(frame, name, &loads)).collect(),
            cell_data: Vec::new(),
            field_data: self.field_data(frame),
            texts: vec![
                ("scene_name".into(), vec![self.scene.clone()]),
                ("material_names".into(), self.materials.clone()),
            ],
        }
    }

    /// Returns the acceleration of gravity at a time (s), m/s2.
    pub fn gravity_at(&self, time: f64) -> [f64; 3] {
        self.gravity.at(time).into()
    }

    /// Gravity at the frame's time, periods, and poses of the driven walls.
    fn field_data(&self, frame: &Snapshot) -> Vec<Array> {
        let mut data = vec![Array::doubles("gravity", 3, self.gravity_at(frame.time).into_iter())];
        if !frame.driven_walls.is_empty() {
            let [wall, displacement, rate] = DRIVEN_WALLS;
            let walls = || frame.driven_walls.iter();
            data.push(Array::integers(wall, walls().map(|driven| driven.wall as i32)));
            data.push(Array::doubles(displacement, 1, walls().map(|driven| driven.displacement)));
            data.push(Array::doubles(rate, 1, walls().map(|driven| driven.rate)));
        }
        if let Some([lengths, starts]) = self.repeats {
            data.push(Array::doubles("period", 3, lengths.into_iter()));
            data.push(Array::doubles("period_start", 3, starts.into_iter()));
        }
        data
    }

    /// The contacts of a frame: lines with forces.
    pub fn contacts(&self, frame: &Snapshot) -> PolyData {
        let contacts = &frame.contacts;
        let grain = |partner| if let Partner::Grain(id) = partner { id as i32 } else { -1 };
        let wall = |partner| if let Partner::Wall(place) = partner { place as i32 } else { -1 };
        let ends = self.ends(frame);
        PolyData {
            time: frame.time,
            points: coordinates("Points", ends.iter().flatten().flatten().copied(), frame),
            cells: Cells::Lines,
            point_data: Vec::new(),
            cell_data: vec![
                Array::floats("normal_force", 1, contacts.iter().map(|c| c.normal_force)),
                Array::floats("tangential_force", 3, contacts.iter().flat_map(|c| c.tangential_force)),
                Array::floats("normal", 3, contacts.iter().flat_map(|c| c.normal)),
                coordinates("point", contacts.iter().flat_map(|c| c.point), frame),
                Array::integers("first", contacts.iter().map(|c| c.first as i32)),
                Array::integers("second_grain", contacts.iter().map(|c| grain(c.second))),
                Array::integers("second_wall", contacts.iter().map(|c| wall(c.second))),
            ],
            field_data: Vec::new(),
            texts: Vec::new(),
        }
    }

    /// Returns both ends of the line of each contact, m: the centre of the first grain, and that of the second, or of its nearest image, or
    /// the contact point on a wall.
    pub fn ends(&self, frame: &Snapshot) -> Vec<[[f64; 3]; 2]> {
        let centre = |id: u32| Vector::from(frame.particles[id as usize].position);
        let contacts = frame.contacts.iter();
        let line = contacts.map(|contact| {
            let start = centre(contact.first);
            let end = match contact.second {
                Partner::Grain(id) => centre(id),
                Partner::Wall(_) => contact.point.into(),
            };
            [start, start + self.period.arm(&start, &end)].map(Into::into)
        });
        line.collect()
    }
}

/// m3.
fn volume(particle: &Particle) -> f64 {
    4.0 / 3.0 * PI * particle.radius.powi(3)
}

/// Contact loads on each grain: the sum of forces, and the mean stress times the volume V of the grain,
///
/// ```text
/// V sigma = - sum over contacts of sym(f (x) l)
/// ```
///
/// with the force f on the grain and the branch vector l from its centre to the contact point; pressure is positive. It is the virial of
/// Love and Weber for one grain, exact for a grain in balance: J. Christoffersen, M. M. Mehrabadi and S. Nemat-Nasser, A micromechanical
/// description of granular material behavior, Journal of Applied Mechanics 48 (1981), 339-344.
fn loads(frame: &Snapshot, period: Period) -> Vec<Loads> {
    let mut loads = vec![Loads::default(); frame.particles.len()];
    for contact in &frame.contacts {
        let on_second = contact.force_on_partner();
        let mut bear = |id: u32, force: Vector| {
            let centre = Vector::from(frame.particles[id as usize].position);
            let branch = period.arm(&centre, &Vector::from(contact.point));
            loads[id as usize].add(&force, &branch);
        };
        bear(contact.first, -on_second);
        if let Partner::Grain(second) = contact.second {
            bear(second, on_second);
        }
    }
    loads
}

impl Loads {
    fn add(&mut self, force: &Vector, branch: &Vector) {
        self.force += force;
        self.contacts += 1;
        for (moment, [i, j]) in self.moments.iter_mut().zip([[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]]) {
            *moment -= 0.5 * (force[i] * branch[j] + force[j] * branch[i]);
        }
    }
}

/// Places that differ by less than the smallest radius.
fn coordinates(name: &str, values: impl Iterator<Item = f64> + Clone, frame: &Snapshot) -> Array {
    let smallest = frame.particles.iter().map(|particle| particle.radius).fold(f64::INFINITY, f64::min);
    Array::coordinates(name, values, smallest)
}
