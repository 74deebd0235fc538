//! Distance of a point from the walls at their present pose, and from the ends of periodic axes.

use makadam::scene::Domain;
use makadam::snapshot::Snapshot;
use makadam_frames::plan::MeasuredScene;
use nalgebra::Vector3;

/// Walls of a scene at one time, and its periodic ends.
///
/// The ends of a periodic axis count as walls: a frame lacks the neighbours beyond the ends.
pub struct PlacedWalls {
    walls: makadam::wall::PlacedWalls,
    domain: Domain,
}

impl PlacedWalls {
    /// Returns the walls of a scene at the time of a frame.
    pub fn at(scene: &MeasuredScene, frame: &Snapshot) -> Self {
        let walls = makadam::wall::PlacedWalls::at(
            &scene.wall,
            &scene.domain,
            frame.time,
            &frame.driven_walls,
            &frame.beginnings,
        );
        Self { walls, domain: scene.domain.clone() }
    }

    /// Returns the distance of a point from the nearest wall, m; infinite without walls.
    ///
    /// Negative behind a plane or a box's face. Thin shells and discs have no back side.
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.to_ends(point).fold(self.walls.distance(point), f64::min)
    }

    /// Returns the number of walls nearer than `radius` (m) to a point; a box counts once per face, and ends of periodic axes do not count.
    pub fn within(&self, point: &Vector3<f64>, radius: f64) -> usize {
        self.walls.within(point, radius)
    }

    /// Returns the position (m) of a wall's point after the wall's motion, from its position in the scene.
    pub fn point_of(&self, wall: usize, point: &Vector3<f64>) -> Vector3<f64> {
        self.walls.point_of(wall, point)
    }

    /// Returns the velocity of a wall's surface at a contact at a point (m) with a unit normal, m/s.
    pub fn velocity_at(&self, wall: usize, point: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
        self.walls.velocity_at(wall, point, normal)
    }

    /// Returns the angular velocity of a wall, rad/s; zero without rotation at the time.
    pub fn spin_of(&self, wall: usize) -> Vector3<f64> {
        let of_wall = self.walls.faces().find(|(number, _)| *number == wall);
        of_wall.map_or_else(Vector3::zeros, |(_, face)| face.spin())
    }

    /// Returns the distances of a point from both ends of every periodic axis, m; negative beyond them.
    fn to_ends(&self, point: &Vector3<f64>) -> impl Iterator<Item = f64> {
        let Domain { min, max, periodic } = &self.domain;
        let axes = periodic.iter().map(|axis| axis.number());
        axes.flat_map(|axis| [point[axis] - min[axis], max[axis] - point[axis]])
    }
}
