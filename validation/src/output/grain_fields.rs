//! What frames hold of grains, taken from a snapshot and the scene.

use super::vtk::{Array, Cells, Kind, PolyData};
use crate::plan::{GrainField, Roster, Scene};
use makadam::effects::gravity::Field;
use makadam::effects::period::Period;
use makadam::snapshot::{DrivenWall, Particle, Partner, Snapshot};
use nalgebra::Vector3;
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

/// Tables of the grains and contacts of frames, by what the scene states of the grains.
#[derive(Clone, Debug)]
pub(crate) struct GrainTable {
    /// Fields of grains; all, if absent.
    fields: Option<Vec<GrainField>>,
    /// Names of the materials, in the order of their numbers.
    materials: Vec<String>,
    /// Density of each material, kg/m3.
    densities: Vec<f64>,
    roster: Roster,
    period: Period,
    /// Lengths of the axes along which the scene repeats itself, zero for the others, and where they begin, m; none without such axes.
    repeats: Option<[[f64; 3]; 2]>,
    gravity: Field,
    scene: String,
}

/// What contacts do to a grain.
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
    /// Tables of the frames of a scene, with these fields of grains, or all.
    pub fn new(scene: &Scene, fields: Option<&[GrainField]>) -> GrainTable {
        GrainTable {
            fields: fields.map(<[GrainField]>::to_vec),
            densities: scene.material.values().map(|material| material.density).collect(),
            materials: scene.material.keys().cloned().collect(),
            roster: Roster::new(scene),
            period: scene.domain.period(),
            repeats: (!scene.domain.periodic.is_empty()).then(|| repeats(scene)),
            gravity: scene.gravity_field(),
            scene: scene.name.clone(),
        }
    }

    fn has(&self, field: GrainField) -> bool {
        self.fields.as_ref().is_none_or(|fields| fields.contains(&field))
    }

    /// The grains of a frame: points with the fields that the scene asks for.
    pub fn grains(&self, frame: &Snapshot) -> PolyData {
        let particles = &frame.particles;
        let has = |field| self.has(field);
        let kind = |particle: &Particle| self.roster.kind(frame, particle.id);
        let population = |particle: &Particle| kind(particle).population.map_or(-1, |place| place as i32);
        let mass = |particle: &Particle| self.densities[usize::from(kind(particle).material)] * volume(particle);
        let mut data = vec![
            Array::floats("diameter", 1, particles.iter().map(|p| 2.0 * p.radius)),
            Array::integers("id", particles.iter().map(|p| p.id as i32)),
            Array {
                name: "material".into(),
                components: 1,
                kind: Kind::UInt8,
                bytes: particles.iter().map(|p| kind(p).material).collect(),
            },
        ];
        if has(GrainField::Population) {
            data.push(Array::integers("population", particles.iter().map(population)));
        }
        if has(GrainField::Mass) {
            data.push(Array::floats("mass", 1, particles.iter().map(mass)));
        }
        if has(GrainField::Speed) {
            data.push(Array::floats("speed", 1, particles.iter().map(|p| Vector::from(p.velocity).norm())));
        }
        if has(GrainField::Velocity) {
            data.push(Array::floats("velocity", 3, particles.iter().flat_map(|p| p.velocity)));
        }
        if has(GrainField::AngularVelocity) {
            data.push(Array::floats("angular_velocity", 3, particles.iter().flat_map(|p| p.spin)));
        }
        let of_contacts = [GrainField::Force, GrainField::CoordinationNumber, GrainField::Stress, GrainField::Pressure];
        if of_contacts.into_iter().any(has) {
            self.add_loads(frame, &mut data);
        }
        PolyData {
            time: frame.time,
            points: Array::coordinates("Points", particles.iter().flat_map(|p| p.position), smallest_radius(frame)),
            cells: Cells::Vertices,
            point_data: data,
            cell_data: Vec::new(),
            field_data: self.field_data(frame),
            texts: vec![
                ("scene_name".into(), vec![self.scene.clone()]),
                ("material_names".into(), self.materials.clone()),
            ],
        }
    }

    /// Gravity at the frame's time, periods, and poses of the driven walls.
    fn field_data(&self, frame: &Snapshot) -> Vec<Array> {
        let gravity: [f64; 3] = self.gravity.at(frame.time).into();
        let mut data = vec![Array::doubles("gravity", 3, gravity.into_iter())];
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
            points: Array::coordinates("Points", ends.iter().flatten().flatten().copied(), smallest_radius(frame)),
            cells: Cells::Lines,
            point_data: Vec::new(),
            cell_data: vec![
                Array::floats("normal_force", 1, contacts.iter().map(|c| c.normal_force)),
                Array::floats("tangential_force", 3, contacts.iter().flat_map(|c| c.tangential_force)),
                Array::floats("normal", 3, contacts.iter().flat_map(|c| c.normal)),
                Array::coordinates("point", contacts.iter().flat_map(|c| c.point), smallest_radius(frame)),
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

    fn add_loads(&self, frame: &Snapshot, data: &mut Vec<Array>) {
        let loads = loads(frame, self.period);
        let each = || loads.iter().zip(&frame.particles);
        if self.has(GrainField::Force) {
            data.push(Array::floats(
                "force",
                3,
                loads.iter().flat_map(|load| [load.force.x, load.force.y, load.force.z]),
            ));
        }
        if self.has(GrainField::CoordinationNumber) {
            data.push(Array::integers("coordination_number", loads.iter().map(|load| load.contacts)));
        }
        if self.has(GrainField::Stress) {
            let stresses = each().flat_map(|(load, particle)| load.moments.map(|moment| moment / volume(particle)));
            data.push(Array::floats("stress", 6, stresses));
        }
        if self.has(GrainField::Pressure) {
            let pressures =
                each().map(|(load, particle)| load.moments[..3].iter().sum::<f64>() / 3.0 / volume(particle));
            data.push(Array::floats("pressure", 1, pressures));
        }
    }
}

/// Returns the lengths of the periodic axes, zero along the others, and the starts of the periods, m.
pub(crate) fn repeats(scene: &Scene) -> [[f64; 3]; 2] {
    let mut repeats = [[0.0; 3]; 2];
    for axis in scene.domain.periodic.iter().map(|axis| axis.number()) {
        repeats[0][axis] = scene.domain.max[axis] - scene.domain.min[axis];
        repeats[1][axis] = scene.domain.min[axis];
    }
    repeats
}

/// m3.
fn volume(particle: &Particle) -> f64 {
    4.0 / 3.0 * PI * particle.radius.powi(3)
}

/// What contacts do to each grain: the sum of their forces, and the mean stress times the volume V of the grain,
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

/// m.
fn smallest_radius(frame: &Snapshot) -> f64 {
    frame.particles.iter().map(|particle| particle.radius).fold(f64::INFINITY, f64::min)
}
