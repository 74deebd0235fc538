//! Walls: shape x motion x index. Shapes are in [`surface`](crate::surface).
//!
//! ```text
//! motion.rs   Pose       position of the wall at a time, and its velocity field: one per wall and step
//! composed.rs            lists of motions, tables of poses
//! rigid.rs    Rigid      rotation and translation
//! steered.rs  WallMotion motion of a wall by the caller, instead of the scene
//! contacts.rs            contacts of grains with meshes
//! mod.rs      Walls      all walls of a scene; face indices are contiguous, wall after wall
//! ```
//!
//! No step loops over all faces. Poses are computed per wall, and a face is moved to its position only for a grain near
//! it ([`PlacedFace`]), at the cost of a sum or a rotation. Queries for faces near a point use
//! `WallsAt::for_each_near`, or for one wall `WallsAt::for_each_near_of`; walls with many faces use their index.
//! Results do not depend on the order of the query: callers sort the faces by index, or take the minimum.
//!
//! Other modules contain friction and the remaining contact laws (materials and solve) and the forces on dynamic walls
//! ([`drive`](crate::effects::drive)).

mod composed;
mod contacts;
mod motion;
mod pose;
mod rigid;
mod steered;

pub(crate) use crate::surface::Impact;
pub(crate) use motion::drive_of;
pub use motion::{Beginning, DrivenWall};
pub(crate) use steered::Steered;
pub use steered::WallMotion;

use crate::scene::{self, Domain, Motion};
use crate::surface::{Face, FaceIndex};
use composed::Extent;
use motion::Movement;
use nalgebra::Vector3;
pub use pose::Pose;
use std::ops::Range;

type Vector = Vector3<f64>;

/// Fraction of the grain radius. A grain with a smaller displacement per step and a larger distance from a face cannot cross the face.
pub(crate) const SHORT_WAY: f64 = 0.5;

/// All walls of a scene, with their positions in the scene and their motions.
#[derive(Clone, Debug)]
pub struct Walls {
    walls: Vec<Wall>,
    faces: Vec<WallFace>,
    /// True if at least one wall is a mesh.
    any_mesh: bool,
}

#[derive(Clone, Debug)]
struct Wall {
    /// Indices of its faces.
    faces: Range<u32>,
    movement: Movement,
    index: Option<FaceIndex>,
    /// Width of closed seams of a mesh, m; absent for other shapes.
    seam: Option<f64>,
    /// Distance of the furthest point of a mesh from the axis of its rotation in the scene, m.
    furthest: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct WallFace {
    shape: Face,
    /// Index of the wall in the scene.
    wall: u32,
    /// Index of the material of the wall.
    material: u8,
    /// True if the motion maps the face onto itself, so that only velocities change.
    in_place: bool,
}

/// Walls at their positions, with a pose for each wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallsAt<'a> {
    walls: &'a Walls,
    poses: &'a [Pose],
}

/// Face at its position, with its velocity field.
#[derive(Clone, Copy, Debug)]
pub struct PlacedFace<'a> {
    /// Face at its position in the scene.
    placed: &'a Face,
    /// Moved face, if the pose differs from that of the scene: most walls are at rest, and their faces are not copied.
    moved: Option<Face>,
    pose: &'a Pose,
    in_place: bool,
}

impl Walls {
    /// Creates the walls of a scene in its domain; `material` returns the index of a material by name.
    pub fn new(walls: &[scene::Wall], domain: &Domain, material: impl Fn(&str) -> u8) -> Walls {
        let mut faces: Vec<WallFace> = Vec::new();
        let place = |(number, wall): (u32, &scene::Wall)| {
            let (shapes, first) = (wall.shape.faces(domain.period()), faces.len() as u32);
            let (material, in_place) = (material(&wall.material), false);
            faces.extend(shapes.iter().map(|shape| WallFace { shape: *shape, wall: number, material, in_place }));
            let motion = scene::course(walls, number as usize);
            Wall {
                faces: first..faces.len() as u32,
                movement: Movement::new(&motion, wall.surface_velocity, Extent::of(&shapes, domain)),
                index: FaceIndex::new(&shapes, first, domain.period()),
                seam: wall.shape.seam(),
                furthest: None,
            }
        };
        let walls: Vec<Wall> = (0..).zip(walls).map(place).collect();
        let any_mesh = walls.iter().any(|wall| wall.seam.is_some());
        let mut all = Walls { walls, faces, any_mesh };
        (0..all.count() as u32).for_each(|wall| all.change(wall, |_| ()));
        all
    }

