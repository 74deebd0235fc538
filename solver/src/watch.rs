//! Watchdogs: detection of invalid states, reported with the grain, the step and the time.
//!
//! ```
//! use makadam::watch::Watchdog;
//! # use makadam::{Scene, Simulation};
//! # let scene = Scene::example();
//! let mut simulation = Simulation::builder(&scene).time_step(5e-4).build()?;
//! let mut watchdog = Watchdog::new(&scene.watch, &simulation);
//! for _ in 0..200 {
//!     let report = simulation.step();
//!     for alarm in watchdog.observe(&simulation, &report) {
//!         println!("{alarm}");
//!     }
//! }
//! # Ok::<(), makadam::Error>(())
//! ```

use crate::scene::{Reaction, Watch};
use crate::simulation::StepReport;
use crate::simulation::energy::{ContactEnergy, Energy};
use crate::simulation::ledger::work_of_changing_gravity;
use crate::solve::{StopReason, residual_text, residual_unit, residual_unit_name};
use crate::{Crossing, Passage, Simulation};
use nalgebra::Vector3;

/// Violation.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Trouble {
    /// A grain's position, velocity or spin is not finite.
    #[error("grain {grain} has no finite position or velocity: the scene diverged; lower solver.step")]
    NotFinite {
        /// Permanent number of the grain.
        grain: u64,
    },
    /// A grain overlaps its partner beyond the tolerance.
    #[error(
        "grain {grain} overlaps its partner by {share:.3} of the smaller radius, more than {bound}; lower solver.step, \
         raise youngs_modulus or the sweeps of solver.stop"
    )]
    Overlap {
        /// Permanent number of the grain.
        grain: u64,
        /// Overlap over the smaller radius.
        share: f64,
        /// Tolerated value.
        bound: f64,
    },
    /// A grain overlaps its partner so far that its centre is inside: the direction of the contact force is no longer meaningful.
    #[error(
        "grain {grain} overlaps its partner by {share:.3} of the smaller radius, more than {bound}: its centre lies inside; \
         lower solver.step, raise youngs_modulus or the sweeps of solver.stop"
    )]
    DeepOverlap {
        /// Permanent number of the grain.
        grain: u64,
        /// Overlap over the smaller radius.
        share: f64,
        /// Limit beyond which the results are invalid.
        bound: f64,
    },
    /// Mechanical energy has grown without a source.
    #[error(
        "mechanical energy grew by {share:.3} of its scale, more than {bound}, with grain {grain} the fastest; lower \
         solver.step, look for grains that start inside each other, or, if contacts are rigid, lower \
         solver.restitution_threshold: overlaps are pushed apart at up to that speed"
    )]
    Energy {
        /// Permanent number of the fastest grain.
        grain: u64,
        /// Gain over the scale of [`Watch::energy`].
        share: f64,
        /// Tolerated value.
        bound: f64,
    },
    /// A grain has left the domain.
    #[error(
        "grain {grain} left the domain at ({:.4}, {:.4}, {:.4}) m; enlarge the domain, close the walls or lower \
         solver.step; where grains are meant to leave, and nothing depends on them, set watch.on_escape = \"ignore\"",
        position[0], position[1], position[2]
    )]
    Escape {
        /// Permanent number of the grain.
        grain: u64,
        /// Position, m.
        position: [f64; 3],
    },
    /// A grain has crossed a wall.
    #[error("grain {grain} has crossed wall {wall}; lower solver.step, or close the walls")]
    Crossing {
        /// Permanent number of the grain.
        grain: u64,
        /// Number of the wall in the scene.
        wall: u32,
    },
    /// Two grains may have passed through each other.
    #[error(
        "grains {} and {} may have passed through each other: too many grains met within one step; lower solver.step, \
         so that no grain moves by more than a diameter in it",
        grains[0], grains[1]
    )]
    Passage {
        /// Permanent numbers of the two grains.
        grains: [u64; 2],
    },
    /// No solve since the last check has come close to a solution.
    #[error(
        "no solve since the last look came below a residual of {}, more than {}; raise the sweeps of solver.stop or lower \
         solver.step",
        residual_text(*residual, unit), residual_text(*bound, unit)
    )]
    Stagnation {
        /// Smallest residual since the last check, in the unit of residuals.
        residual: f64,
        /// Tolerated value.
        bound: f64,
        /// Name of the unit: g h, or m/s without gravity.
        unit: &'static str,
    },
    /// A stage has not ended within its longest time.
    #[error(
        "stage[{stage}] has not ended within at_most: its until is at {:.3e}, and ends it at {:e}; raise \
         stage[{stage}].at_most, or change stage[{stage}].until",
        condition[0], condition[1]
    )]
    Overdue {
        /// Number of the stage in the scene, from 0.
        stage: u32,
        /// Value of its condition, and the value that ends it: J per grain, N or kg.
        condition: [f64; 2],
    },
}

