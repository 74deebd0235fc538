//! Interventions of the caller between steps, in addition to the scene: forces, states that are written, grains that
//! come and go, walls that are steered.
//!
//! ```text
//! forces.rs   forces and torques on grains, for one step
//! states.rs   positions, velocities and spins as arrays in memory, to be read and written
//! grains.rs   insertion and removal
//! walls.rs    walls that the caller moves
//! contacts.rs pairs that may touch and what they bore, handed out without copying
//! ```
//!
//! None of it costs anything in a simulation that nobody intervenes in. What is done depends on nothing but the state and what is asked
//! for, so that bits are the same on any number of threads. The ledger enters all of it under `outside`; a watchdog judges energy anew
//! after it, but for forces, whose work it knows. A checkpoint holds what later steps depend on, forces of the step to come left out:
//! these are given for one step, and are given again.

mod forces;
mod grains;
mod states;

use crate::Simulation;
use crate::lanes::{minus, plus};
use crate::wall::WallMotion;
#[doc(hidden)]
use forces::{LOADS, Loads};
use serde::{Deserialize, Serialize};
pub use states::{KeptContact, PairsInList, States};

/// Reason for which an intervention was refused; the simulation stays as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InterventionError {
    /// A list is not as long as there are grains.
    #[error("{what} has {given} rows where there are {grains} grains; give one for each, in the order of their ids")]
    Length {
        /// The list.
        what: &'static str,
        /// Its length.
        given: usize,
        /// Number of grains.
        grains: usize,
    },
    /// A number is not one that a run can have.
    #[error("{what} of grain {grain} is {value:?}; give finite numbers below 1e30 in SI units")]
    Number {
        /// The list.
        what: &'static str,
        /// Id of the grain.
        grain: usize,
        /// Given value.
        value: [f64; 3],
    },
    /// A grain cannot be inserted.
    #[error("grain {index} of those to insert {problem}; {remedy}")]
    Insertion {
        /// Its place among those to insert.
        index: usize,
        /// Problem.
        problem: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// With the grains to insert, those that are there and the walls would not be a scene.
    #[error("with the grains to insert the scene breaks a rule of scenes: {0}")]
    Rule(String),
    /// There is no such grain.
    #[error("there is no grain {id} to remove; ids go from 0 to {} without holes", grains.saturating_sub(1))]
    NoGrain {
        /// Requested index.
        id: u32,
        /// Number of grains.
        grains: usize,
    },
    /// There would be more grains than can be numbered.
    #[error("{grains} grains are too many; at most {most} can be numbered")]
    TooMany {
        /// Resulting number.
        grains: usize,
        /// Largest number.
        most: usize,
    },
    /// There is no such wall.
    #[error("there is no wall {wall}; walls are numbered from 0 in the order of the scene, which has {walls}")]
    NoWall {
        /// Requested index.
        wall: u32,
        /// Number of walls.
        walls: usize,
    },
    /// A wall cannot be moved so.
    #[error("wall {wall}: {problem}")]
    Wall {
        /// Number of the wall in the scene.
        wall: u32,
        /// Problem and remedy.
        problem: String,
    },
}

/// Interventions so far, and loads of the step to come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interventions {
    /// Forces and torques of the step to come: those that are applied, and those on top of them.
    loads: [Loads; LOADS],
    /// Scaled spins at the start of the step in which these act, m/s, by place.
    spins_before: Vec<[f64; 3]>,
    /// Work of forces and torques in the last step, J.
    pub work: f64,
    /// Number of interventions that a watchdog cannot account for.
    pub count: u64,
    /// True if there are, or may be, other grains than the scene has.
    pub other_grains: bool,
    /// Number of each grain, by id, that no other grain of the run has or had; empty unless `other_grains`.
    numbers: Vec<u64>,
    /// Number of the next grain that is inserted; 0 unless `other_grains`.
    next_number: u64,
    /// Entry `outside` of the ledger.
    pub booked: Booked,
    /// True if grains came, went or were written since the last step, where a ledger is kept.
    pub disturbed: bool,
    /// True if positions and velocities may be written from outside.
    handed_out: bool,
    /// Energy, momentum and angular momentum before the caller wrote; only where a ledger is kept and states were handed out.
    known: Option<Booked>,
}

impl Interventions {
    /// Numbers of the grains by id, which stay with them; none where no grain was inserted or removed.
    pub fn numbers(&self) -> &[u64] {
        &self.numbers
    }

    /// The numbers and the next one, for a checkpoint.
    pub fn numbering(&self) -> (Vec<u64>, u64) {
        (self.numbers.clone(), self.next_number)
    }

    /// Takes over the numbers of a checkpoint in which grains came or went.
    pub fn renumber(&mut self, (numbers, next_number): (Vec<u64>, u64)) {
        (self.other_grains, self.numbers, self.next_number) = (true, numbers, next_number);
    }

    /// Numbers of the grains once some have come or gone, and the next number: those that stay keep theirs.
    fn numbers_after(&self, new_ids: &[Option<u32>], grains: usize) -> (Vec<u64>, u64) {
        let (numbered, mut next) = (self.other_grains, self.next_number);
        if !numbered {
            next = new_ids.len() as u64;
        }
        let old = |id: usize| if numbered { self.numbers[id] } else { id as u64 };
        let mut numbers: Vec<u64> =
            new_ids.iter().enumerate().filter(|(_, new_id)| new_id.is_some()).map(|(id, _)| old(id)).collect();
        let inserted = (grains - numbers.len()) as u64;
        numbers.extend(next..next + inserted);
        (numbers, next + inserted)
    }

    /// Interventions after grains have been inserted or removed; `new_ids` tells who is who of the old ones.
    fn after(&self, new_ids: &[Option<u32>], grains: usize) -> Interventions {
        let renumbered = |list: &[[f64; 3]]| {
            let mut new = vec![[0.0; 3]; if list.is_empty() { 0 } else { grains }];
            for (vector, new_id) in list.iter().zip(new_ids) {
                if let Some(id) = new_id {
                    new[*id as usize] = *vector;
                }
            }
            new
        };
        let (numbers, next_number) = self.numbers_after(new_ids, grains);
        Interventions {
            numbers,
            next_number,
            loads: self
                .loads
                .each_ref()
                .map(|loads| Loads { forces: renumbered(&loads.forces), torques: renumbered(&loads.torques) }),
            count: self.count + 1,
            other_grains: true,
            handed_out: self.handed_out,
            booked: self.booked,
            disturbed: self.disturbed,
            ..Interventions::default()
        }
    }
}

/// Energy (J), momentum (kg m/s) and angular momentum (kg m2/s) that came from outside.
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

    /// Adds what a change from one state to another has brought.
    fn add_change(&mut self, before: &Booked, after: &Booked) {
        self.energy += after.energy - before.energy;
        self.impulse = plus(self.impulse, minus(after.impulse, before.impulse));
        self.angular_impulse = plus(self.angular_impulse, minus(after.angular_impulse, before.angular_impulse));
    }
}

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

    /// Displacement (m) and angle (rad) of a wall that the caller moves, from its place in the scene; absent for others.
    pub fn moved_by(&self, wall: u32) -> Option<([f64; 3], f64)> {
        self.world.walls.steered().find(|(number, _)| *number == wall).map(|(_, steered)| steered.place())
    }
}
