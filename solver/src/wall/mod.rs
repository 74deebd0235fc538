//! Walls: shape x motion x index.
//!
//! ```text
//! shape.rs    Face       where the surface lies, as the scene places it: nearest point, time of impact
//! motion.rs   Pose       where the wall stands at a time, and its velocity field: one a wall and step
//! steered.rs  WallMotion how the caller moves a wall, in place of what the scene says
//! index.rs    FaceIndex  which faces may be near a point: built once, in the wall's own frame
//! mod.rs      Walls      all walls of a scene; their faces are numbered through, wall after wall
//! ```
//!
//! Nobody goes through all faces at every step. Poses are worked out wall by wall, and a face is put where it stands when a grain asks for
//! it ([`PlacedFace`]), which costs a sum or a rotation. Whoever looks for faces near a point asks `WallsAt::for_each_near`, or of one wall
//! `WallsAt::for_each_near_of`: walls of many faces answer from their index. What they find comes out as if all faces had been asked in
//! the order of their numbers: whoever visits them puts what counts in that order, or takes the least.
//!
//! What is not here: friction and the rest of the contact, which are the materials' and the solve's; forces on driven walls
//! ([`drive`](crate::effects::drive)).

mod index;
mod motion;
mod shape;
mod steered;

pub(crate) use motion::drive_of;
pub use motion::{DrivenWall, Pose};
pub(crate) use shape::Impact;
pub(crate) use steered::Steered;
pub use steered::WallMotion;

use crate::scene::{self, Domain};
use index::FaceIndex;
use motion::{Movement, keeps_in_place};
use nalgebra::Vector3;
use shape::Face;
use std::ops::Range;

type Vector = Vector3<f64>;

/// Share of its radius up to which a grain that moves no farther in a step, and is no nearer to a face, cannot cross it.
pub(crate) const SHORT_WAY: f64 = 0.5;

/// All walls of a scene, as they are placed, and how they move.
#[derive(Clone, Debug)]
pub struct Walls {
    walls: Vec<Wall>,
    faces: Vec<WallFace>,
}

#[derive(Clone, Debug)]
struct Wall {
    /// Numbers of its faces.
    faces: Range<u32>,
    movement: Movement,
    index: Option<FaceIndex>,
}

#[derive(Clone, Copy, Debug)]
struct WallFace {
    shape: Face,
    /// Number of the wall in the scene.
    wall: u32,
    /// Number of the wall's material.
    material: u8,
    /// True if the wall's motion maps it onto itself, so that only velocities change.
    in_place: bool,
}

/// Walls and where they stand, a pose for each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallsAt<'a> {
    walls: &'a Walls,
    poses: &'a [Pose],
}

/// A face where it stands, with its velocity field.
#[derive(Clone, Copy, Debug)]
pub struct PlacedFace<'a> {
    /// As the scene places it.
    placed: &'a Face,
    /// Pose, if it differs from the scene's: most walls are at rest, and their faces are not copied.
    moved: Option<Face>,
    pose: &'a Pose,
    in_place: bool,
}

