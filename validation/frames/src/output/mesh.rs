//! Wall shapes as triangles, for all codes that take meshes and for pictures.
//!
//! Triangles are few and large: near an edge, some codes count a contact with both triangles.

use makadam::scene::{Domain, Revolution, Shape};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Tolerance of the facets of curved walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Largest sagitta of a cylinder's facets over the smallest grain's radius.
    sagitta: f64,
    /// Fewest and most facets around a cylinder.
    facets: [usize; 2],
    /// Smallest angle of a cylinder's triangles, rad; rings are shortened to respect it. If absent, the bend between neighbours, as LIGGGHTS
    /// advises.
    sharpest: Option<f64>,
    /// Corners of a disc's outline.
    disc_corners: usize,
    /// True if a surface ends at the scene's shape and domain, with all corners on the shape. Otherwise planes, and side faces of open
    /// boxes, extend beyond the domain, and the mean radius of facets is that of the shape.
    ends: bool,
}

/// Fine tolerance: a cylinder and its mesh give the same compared observables.
pub const FINE: Fineness =
    Fineness { sagitta: 0.005, facets: [100, 1000], sharpest: None, disc_corners: 32, ends: false };

/// Coarsest tolerance for angles of repose, packing fraction and coordination number (`validation/docs/timing.md`). LIGGGHTS refuses meshes
/// with angles of one degree.
pub const COARSE: Fineness =
    Fineness { sagitta: 0.025, facets: [32, 1000], sharpest: Some(1.5 * PI / 180.0), disc_corners: 32, ends: false };

/// Tolerance for pictures and exports: sides lie within 0.06% of the radius from the circle.
pub(crate) const DRAWN: Fineness =
    Fineness { sagitta: 0.0, facets: [96, 96], sharpest: Some(0.0), disc_corners: 96, ends: true };

/// Largest total number of triangles of the drawn spheres; above it, each sphere is drawn more coarsely.
const MOST_TRIANGLES: usize = 200_000;

/// Largest ratio of the radii of two neighbouring outlines of a ring: the sharpest angle of a triangle between them is then 2 degrees,
/// and LIGGGHTS refuses meshes with angles of one degree.
const RING_RATIO: f64 = 5.0;

/// Ratio of a triangle's height to its longest side, below which the triangle is a line at the output precision of meshes.
const FLAT: f64 = 1e-9;

/// Extension of planes beyond the domain on each side, as a fraction of the domain's width: a grain that rolls this far
/// still finds the plane, as on an infinite plane.
const PLANE_REACH: f64 = 0.5;

/// Corners of a triangle, m; counter-clockwise seen from the grains' side.
pub type Triangle = [[f64; 3]; 3];

/// Surface of a wall.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Triangles, their normals towards the grains.
    pub triangles: Vec<Triangle>,
    /// Largest angle between neighbouring triangles of one smooth surface, degrees; 0 for flat faces.
    pub bend: f64,
}

/// Returns the surface of a wall; empty for a plane that misses the domain, and for spheres, which codes refuse.
pub fn wall_mesh(shape: &Shape, domain: &Domain, smallest_radius: f64, fineness: Fineness) -> Mesh {
    let limits = if fineness.ends { domain.clone() } else { reach(domain) };
    let mut mesh = match shape {
        Shape::Plane { point, normal } => plane(Vector3::from(*point), unit(normal), &limits),
        Shape::Box { min, max, open } => {
            let own = Domain { min: *min, max: *max, periodic: Vec::new() };
            open_box(*min, *max, open, if fineness.ends { &own } else { &limits })
        }
        Shape::Spheres { .. } if !fineness.ends => Mesh::default(),
        Shape::Spheres { centres, radius } => Mesh { triangles: spheres(centres, *radius), bend: 0.0 },
        _ => match shape.revolution() {
            Some(part) => revolved(&part, domain, smallest_radius, fineness),
            None => Mesh { triangles: shape.triangles().unwrap_or_default(), bend: 0.0 },
        },
    };
    mesh.triangles.retain(has_area);
    mesh
}