    crate::getters! {
        /// Returns the number of faces.
        pub faces: usize = |walls| walls.faces.len();
        /// Returns true if at least one wall does work at any time: it moves, or its surface does.
        pub any_works: bool = |walls| walls.walls.iter().any(|Wall { movement, .. }| movement.moves() || movement.surface_velocity != Vector::zeros());
    }

    /// Returns the index in the scene of the wall of a face.
    #[inline]
    pub fn wall_of(&self, face: u32) -> u32 {
        self.faces[face as usize].wall
    }

    /// Returns the index of the material of a face.
    #[inline]
    pub fn material_of(&self, face: u32) -> u8 {
        self.faces[face as usize].material
    }

    /// Returns the index in the scene of the wall of a face, and the index of the face in the wall.
    pub(crate) fn place_of(&self, face: u32) -> (u32, u32) {
        let wall = self.wall_of(face);
        (wall, face - self.walls[wall as usize].faces.start)
    }

    /// Returns the point (m) of a wall about which torques are stated: on the axis of its rotation, or the origin without an axis.
    pub(crate) fn pivot(&self, wall: u32) -> [f64; 3] {
        self.walls[wall as usize].movement.axis().unwrap_or_default().0.into()
    }

    /// Returns the indices of the walls that move at any time.
    pub(crate) fn moving(&self) -> impl Iterator<Item = u32> + '_ {
        let moves = |wall: &Wall| wall.movement.moves() && !wall.faces.is_empty();
        (0..).zip(&self.walls).filter(move |(_, wall)| moves(wall)).map(|(number, _)| number)
    }

    /// Sets the displacement (m or rad) and the rate (m/s or rad/s) of a dynamic wall; no effect on a wall without a drive.
    pub fn put(&mut self, wall: u32, displacement: f64, rate: f64) {
        let movement = &mut self.walls[wall as usize].movement;
        (movement.displacement, movement.rate) = (displacement, rate);
    }

    /// Prescribes a motion of a wall from the next step on; `times` are the present time and that of the last build of the candidate list, s.
    ///
    /// # Errors
    /// Reason why the wall cannot have this motion, as text that follows its name.
    pub(crate) fn steer(&mut self, wall: u32, motion: &WallMotion, times: [f64; 2]) -> Result<(), String> {
        self.change(wall, |movement| movement.steer(motion, times))
    }

    /// Restores the prescribed motion of a wall from a stored state.
    pub(crate) fn restore(&mut self, wall: u32, steered: Steered) {
        self.change(wall, |movement| movement.steered = Some(steered));
    }

    /// Changes the motion of a wall, and updates which faces the motion maps onto themselves.
    fn change<R>(&mut self, wall: u32, change: impl FnOnce(&mut Movement) -> R) -> R {
        let Wall { faces, movement, furthest, seam, .. } = &mut self.walls[wall as usize];
        let own = &mut self.faces[faces.start as usize..faces.end as usize];
        let result = change(movement);
        own.iter_mut().for_each(|face| face.in_place = movement.keeps_in_place(&face.shape));
        movement.turns = movement.axis().is_some() && !own.iter().all(|face| face.in_place);
        *furthest = seam.and_then(|_| furthest_corner(movement, own));
        result
    }

    /// Returns the beginning of a motion at the pose that a wall has at a time (s).
    pub(crate) fn reached(&self, wall: u32, time: f64) -> Beginning {
        Beginning { pose: self.walls[wall as usize].movement.at(time).displacement.rigid(), time }
    }

    /// Begins another motion of a wall. The candidate list must be built again before the next step.
    pub(crate) fn begin_motion(&mut self, wall: u32, motion: &Motion, beginning: &Beginning) {
        self.change(wall, |movement| movement.begin(motion, beginning));
    }

    /// Returns the kinematic walls under control of the caller, each with its state.
    pub(crate) fn steered(&self) -> impl Iterator<Item = (u32, &Steered)> {
        (0..).zip(&self.walls).filter_map(|(number, wall)| Some((number, wall.movement.steered.as_ref()?)))
    }

    /// Returns the displacement (m) and the angle (rad) of a wall at a time (s) from its position in the scene.
    pub(crate) fn displacement(&self, wall: u32, time: f64) -> ([f64; 3], f64) {
        self.walls[wall as usize].movement.place(time)
    }

    /// Moves the walls under control of the caller for a step of length `h`, s.
    pub(crate) fn advance_steered(&mut self, h: f64) {
        self.walls.iter_mut().filter_map(|wall| wall.movement.steered.as_mut()).for_each(|steered| steered.advance(h));
    }

    /// Stores the displacements by drives when the candidate list is built.
    pub(crate) fn enter_list(&mut self) {
        for Wall { movement, .. } in &mut self.walls {
            movement.displacement_in_list = movement.displacement;
            movement.steered.iter_mut().for_each(Steered::enter_list);
        }
    }

    /// Returns the stored displacement of a dynamic wall, m or rad.
    pub(crate) fn displacement_in_list(&self, wall: u32) -> f64 {
        self.walls[wall as usize].movement.displacement_in_list
    }

    /// Returns an upper bound of the displacement (m) between two times (s) of a point of a wall within `radius` (m) of
    /// the centre of its motion. The displacement of a dynamic wall is that since the build of the list.
    pub(crate) fn largest_shift(&self, from: f64, to: f64, radius: f64) -> f64 {
        let walls = self.walls.iter().filter(|wall| !wall.faces.is_empty());
        let arm = |wall: &Wall| wall.furthest.map_or(radius, |furthest| furthest.min(radius));
        walls.map(|wall| wall.movement.largest_shift(from, to, arm(wall))).fold(0.0, f64::max)
    }

    /// Returns the poses of the walls at a time (s), with the velocities at that time; for dynamic walls, the last state of their drives.
    pub fn poses(&self, time: f64) -> impl Iterator<Item = Pose> + '_ {
        self.walls.iter().map(move |wall| wall.movement.at(time))
    }

    /// Returns the poses at the start of a step of length `step` (s), with the effective velocities of the step: the mean velocity of a vibration.
    pub(crate) fn poses_over(&self, time: f64, step: f64) -> impl Iterator<Item = Pose> + '_ {
        self.walls.iter().map(move |wall| wall.movement.over(time, step))
    }

    /// Returns the pose of one wall, as [`Walls::poses_over`] does.
    pub(crate) fn pose_over(&self, wall: u32, time: f64, step: f64) -> Pose {
        self.walls[wall as usize].movement.over(time, step)
    }

    /// Returns the pose of a wall at the start of a step of length `step` (s), with the velocity that leads to its
    /// position at the end. A dynamic wall moves at `rate` (m/s or rad/s).
    pub(crate) fn pose_through(&self, wall: u32, time: f64, step: f64, rate: f64) -> Pose {
        self.walls[wall as usize].movement.through(time, step, rate)
    }

    /// Returns the walls at these poses.
    pub(crate) fn placed<'a>(&'a self, poses: &'a [Pose]) -> WallsAt<'a> {
        WallsAt { walls: self, poses }
    }

    /// Returns the number of walls.
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
    /// Returns a face at its position.
    #[inline]
    pub fn face(&self, number: u32) -> PlacedFace<'a> {
        let WallFace { shape, wall, in_place, .. } = &self.walls.faces[number as usize];
        let pose = &self.poses[*wall as usize];
        PlacedFace { placed: shape, moved: pose.moved(shape, *in_place), pose, in_place: *in_place }
    }

    /// Evaluates a function of a face at its position, and of its wall; a face at rest is not copied.
    #[inline(always)]
    fn ask<R>(&self, number: u32, question: impl FnOnce(&Face, &Pose, bool) -> R) -> R {
        let WallFace { shape, wall, in_place, .. } = &self.walls.faces[number as usize];
        let pose = &self.poses[*wall as usize];
        match pose.moved(shape, *in_place) {
            None => question(shape, pose, *in_place),
            Some(moved) => question(&moved, pose, *in_place),
        }
    }

    /// Returns the distance of the face with an index, as [`PlacedFace::distance`] does.
    #[inline]
    pub fn distance(&self, number: u32, point: &Vector) -> f64 {
        self.ask(number, |face, _, _| face.distance(point))
    }

    /// Returns true if a grain has a contact with a face in a step (s), and the distance (m) from its centre to the
    /// face. Input: index of the face; centre (m) and velocity (m/s) of the grain; its radius and the largest gap of a
    /// contact (m). Swept contacts are included: a grain that moves by more than its radius relative to the wall could
    /// otherwise be deep behind the face, or on the other side of a shell, before detection.
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

    /// Returns the contact of a grain with a face in a step.
    ///
    /// Input: index of the face; centre (m) and velocity (m/s) of the grain at the start; its radius (m); the step (s); the
    /// velocity increment by gravity (m/s). Output: distance from the centre to the face (m), or to its tangent plane at the
    /// impact of a grain too fast for the step; unit normal towards the face; true for a swept contact. Further output, m/s:
    /// velocity of the wall at the contact, its change without a jump, and its drift in a rotation.
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
            let velocity_at_contact = pose.velocity_at(&(centre + normal * distance), in_place);
            let (mean, gain) = (velocity_at_contact + pose.slides_at(&normal), pose.gain_at(centre));
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

    /// Returns the index, the pose and the face indices of each wall.
    pub fn each_wall(&self) -> impl Iterator<Item = (u32, &'a Pose, Range<u32>)> + use<'a> {
        let walls = (0..).zip(&self.walls.walls).zip(self.poses);
        walls.map(|((number, wall), pose)| (number, pose, wall.faces.clone()))
    }

    /// Returns true if a wall has an index for its faces: queries then return faces in arbitrary order, and possibly more than once.
    pub fn has_index(&self, wall: u32) -> bool {
        self.walls.walls[wall as usize].index.is_some()
    }

    /// Visits every face of a wall that may be nearer to a point (m) than `radius` (m), and other faces.
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

    /// Visits the faces of all walls, with a radius for each wall from its pose.
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

    /// Returns the distance from a point to the face (m), negative behind a plane: see [`PlacedFace::nearest`].
    #[inline]
    pub fn distance(&self, point: &Vector) -> f64 {
        self.shape().distance(point)
    }

    /// Returns the distance from the centre of a grain to the face (m), and the unit normal from the centre to the nearest point. If a whole circle
    /// or sphere of points is nearest, as on the axis of a tube, the result is the point in the direction of `travel`, a vector of any length.
    ///
    /// Behind a plane, the distance is negative, so that the contact pushes the grain back. Discs, with or without a
    /// hole, and shells are thin: both have two sides, and rims as contact surfaces.
    #[inline]
    pub fn nearest(&self, centre: &Vector, travel: impl FnOnce() -> Vector) -> (f64, Vector) {
        self.shape().nearest(centre, travel)
    }

    /// Returns true if a grain has a swept contact with the face: see [`WallsAt::touches`].
    pub(crate) fn is_swept(&self, centre: &Vector, radius: f64, velocity: &Vector, step: f64) -> bool {
        let path = self.path(centre, velocity, step);
        path.norm_squared() > radius * radius && self.shape().time_of_impact(centre, &path, radius).is_some()
    }

    /// Returns the path of a point with the given `velocity` (m/s) over a step (s), relative to the face, m.
    pub(crate) fn path(&self, from: &Vector, velocity: &Vector, step: f64) -> Vector {
        self.pose.path(from, velocity, step, self.in_place)
    }

    /// Returns the first point of a path within `level` (m) of the face, for a path that starts at a larger distance.
    pub(crate) fn time_of_impact(&self, from: &Vector, path: &Vector, level: f64) -> Option<Impact> {
        self.shape().time_of_impact(from, path, level)
    }

    /// Returns the velocity (m/s) of a point that moves with the wall over a step (s).
    pub(crate) fn carries(&self, point: &Vector, step: f64) -> Vector {
        self.pose.carries(point, step, self.in_place)
    }

    /// Returns the largest speed (m/s) of a point of the face within `radius` (m) of another point (m), from the motion of the face itself.
    pub(crate) fn largest_speed(&self, around: &Vector, radius: f64) -> f64 {
        self.pose.largest_speed_of(around, radius, self.in_place)
    }

    /// Returns the velocity of the wall at a point, m/s; in a step, the effective velocity without the drift of a rotation.
    #[inline]
    pub fn velocity_at(&self, point: &Vector) -> Vector {
        self.pose.velocity_at(point, self.in_place)
    }

    /// Returns the velocity of the surface along itself (m/s) at a contact with this normal.
    pub(crate) fn slides_at(&self, normal: &Vector) -> Vector {
        self.pose.slides_at(normal)
    }

    /// Returns the change of the wall's velocity since the last step, without a jump and without the drift, m/s; no
    /// part of the approach speed of a resting grain with this centre, m.
    pub(crate) fn gain_at(&self, centre: &Vector) -> Vector {
        self.pose.gain_at(centre)
    }

    /// Returns the angular velocity of the wall, rad/s.
    pub fn spin(&self) -> Vector {
        self.pose.spin(self.in_place)
    }
}