impl Trouble {
    /// Returns the alarm of a violation at the present step.
    fn alarm(self, simulation: &Simulation, reaction: Reaction) -> Alarm {
        Alarm { trouble: self, reaction, step: simulation.steps, time: simulation.world.time }
    }

    /// Returns the kind in one word.
    pub fn kind(&self) -> &'static str {
        match self {
            Trouble::NotFinite { .. } => "not finite",
            Trouble::Overlap { .. } => "overlap",
            Trouble::DeepOverlap { .. } => "deep overlap",
            Trouble::Energy { .. } => "energy",
            Trouble::Escape { .. } => "escape",
            Trouble::Crossing { .. } => "crossing",
            Trouble::Passage { .. } => "passage",
            Trouble::Stagnation { .. } => "stagnation",
            Trouble::Overdue { .. } => "overdue stage",
        }
    }

    /// Returns true if the violation invalidates the results of a run, for any requested reaction.
    pub fn is_fatal(&self) -> bool {
        !matches!(self, Trouble::Overlap { .. } | Trouble::Stagnation { .. } | Trouble::Overdue { .. })
    }
}

/// Violation with its step, time and reaction.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{trouble} (step {step}, {time:.6} s)")]
pub struct Alarm {
    /// Violation.
    pub trouble: Trouble,
    /// Requested reaction of the scene.
    pub reaction: Reaction,
    /// Steps taken.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
}

/// Overlap over the smaller radius above which a centre lies inside its partner.
const DEEP: f64 = 1.0;

/// Watchdog that checks a simulation at a fixed interval of steps.
#[derive(Clone, Debug)]
pub struct Watchdog {
    settings: Watch,
    /// Number of interventions at the last observed step.
    interventions: u64,
    /// Energy of grains that came and went by the last observed step, J.
    flowed: f64,
    /// Number of steps at the last observed step, and at the last check.
    noted: u64,
    looked: Option<u64>,
    /// Energy of the contacts at the last check; `None` if grains have no finite state.
    contacts: Option<ContactEnergy>,
    /// First violation of each kind.
    noticed: Vec<Alarm>,
    /// Gravity at the end of the last step, m/s2.
    gravity: Vector3<f64>,
    /// Work of walls and of changing gravity so far, J.
    supplied: f64,
    /// Smallest mechanical energy so far, J, minus the energy supplied until then: an upper bound on that of later states,
    /// without elastic energy.
    available: f64,
    /// Largest kinetic energy so far, J.
    kinetic: f64,
    /// Smallest residual since the last check, in units of g h; `None` without an observed step.
    residual: Option<f64>,
    /// True until the first check, if the watchdog has begun between two checks: it does not know all residuals.
    is_partial: bool,
}

impl Watchdog {
    /// Creates a watchdog without observations.
    pub fn new(settings: &Watch, simulation: &Simulation) -> Watchdog {
        Watchdog {
            settings: settings.clone(),
            interventions: simulation.interventions.count,
            flowed: simulation.supplied_by_flow(),
            noted: simulation.steps,
            looked: None,
            contacts: None,
            gravity: simulation.world.gravity,
            supplied: 0.0,
            available: f64::INFINITY,
            kinetic: 0.0,
            residual: None,
            is_partial: settings.every > 0 && !simulation.steps.is_multiple_of(u64::from(settings.every)),
            noticed: Vec::new(),
        }
    }

