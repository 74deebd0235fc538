//! Walls as triangles, where they stand at a time.

use super::vtk::{Array, Cells, Kind, PolyData};
use crate::plan::Scene;
use makadam::scene::{Domain, Motion, Shape, Wall};
use makadam::snapshot::DrivenWall;
use makadam::wall::PlacedWalls;
use nalgebra::Vector3;
use std::f64::consts::TAU;

type Vector = Vector3<f64>;

/// Corners of a polygon that stands for a circle: its sides lie within 0.06% of the radius from the circle.
const CORNERS: u32 = 96;

/// Triangles of all spheres together, beyond which each is drawn more coarsely.
const MOST_TRIANGLES: usize = 200_000;

/// Share of the domain's diagonal within which two points are one.
const SAME: f64 = 1e-9;

/// The walls of a scene as triangles.
#[derive(Clone, Debug)]
pub(crate) struct WallMesh {
    walls: Vec<Wall>,
    domain: Domain,
    /// Number of each wall's material.
    materials: Vec<u8>,
    /// Each wall as the scene places it; planes are cut anew where they stand.
    placed: Vec<Triangles>,
}

/// Points and triangles on them.
#[derive(Clone, Debug, Default)]
struct Triangles {
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
}

impl WallMesh {
    pub fn new(scene: &Scene) -> WallMesh {
        let number = |wall: &Wall| scene.material.keys().position(|name| *name == wall.material).unwrap_or(0) as u8;
        WallMesh {
            materials: scene.wall.iter().map(number).collect(),
            placed: scene.wall.iter().map(|wall| placed(&wall.shape, &scene.domain)).collect(),
            walls: scene.wall.clone(),
            domain: scene.domain.clone(),
        }
    }

    /// Whether any of them ever moves, be it within its own surface.
    pub fn moves(&self) -> bool {
        self.walls.iter().any(|wall| !matches!(wall.motion, Motion::Fixed))
    }

    /// The walls at a time (s), with those that are driven where they are.
    pub fn at(&self, time: f64, driven: &[DrivenWall]) -> PolyData {
        let placed = PlacedWalls::at(&self.walls, &self.domain, time, driven);
        let (mut points, mut triangles, mut velocities) = (Vec::new(), Vec::new(), Vec::new());
        let (mut walls, mut materials) = (Vec::new(), Vec::new());
        for (number, wall) in self.walls.iter().enumerate() {
            let Some((_, face)) = placed.faces().find(|(of, _)| *of == number) else { continue };
            let first = points.len() as u32;
            let stands = |point: &Vector| placed.point_of(number, point);
            let moved = match &wall.shape {
                // Without end: what the domain shows of it, wherever it stands.
                Shape::Plane { point, normal } => {
                    let (point, normal) = (Vector::from(*point), Vector::from(*normal).normalize());
                    let foot = stands(&point);
                    plane(&foot, &(stands(&(point + normal)) - foot), &self.domain)
                }
                _ => {
                    let Triangles { points, triangles } = &self.placed[number];
                    Triangles { points: points.iter().map(stands).collect(), triangles: triangles.clone() }
                }
            };
            velocities.extend(moved.points.iter().map(|point| face.velocity_at(point)));
            points.extend(moved.points);
            walls.extend(moved.triangles.iter().map(|_| number as i32));
            materials.extend(moved.triangles.iter().map(|_| self.materials[number]));
            triangles.extend(moved.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
        }
        let flat = |vectors: &[Vector]| vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect::<Vec<_>>();
        let axes: Vec<Vector> = self.walls.iter().map(|wall| axis(&wall.motion)).collect();
        PolyData {
            time,
            points: Array::coordinates("Points", flat(&points).into_iter(), 1e-3 * self.diagonal()),
            cells: Cells::Triangles(triangles),
            point_data: vec![Array::floats("velocity", 3, flat(&velocities).into_iter())],
            cell_data: vec![
                Array::integers("wall", walls.into_iter()),
                Array { name: "material".into(), components: 1, kind: Kind::UInt8, bytes: materials },
            ],
            field_data: vec![Array::doubles("wall_axes", 3, flat(&axes).into_iter())],
            texts: vec![
                ("wall_names".into(), self.walls.iter().map(|wall| wall.name.clone()).collect()),
                ("wall_shapes".into(), self.walls.iter().map(|wall| kind(&wall.shape).into()).collect()),
            ],
        }
    }

    fn diagonal(&self) -> f64 {
        (Vector::from(self.domain.max) - Vector::from(self.domain.min)).norm()
    }
}

/// What the scene calls a shape.
fn kind(shape: &Shape) -> &'static str {
    match shape {
        Shape::Plane { .. } => "plane",
        Shape::Box { .. } => "box",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Spheres { .. } => "spheres",
        Shape::Disc { .. } => "disc",
    }
}

