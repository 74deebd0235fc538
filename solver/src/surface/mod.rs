//! Surfaces of walls: the only module with the geometry of each shape.
//!
//! ```text
//! mod.rs       Shape         shape of a wall in a scene; its faces, bounds and depth of a grain
//! face.rs      Face          smooth surface: nearest point, time of impact, displacement
//! triangle.rs  Triangle      face of a mesh
//! frustum.rs   Frustum       face of a cone
//! mesh.rs      TriangleMesh  triangles of a file, welded
//! files.rs                   readers of STL and OBJ
//! index.rs     FaceIndex     search for faces near a point
//! minima.rs    Minima        contacts of a sphere with a mesh: local minima of the distance
//! ```
//!
//! A new shape is a file here, a variant of [`Shape`] with its faces and its triangles or [`Revolution`], and its checks (`scene/check.rs`).

mod face;
mod files;
mod frustum;
mod index;
mod mesh;
mod minima;
mod triangle;

pub(crate) use face::{Face, Impact, Rotation};
pub(crate) use index::FaceIndex;
pub use mesh::{MeshRotation, TriangleMesh};
pub(crate) use minima::{MOST_CONTACTS, MeshFaces, Minima, Minimum, Near, NearPart};

use crate::laws::period::Period;
use frustum::Frustum;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

type Vector = Vector3<f64>;

/// Names of the faces of a box.
pub(crate) const FACES: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];

fn one() -> f64 {
    1.0
}

fn is_one(value: &f64) -> bool {
    *value == 1.0
}

/// Surface that a straight line sweeps around an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolution {
    /// Point of the axis, m.
    pub base: [f64; 3],
    /// Direction of the axis, of unit length.
    pub axis: [f64; 3],
    /// Ends of the line: distance from the axis, and position along it from the base, m.
    pub line: [[f64; 2]; 2],
}

impl Revolution {
    /// Returns the centre of the circle of an end, m.
    fn centre(&self, [_, along]: [f64; 2]) -> Vector {
        Vector::from(self.base) + Vector::from(self.axis) * along
    }
}

/// Surface of a wall. Planes and boxes have grains on one side, spheres outside; all other shapes are thin, with grains on both sides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// Infinite plane; grains are on the side of the normal.
    Plane {
        /// A point of the plane, metres.
        point: [f64; 3],
        /// Normal towards the grains; need not be of unit length.
        normal: [f64; 3],
    },
    /// Box seen from inside, without the open faces; each face is a plane without an edge.
    Box {
        /// Lower corner, metres.
        min: [f64; 3],
        /// Upper corner, metres.
        max: [f64; 3],
        /// Open faces: any of "-x", "+x", "-y", "+y", "-z", "+z".
        #[serde(default)]
        open: Vec<String>,
    },
    /// Thin cylindrical shell without ends.
    Cylinder {
        /// Centre of the first end, metres.
        base: [f64; 3],
        /// Direction of the axis; need not be of unit length.
        axis: [f64; 3],
        /// Inner radius, metres.
        radius: f64,
        /// Length along the axis, metres.
        length: f64,
    },
    /// Thin conical shell without ends, such as a funnel.
    Frustum {
        /// Centre of the first end, metres.
        base: [f64; 3],
        /// Direction of the axis; need not be of unit length.
        axis: [f64; 3],
        /// Radii of the first and of the second end, metres; one may be zero, for a tip.
        radii: [f64; 2],
        /// Length along the axis, metres.
        length: f64,
    },
    /// Thin rectangle or parallelogram.
    Rectangle {
        /// Corner, metres.
        corner: [f64; 3],
        /// The two sides from the corner, metres.
        edges: [[f64; 3]; 2],
    },
    /// Spheres of one size, seen from outside: a rough bed, or obstacles.
    Spheres {
        /// Centres, metres.
        centres: Vec<[f64; 3]>,
        /// Radius, metres.
        radius: f64,
    },
    /// Thin flat disc, such as a drum's end cap; with a hole, a ring, such as the floor of a silo.
    Disc {
        /// Centre, metres.
        centre: [f64; 3],
        /// Normal; need not be of unit length. Observables take its side for that of the grains.
        normal: [f64; 3],
        /// Radius, metres.
        radius: f64,
        /// Radius of the round hole in its middle, metres; none, if zero.
        #[serde(default, skip_serializing_if = "crate::is_default")]
        hole: f64,
    },
    /// Triangles of a file of a CAD program: STL (text or binary) or OBJ; thin, with grains on both sides.
    Mesh {
        /// File, relative to the folder of the scene's file.
        file: String,
        /// Metres per unit of length of the file: 0.001 for a file in millimetres.
        #[serde(default = "one", skip_serializing_if = "is_one")]
        scale: f64,
        /// Rotation about the origin, after scaling.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rotate: Option<MeshRotation>,
        /// Translation after scaling and rotation, metres.
        #[serde(default, skip_serializing_if = "crate::is_default")]
        translate: [f64; 3],
        /// Triangles of the file, encoded. Scenes that Makadam writes have this key, so that they are complete without the file.
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "String"))]
        content: TriangleMesh,
    },
}