/// Returns the index of the first wall that would jump, or whose vibration would change its phase, on a reset of the time from the given
/// time (s) to zero. This is the case if its prescribed motion begins earlier and does not lead back to the same surface. Displacements by
/// a drive remain.
pub fn first_that_jumps_back(walls: &[scene::Wall], domain: &Domain, time: f64) -> Option<usize> {
    let extent = (Vector::from(domain.max) - Vector::from(domain.min)).norm();
    let Walls { walls, faces, .. } = Walls::new(walls, domain, |_| 0);
    let own = |wall: &Wall| &faces[wall.faces.start as usize..wall.faces.end as usize];
    walls.iter().position(|wall| wall.movement.jumps_back(time, own(wall), extent))
}

/// Returns the distance (m) of the furthest corner of a mesh from the axis about which its motion in the scene turns it.
fn furthest_corner(movement: &Movement, faces: &[WallFace]) -> Option<f64> {
    let (point, axis) = movement.motion.axis()?;
    let (point, axis, mut furthest) = (Vector::from(point), Vector::from(axis).normalize(), 0.0);
    for face in faces {
        let based = movement.based(&face.shape);
        furthest = based.corners().iter().map(|corner| (corner - point).cross(&axis).norm()).fold(furthest, f64::max);
    }
    Some(furthest)
}

