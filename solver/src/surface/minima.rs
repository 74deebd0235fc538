//! Contacts of a sphere with a mesh: the local minima of the distance from its centre to the surface.
//!
//! A sphere near a mesh is near several triangles, and has one contact where the surface is one. For a centre x, triangle A has the nearest
//! point f at the distance D in the direction n. The point is a contact by two rules:
//!
//! ```text
//! minimum  f is inside A, or no triangle B through f has a smaller distance: B is convex, so that f is then no minimum
//! hidden   f lies beyond the tangent plane at an accepted contact g that is nearer: D n . n_g >= D_g
//! ```
//!
//! So coplanar triangles give one contact, convex edges and corners one, a concave corner one for each side, and a duplicate, a second layer
//! or a T-junction none of its own. Neither rule depends on how the corners are connected: a triangle passes through f if it is within
//! the seam of f.
//!
//! A grain has at most [`MOST_CONTACTS`] contacts with one mesh: the nearest, then each time the one whose direction has the smallest
//! cosine with those taken. So they surround the grain.

use super::triangle::{NearestPoint, Triangle};
use super::{Face, FaceIndex, Vector};
use bytemuck::{Pod, Zeroable};

/// Largest number of contacts of a grain with a mesh: six sides of a cell of its own size.
pub(crate) const MOST_CONTACTS: usize = 6;

/// Largest number of minima that are compared; of more, the farther one of the two with the largest cosine is dropped.
const MOST: usize = 16;

/// Smallest relative difference of two distances.
const NEARER: f64 = 1e-12;

/// Contact of a sphere with a mesh, in the frame of the wall.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Minimum {
    /// Number of the face.
    pub face: u32,
    /// Distance from the centre, m.
    pub distance: f64,
    /// Unit vector from the centre to the surface.
    pub normal: Vector,
    /// True if the nearest point is inside the triangle.
    inside: bool,
    /// True if the contact continues that of its slot.
    pub continues: bool,
}

/// Contacts of a sphere with a mesh, in ascending order of distance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Minima {
    list: [Minimum; MOST],
    length: usize,
}

/// Largest number of faces of [`Near`].
const MOST_NEAR: usize = 12;

/// Radius of [`Near`] over that of the search, if few faces are near.
const WIDER: f64 = 1.1;

/// Radius of [`Near`] over that of the search, if no face is near.
const FAR: f64 = 4.0;

/// Relative reduction of distances in single precision.
const ROUNDED: f64 = 1e-6;

/// Largest rounding error of a distance, relative to the radius.
const SLACK: f64 = 1e-9;

/// All faces of a mesh within a radius of a point: while a grain stays close to the point, its contacts are found among them. The contacts
/// are the same as those of a search in the index.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Near {
    /// Point in the frame of the wall, m.
    point: [f64; 3],
    /// Radius, m; zero before the first search.
    radius: f64,
    /// Faces in ascending order of their distances from the point.
    faces: [u32; MOST_NEAR],
    /// Lower bounds of these distances, m.
    distances: [f32; MOST_NEAR],
    count: u32,
    padding: [u32; 3],
}

/// Part of [`Near`] for each contact.
pub(crate) type NearPart = [u32; 6];

impl Near {
    /// Joins the parts.
    pub fn of(parts: [NearPart; MOST_CONTACTS]) -> Near {
        bytemuck::cast(parts)
    }

    /// Returns the parts.
    pub fn parts(self) -> [NearPart; MOST_CONTACTS] {
        bytemuck::cast(self)
    }

    /// Returns true if all faces nearer to a point than `reach` (m) are known.
    fn holds(&self, centre: &Vector, reach: f64) -> bool {
        (centre - Vector::from(self.point)).norm() + reach < self.radius * (1.0 - SLACK)
    }

    /// Searches the faces about a point.
    fn search<'f>(mesh: &MeshFaces<'_, impl Fn(u32) -> &'f Face>, centre: &Vector, reach: f64) -> Near {
        let mut found = [(f64::INFINITY, 0); MOST_NEAR + 1];
        let mut near = Near { point: (*centre).into(), radius: WIDER * reach, ..Near::default() };
        mesh.index.for_each_near(centre, near.radius, |number| {
            if let Some(one) = mesh.triangle(number).nearest_within(centre, near.radius) {
                let one = (one.distance, number);
                let place = found.iter().position(|other| one < *other).unwrap_or(found.len());
                if place < found.len() {
                    found[place..].rotate_right(1);
                    found[place] = one;
                }
            }
        });
        near.radius = near.radius.min(found[MOST_NEAR].0);
        if found[0].0.is_infinite() {
            near.radius = mesh.index.nearest(centre, FAR * reach, |number, limit| {
                mesh.triangle(number).nearest_within(centre, limit).map(|near| near.distance)
            });
        }
        let known = found[..MOST_NEAR].iter().take_while(|(distance, _)| distance.is_finite());
        for (place, (distance, number)) in known.enumerate() {
            near.faces[place] = *number;
            // Rounding to single precision does not exceed the distance.
            near.distances[place] = (distance * (1.0 - ROUNDED)) as f32;
            near.count += 1;
        }
        near
    }
}

