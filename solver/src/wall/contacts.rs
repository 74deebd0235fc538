//! Contacts of grains with meshes.
//!
//! The list of candidates has [`MOST_CONTACTS`] slots for each grain near a mesh, consecutive, in place of faces: memory and time do not
//! depend on the number of triangles. An empty slot has the first face of its wall. Each step finds the contacts of a grain
//! ([`Minima`]) in the frame of the wall and writes their faces into the slots. The slot of a contact keeps its impulse, so that friction
//! continues from triangle to triangle.

use super::{Vector, WallFace, Walls, WallsAt};
use crate::surface::{Face, MOST_CONTACTS, MeshFaces, Minima, Minimum, Near};

impl Walls {
    /// Returns true if the wall with this index in the scene is a mesh.
    pub fn is_mesh(&self, wall: u32) -> bool {
        self.walls[wall as usize].seam.is_some()
    }

    /// Returns true if at least one wall is a mesh.
    pub(crate) fn any_mesh(&self) -> bool {
        self.any_mesh
    }

    /// Returns the mesh of a face; `None` for a face of another shape.
    #[inline]
    pub(crate) fn mesh_of(&self, face: u32) -> Option<u32> {
        if !self.any_mesh {
            return None;
        }
        let wall = self.faces[face as usize].wall;
        self.is_mesh(wall).then_some(wall)
    }

    /// Returns the face under which a face is listed: the first face of a mesh, and any other face itself.
    pub(crate) fn listed(&self, face: u32) -> u32 {
        self.mesh_of(face).map_or(face, |wall| self.walls[wall as usize].faces.start)
    }

    /// Returns the number of candidates of a grain near a listed face.
    pub(crate) fn slots_of(&self, face: u32) -> usize {
        if self.mesh_of(face).is_some() { MOST_CONTACTS } else { 1 }
    }
}

impl<'a> WallsAt<'a> {
    /// Returns the walls without poses.
    pub fn walls(&self) -> &'a Walls {
        self.walls
    }

    fn mesh(&self, wall: u32) -> MeshFaces<'a, impl Fn(u32) -> &'a Face> {
        let (walls, wall) = (self.walls, &self.walls.walls[wall as usize]);
        let index = wall.index.as_ref().expect("a mesh has an index");
        let face = move |number: u32| &walls.faces[number as usize].shape;
        MeshFaces { index, face, seam: wall.seam.unwrap_or_default() }
    }

    fn shape(&self, face: u32) -> &'a Face {
        let WallFace { shape, .. } = &self.walls.faces[face as usize];
        shape
    }

    /// Returns true if a face of a wall with an index is nearer to a point (m) than `radius` (m); for other shapes than meshes, also if
    /// one may be nearer.
    pub fn any_near_of(&self, wall: u32, point: &Vector, radius: f64) -> bool {
        let Some(index) = &self.walls.walls[wall as usize].index else { return true };
        if !self.walls.is_mesh(wall) {
            return true;
        }
        let point = self.poses[wall as usize].in_wall(point);
        index.any_near(&point, radius, |face| self.shape(face).is_nearer(&point, radius))
    }

    /// Returns the distance of a point (m) from a mesh, m.
    pub fn distance_of_mesh(&self, wall: u32, point: &Vector) -> f64 {
        let point = self.poses[wall as usize].in_wall(point);
        self.mesh(wall).index.nearest(&point, f64::INFINITY, |face, limit| {
            Some(self.shape(face).distance(&point)).filter(|distance| *distance < limit)
        })
    }

    /// Finds the contacts nearer than `reach` (m) of a grain with this centre (m) with a mesh, in the frame of the wall.
    pub fn minima(&self, wall: u32, centre: &Vector, reach: f64) -> Minima {
        let centre = self.poses[wall as usize].in_wall(centre);
        Minima::find(&self.mesh(wall), &centre, reach)
    }

    /// Finds the contacts of a grain with a mesh in a step (s) from the faces `near` it, and the first face that it reaches on a path longer
    /// than its radius: see [`WallsAt::touches`]. `None` without contacts.
    pub fn mesh_contacts(
        &self,
        wall: u32,
        [centre, velocity]: [&Vector; 2],
        [radius, margin]: [f64; 2],
        step: f64,
        near: &mut Near,
    ) -> Option<Minima> {
        let pose = &self.poses[wall as usize];
        let start = pose.in_wall(centre);
        let found = Minima::find_near(&self.mesh(wall), &start, radius + margin, near);
        let Some(path) = pose.long_path(centre, velocity, step, false, radius) else { return found };
        let path = pose.in_wall(&(centre + path)) - start;
        let mut first: Option<(f64, u32)> = None;
        self.mesh(wall).index.for_each_near(&start, path.norm() + radius, |face| {
            if let Some(impact) = self.shape(face).time_of_impact(&start, &path, radius)
                && first.is_none_or(|first| (impact.share, face) < first)
            {
                first = Some((impact.share, face));
            }
        });
        let Some((_, face)) = first else { return found };
        let (distance, normal) = self.shape(face).nearest(&start, Vector::zeros);
        let mut found = found.unwrap_or_default();
        found.add_swept(face, distance, normal);
        Some(found)
    }

    /// Assigns contacts of a grain with this centre (m) to slots, given the last face of each occupied slot.
    pub fn assign_slots(
        &self,
        wall: u32,
        centre: &Vector,
        minima: &Minima,
        known: &[Option<u32>; MOST_CONTACTS],
    ) -> [Option<Minimum>; MOST_CONTACTS] {
        let centre = self.poses[wall as usize].in_wall(centre);
        minima.assign(known, |face| self.shape(face).nearest(&centre, Vector::zeros).1)
    }
}