/// Unit vector along the axis that a wall turns about; zero if it does not turn.
fn axis(motion: &Motion) -> Vector {
    match motion {
        Motion::Rotating { axis, rate, .. } => Vector::from(*axis).normalize() * rate.signum(),
        Motion::TorqueDriven { axis, .. } => Vector::from(*axis).normalize(),
        _ => Vector::zeros(),
    }
}

fn placed(shape: &Shape, domain: &Domain) -> Triangles {
    match shape {
        Shape::Plane { .. } => Triangles::default(),
        Shape::Box { min, max, open } => cuboid(min, max, open),
        Shape::Cylinder { base, axis, radius, length } => {
            let (base, axis) = (Vector::from(*base), Vector::from(*axis).normalize());
            let [from, to] = extent(&base, &axis, *length, domain);
            band([(base + axis * from, *radius), (base + axis * to, *radius)], &axis)
        }
        Shape::Disc { centre, normal, radius, hole } => {
            let (centre, normal) = (Vector::from(*centre), Vector::from(*normal).normalize());
            band([(centre, *hole), (centre, *radius)], &normal)
        }
        Shape::Spheres { centres, radius } => spheres(centres, *radius),
    }
}

/// From where to where a cylinder reaches along its axis from its base, m: all through the domain where that repeats itself.
fn extent(base: &Vector, axis: &Vector, length: f64, domain: &Domain) -> [f64; 2] {
    match (0..3).find(|&along| domain.period().is_periodic(along) && axis[along] != 0.0) {
        None => [0.0, length],
        Some(along) => [domain.min[along], domain.max[along]].map(|end| (end - base[along]) / axis[along]),
    }
}

/// Two directions that are perpendicular to a unit vector and to each other.
fn across(axis: &Vector) -> [Vector; 2] {
    let first = axis.cross(&Vector::ith(axis.iamin(), 1.0)).normalize();
    [first, axis.cross(&first)]
}

/// What lies between two circles about an axis, each by its centre and radius; a circle of no radius is a point.
fn band(circles: [(Vector, f64); 2], axis: &Vector) -> Triangles {
    let [right, up] = across(axis);
    let mut points = Vec::new();
    let rings = circles.map(|(centre, radius)| {
        let first = points.len() as u32;
        let corners = if radius > 0.0 { CORNERS } else { 1 };
        points.extend((0..corners).map(|corner| {
            let (sine, cosine) = (TAU * f64::from(corner) / f64::from(CORNERS)).sin_cos();
            centre + (right * cosine + up * sine) * radius
        }));
        move |corner: u32| first + corner % corners
    });
    let [inner, outer] = rings;
    let sides = (0..CORNERS).flat_map(|corner| {
        let [a, b, c, d] = [inner(corner), inner(corner + 1), outer(corner), outer(corner + 1)];
        [[a, c, d], [a, d, b]]
    });
    let triangles = sides.filter(|[a, b, c]| a != b && b != c && a != c).collect();
    Triangles { points, triangles }
}

