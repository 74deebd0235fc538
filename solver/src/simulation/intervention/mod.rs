//! Interventions of the caller between steps, in addition to the scene: forces, written states, inserted and removed grains,
//! kinematic walls.
//!
//! ```text
//! forces.rs   forces and torques on grains, for one step
//! states.rs   positions, velocities and spins as arrays in memory, to be read and written; candidate pairs and their impulses
//! grains.rs   insertion and removal
//! ```
//!
//! Interventions cost nothing in simulations without them. Their effect depends only on the state and the arguments, so that bits
//! are the same on any number of threads. The ledger books them under `outside`. A watchdog resets its energy reference after
//! them, except for forces, whose work is known. A checkpoint holds the state of later steps without the forces of the next step:
//! the caller must set these again.

mod forces;
mod grains;
mod states;

use crate::Simulation;
use crate::lanes::plus;
use crate::wall::WallMotion;
use forces::{LOADS, Loads};
use serde::{Deserialize, Serialize};
pub use states::{PairsInList, States};

/// Reason why an intervention was refused; the simulation stays unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InterventionError {
    /// List of another length than the number of grains.
    #[error("{what} has {given} rows where there are {grains} grains; give one for each, in the order of their ids")]
    Length {
        /// The list.
        what: &'static str,
        /// Length of the list.
        given: usize,
        /// Number of grains.
        grains: usize,
    },
    /// Number outside the valid range of a run.
    #[error("{what} of grain {grain} is {value:?}; give finite numbers below 1e30 in SI units")]
    Number {
        /// The list.
        what: &'static str,
        /// Id of the grain.
        grain: usize,
        /// Given value.
        value: [f64; 3],
    },
    /// Grain that cannot be inserted.
    #[error("grain {index} of those to insert {problem}; {remedy}")]
    Insertion {
        /// Index in the list of grains to insert.
        index: usize,
        /// Problem.
        problem: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// Violated scene rule: the new grains, the present grains and the walls do not form a valid scene.
    #[error("with the grains to insert the scene breaks a rule of scenes: {0}")]
    Rule(String),
    /// Unknown grain.
    #[error("there is no grain {id} to remove; ids go from 0 to {} without holes", grains.saturating_sub(1))]
    NoGrain {
        /// Requested index.
        id: u32,
        /// Number of grains.
        grains: usize,
    },
    /// More grains than ids.
    #[error("{grains} grains are too many; at most {most} can be numbered")]
    TooMany {
        /// Resulting number.
        grains: usize,
        /// Largest number.
        most: usize,
    },
    /// Unknown wall.
    #[error("there is no wall {wall}; walls are numbered from 0 in the order of the scene, which has {walls}")]
    NoWall {
        /// Requested index.
        wall: u32,
        /// Number of walls.
        walls: usize,
    },
    /// Invalid motion of a wall.
    #[error("wall {wall}: {problem}")]
    Wall {
        /// Number of the wall in the scene.
        wall: u32,
        /// Problem and remedy.
        problem: String,
    },
}

/// Interventions so far, and loads of the next step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interventions {
    /// Forces and torques of the next step: applied loads, and added loads.
    loads: [Loads; LOADS],
    /// Scaled spins at the start of the step with loads, m/s, by body index.
    pub spins_before: Vec<[f64; 3]>,
    /// Work of forces and torques in the last step, J.
    pub work: f64,
    /// Number of interventions that a watchdog cannot account for.
    pub count: u64,
    /// Entry `outside` of the ledger.
    pub booked: Booked,
    /// True if grains were inserted, removed or written since the last step and a ledger is open.
    pub disturbed: bool,
    /// True if the caller may write positions and velocities.
    handed_out: bool,
    /// Energy, momentum and angular momentum before the caller's changes; only with a ledger and after states were handed out.
    known: Option<Booked>,
}

