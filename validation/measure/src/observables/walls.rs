//! Distance of a point from the walls, wherever their motion has brought them, and from the ends of periodic axes.

use makadam::scene::Domain;
use makadam::snapshot::Snapshot;
use makadam_frames::plan::MeasuredScene;
use nalgebra::Vector3;

/// The walls of a scene at one time, and its periodic ends.
///
/// The ends of a periodic axis count as walls: a frame does not have the neighbours that grains there have beyond.
pub struct PlacedWalls {
    walls: makadam::wall::PlacedWalls,
    domain: Domain,
}

impl PlacedWalls {
    /// The walls of a scene at the time of a frame.
    pub fn at(scene: &MeasuredScene, frame: &Snapshot) -> Self {
        let walls = makadam::wall::PlacedWalls::at(&scene.wall, &scene.domain, frame.time, &frame.driven_walls);
        Self { walls, domain: scene.domain.clone() }
    }

    /// Distance of a point from the nearest wall, m; infinite where there is no wall.
    ///
    /// It is negative behind a plane or a box's face. Thin shells and discs have no behind.
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.to_ends(point).fold(self.walls.distance(point), f64::min)
    }

    /// Number of walls nearer than `radius` (m) to a point; a box counts once a face, and ends of periodic axes do not count.
    pub fn within(&self, point: &Vector3<f64>, radius: f64) -> usize {
        self.walls.within(point, radius)
    }

    /// Point (m) to which the motion of a wall has brought a point of it that the scene places.
    pub fn point_of(&self, wall: usize, point: &Vector3<f64>) -> Vector3<f64> {
        self.walls.point_of(wall, point)
    }

    /// Angular velocity of a wall, rad/s; zero where it does not turn at the time.
    pub fn spin_of(&self, wall: usize) -> Vector3<f64> {
        let of_wall = self.walls.faces().find(|(number, _)| *number == wall);
        of_wall.map_or_else(Vector3::zeros, |(_, face)| face.spin())
    }

    /// Distances of a point from both ends of every periodic axis, m; negative beyond them.
    fn to_ends(&self, point: &Vector3<f64>) -> impl Iterator<Item = f64> {
        let Domain { min, max, periodic } = &self.domain;
        let axes = periodic.iter().map(|axis| axis.number());
        axes.flat_map(|axis| [point[axis] - min[axis], max[axis] - point[axis]])
    }
}