impl Shape {
    /// Returns the name of the kind of shape in scenes.
    pub fn kind(&self) -> &'static str {
        match self {
            Shape::Plane { .. } => "plane",
            Shape::Box { .. } => "box",
            Shape::Cylinder { .. } => "cylinder",
            Shape::Frustum { .. } => "frustum",
            Shape::Rectangle { .. } => "rectangle",
            Shape::Spheres { .. } => "spheres",
            Shape::Disc { .. } => "disc",
            Shape::Mesh { .. } => "mesh",
        }
    }

    /// Creates a wall of the triangles of a mesh, in metres, under a name.
    pub fn mesh(name: impl Into<String>, mesh: TriangleMesh) -> Shape {
        Shape::Mesh { file: name.into(), scale: 1.0, rotate: None, translate: [0.0; 3], content: mesh }
    }

    /// Returns the triangles (m) of a mesh or a rectangle; `None` for other shapes.
    pub fn triangles(&self) -> Option<Vec<[[f64; 3]; 3]>> {
        if let Shape::Rectangle { corner, edges: [one, other] } = self {
            let at = |x: f64, y: f64| std::array::from_fn(|axis| corner[axis] + x * one[axis] + y * other[axis]);
            return Some(vec![[*corner, at(1.0, 0.0), at(1.0, 1.0)], [*corner, at(1.0, 1.0), at(0.0, 1.0)]]);
        }
        let Shape::Mesh { scale, rotate, translate, content, .. } = self else { return None };
        let turn =
            |rotate: &MeshRotation| Rotation::new(Vector::from(rotate.axis).normalize(), rotate.angle.to_radians());
        let rotation = rotate.as_ref().map(turn);
        let place = |point: [f64; 3]| {
            let point = Vector::from(point) * *scale;
            let point = rotation.map_or(point, |rotation| rotation.turn(point));
            <[f64; 3]>::from(point + Vector::from(*translate))
        };
        Some(content.corners().map(|corners| corners.map(place)).collect())
    }

    /// Returns a cylinder, a frustum or a disc as a surface of revolution; `None` for other shapes.
    pub fn revolution(&self) -> Option<Revolution> {
        let (base, axis, line) = match self {
            Shape::Cylinder { base, axis, radius, length } => (base, axis, [[*radius, 0.0], [*radius, *length]]),
            Shape::Frustum { base, axis, radii, length } => (base, axis, [[radii[0], 0.0], [radii[1], *length]]),
            Shape::Disc { centre, normal, radius, hole } => (centre, normal, [[*hole, 0.0], [*radius, 0.0]]),
            _ => return None,
        };
        Some(Revolution { base: *base, axis: Vector::from(*axis).normalize().into(), line })
    }

    /// Returns the faces of the shape in a space of this period: along a periodic axis, faces repeat or have no end.
    pub(crate) fn faces(&self, period: Period) -> Vec<Face> {
        match self {
            Shape::Plane { point, normal } => {
                vec![Face::Plane { point: Vector::from(*point), normal: Vector::from(*normal).normalize() }]
            }
            Shape::Disc { centre, normal, radius, hole } => {
                let (centre, normal) = (Vector::from(*centre), Vector::from(*normal).normalize());
                if *hole <= 0.0 {
                    return vec![Face::Disc { centre, normal, radius: *radius }];
                }
                let ring = Face::Ring { centre, normal, radius: *radius, hole: *hole };
                std::iter::once(ring).chain(Face::rim(centre, normal, *hole)).collect()
            }
            Shape::Frustum { base, axis, radii, length } => {
                let (base, axis) = (Vector::from(*base), Vector::from(*axis).normalize());
                let lines = [0.0].into_iter().chain(face::THIRD_OF_A_TURN);
                lines.map(|sine| Face::Frustum(Frustum { base, axis, radii: *radii, length: *length, sine })).collect()
            }
            Shape::Cylinder { base, axis, radius, length } => {
                let (base, normal) = (Vector::from(*base), Vector::from(*axis).normalize());
                let shell = |ends| Face::Shell { base, axis: normal, radius: *radius, ends };
                if (0..3).any(|along| period.is_periodic(along) && axis[along] != 0.0) {
                    return vec![shell([f64::NEG_INFINITY, f64::INFINITY])];
                }
                let rims = [0.0, *length].into_iter().flat_map(|end| Face::rim(base + normal * end, normal, *radius));
                std::iter::once(shell([0.0, *length])).chain(rims).collect()
            }
            Shape::Spheres { centres, radius } => (centres.iter())
                .map(|centre| Face::Ball { centre: Vector::from(*centre), radius: *radius, period })
                .collect(),
            Shape::Box { min, max, open } => {
                let (min, max) = (Vector::from(*min), Vector::from(*max));
                (FACES.iter().enumerate())
                    .filter(|(_, name)| !open.iter().any(|face| face == *name))
                    .map(|(number, _)| {
                        let inward = Vector::ith(number / 2, if number % 2 == 0 { 1.0 } else { -1.0 });
                        Face::Plane { point: if number % 2 == 0 { min } else { max }, normal: inward }
                    })
                    .collect()
            }
            Shape::Rectangle { .. } | Shape::Mesh { .. } => {
                self.triangles().into_iter().flatten().map(Face::triangle).collect()
            }
        }
    }

    /// Returns the width (m) of seams between triangles that count as closed; `None` for shapes whose contacts are not those of triangles.
    pub(crate) fn seam(&self) -> Option<f64> {
        match self {
            Shape::Mesh { scale, content, .. } => Some(content.seam() * scale),
            Shape::Rectangle { .. } => Some(TriangleMesh::new(&self.triangles()?).ok()?.seam()),
            _ => None,
        }
    }

    /// Returns the corners (m) of boxes around the parts of the shape; none for an infinite shape.
    pub fn bounds(&self) -> Vec<([f64; 3], [f64; 3])> {
        match self {
            Shape::Plane { .. } => Vec::new(),
            Shape::Box { min, max, .. } => vec![(*min, *max)],
            Shape::Spheres { centres, radius } => centres.iter().map(|centre| around(centre, &[*radius; 3])).collect(),
            _ => {
                let revolution = self.revolution().into_iter().flat_map(|one| one.line.map(|line| (one, line)));
                let circles = revolution.map(|(one, line)| {
                    around(&one.centre(line).into(), &one.axis.map(|x| line[0] * (1.0 - x * x).max(0.0).sqrt()))
                });
                let corners = self.triangles().into_iter().flatten().flatten().map(|corner| (corner, corner));
                let join = |(low, high): ([f64; 3], [f64; 3]), (min, max): ([f64; 3], [f64; 3])| {
                    (std::array::from_fn(|i| low[i].min(min[i])), std::array::from_fn(|i| high[i].max(max[i])))
                };
                circles.chain(corners).reduce(join).into_iter().collect()
            }
        }
    }

    /// Returns an upper bound of the distance (m) of the points of the shape from an axis, given the distance of one point.
    pub fn furthest(&self, arm: impl Fn(Vector) -> f64) -> f64 {
        match self {
            Shape::Plane { .. } => f64::INFINITY,
            Shape::Box { min, max, .. } => furthest_corner(min, max, arm),
            Shape::Spheres { centres, radius } => {
                centres.iter().map(|centre| arm(Vector::from(*centre))).fold(0.0, f64::max) + radius
            }
            _ => {
                let revolution = self.revolution().into_iter();
                let circles = revolution.flat_map(|one| one.line.map(|line| arm(one.centre(line)) + line[0]));
                let corners = self.triangles().into_iter().flatten().flatten();
                corners.map(|corner| arm(Vector::from(corner))).chain(circles).fold(0.0, f64::max)
            }
        }
    }
}

