//! Walls as triangles: the same ones for every code that takes meshes.
//!
//! Triangles are few and large: where a grain rests near an edge, some codes count both triangles.

use makadam::scene::{Domain, Shape};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// How finely curved walls are cut into facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Largest sagitta of a cylinder's facets over the smallest grain's radius.
    sagitta: f64,
    /// Fewest facets around a cylinder.
    fewest: usize,
    /// Whether cylinders are cut into rings, so that no angle of a triangle is below the bend between neighbours.
    rings: bool,
}

/// So fine that no observable that is compared tells a cylinder from its mesh.
pub const FINE: Fineness = Fineness { sagitta: 0.005, fewest: 100, rings: true };

/// As coarse as angles of repose, packing fraction and coordination number bear (`validation/docs/timing.md`).
pub const COARSE: Fineness = Fineness { sagitta: 0.025, fewest: 32, rings: false };

/// Smallest angle of a triangle of a mesh without rings, rad: LIGGGHTS refuses meshes with angles of a degree.
const SHARPEST: f64 = 1.5 * PI / 180.0;

/// Corners of a disc's outline.
const DISC_CORNERS: usize = 32;

/// Largest ratio of the radii of two neighbouring outlines of a ring: the sharpest angle of a triangle between them is then 2 degrees,
/// and LIGGGHTS refuses meshes with angles of one.
const RING_RATIO: f64 = 5.0;

/// Height of a triangle over its longest side below which it is a line, written with the digits that meshes are written with.
const FLAT: f64 = 1e-9;

/// Share of the domain's width by which planes reach beyond it on each side: a grain that rolls that far still finds
/// the plane, as on an endless one.
const PLANE_REACH: f64 = 0.5;

/// A triangle's corners, metres; counter-clockwise seen from the grains' side.
pub type Triangle = [[f64; 3]; 3];

/// A wall's surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Triangles, their normals towards the grains.
    pub triangles: Vec<Triangle>,
    /// Largest angle between neighbours that stand for one smooth surface, degrees; 0 for flat faces.
    pub bend: f64,
}

/// The surface of a wall; empty for a plane that misses the domain.
pub fn wall_mesh(shape: &Shape, domain: &Domain, smallest_radius: f64) -> Mesh {
    cut_wall(shape, domain, smallest_radius, FINE)
}

/// The same, its curved parts cut so finely.
pub fn cut_wall(shape: &Shape, domain: &Domain, smallest_radius: f64, fineness: Fineness) -> Mesh {
    let mut mesh = match shape {
        Shape::Plane { point, normal } => plane(Vector3::from(*point), unit(normal), &reach(domain)),
        Shape::Box { min, max, open } => open_box(*min, *max, open, &reach(domain)),
        Shape::Cylinder { base, axis, radius, length } => {
            cylinder(Vector3::from(*base), unit(axis), *radius, *length, smallest_radius, fineness)
        }
        // Codes that need meshes refuse these beforehand.
        Shape::Spheres { .. } => Mesh::default(),
        // Over a smaller hole a grain sinks by less than cylinders are coarse: `hole^2 / 2 r`.
        Shape::Disc { centre, normal, radius, hole } if hole * hole > 2.0 * FINE.sagitta * smallest_radius.powi(2) => {
            ring(Vector3::from(*centre), unit(normal), *radius, *hole)
        }
        Shape::Disc { centre, normal, radius, .. } => disc(Vector3::from(*centre), unit(normal), *radius),
    };
    mesh.triangles.retain(has_area);
    mesh
}

/// Whether a triangle has an area, beyond rounding: without one it has no normal either, and codes refuse it.
fn has_area(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.map(Vector3::from);
    let (first, second, third) = (b - a, c - a, c - b);
    let longest = first.norm_squared().max(second.norm_squared()).max(third.norm_squared());
    first.cross(&second).norm() > FLAT * longest
}