/// Walls of a scene at their positions at a time.
///
/// ```
/// use makadam::{Domain, Face, Shape, Wall, wall::PlacedWalls};
///
/// let domain = Domain { min: [-1.0; 3], max: [1.0; 3], periodic: Vec::new() };
/// let walls = [Wall::new("box", "glass", Shape::cuboid([0.0; 3], [0.1; 3], &[Face::Top]))];
/// let placed = PlacedWalls::at(&walls, &domain, 0.0, &[], &[]);
/// assert!((placed.distance(&[0.05, 0.05, 0.02].into()) - 0.02).abs() < 1e-12);
/// assert!(placed.distance(&[0.05, 0.05, -0.02].into()) < 0.0, "behind the floor");
/// ```
#[derive(Clone, Debug)]
pub struct PlacedWalls {
    walls: Walls,
    poses: Vec<Pose>,
}

impl PlacedWalls {
    /// Returns the walls at a time (s) in a domain. Dynamic walls have the positions in `driven`, or those in the scene
    /// without an entry in `driven`. Walls in `beginnings` begin their motion at another pose and time.
    pub fn at(
        walls: &[scene::Wall],
        domain: &Domain,
        time: f64,
        driven: &[DrivenWall],
        beginnings: &[(u32, Beginning)],
    ) -> PlacedWalls {
        let mut placed = Walls::new(walls, domain, |_| 0);
        for (wall, beginning) in beginnings.iter().filter(|(wall, _)| (*wall as usize) < walls.len()) {
            placed.begin_motion(*wall, &scene::course(walls, *wall as usize), beginning);
        }
        for one in driven.iter().filter(|one| (one.wall as usize) < walls.len()) {
            placed.put(one.wall, one.displacement, one.rate);
        }
        let poses = placed.poses(time).collect();
        PlacedWalls { walls: placed, poses }
    }