impl Walls {
    /// The walls that a scene lists, in its domain; `material` gives the number of a material's name.
    pub fn new(walls: &[scene::Wall], domain: &Domain, material: impl Fn(&str) -> u8) -> Walls {
        let mut faces: Vec<WallFace> = Vec::new();
        let place = |(number, wall): (u32, &scene::Wall)| {
            let (shapes, first) = (Face::of_shape(&wall.shape, domain), faces.len() as u32);
            let (material, in_place) = (material(&wall.material), |face: &Face| keeps_in_place(face, &wall.motion));
            let face = |shape: &Face| WallFace { shape: *shape, wall: number, material, in_place: in_place(shape) };
            faces.extend(shapes.iter().map(face));
            Wall {
                faces: first..faces.len() as u32,
                movement: Movement::new(&wall.motion, &shapes),
                index: FaceIndex::new(&shapes, first, domain.period()),
            }
        };
        let walls = (0..).zip(walls).map(place).collect();
        Walls { walls, faces }
    }

    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.faces.len()
    }

    /// Number in the scene of the wall that a face belongs to.
    #[inline]
    pub fn wall_of(&self, face: u32) -> u32 {
        self.faces[face as usize].wall
    }

    /// Number of the material of a face.
    #[inline]
    pub fn material_of(&self, face: u32) -> u8 {
        self.faces[face as usize].material
    }

    /// Returns true if any of them ever moves.
    pub fn any_moves(&self) -> bool {
        self.walls.iter().any(|wall| wall.movement.moves())
    }

    /// Numbers of the walls that ever move.
    pub(crate) fn moving(&self) -> impl Iterator<Item = u32> + '_ {
        let moves = |wall: &Wall| wall.movement.moves() && !wall.faces.is_empty();
        (0..).zip(&self.walls).filter(move |(_, wall)| moves(wall)).map(|(number, _)| number)
    }

    /// Puts a wall where a drive has moved it, m or rad, at this rate, m/s or rad/s. One that nothing drives takes no notice.
    pub fn put(&mut self, wall: u32, displacement: f64, rate: f64) {
        self.walls[wall as usize].movement.put(displacement, rate);
    }

    /// Steers a wall from the next step on; `times` are now and when the candidate list was built, s.
    ///
    /// # Errors
    /// Why it cannot be moved so, in words that follow its name.
    pub(crate) fn steer(&mut self, wall: u32, motion: &WallMotion, times: [f64; 2]) -> Result<(), String> {
        self.with_faces(wall, |movement, faces| movement.steer(motion, faces, times))
    }

    /// Has a wall steered as it was at some time.
    pub(crate) fn restore(&mut self, wall: u32, steered: Steered) {
        self.with_faces(wall, |movement, faces| movement.restore(steered, faces));
    }

    /// Changes how a wall moves, and with it which of its faces that maps onto themselves.
    fn with_faces<R>(&mut self, wall: u32, change: impl FnOnce(&mut Movement, &[Face]) -> R) -> R {
        let Wall { faces, movement, .. } = &mut self.walls[wall as usize];
        let own = &mut self.faces[faces.start as usize..faces.end as usize];
        let shapes: Vec<Face> = own.iter().map(|face| face.shape).collect();
        let result = change(movement, &shapes);
        if let Some(steered) = &movement.steered {
            own.iter_mut().for_each(|face| face.in_place = steered.keeps_in_place(&face.shape));
        }
        result
    }

    /// Walls that are steered, each with its state.
    pub(crate) fn steered(&self) -> impl Iterator<Item = (u32, &Steered)> {
        (0..).zip(&self.walls).filter_map(|(number, wall)| Some((number, wall.movement.steered.as_ref()?)))
    }

    /// Displacement of a wall along (m) and its angle (rad) at a time (s), from where the scene places it.
    pub(crate) fn displacement(&self, wall: u32, time: f64) -> ([f64; 3], f64) {
        self.walls[wall as usize].movement.place(time)
    }

    /// Moves walls that are steered for a step of length `h`, s.
    pub(crate) fn advance_steered(&mut self, h: f64) {
        self.walls.iter_mut().filter_map(|wall| wall.movement.steered.as_mut()).for_each(|steered| steered.advance(h));
    }

    /// Keeps in mind where drives have walls while the candidate list is built.
    pub(crate) fn enter_list(&mut self) {
        self.walls.iter_mut().for_each(|wall| wall.movement.enter_list());
    }

    /// Displacement of a driven wall then, m or rad.
    pub(crate) fn displacement_in_list(&self, wall: u32) -> f64 {
        self.walls[wall as usize].movement.displacement_in_list()
    }

    /// Upper bound of how far a point of a wall within `radius` (m) of its motion's centre moves between two times (s), m; of driven
    /// ones since they entered the list.
    pub(crate) fn largest_shift(&self, from: f64, to: f64, radius: f64) -> f64 {
        let walls = self.walls.iter().filter(|wall| !wall.faces.is_empty());
        walls.map(|wall| wall.movement.largest_shift(from, to, radius)).fold(0.0, f64::max)
    }

    /// Poses of the walls at a time (s), with their velocities there; driven ones as they were last put.
    pub fn poses(&self, time: f64) -> impl Iterator<Item = Pose> + '_ {
        self.walls.iter().map(move |wall| wall.movement.at(time))
    }

    /// Poses of the walls at the start of a step of length `step` (s), with the velocities that count in it: where a wall vibrates, the mean one.
    pub(crate) fn poses_over(&self, time: f64, step: f64) -> impl Iterator<Item = Pose> + '_ {
        self.walls.iter().map(move |wall| wall.movement.over(time, step))
    }

    /// The pose of one wall as by [`Walls::poses_over`].
    pub(crate) fn pose_over(&self, wall: u32, time: f64, step: f64) -> Pose {
        self.walls[wall as usize].movement.over(time, step)
    }

    /// A wall at the start of a step of length `step` (s), with the velocity that takes it to where it is at the end; a driven one
    /// moves at `rate` (m/s or rad/s).
    pub(crate) fn pose_through(&self, wall: u32, time: f64, step: f64, rate: f64) -> Pose {
        self.walls[wall as usize].movement.through(time, step, rate)
    }

    /// The walls where these poses have them.
    pub(crate) fn placed<'a>(&'a self, poses: &'a [Pose]) -> WallsAt<'a> {
        WallsAt { walls: self, poses }
    }

    /// Number of walls.
    pub(crate) fn count(&self) -> usize {
        self.walls.len()
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        let indices = self.walls.iter().filter_map(|wall| wall.index.as_ref());
        self.walls.capacity() * size_of::<Wall>()
            + self.faces.capacity() * size_of::<WallFace>()
            + indices.map(FaceIndex::memory_bytes).sum::<usize>()
    }
}