/// Triangulates a surface of revolution. A line parallel to a periodic axis leads from end to end of the domain.
fn revolved(part: &Revolution, domain: &Domain, smallest_radius: f64, fineness: Fineness) -> Mesh {
    let (base, axis) = (Vector3::from(part.base), Vector3::from(part.axis));
    let [[first, start], [last, end]] = part.line;
    if start == end {
        let (hole, radius) = (first, last);
        let circle = |radius: f64| circle(base, axis, radius, fineness);
        // Over a smaller hole a grain sinks by less than the sagitta of cylinders: `hole^2 / 2 r`.
        let smallest = 2.0 * FINE.sagitta * smallest_radius.powi(2);
        let triangles = match hole * hole > if fineness.ends { 0.0 } else { smallest } {
            true => ring(radius, hole, circle),
            false => triangulate(circle(radius)),
        };
        return Mesh { triangles, bend: 0.0 };
    }
    match (0..3).find(|&along| domain.period().is_periodic(along) && axis[along] != 0.0) {
        None => cone([base, axis], part.line, smallest_radius, fineness),
        Some(along) => {
            let [from, to] = [domain.min[along], domain.max[along]].map(|end| (end - base[along]) / axis[along]);
            cone([base + axis * from, axis], [[first, 0.0], [last, to - from]], smallest_radius, fineness)
        }
    }
}

/// Returns true if a triangle has an area beyond rounding: a triangle without area has no normal either, and codes refuse it.
pub(crate) fn has_area(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.map(Vector3::from);
    let (first, second, third) = (b - a, c - a, c - b);
    let longest = first.norm_squared().max(second.norm_squared()).max(third.norm_squared());
    first.cross(&second).norm() > FLAT * longest
}

/// Returns the enlarged domain, which bounds the planes and lies within a code's simulation box.
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

/// Returns two unit vectors that form a right-handed frame with `normal`, axis-aligned if the normal is.
fn frame(normal: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let helper = if normal.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let second = normal.cross(&helper).normalize();
    (second.cross(normal), second)
}

