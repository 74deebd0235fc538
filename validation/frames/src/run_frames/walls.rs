//! Walls of a scene as triangles, at their pose at a given time.

use super::columns::{Column, DOUBLES, Number, Part, REAL, VECTOR, WHOLE};
use super::frame::FrameTables;
use crate::output::mesh::{DRAWN, has_area, wall_mesh};
use crate::plan::Observable;
use makadam::scene::{Domain, Motion, Shape, Wall};
use makadam::snapshot::{FaceWear, Snapshot};
use makadam::wall::PlacedWalls;
use nalgebra::Vector3;
use std::collections::HashMap;

type Vector = Vector3<f64>;

/// Walls as triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walls {
    /// Corners, m.
    pub points: Vec<[f64; 3]>,
    /// Triangles, by the numbers of their corners.
    pub triangles: Vec<[u32; 3]>,
    /// Number of each triangle's wall.
    pub wall: Vec<u32>,
    /// Names of the walls, by their numbers.
    pub names: Vec<String>,
    /// Kinds of their shapes by their names in scenes, by wall number.
    pub shapes: Vec<&'static str>,
    /// Unit vectors along the rotation axes of walls, by wall number; zero for walls without rotation.
    pub axes: Vec<[f64; 3]>,
    /// Velocities of the corners, m/s.
    pub velocities: Vec<[f64; 3]>,
}

/// Points, and triangles between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Triangles {
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    /// Number of the face of each triangle of a mesh; empty for other shapes.
    faces: Vec<u32>,
}

impl Triangles {
    /// Triangulates a shape and joins coincident corners.
    pub fn of(shape: &Shape, domain: &Domain) -> Triangles {
        let mut all = Triangles::default();
        let mut known = HashMap::new();
        for corners in wall_mesh(shape, domain, 0.0, DRAWN).triangles {
            all.triangles.push(corners.map(|corner| {
                *known.entry(corner.map(f64::to_bits)).or_insert_with(|| {
                    all.points.push(corner.into());
                    all.points.len() as u32 - 1
                })
            }));
        }
        if let (Shape::Mesh { .. }, Some(triangles)) = (shape, shape.triangles()) {
            all.faces =
                (0..).zip(&triangles).filter(|(_, triangle)| has_area(triangle)).map(|(face, _)| face).collect();
        }
        all
    }
}

