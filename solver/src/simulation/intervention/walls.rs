//! Walls that the caller moves.

use super::InterventionError;
use crate::Simulation;
use crate::wall::WallMotion;

impl Simulation {
    /// Moves a wall, by its number in the scene, from the next step on: at this velocity or rate, until it is given another. It goes from
    /// where it stands, and the scene no longer says how it moves. Grains have no influence on it.
    ///
    /// A wall either moves along or turns about one axis: which one is settled at its first motion, and by the scene where that moves it.
    /// The first velocity is a jump; later changes count as acceleration, as those of a vibrating wall do.
    ///
    /// ```
    /// # use makadam::{Material, Scene, Shape, Simulation, Wall, wall::WallMotion};
    /// # let floor = Wall::new("floor", "glass", Shape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] });
    /// # let scene = Scene::builder().material("glass", Material::default()).domain([-1.0; 3], [1.0; 3]).wall(floor).build()?;
    /// let mut simulation = Simulation::builder(&scene).time_step(1e-3).build()?;
    /// while simulation.time() < 0.1 {
    ///     let velocity = [0.0, 0.0, 0.05 * (2.0 * std::f64::consts::PI * 20.0 * simulation.time()).cos()];
    ///     simulation.move_wall(0, WallMotion::Translation { velocity })?;
    ///     simulation.step();
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InterventionError::NoWall`], [`InterventionError::Wall`].
    pub fn move_wall(&mut self, wall: u32, motion: WallMotion) -> Result<(), InterventionError> {
        let walls = self.world.walls.count();
        if wall as usize >= walls {
            return Err(InterventionError::NoWall { wall, walls });
        }
        let now = self.world.time;
        let listed = self.candidates.built_from().map_or(now, |(_, built_at)| built_at);
        let moved = self.world.walls.steer(wall, &motion, [now, listed]);
        moved.map_err(|problem| InterventionError::Wall { wall, problem })
    }

    /// Displacement of any wall along (m) and its angle (rad) from where the scene places it, whatever moves it.
    ///
    /// # Errors
    /// [`InterventionError::NoWall`].
    pub fn wall_displacement(&self, wall: u32) -> Result<([f64; 3], f64), InterventionError> {
        let walls = self.world.walls.count();
        match (wall as usize) < walls {
            true => Ok(self.world.walls.displacement(wall, self.world.time)),
            false => Err(InterventionError::NoWall { wall, walls }),
        }
    }

    /// How far a wall that the caller moves has moved along (m) and turned (rad) from where the scene places it; absent for others.
    pub fn moved_by(&self, wall: u32) -> Option<([f64; 3], f64)> {
        self.world.walls.steered().find(|(number, _)| *number == wall).map(|(_, steered)| steered.place())
    }
}