/// Cuts off every second corner until three remain: unlike in a fan, no corner collects many triangles.
fn triangulate(mut corners: Vec<Vector3<f64>>) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    while corners.len() > 3 {
        let count = corners.len();
        let mut kept = Vec::with_capacity(count / 2 + 1);
        for first in (0..count).step_by(2) {
            kept.push(corners[first]);
            if first + 1 < count {
                let ear = [corners[first], corners[first + 1], corners[(first + 2) % count]];
                // Four corners leave two after both ears: the second ear is the remainder.
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
        // A plane in a face of the box is not cut by that face.
        corners = clip(&corners, |corner| corner[axis] - min[axis] + 1e-9 * half);
        corners = clip(&corners, |corner| max[axis] - corner[axis] + 1e-9 * half);
    }
    Mesh { triangles: triangulate(corners), bend: 0.0 }
}

/// Returns the part of a convex polygon with non-negative `height` (Sutherland-Hodgman).
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

/// Makes the faces of an open box. Side faces have no edge next to an open face: they extend to the limits.
fn open_box(min: [f64; 3], max: [f64; 3], open: &[String], limits: &Domain) -> Mesh {
    let is_open = |axis: usize, sign: &str| open.iter().any(|face| *face == format!("{sign}{}", ["x", "y", "z"][axis]));
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

/// Triangulates the surface that a line sweeps, which is not across the axis.
fn cone([base, axis]: [Vector3<f64>; 2], line: [[f64; 2]; 2], smallest_radius: f64, fineness: Fineness) -> Mesh {
    let [[first, start], [last, end]] = line;
    let (u, v) = frame(&axis);
    let (radius, slant) = (first.max(last), (end - start).hypot(last - first));
    let [fewest, most] = fineness.facets;
    let sagitta = (fineness.sagitta * smallest_radius / radius).clamp(1e-6, 0.5);
    let segments = ((PI / (1.0 - sagitta).acos()).ceil() as usize).clamp(fewest, most);
    let half_angle = PI / segments as f64;
    let width = 2.0 * corner_radius(radius, half_angle, fineness) * half_angle.sin();
    let angle = fineness.sharpest.unwrap_or(3.0 * half_angle);
    let rings = (slant / (width / angle.tan())).ceil().max(1.0) as usize;
    let corner = |segment: usize, ring: usize| {
        let (sine, cosine) = (2.0 * half_angle * (segment % segments) as f64).sin_cos();
        let radius = first + (last - first) * ring as f64 / rings as f64;
        let along = start + (end - start) * ring as f64 / rings as f64;
        base + (u * cosine + v * sine) * corner_radius(radius, half_angle, fineness) + axis * along
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

/// Returns the radius of corners. Corners lie slightly outside, for the correct mean radius of the facets, unless they lie on the shape.
fn corner_radius(radius: f64, half_angle: f64, fineness: Fineness) -> f64 {
    if fineness.ends { radius } else { radius * (1.0 + half_angle * half_angle / 3.0) }
}

/// Triangulates a disc with a hole: two triangles between each two corners of its outlines.
fn ring(radius: f64, hole: f64, circle: impl Fn(f64) -> Vec<Vector3<f64>>) -> Vec<Triangle> {
    let rings = ((radius / hole).ln() / RING_RATIO.ln()).ceil().max(1.0);
    let outline = |ring: f64| circle(if ring == rings { radius } else { hole * (radius / hole).powf(ring / rings) });
    let mut triangles = Vec::new();
    for ring in 0..rings as usize {
        let (inner, outer) = (outline(ring as f64), outline(ring as f64 + 1.0));
        for index in 0..inner.len() {
            let next = (index + 1) % inner.len();
            let (a, b, c, d) = (inner[index], outer[index], outer[next], inner[next]);
            triangles.extend([[a, b, c].map(Into::into), [a, c, d].map(Into::into)]);
        }
    }
    triangles
}

/// Returns the corners of a circle's outline, counter-clockwise about the normal.
fn circle(centre: Vector3<f64>, normal: Vector3<f64>, radius: f64, fineness: Fineness) -> Vec<Vector3<f64>> {
    let (u, v) = frame(&normal);
    let half_angle = PI / fineness.disc_corners as f64;
    let corner_radius = corner_radius(radius, half_angle, fineness);
    let corner = |index: usize| {
        let (sine, cosine) = (2.0 * half_angle * index as f64).sin_cos();
        centre + (u * cosine + v * sine) * corner_radius
    };
    (0..fineness.disc_corners).map(corner).collect()
}

/// Triangulates spheres: icosahedra with triangles divided twice, or less for many spheres.
fn spheres(centres: &[[f64; 3]], radius: f64) -> Vec<Triangle> {
    let fits = |divisions: &u32| centres.len() * 20 * 4_usize.pow(*divisions) <= MOST_TRIANGLES;
    let one = icosphere((0..=2).rev().find(fits).unwrap_or(0));
    let placed = |centre: &[f64; 3]| {
        let centre = Vector3::from(*centre);
        one.iter().map(|corners| corners.map(|corner| (centre + corner * radius).into())).collect::<Vec<_>>()
    };
    centres.iter().flat_map(placed).collect()
}

/// Triangulates a unit sphere.
fn icosphere(divisions: u32) -> Vec<[Vector3<f64>; 3]> {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let corner = |number: usize| {
        let [one, long] = [[1.0, golden], [-1.0, golden], [1.0, -golden], [-1.0, -golden]][number % 4];
        let mut point = Vector3::zeros();
        (point[number / 4], point[(number / 4 + 1) % 3]) = (one, long);
        point.normalize()
    };
    // Three corners form a triangle if all are neighbours.
    let near = |a: usize, b: usize| (corner(a) - corner(b)).norm() < 1.1;
    let triples = (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| [a, b, c])));
    let faces = triples.filter(|[a, b, c]| near(*a, *b) && near(*b, *c) && near(*a, *c));
    let mut triangles: Vec<[Vector3<f64>; 3]> = faces.map(|face| face.map(corner)).collect();
    for _ in 0..divisions {
        let divide = |[a, b, c]: [Vector3<f64>; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(|middle| middle.normalize());
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(divide).collect();
    }
    triangles
}