impl Interventions {
    /// Returns true if the caller has intervened since there were so many interventions, or may have.
    pub(crate) fn any_since(&self, count: u64) -> bool {
        self.count > count || self.handed_out || self.loads.iter().any(|loads| !loads.are_none())
    }

    /// Returns the interventions after grains have been inserted or removed; `new_ids` maps old ids to new ids.
    fn after(&self, new_ids: &[Option<u32>], grains: usize) -> Interventions {
        let mut next = Interventions {
            loads: self.loads.clone(),
            count: self.count + 1,
            handed_out: self.handed_out,
            booked: self.booked,
            disturbed: self.disturbed,
            ..Interventions::default()
        };
        next.renumber_loads(new_ids, grains);
        next
    }

    /// Moves the loads of the next step to the new ids of their grains, after grains have come and gone.
    pub(crate) fn renumber_loads(&mut self, new_ids: &[Option<u32>], grains: usize) {
        let renumbered = |list: &[[f64; 3]]| {
            let mut new = vec![[0.0; 3]; if list.is_empty() { 0 } else { grains }];
            for (vector, new_id) in list.iter().zip(new_ids) {
                if let Some(id) = new_id {
                    new[*id as usize] = *vector;
                }
            }
            new
        };
        for loads in self.loads.iter_mut().filter(|loads| !loads.are_none()) {
            *loads = Loads { forces: renumbered(&loads.forces), torques: renumbered(&loads.torques) };
        }
    }
}

/// External energy (J), momentum (kg m/s) and angular momentum (kg m2/s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Booked {
    pub energy: f64,
    pub impulse: [f64; 3],
    pub angular_impulse: [f64; 3],
}

impl Booked {
    /// Energy, momentum and angular momentum of a simulation.
    fn of(simulation: &Simulation) -> Booked {
        Booked {
            energy: simulation.energy_half_a_step_earlier().total(),
            impulse: simulation.momentum(),
            angular_impulse: simulation.angular_momentum(),
        }
    }

    /// Returns the sum of two entries.
    pub fn with(&self, other: &Booked) -> Booked {
        Booked {
            energy: self.energy + other.energy,
            impulse: plus(self.impulse, other.impulse),
            angular_impulse: plus(self.angular_impulse, other.angular_impulse),
        }
    }
}

impl Simulation {
    /// Moves a wall, by its number in the scene, from the next step on, at this velocity or rate until the next call. The motion
    /// starts from the present pose and replaces the motion of the scene. Grains have no influence on the wall.
    ///
    /// A wall either translates or turns about one axis: its first motion decides, or the scene if the scene moves the wall. The
    /// first velocity is a jump; later changes count as acceleration, as for a vibrating wall.
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
        self.check_wall(wall)?;
        let now = self.world.time;
        let listed = self.candidates.built_from().map_or(now, |(_, built_at)| built_at);
        let moved = self.world.walls.steer(wall, &motion, [now, listed]);
        moved.map_err(|problem| InterventionError::Wall { wall, problem })
    }

    /// Returns the displacement (m) and the angle (rad) of any wall from its pose in the scene, for every kind of motion.
    ///
    /// # Errors
    /// [`InterventionError::NoWall`].
    pub fn wall_displacement(&self, wall: u32) -> Result<([f64; 3], f64), InterventionError> {
        self.check_wall(wall)?;
        Ok(self.world.walls.displacement(wall, self.world.time))
    }

    fn check_wall(&self, wall: u32) -> Result<(), InterventionError> {
        let walls = self.world.walls.count();
        if (wall as usize) < walls { Ok(()) } else { Err(InterventionError::NoWall { wall, walls }) }
    }

    /// Returns the displacement (m) and angle (rad) of a kinematic wall from its pose in the scene; `None` for other walls.
    pub fn moved_by(&self, wall: u32) -> Option<([f64; 3], f64)> {
        self.world.walls.steered().find(|(number, _)| *number == wall).map(|(_, steered)| steered.place())
    }
}