/// The faces of a box that are not open.
fn cuboid(min: &[f64; 3], max: &[f64; 3], open: &[String]) -> Triangles {
    let mut all = Triangles::default();
    for (number, name) in ["-x", "+x", "-y", "+y", "-z", "+z"].iter().enumerate() {
        if open.iter().any(|face| face == name) {
            continue;
        }
        let (axis, first) = (number / 2, all.points.len() as u32);
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
            let mut high = [0; 3];
            (high[axis], high[(axis + 1) % 3], high[(axis + 2) % 3]) = (number % 2, u, v);
            Vector::from_fn(|k, _| if high[k] == 1 { max[k] } else { min[k] })
        });
        all.points.extend(corners);
        all.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|corner: u32| first + corner)));
    }
    all
}

/// What the domain shows of a plane: a polygon of three to six corners, or nothing.
fn plane(point: &Vector, normal: &Vector, domain: &Domain) -> Triangles {
    let [low, high] = [domain.min, domain.max].map(Vector::from);
    let same = SAME * (high - low).norm();
    let corner = |number: usize| Vector::from_fn(|k, _| if number >> k & 1 == 1 { high[k] } else { low[k] });
    let above = |corner: &Vector| normal.dot(&(corner - point));
    let mut points: Vec<Vector> = Vec::new();
    let mut add = |point: Vector| {
        if points.iter().all(|other| (other - point).norm() > same) {
            points.push(point);
        }
    };
    for (start, axis) in (0..8).flat_map(|start| (0..3).map(move |axis| (start, axis))) {
        let (from, to) = (corner(start), corner(start | 1 << axis));
        let (before, behind) = (above(&from), above(&to));
        if before.abs() <= same {
            add(from);
        } else if before * behind < 0.0 && behind.abs() > same {
            add(from + (to - from) * (before / (before - behind)));
        }
    }
    if points.len() < 3 {
        return Triangles::default();
    }
    let middle = points.iter().sum::<Vector>() / points.len() as f64;
    let [right, up] = across(normal);
    let angle = |point: &Vector| (point - middle).dot(&up).atan2((point - middle).dot(&right));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let triangles = (2..points.len() as u32).map(|corner| [0, corner - 1, corner]).collect();
    Triangles { points, triangles }
}

/// Spheres, each an icosahedron whose triangles are divided twice, or less if there are many.
fn spheres(centres: &[[f64; 3]], radius: f64) -> Triangles {
    let fits = |divisions: &u32| centres.len() * 20 * 4_usize.pow(*divisions) <= MOST_TRIANGLES;
    let one = icosphere((0..=2).rev().find(fits).unwrap_or(0));
    let mut all = Triangles::default();
    for centre in centres {
        let first = all.points.len() as u32;
        all.points.extend(one.points.iter().map(|point| Vector::from(*centre) + point * radius));
        all.triangles.extend(one.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    }
    all
}

/// A unit sphere.
fn icosphere(divisions: u32) -> Triangles {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut points = Vec::new();
    for k in 0..3 {
        for [one, long] in [[1.0, golden], [-1.0, golden], [1.0, -golden], [-1.0, -golden]] {
            let mut point = Vector::zeros();
            (point[k], point[(k + 1) % 3]) = (one, long);
            points.push(point.normalize());
        }
    }
    // Three corners are a triangle if all are neighbours.
    let near = |a: usize, b: usize| (points[a] - points[b]).norm() < 1.1;
    let mut triangles = Vec::new();
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c)))) {
        if near(a, b) && near(b, c) && near(a, c) {
            triangles.push([a as u32, b as u32, c as u32]);
        }
    }
    for _ in 0..divisions {
        let mut middles = std::collections::HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]: [u32; 2]| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let middle: Vector = points[p as usize] + points[q as usize];
                    points.push(middle.normalize());
                    points.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    Triangles { points, triangles }
}

#[cfg(test)]
#[path = "../../tests/unit/output_wall_mesh.rs"]
mod tests;