/// The domain, enlarged: what planes are cut to, and what a code's simulation box must hold.
pub fn reach(domain: &Domain) -> Domain {
    let grow = |at: f64, width: f64| at + PLANE_REACH * width;
    let width: [f64; 3] = std::array::from_fn(|i| domain.max[i] - domain.min[i]);
    Domain {
        min: std::array::from_fn(|i| grow(domain.min[i], -width[i])),
        max: std::array::from_fn(|i| grow(domain.max[i], width[i])),
        periodic: domain.periodic.clone(),
    }
}

fn unit(vector: &[f64; 3]) -> Vector3<f64> {
    Vector3::from(*vector).normalize()
}

/// Two unit vectors that make a right-handed frame with `normal`, along the axes where the normal is.
fn frame(normal: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let helper = if normal.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let second = normal.cross(&helper).normalize();
    (second.cross(normal), second)
}

/// Cuts every second corner off until three are left: no corner collects many triangles, as it would in a fan.
fn triangulate(mut corners: Vec<Vector3<f64>>) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    while corners.len() > 3 {
        let count = corners.len();
        let mut kept = Vec::with_capacity(count / 2 + 1);
        for first in (0..count).step_by(2) {
            kept.push(corners[first]);
            if first + 1 < count {
                let ear = [corners[first], corners[first + 1], corners[(first + 2) % count]];
                // Four corners leave two after both ears: the second ear is the rest itself.
                triangles.push(ear.map(Into::into));
            }
        }
        corners = kept;
    }
    if let [a, b, c] = corners[..] {
        triangles.push([a, b, c].map(Into::into));
    }
    triangles
}

fn plane(point: Vector3<f64>, normal: Vector3<f64>, limits: &Domain) -> Mesh {
    let (min, max) = (Vector3::from(limits.min), Vector3::from(limits.max));
    let centre = (min + max) * 0.5;
    let centre = centre - normal * normal.dot(&(centre - point));
    let (u, v) = frame(&normal);
    let half = (max - min).norm();
    let mut corners: Vec<Vector3<f64>> =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| centre + (u * a + v * b) * half).into();
    for axis in 0..3 {
        // A plane that lies in a face of the box is not cut by that face.
        corners = clip(&corners, |corner| corner[axis] - min[axis] + 1e-9 * half);
        corners = clip(&corners, |corner| max[axis] - corner[axis] + 1e-9 * half);
    }
    Mesh { triangles: triangulate(corners), bend: 0.0 }
}

/// Sutherland-Hodgman: what of a convex polygon lies where `height` is not negative.
fn clip(corners: &[Vector3<f64>], height: impl Fn(&Vector3<f64>) -> f64) -> Vec<Vector3<f64>> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (index, here) in corners.iter().enumerate() {
        let next = &corners[(index + 1) % corners.len()];
        let (a, b) = (height(here), height(next));
        if a >= 0.0 {
            kept.push(*here);
        }
        if (a >= 0.0) != (b >= 0.0) {
            kept.push(here + (next - here) * (a / (a - b)));
        }
    }
    kept
}

fn open_box(min: [f64; 3], max: [f64; 3], open: &[String], limits: &Domain) -> Mesh {
    let is_open = |axis: usize, sign: &str| open.iter().any(|face| *face == format!("{sign}{}", ["x", "y", "z"][axis]));
    // Side faces have no edge: beside an open face they go on to the limits.
    let low: [f64; 3] = std::array::from_fn(|i| if is_open(i, "-") { min[i].min(limits.min[i]) } else { min[i] });
    let high: [f64; 3] = std::array::from_fn(|i| if is_open(i, "+") { max[i].max(limits.max[i]) } else { max[i] });
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
        for (sign, at) in [("-", min[axis]), ("+", max[axis])] {
            if is_open(axis, sign) {
                continue;
            }
            let corner = |b: f64, c: f64| {
                let mut corner = [0.0; 3];
                (corner[axis], corner[second], corner[third]) = (at, b, c);
                corner
            };
            let (a, b) = (corner(low[second], low[third]), corner(high[second], low[third]));
            let (c, d) = (corner(high[second], high[third]), corner(low[second], high[third]));
            match sign {
                "-" => triangles.extend([[a, b, c], [a, c, d]]),
                _ => triangles.extend([[a, c, b], [a, d, c]]),
            }
        }
    }
    Mesh { triangles, bend: 0.0 }
}