/// Returns the largest distance (m) of the corners of a box from an axis, given the distance of one point.
pub(crate) fn furthest_corner(min: &[f64; 3], max: &[f64; 3], arm: impl Fn(Vector) -> f64) -> f64 {
    let corner = |number: usize| Vector::from_fn(|axis, _| if number >> axis & 1 == 0 { min[axis] } else { max[axis] });
    (0..8).map(corner).map(arm).fold(0.0, f64::max)
}

/// Faces of a shape with their index, for the distances of many points.
pub(crate) struct Surface {
    faces: Vec<Face>,
    index: Option<FaceIndex>,
}

impl Surface {
    /// Creates the faces of a shape in a space of this period.
    pub fn of(shape: &Shape, period: Period) -> Surface {
        let faces = shape.faces(period);
        let index = FaceIndex::new(&faces, 0, period);
        Surface { faces, index }
    }

    /// Returns the depth (m) of a sphere in or behind the surface; negative infinity if the two are apart.
    pub fn depth(&self, centre: &Vector, radius: f64) -> f64 {
        let mut deepest = f64::NEG_INFINITY;
        let mut visit = |face: &Face| deepest = f64::max(deepest, radius - face.distance(centre));
        match &self.index {
            Some(index) => index.for_each_near(centre, radius, |face| visit(&self.faces[face as usize])),
            None => self.faces.iter().for_each(visit),
        }
        if deepest < 0.0 { f64::NEG_INFINITY } else { deepest }
    }
}

/// Returns the corners (m) of a box around a point.
pub(crate) fn around(centre: &[f64; 3], side: &[f64; 3]) -> ([f64; 3], [f64; 3]) {
    (std::array::from_fn(|i| centre[i] - side[i]), std::array::from_fn(|i| centre[i] + side[i]))
}