impl<'a> WallsAt<'a> {
    /// A face where it stands.
    #[inline]
    pub fn face(&self, number: u32) -> PlacedFace<'a> {
        let WallFace { shape, wall, in_place, .. } = &self.walls.faces[number as usize];
        let pose = &self.poses[*wall as usize];
        PlacedFace { placed: shape, moved: pose.moved(shape, *in_place), pose, in_place: *in_place }
    }

    /// Asks a face where it stands, and its wall; a face at rest is not copied.
    #[inline(always)]
    fn ask<R>(&self, number: u32, question: impl FnOnce(&Face, &Pose, bool) -> R) -> R {
        let WallFace { shape, wall, in_place, .. } = &self.walls.faces[number as usize];
        let pose = &self.poses[*wall as usize];
        match pose.moved(shape, *in_place) {
            None => question(shape, pose, *in_place),
            Some(moved) => question(&moved, pose, *in_place),
        }
    }

    /// As [`PlacedFace::distance`], of the face of a number.
    #[inline]
    pub fn distance(&self, number: u32, point: &Vector) -> f64 {
        self.ask(number, |face, _, _| face.distance(point))
    }

    /// Returns true if a grain has a contact in a step (s) with the face of a number, given its centre (m) and its velocity (m/s), its radius
    /// and the gap up to which contacts count (m); and the distance from its centre to the face (m). A swept contact is one, too: that of
    /// a grain which moves by more than its radius against the wall, and would otherwise be deep behind the face, or on the other side
    /// of a shell, before the two are seen to touch.
    #[inline(always)]
    pub fn touches(
        &self,
        number: u32,
        [centre, velocity]: [&Vector; 2],
        [radius, margin]: [f64; 2],
        step: f64,
    ) -> (bool, f64) {
        self.ask(number, |face, pose, in_place| {
            let distance = face.distance(centre);
            let is_swept = || {
                let path = pose.long_path(centre, velocity, step, in_place, radius);
                path.is_some_and(|path| face.time_of_impact(centre, &path, radius).is_some())
            };
            (distance < radius + margin || is_swept(), distance)
        })
    }

    /// Contact of a grain with a face in a step.
    ///
    /// Input: number of the face; centre (m) and velocity (m/s) of the grain at the start; its radius (m); the step (s); the change of
    /// velocity by gravity (m/s). Output: distance from the centre to the face (m), or to its tangent plane at the impact of a grain
    /// too fast for the step; unit normal towards the face; true for a swept contact; velocity of the wall there, its change without a
    /// jump, and its part from the drift of a turning wall, m/s.
    #[inline]
    pub fn contact(
        &self,
        number: u32,
        [centre, velocity]: [&Vector; 2],
        radius: f64,
        step: f64,
        falling: &Vector,
    ) -> (f64, Vector, bool, [Vector; 3]) {
        self.ask(number, |face, pose, in_place| {
            let path = pose.long_path(centre, velocity, step, in_place, radius);
            let impact = path.and_then(|path| face.time_of_impact(centre, &path, radius));
            let (distance, normal) = match &impact {
                Some(impact) => (impact.distance, impact.normal),
                None => face.nearest(centre, || velocity + falling - pose.velocity_at(centre, in_place)),
            };
            let (mean, gain) = (pose.velocity_at(&(centre + normal * distance), in_place), pose.gain());
            let velocities = match pose.drifts() {
                true => {
                    let drift = pose.drift(centre, &normal, in_place);
                    [mean + drift, gain + drift * 2.0, drift]
                }
                false => [mean, gain, Vector::zeros()],
            };
            (distance, normal, impact.is_some(), velocities)
        })
    }

    /// The pose of each wall, with the numbers of its faces.
    pub fn each_wall(&self) -> impl Iterator<Item = (u32, &'a Pose, Range<u32>)> + use<'a> {
        let walls = (0..).zip(&self.walls.walls).zip(self.poses);
        walls.map(|((number, wall), pose)| (number, pose, wall.faces.clone()))
    }

    /// Returns true if the faces of a wall are found by an index: they then come in no order, and perhaps more than once.
    pub fn has_index(&self, wall: u32) -> bool {
        self.walls.walls[wall as usize].index.is_some()
    }

    /// Visits every face of a wall that may be nearer to a point (m) than `radius` (m), and others.
    pub fn for_each_near_of(
        &self,
        wall: u32,
        point: &Vector,
        radius: f64,
        mut visit: impl FnMut(u32, &PlacedFace<'a>),
    ) {
        let Wall { faces, index, .. } = &self.walls.walls[wall as usize];
        let mut visit = |face: u32| visit(face, &self.face(face));
        match index {
            Some(index) => index.for_each_near(&self.poses[wall as usize].in_wall(point), radius, visit),
            None => faces.clone().for_each(&mut visit),
        }
    }

    /// Visits the faces of all walls, given the radius for a wall with a pose.
    pub fn for_each_near(
        &self,
        point: &Vector,
        radius: impl Fn(&Pose) -> f64,
        mut visit: impl FnMut(u32, &PlacedFace<'a>),
    ) {
        for (wall, pose, _) in self.each_wall() {
            self.for_each_near_of(wall, point, radius(pose), &mut visit);
        }
    }
}

impl PlacedFace<'_> {
    #[inline(always)]
    fn shape(&self) -> &Face {
        self.moved.as_ref().unwrap_or(self.placed)
    }

    /// Distance from a point to the face (m), negative behind a plane: see [`PlacedFace::nearest`].
    #[inline]
    pub fn distance(&self, point: &Vector) -> f64 {
        self.shape().distance(point)
    }

    /// Distance from a grain's centre to the face (m), and the unit normal from the centre to the nearest point. Where a whole circle or
    /// sphere of points is nearest, as to the axis of a tube, it is the one in the grain's direction of `travel`, a vector of any length.
    ///
    /// Behind a plane the distance is negative, so that the grain is pushed back. Discs, with a hole or without, and shells are thin: they
    /// have two sides, and rims that grains roll over.
    #[inline]
    pub fn nearest(&self, centre: &Vector, travel: impl FnOnce() -> Vector) -> (f64, Vector) {
        self.shape().nearest(centre, travel)
    }

    /// Returns true if a grain comes to a swept contact with the face: see [`WallsAt::touches`].
    pub(crate) fn is_swept(&self, centre: &Vector, radius: f64, velocity: &Vector, step: f64) -> bool {
        let path = self.path(centre, velocity, step);
        path.norm_squared() > radius * radius && self.shape().time_of_impact(centre, &path, radius).is_some()
    }

    /// The path of a point that moves at `velocity` (m/s) for a step (s), as seen from the face, m.
    pub(crate) fn path(&self, from: &Vector, velocity: &Vector, step: f64) -> Vector {
        self.pose.path(from, velocity, step, self.in_place)
    }

    /// First point where a path from a point comes within `level` (m) of the face, having begun farther away.
    pub(crate) fn time_of_impact(&self, from: &Vector, path: &Vector, level: f64) -> Option<Impact> {
        self.shape().time_of_impact(from, path, level)
    }

    /// The velocity that takes a point where the wall takes it within a step (s), m/s.
    pub(crate) fn carries(&self, point: &Vector, step: f64) -> Vector {
        self.pose.carries(point, step, self.in_place)
    }

    /// Largest speed of a point of the face within `radius` (m) of another (m), as far as the face moves, m/s.
    pub(crate) fn largest_speed(&self, around: &Vector, radius: f64) -> f64 {
        self.pose.largest_speed_of(around, radius, self.in_place)
    }

    /// Velocity of the wall at a point, m/s; in a step that of the step, without the drift of a wall that turns.
    #[inline]
    pub fn velocity_at(&self, point: &Vector) -> Vector {
        self.pose.velocity_at(point, self.in_place)
    }

    /// Gain of the wall's velocity since the step before without a jump, m/s, besides what comes of drifts: no approach of what
    /// rests on it.
    pub(crate) fn gain(&self) -> Vector {
        self.pose.gain()
    }

    /// Angular velocity of the wall, rad/s.
    pub fn spin(&self) -> Vector {
        self.pose.spin(self.in_place)
    }
}

/// Returns true if a wall would jump, or a vibration change its phase, where a scene is simulated for a time (s) and its clock then goes back to
/// zero: its prescribed motion begins before, and does not lead back to the same surface. What a drive has moved stays where it is.
pub fn jumps_back(wall: &scene::Wall, domain: &Domain, time: f64) -> bool {
    let faces = Face::of_shape(&wall.shape, domain);
    let extent = (Vector::from(domain.max) - Vector::from(domain.min)).norm();
    Movement::new(&wall.motion, &faces).jumps_back(time, &faces, extent)
}

/// The walls of a scene where they stand at a time.
///
/// ```
/// use makadam::{Domain, Face, Shape, Wall, wall::PlacedWalls};
///
/// let domain = Domain { min: [-1.0; 3], max: [1.0; 3], periodic: Vec::new() };
/// let walls = [Wall::new("box", "glass", Shape::cuboid([0.0; 3], [0.1; 3], &[Face::Top]))];
/// let placed = PlacedWalls::at(&walls, &domain, 0.0, &[]);
/// assert!((placed.distance(&[0.05, 0.05, 0.02].into()) - 0.02).abs() < 1e-12);
/// assert!(placed.distance(&[0.05, 0.05, -0.02].into()) < 0.0, "behind the floor");
/// ```
#[derive(Clone, Debug)]
pub struct PlacedWalls {
    walls: Walls,
    poses: Vec<Pose>,
}

impl PlacedWalls {
    /// The walls at a time (s), in a domain; those that a force or a torque drives where `driven` says, and where the scene places them if
    /// it says nothing.
    pub fn at(walls: &[scene::Wall], domain: &Domain, time: f64, driven: &[DrivenWall]) -> PlacedWalls {
        let mut placed = Walls::new(walls, domain, |_| 0);
        for one in driven.iter().filter(|one| (one.wall as usize) < walls.len()) {
            placed.put(one.wall, one.displacement, one.rate);
        }
        let poses = placed.poses(time).collect();
        PlacedWalls { walls: placed, poses }
    }

    /// Faces, wall after wall, each with its wall's number in the scene.
    pub fn faces(&self) -> impl Iterator<Item = (usize, PlacedFace<'_>)> {
        let placed = self.walls.placed(&self.poses);
        (0..self.walls.faces() as u32).map(move |face| (self.walls.wall_of(face) as usize, placed.face(face)))
    }

    /// Distance of a point from the nearest wall, m; infinite where there is no wall.
    ///
    /// It is negative behind a plane or a box's face. Thin shells and discs have no behind.
    pub fn distance(&self, point: &Vector) -> f64 {
        self.distances(point).fold(f64::INFINITY, f64::min)
    }

    /// Number of faces nearer to a point than `radius` (m).
    pub fn within(&self, point: &Vector, radius: f64) -> usize {
        self.distances(point).filter(|&distance| distance < radius).count()
    }

    /// Distances of a point from all faces, m.
    fn distances(&self, point: &Vector) -> impl Iterator<Item = f64> {
        let placed = self.walls.placed(&self.poses);
        (0..self.walls.faces() as u32).map(move |face| placed.distance(face, point))
    }

    /// Position of a point (m) of a wall that the scene places.
    pub fn point_of(&self, wall: usize, point: &Vector) -> Vector {
        self.poses[wall].in_world(point)
    }
}