fn cylinder(
    base: Vector3<f64>,
    axis: Vector3<f64>,
    radius: f64,
    length: f64,
    smallest_radius: f64,
    fineness: Fineness,
) -> Mesh {
    let (u, v) = frame(&axis);
    let sagitta = (fineness.sagitta * smallest_radius / radius).clamp(1e-6, 0.5);
    let segments = ((PI / (1.0 - sagitta).acos()).ceil() as usize).clamp(fineness.fewest, 1000);
    let half_angle = PI / segments as f64;
    // The corners lie a hair outside, so that the mean radius is right.
    let corner_radius = radius * (1.0 + half_angle * half_angle / 3.0);
    // Rings keep the triangles' smallest angle above the bend between neighbours, as LIGGGHTS advises, or above what it refuses.
    let width = 2.0 * corner_radius * half_angle.sin();
    let sharpest = if fineness.rings { 3.0 * half_angle } else { SHARPEST };
    let rings = (length / (width / sharpest.tan())).ceil().max(1.0) as usize;
    let corner = |segment: usize, ring: usize| {
        let (sine, cosine) = (2.0 * half_angle * (segment % segments) as f64).sin_cos();
        base + (u * cosine + v * sine) * corner_radius + axis * (length * ring as f64 / rings as f64)
    };
    let mut triangles = Vec::with_capacity(2 * rings * segments);
    for ring in 0..rings {
        for segment in 0..segments {
            let (a, b) = (corner(segment, ring), corner(segment + 1, ring));
            let (c, d) = (corner(segment + 1, ring + 1), corner(segment, ring + 1));
            triangles.extend([[a, c, b].map(Into::into), [a, d, c].map(Into::into)]);
        }
    }
    Mesh { triangles, bend: 2.0 * half_angle.to_degrees() }
}

fn disc(centre: Vector3<f64>, normal: Vector3<f64>, radius: f64) -> Mesh {
    Mesh { triangles: triangulate(circle(centre, normal, radius)), bend: 0.0 }
}

/// A disc with a hole: two triangles between each two corners of its outlines.
fn ring(centre: Vector3<f64>, normal: Vector3<f64>, radius: f64, hole: f64) -> Mesh {
    let rings = ((radius / hole).ln() / RING_RATIO.ln()).ceil().max(1.0);
    let outline = |ring: f64| match ring {
        ring if ring == rings => circle(centre, normal, radius),
        ring => circle(centre, normal, hole * (radius / hole).powf(ring / rings)),
    };
    let mut triangles = Vec::new();
    for ring in 0..rings as usize {
        let (inner, outer) = (outline(ring as f64), outline(ring as f64 + 1.0));
        for index in 0..DISC_CORNERS {
            let next = (index + 1) % DISC_CORNERS;
            let (a, b, c, d) = (inner[index], outer[index], outer[next], inner[next]);
            triangles.extend([[a, b, c].map(Into::into), [a, c, d].map(Into::into)]);
        }
    }
    Mesh { triangles, bend: 0.0 }
}

/// Corners of a circle's outline, counter-clockwise about the normal; they lie a hair outside, so that the mean radius is right.
fn circle(centre: Vector3<f64>, normal: Vector3<f64>, radius: f64) -> Vec<Vector3<f64>> {
    let (u, v) = frame(&normal);
    let half_angle = PI / DISC_CORNERS as f64;
    let corner_radius = radius * (1.0 + half_angle * half_angle / 3.0);
    let corner = |index: usize| {
        let (sine, cosine) = (2.0 * half_angle * index as f64).sin_cos();
        centre + (u * cosine + v * sine) * corner_radius
    };
    (0..DISC_CORNERS).map(corner).collect()
}