    /// Observes a step, and checks the state at the interval of the settings. Returns the violations, the most severe first.
    ///
    /// Every step must be observed: after a missed step or an intervention on grains, the energy supply is unknown, and the
    /// energy check restarts. Steps between checks allocate nothing, and a check at most one pose per wall. A grain that has
    /// crossed a wall, or may have passed through another grain, is always reported in the same step, and so is a stage that has
    /// not ended in time.
    pub fn observe(&mut self, simulation: &Simulation, report: &StepReport) -> Vec<Alarm> {
        let crossing = simulation.crossing().map(|Crossing { grain, wall }| Trouble::Crossing { grain, wall });
        let passage = || simulation.passage().map(|Passage { grains }| Trouble::Passage { grains });
        let stage = || simulation.stage().map_or(0, |stage| stage.number);
        let overdue = || simulation.overdue().map(|condition| Trouble::Overdue { stage: stage(), condition });
        if let Some(trouble) = crossing.or_else(passage).or_else(overdue) {
            return vec![trouble.alarm(simulation, Reaction::Stop)];
        }
        if self.settings.every == 0 {
            return Vec::new();
        }
        let unit = residual_unit(&simulation.world, simulation.settings.step);
        let solved = report.solve.reason != StopReason::NoContacts;
        let residual = if solved { report.solve.residuals.rms() / unit } else { 0.0 };
        self.residual = Some(self.residual.map_or(residual, |least| least.min(residual)));
        if self.settings.on_energy != Reaction::Ignore {
            self.note_supply(simulation);
        }
        match simulation.steps.is_multiple_of(u64::from(self.settings.every)) {
            true => self.last(simulation),
            false => Vec::new(),
        }
    }

    /// Checks the state after the last step of a run, or at an interrupt, independent of the interval. A checked state is not
    /// checked again. Returns the violations, the most severe first.
    pub fn last(&mut self, simulation: &Simulation) -> Vec<Alarm> {
        let mut troubles = self.look(simulation);
        if self.settings.every > 0 && self.settings.on_stagnation != Reaction::Ignore {
            let alarm = |trouble: Trouble| trouble.alarm(simulation, self.settings.on_stagnation);
            troubles.extend(self.stagnation(simulation).map(alarm));
        }
        (self.residual, self.is_partial) = (None, false);
        troubles
    }

    /// Checks a measured state like [`Watchdog::last`], except for stagnation of solves, which is checked at the interval over
    /// all solves since.
    pub fn look(&mut self, simulation: &Simulation) -> Vec<Alarm> {
        let mut troubles = Vec::new();
        if self.settings.every == 0 || self.looked == Some(simulation.steps) {
            return troubles;
        }
        (self.looked, self.contacts) = (Some(simulation.steps), None);
        let mut note = |trouble: Option<Trouble>, reaction: Reaction| {
            let noted = trouble.filter(|_| reaction != Reaction::Ignore);
            troubles.extend(noted.map(|trouble| trouble.alarm(simulation, reaction)));
        };
        let lost = simulation.not_finite();
        note(lost.map(|grain| Trouble::NotFinite { grain }), Reaction::Stop);
        if lost.is_none() {
            note(self.escape(simulation), self.settings.on_escape);
            let contacts = simulation.contact_energy();
            note(self.gain(simulation, &contacts), self.settings.on_energy);
            let (overlap, reaction) = self.overlap(simulation, &contacts);
            note(overlap, reaction);
            self.contacts = Some(contacts);
        }
        troubles
    }

    /// Returns the mechanical energy like [`Simulation::energy`], J; reuses the energy of the contacts where this state was checked.
    pub fn energy(&self, simulation: &Simulation) -> Energy {
        let is_checked = self.looked == Some(simulation.steps) && self.interventions == simulation.interventions.count;
        let checked = self.contacts.filter(|_| is_checked);
        simulation.energy_with(&checked.unwrap_or_else(|| simulation.contact_energy()))
    }

    /// Observes a step like [`Watchdog::observe`], but returns only violations that end a run; also checks measured states and
    /// the last state.
    ///
    /// # Errors
    /// Returns the most severe violation that ends a run.
    pub fn check(&mut self, simulation: &Simulation, report: &StepReport, measured: bool) -> Result<(), Alarm> {
        let mut alarms = self.observe(simulation, report);
        if measured {
            alarms.extend(self.look(simulation));
        }
        for alarm in &alarms {
            if self.noticed.iter().all(|known| known.trouble.kind() != alarm.trouble.kind()) {
                self.noticed.push(*alarm);
            }
        }
        alarms.into_iter().find(|alarm| alarm.reaction == Reaction::Stop).map_or(Ok(()), Err)
    }

    /// First violation of each kind found by [`Watchdog::check`], including those that did not end the run.
    pub fn noticed(&self) -> &[Alarm] {
        &self.noticed
    }