/// Faces of a mesh with their index.
pub(crate) struct MeshFaces<'a, F> {
    pub index: &'a FaceIndex,
    /// Returns a face by its number.
    pub face: F,
    /// Width of closed seams, m.
    pub seam: f64,
}

impl<'f, F: Fn(u32) -> &'f Face> MeshFaces<'_, F> {
    #[inline]
    fn triangle(&self, number: u32) -> &'f Triangle {
        match (self.face)(number) {
            Face::Triangle(triangle) => triangle,
            other => unreachable!("a mesh has a face {other:?}"),
        }
    }

    /// Returns true if another face passes through a point at a distance (m) from the centre, and is nearer to the centre.
    #[inline]
    fn descends(&self, centre: &Vector, (foot, distance): (&Vector, f64), other: u32) -> bool {
        let triangle = self.triangle(other);
        triangle.nearest_within(foot, self.seam).is_some()
            && triangle.nearest_within(centre, distance * (1.0 - NEARER)).is_some()
    }
}

impl Minima {
    /// Finds the contacts nearer than `reach` (m) of a sphere with this centre (m), in the frame of the wall.
    pub fn find<'f>(mesh: &MeshFaces<'_, impl Fn(u32) -> &'f Face>, centre: &Vector, reach: f64) -> Minima {
        let mut found = Minima::default();
        mesh.index.for_each_near(centre, reach, |number| {
            let passes = |foot: &Vector, distance| {
                mesh.index.any_near(foot, mesh.seam, |other| mesh.descends(centre, (foot, distance), other))
            };
            found.look_at(number, mesh.triangle(number).nearest_within(centre, reach), centre, passes);
        });
        found.reduced()
    }

    /// Does the work of [`Minima::find`] with the faces near an earlier centre of the same grain, which are updated; `None` if no face is
    /// near.
    pub fn find_near<'f>(
        mesh: &MeshFaces<'_, impl Fn(u32) -> &'f Face>,
        centre: &Vector,
        reach: f64,
        near: &mut Near,
    ) -> Option<Minima> {
        if !near.holds(centre, reach) {
            *near = Near::search(mesh, centre, reach);
            if !near.holds(centre, reach) {
                return Some(Minima::find(mesh, centre, reach));
            }
        }
        if near.count == 0 {
            return None;
        }
        let mut found = Minima::default();
        let within = reach + (centre - Vector::from(near.point)).norm();
        let known = near.distances[..near.count as usize].iter();
        let faces = &near.faces[..known.take_while(|distance| f64::from(**distance) < within).count()];
        for &number in faces {
            let passes =
                |foot: &Vector, distance| faces.iter().any(|&other| mesh.descends(centre, (foot, distance), other));
            found.look_at(number, mesh.triangle(number).nearest_within(centre, reach), centre, passes);
        }
        Some(found.reduced())
    }

    /// Adds the nearest point of a face, if it is a local minimum; `passes` returns true if a nearer face passes through a point at a
    /// distance, m.
    #[inline]
    fn look_at(
        &mut self,
        face: u32,
        near: Option<NearestPoint>,
        centre: &Vector,
        passes: impl Fn(&Vector, f64) -> bool,
    ) {
        if let Some(NearestPoint { distance, normal, inside }) = near
            && (inside || !passes(&(centre + normal * distance), distance))
        {
            self.insert(Minimum { face, distance, normal, inside, continues: false });
        }
    }

    fn reduced(mut self) -> Minima {
        self.drop_hidden();
        self.keep_surrounding();
        self
    }

    /// Returns the contacts.
    pub fn list(&self) -> &[Minimum] {
        &self.list[..self.length]
    }

    /// Inserts a contact in order; of equal distances, points inside a triangle and then lower numbers come first.
    fn insert(&mut self, one: Minimum) {
        if self.length == MOST {
            self.thin_out();
        }
        let key = |one: &Minimum| (one.distance, !one.inside, one.face);
        let place = self.list().iter().position(|other| key(other) > key(&one)).unwrap_or(self.length);
        self.length += 1;
        self.list[place..self.length].rotate_right(1);
        self.list[place] = one;
    }

    /// Removes the farther one of the two contacts with the largest cosine.
    #[cold]
    fn thin_out(&mut self) {
        let mut best = (f64::NEG_INFINITY, self.length - 1);
        for (farther, nearer) in (1..self.length).flat_map(|farther| (0..farther).map(move |nearer| (farther, nearer)))
        {
            let cosine = self.list[farther].normal.dot(&self.list[nearer].normal);
            if cosine > best.0 {
                best = (cosine, farther);
            }
        }
        self.list[best.1..self.length].rotate_left(1);
        self.length -= 1;
    }

    /// Removes contacts behind nearer ones.
    fn drop_hidden(&mut self) {
        let mut kept = 0;
        for place in 0..self.length {
            let one = self.list[place];
            let hides =
                |other: &Minimum| one.distance * one.normal.dot(&other.normal) >= other.distance * (1.0 - NEARER);
            if !self.list[..kept].iter().any(hides) {
                self.list[kept] = one;
                kept += 1;
            }
        }
        self.length = kept;
    }

    /// Reduces the contacts to the largest number.
    fn keep_surrounding(&mut self) {
        for taken in 1..MOST_CONTACTS.min(self.length) {
            if self.length <= MOST_CONTACTS {
                return;
            }
            let closest = |one: &Minimum| {
                self.list[..taken].iter().map(|other| other.normal.dot(&one.normal)).fold(-1.0, f64::max)
            };
            let rest = taken..self.length;
            let next = rest.min_by(|&a, &b| closest(&self.list[a]).total_cmp(&closest(&self.list[b])));
            if let Some(next) = next {
                self.list[taken..=next].rotate_right(1);
            }
        }
        self.length = self.length.min(MOST_CONTACTS);
    }

    /// Adds a face that a grain reaches within the step, unless it is a contact already.
    pub fn add_swept(&mut self, face: u32, distance: f64, normal: Vector) {
        if self.list().iter().all(|one| one.face != face) {
            self.length = MOST_CONTACTS.min(self.length + 1);
            self.list[self.length - 1] = Minimum { face, distance, normal, inside: true, continues: false };
        }
    }

    /// Assigns the contacts to slots; `known` holds the last face of each occupied slot, and `direction` returns the direction towards a
    /// face, in the frame of the wall. A contact takes the slot of its face, or else the slot whose direction is nearest, within the cosine
    /// [`SAME`], the nearest pair first; the others take empty slots.
    pub fn assign(
        &self,
        known: &[Option<u32>; MOST_CONTACTS],
        direction: impl Fn(u32) -> Vector,
    ) -> [Option<Minimum>; MOST_CONTACTS] {
        let mut slots = [None; MOST_CONTACTS];
        let mut left = [false; MOST_CONTACTS];
        left[..self.length].fill(true);
        for (place, one) in self.list().iter().enumerate() {
            if let Some(slot) =
                known.iter().position(|last| *last == Some(one.face)).filter(|&slot| slots[slot].is_none())
            {
                (slots[slot], left[place]) = (Some(Minimum { continues: true, ..*one }), false);
            }
        }
        if !left.contains(&true) {
            return slots;
        }
        let known: [Option<Vector>; MOST_CONTACTS] =
            std::array::from_fn(|slot| known[slot].filter(|_| slots[slot].is_none()).map(&direction));
        loop {
            let mut best: Option<(f64, usize, usize)> = None;
            for (slot, last) in known.iter().enumerate().filter(|(slot, _)| slots[*slot].is_none()) {
                let Some(last) = last else { continue };
                for (place, one) in self.list().iter().enumerate().filter(|(place, _)| left[*place]) {
                    let cosine = last.dot(&one.normal);
                    if cosine > best.map_or(SAME, |best| best.0) {
                        best = Some((cosine, slot, place));
                    }
                }
            }
            let Some((_, slot, place)) = best else { break };
            (slots[slot], left[place]) = (Some(Minimum { continues: true, ..self.list[place] }), false);
        }
        for (one, _) in self.list().iter().zip(left).filter(|(_, left)| *left) {
            let empty = (0..known.len()).filter(|&slot| slots[slot].is_none());
            // An occupied slot without a successor is free, too, but only if no other is.
            if let Some(slot) = empty.min_by_key(|&slot| (known[slot].is_some(), slot)) {
                slots[slot] = Some(*one);
            }
        }
        slots
    }
}

/// Smallest cosine of the directions of a contact in two successive steps.
const SAME: f64 = 0.7;