impl FrameTables {
    /// Returns the walls at the time of a frame.
    pub(super) fn walls_at(&self, frame: &Snapshot) -> Walls {
        let scene = self.scene_of(frame);
        let (walls, domain) = (&scene.wall, &scene.domain);
        let placed = PlacedWalls::at(walls, domain, frame.time, &frame.driven_walls, &frame.beginnings);
        let mut all = Walls {
            names: walls.iter().map(|wall| wall.name.clone()).collect(),
            shapes: walls.iter().map(|wall| wall.shape.kind()).collect(),
            axes: walls.iter().map(|wall| axis(&wall.motion).into()).collect(),
            ..Walls::default()
        };
        for (number, wall) in walls.iter().enumerate() {
            let Some((_, face)) = placed.faces().find(|(of, _)| *of == number) else { continue };
            let first = all.points.len() as u32;
            let stands = |point: &Vector| placed.point_of(number, point);
            let Triangles { points, triangles, .. } = match &wall.shape {
                // A plane is infinite: the part in the domain, at its pose.
                Shape::Plane { point, normal } => {
                    let (point, normal) = (Vector::from(*point), Vector::from(*normal).normalize());
                    let foot = stands(&point);
                    let normal = (stands(&(point + normal)) - foot).into();
                    Triangles::of(&Shape::Plane { point: foot.into(), normal }, domain)
                }
                _ => {
                    let Triangles { points, triangles, .. } = &self.walls[number];
                    Triangles {
                        points: points.iter().map(stands).collect(),
                        triangles: triangles.clone(),
                        faces: Vec::new(),
                    }
                }
            };
            all.velocities.extend(points.iter().map(|point| <[f64; 3]>::from(face.velocity_at(point))));
            all.points.extend(points.iter().map(|point| <[f64; 3]>::from(*point)));
            all.wall.extend(triangles.iter().map(|_| number as u32));
            all.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| first + corner)));
        }
        all
    }

    /// Returns the walls of a frame as a part of it, with pressure and wear if the scene measures the wear.
    pub fn walls_part(&self, frame: &Snapshot) -> Part {
        let walls = self.walls_at(frame);
        let worn = match self.scene.measure.observables.contains(&Observable::Wear) {
            true => self.wear(&walls, &frame.wear).to_vec(),
            false => Vec::new(),
        };
        let Walls { points, triangles, wall, names, shapes, axes, velocities } = walls;
        let diagonal = (Vector::from(self.scene.domain.max) - Vector::from(self.scene.domain.min)).norm();
        let material = |wall: &Wall| self.scene.material.keys().position(|name| *name == wall.material).unwrap_or(0);
        let numbers: Vec<usize> = self.scene.wall.iter().map(material).collect();
        let materials = wall.iter().map(|wall| numbers[*wall as usize] as f64);
        Part {
            corners_per_cell: 3,
            time: frame.time,
            points: Column::coordinates("Points", points.into_flattened(), 1e-3 * diagonal),
            corners: Some(triangles.into_flattened()),
            of_points: vec![Column::new("velocity", VECTOR, velocities.into_flattened())],
            of_cells: vec![
                Column::new("wall", WHOLE, wall.iter().map(|wall| f64::from(*wall))),
                Column::new("material", (Number::UInt8, 1), materials),
            ]
            .into_iter()
            .chain(worn)
            .collect(),
            whole: vec![Column::new("wall_axes", DOUBLES, axes.into_flattened())],
            texts: vec![("wall_names", names), ("wall_shapes", shapes.into_iter().map(String::from).collect())],
        }
    }
}

impl FrameTables {
    /// Returns pressure (Pa), Archard's and Finnie's sums (J/m2) of each triangle: of its face for a mesh, of the whole wall for other shapes.
    fn wear(&self, walls: &Walls, wear: &[FaceWear]) -> [Column; 3] {
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| Vector::from(walls.points[corner as usize]));
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        let is_mesh = |wall: u32| matches!(self.scene.wall[wall as usize].shape, Shape::Mesh { .. });
        let key = |wall: u32, face: u32| (wall, if is_mesh(wall) { face } else { 0 });
        let mut sums: HashMap<(u32, u32), [f64; 3]> = HashMap::new();
        for face in wear {
            let sum = sums.entry(key(face.wall, face.face)).or_default();
            *sum = [sum[0] + face.normal_force, sum[1] + face.archard, sum[2] + face.finnie];
        }
        let (mut places, mut areas, mut before) = (Vec::new(), HashMap::new(), (u32::MAX, 0));
        for (wall, corners) in walls.wall.iter().zip(&walls.triangles) {
            before = if before.0 == *wall { (*wall, before.1 + 1) } else { (*wall, 0) };
            let place = key(*wall, self.walls[*wall as usize].faces.get(before.1).copied().unwrap_or_default());
            places.push(place);
            *areas.entry(place).or_insert(0.0) += area(corners);
        }
        let density = |part: usize| {
            let of = |place: &(u32, u32)| sums.get(place).map_or(0.0, |sum| sum[part] / areas[place]);
            places.iter().map(of).collect::<Vec<f64>>()
        };
        [("pressure", 0), ("archard", 1), ("finnie", 2)].map(|(name, part)| Column::new(name, REAL, density(part)))
    }
}

/// Returns the unit vector along the rotation axis of a wall; zero without rotation.
fn axis(motion: &Motion) -> Vector {
    let sense = if let Motion::Rotating { rate, .. } = motion { rate.signum() } else { 1.0 };
    motion.axis().map_or_else(Vector::zeros, |(_, axis)| Vector::from(axis).normalize() * sense)
}

#[cfg(test)]
#[path = "../../tests/unit/run_frames_walls.rs"]
mod tests;