    /// Adds the energy supplied by walls and by changing gravity in the last step.
    fn note_supply(&mut self, simulation: &Simulation) {
        let interventions = simulation.interventions.count;
        if simulation.steps != self.noted + 1 || interventions != self.interventions {
            (self.available, self.supplied) = (f64::INFINITY, 0.0);
        } else {
            let (world, h) = (&simulation.world, simulation.settings.step);
            let flowed = simulation.supplied_by_flow() - self.flowed;
            let walls_and_forces = simulation.work_of_walls() + simulation.interventions.work + flowed;
            self.supplied += walls_and_forces + work_of_changing_gravity(world, self.gravity, h);
        }
        (self.noted, self.gravity) = (simulation.steps, simulation.world.gravity);
        self.interventions = interventions;
        self.flowed = simulation.supplied_by_flow();
    }

    /// Returns the deepest overlap, if beyond a limit, and the reaction.
    fn overlap(&self, simulation: &Simulation, contacts: &ContactEnergy) -> (Option<Trouble>, Reaction) {
        let Watch { overlap: bound, on_overlap, on_deep_overlap, .. } = self.settings;
        let Some((share, grain)) = contacts.deepest.filter(|(share, _)| *share > bound) else {
            return (None, on_overlap);
        };
        let grain = simulation.world.roll.number(grain);
        let deep = bound.max(DEEP);
        if share > deep && on_deep_overlap != Reaction::Ignore {
            return (Some(Trouble::DeepOverlap { grain, share, bound: deep }), on_deep_overlap);
        }
        (Some(Trouble::Overlap { grain, share, bound }), on_overlap)
    }

    fn stagnation(&self, simulation: &Simulation) -> Option<Trouble> {
        let (bound, unit) = (self.settings.residual, residual_unit_name(simulation.world.field.largest()));
        let stagnates = self.residual.filter(|residual| *residual > bound && !self.is_partial);
        stagnates.map(|residual| Trouble::Stagnation { residual, bound, unit })
    }

    fn escape(&self, simulation: &Simulation) -> Option<Trouble> {
        let (low, high) = simulation.world.domain;
        let (id, place) = simulation.first_grain(|sphere, _| {
            let outside = |axis: usize| sphere.centre[axis] < low[axis] || sphere.centre[axis] > high[axis];
            (0..3).any(|axis| outside(axis) && !simulation.world.period.is_periodic(axis))
        })?;
        let position = simulation.world.spheres[place].centre.into();
        Some(Trouble::Escape { grain: simulation.world.roll.number(id), position })
    }

    /// Detects energy gain without a source.
    fn gain(&mut self, simulation: &Simulation, contacts: &ContactEnergy) -> Option<Trouble> {
        let world = &simulation.world;
        let energy = simulation.energy_of_grains();
        // Potential energy half a step earlier: a step without contacts does not change it.
        let (half, momentum) = (0.5 * simulation.settings.step, simulation.momentum());
        let mechanical = energy.kinetic
            + energy.potential
            + contacts.stored.cohesive
            + half * world.gravity.dot(&Vector3::from(momentum))
            - self.supplied;
        let mass: f64 = world.bodies[..world.grains()].iter().map(|body| 1.0 / body.inverse_mass).sum();
        let weight = world.field.largest() * mass;
        self.kinetic = self.kinetic.max(energy.kinetic);
        // Positions are known to half a step, and so is potential energy.
        let speeds = world.bodies[..world.grains()].iter().map(|body| Vector3::from(body.velocity).norm());
        let step = half * speeds.fold(0.0, f64::max);
        let scale = self.kinetic + weight * world.largest_and_mean_radius().1.max(step);
        // Beyond the range of numbers, an energy is infinite, or a difference of two infinite energies.
        let share = if mechanical.is_finite() { (mechanical - self.available) / scale } else { f64::INFINITY };
        let bound = self.settings.energy;
        let gained = share > bound;
        // Each gain is reported once.
        let present = mechanical + contacts.stored.elastic;
        self.available = if gained { present } else { self.available.min(present) };
        let fastest = || {
            let squares =
                world.bodies[..world.grains()].iter().map(|body| body.velocity.iter().map(|v| v * v).sum::<f64>());
            let place = squares.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(place, _)| place);
            world.ids.get(place).map_or(0, |&id| world.roll.number(id))
        };
        gained.then(|| Trouble::Energy { grain: fastest(), share, bound })
    }
}
