//! One frame of a run in memory.

use crate::output::vtk::{Array, Cells, PolyData};
use crate::output::{driven_walls, wall_triangles};
use crate::plan::Scene;
use makadam::snapshot::{DrivenWall, Particle};

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
    /// Acceleration of gravity, m/s2; zero where it is not known.
    pub gravity: [f64; 3],
    /// Poses of the walls that forces drive.
    pub driven_walls: Vec<DrivenWall>,
    /// The axes along which the scene repeats itself; none where there are no such, or an earlier version wrote the frame.
    pub repeats: Option<Repeats>,
}

/// Axes along which a scene repeats itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// Length of the period along each axis, m; zero along those that do not repeat themselves.
    pub lengths: [f64; 3],
    /// Where it begins, m.
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
        let walls = surfaces(wall_triangles(scene, time)).ok().map(|walls| {
            let is_known = |(_, wall): &([u32; 3], u32)| !scene.wall[*wall as usize].motion.is_driven();
            let (triangles, wall) = walls.triangles.into_iter().zip(walls.wall).filter(is_known).unzip();
            Walls { triangles, wall, ..walls }
        });
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
            walls,
            driven_walls: Vec::new(),
            repeats: None,
        }
    }
}

/// A frame from its files.
pub(super) fn assemble(
    grains: PolyData,
    contacts: Option<PolyData>,
    walls: Option<PolyData>,
) -> Result<RunFrame, String> {
    let gravity = grains.field_data.iter().find(|array| array.name == "gravity").map(triples);
    let vector = |name: &str| {
        let array = grains.field_data.iter().find(|array| array.name == name && array.components == 3)?;
        triples(array).first().copied().filter(|numbers| numbers.iter().all(|number| number.is_finite()))
    };
    let repeats = match (vector("period"), vector("period_start")) {
        (Some(lengths), Some(starts)) if lengths.iter().all(|length| *length >= 0.0) => {
            Some(Repeats { lengths, starts })
        }
        _ => None,
    };
    let pose = |name: &str| grains.field_data.iter().find(|array| array.name == name).map(Array::values);
    let driven_walls = driven_walls(pose)?;
    let materials = texts(&grains, "material_names");
    let positions = triples(&grains.points);
    let sizes = |name: &str| grains.point_data.iter().find(|array| array.name == name && array.components == 1);
    let radii = match (sizes("diameter"), sizes("radius")) {
        (Some(diameters), _) => diameters.values().iter().map(|diameter| 0.5 * diameter).collect(),
        (_, Some(radii)) => radii.values(),
        _ => return Err("its grains have neither a diameter nor a radius".into()),
    };
    let sound = |values: &[f64]| values.iter().all(|value| value.is_finite());
    if !positions.iter().all(|position| sound(position))
        || !radii.iter().all(|radius| *radius > 0.0 && radius.is_finite())
    {
        return Err("a grain has no finite place or no size".into());
    }
    Ok(RunFrame {
        time: grains.time,
        gravity: gravity.and_then(|all| all.first().copied()).unwrap_or_default(),
        grains: Grains { positions, radii, fields: grains.point_data, materials },
        contacts: contacts.map(|contacts| lines(&contacts)).transpose()?,
        walls: walls.map(surfaces).transpose()?,
        driven_walls,
        repeats,
    })
}

fn lines(contacts: &PolyData) -> Result<Vec<ContactLine>, String> {
    let forces = contacts.cell_data.iter().find(|array| array.name == "normal_force" && array.components == 1);
    let forces = forces.ok_or("its contacts have no normal force")?.values();
    let points = triples(&contacts.points);
    let ends = points.as_chunks::<2>().0;
    Ok(ends.iter().zip(forces).map(|(ends, normal_force)| ContactLine { ends: *ends, normal_force }).collect())
}

fn surfaces(walls: PolyData) -> Result<Walls, String> {
    let (names, shapes) = (texts(&walls, "wall_names"), texts(&walls, "wall_shapes"));
    let axes = walls.field_data.iter().find(|array| array.name == "wall_axes" && array.components == 3).map(triples);
    let points = triples(&walls.points);
    let wall = walls.cell_data.iter().find(|array| array.name == "wall" && array.components == 1);
    let wall = wall.map(|array| array.values().iter().map(|number| *number as u32).collect());
    match walls.cells {
        Cells::Triangles(triangles) => Ok(Walls {
            wall: wall.unwrap_or_else(|| vec![0; triangles.len()]),
            axes: axes.unwrap_or_default(),
            points,
            triangles,
            names,
            shapes,
        }),
        // A scene whose walls the domain does not show.
        _ if points.is_empty() => {
            Ok(Walls { points, triangles: Vec::new(), wall: Vec::new(), names, shapes, axes: axes.unwrap_or_default() })
        }
        _ => Err("its walls are no triangles".into()),
    }
}

fn triples(array: &Array) -> Vec<[f64; 3]> {
    array.values().as_chunks::<3>().0.to_vec()
}

fn texts(data: &PolyData, name: &str) -> Vec<String> {
    data.texts.iter().find(|(of, _)| of == name).map_or(Vec::new(), |(_, texts)| texts.clone())
}