    /// Returns the faces, wall after wall, each with the index of its wall in the scene.
    pub fn faces(&self) -> impl Iterator<Item = (usize, PlacedFace<'_>)> {
        let placed = self.walls.placed(&self.poses);
        (0..self.walls.faces() as u32).map(move |face| (self.walls.wall_of(face) as usize, placed.face(face)))
    }

    /// Returns the distance of a point from the nearest wall, m; infinite without walls.
    ///
    /// The distance is negative behind a plane or a face of a box. Thin shells and discs have no back.
    pub fn distance(&self, point: &Vector) -> f64 {
        let placed = self.walls.placed(&self.poses);
        let of_meshes = self.meshes().map(|mesh| placed.distance_of_mesh(mesh, point));
        // The disc or the shell of a rim is never farther than the other points of the rim.
        let is_nearest = |face: &u32| !matches!(self.walls.faces[*face as usize].shape, Face::Rim { .. });
        let of_faces = self.faces_beside_meshes().filter(is_nearest).map(|face| placed.distance(face, point));
        of_faces.chain(of_meshes).fold(f64::INFINITY, f64::min)
    }

    /// Returns the number of faces nearer to a point than `radius` (m); of meshes, the number of contacts of a sphere.
    pub fn within(&self, point: &Vector, radius: f64) -> usize {
        let placed = self.walls.placed(&self.poses);
        let of_meshes = self.meshes().map(|mesh| placed.minima(mesh, point, radius).list().len());
        let near = self.faces_beside_meshes().filter(|&face| placed.distance(face, point) < radius);
        near.count() + of_meshes.sum::<usize>()
    }

    /// Returns the indices of all faces except those of meshes.
    fn faces_beside_meshes(&self) -> impl Iterator<Item = u32> + '_ {
        let walls = self.walls.walls.iter().filter(|wall| wall.seam.is_none());
        walls.flat_map(|wall| wall.faces.clone())
    }

    fn meshes(&self) -> impl Iterator<Item = u32> {
        (0..self.walls.count() as u32).filter(|&wall| self.walls.is_mesh(wall))
    }

    /// Returns the velocity of the surface of a wall at a contact at a point (m) with a unit normal, m/s.
    pub fn velocity_at(&self, wall: usize, point: &Vector, normal: &Vector) -> Vector {
        self.poses[wall].velocity_at(point, false) + self.poses[wall].slides_at(normal)
    }

    /// Returns the present position of a point (m) of a wall, given in the scene.
    pub fn point_of(&self, wall: usize, point: &Vector) -> Vector {
        self.poses[wall].in_world(point)
    }
}
