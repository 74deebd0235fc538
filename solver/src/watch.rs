//! Watchdogs: what goes wrong without a word elsewhere is named here, with the grain, the step and the time.

use crate::Simulation;
use crate::energy::ContactEnergy;
use crate::scene::{Reaction, Watch};
use crate::simulation::StepReport;
use crate::solve::{StopReason, residual_unit};
use nalgebra::Vector3;
use std::fmt;

/// What was noticed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// A grain's position, velocity or spin is not finite.
    NotFinite {
        /// Its id.
        grain: u32,
    },
    /// A grain overlaps its partner too far.
    Overlap {
        /// Its id.
        grain: u32,
        /// Overlap over the smaller radius.
        share: f64,
        /// What is tolerated.
        bound: f64,
    },
    /// Mechanical energy came from nowhere.
    Energy {
        /// Id of the fastest grain.
        grain: u32,
        /// Gain over the scale of [`Watch::energy`].
        share: f64,
        /// What is tolerated.
        bound: f64,
    },
    /// A grain has left the domain.
    Escape {
        /// Its id.
        grain: u32,
        /// Where it is, m.
        position: [f64; 3],
    },
    /// No solve since the last look has come close to a solution.
    Stagnation {
        /// Smallest residual since then, in units of g h.
        residual: f64,
        /// What is tolerated.
        bound: f64,
    },
}

impl Trouble {
    /// Its kind, in a word.
    pub fn kind(&self) -> &'static str {
        match self {
            Trouble::NotFinite { .. } => "not finite",
            Trouble::Overlap { .. } => "overlap",
            Trouble::Energy { .. } => "energy",
            Trouble::Escape { .. } => "escape",
            Trouble::Stagnation { .. } => "stagnation",
        }
    }
}

/// Something that was noticed, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alarm {
    /// What.
    pub trouble: Trouble,
    /// What the scene wants done.
    pub reaction: Reaction,
    /// Steps taken.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
}

impl fmt::Display for Alarm {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.trouble {
            Trouble::NotFinite { grain } => {
                write!(out, "grain {grain} has no finite position or velocity: the scene diverged; lower solver.step")
            }
            Trouble::Overlap { grain, share, bound } => write!(
                out,
                "grain {grain} overlaps its partner by {share:.3} of the smaller radius, more than {bound}; lower solver.step, \
                 raise youngs_modulus or the sweeps of solver.stop"
            ),
            Trouble::Energy { grain, share, bound } => write!(
                out,
                "mechanical energy grew by {share:.3} of its scale, more than {bound}, with grain {grain} the fastest; lower \
                 solver.step, or look for grains that start inside each other"
            ),
            Trouble::Escape { grain, position: [x, y, z] } => write!(
                out,
                "grain {grain} left the domain at ({x:.4}, {y:.4}, {z:.4}) m; enlarge the domain, close the walls or lower solver.step"
            ),
            Trouble::Stagnation { residual, bound } => write!(
                out,
                "no solve since the last look came below a residual of {residual:.2} g h, more than {bound}; raise the sweeps of \
                 solver.stop or lower solver.step"
            ),
        }?;
        write!(out, " (step {}, {:.6} s)", self.step, self.time)
    }
}

/// Looks at a simulation every so many steps.
#[derive(Clone, Debug)]
pub struct Watchdog {
    settings: Watch,
    /// Whether mechanical energy cannot come from walls.
    closed: bool,
    /// Time of the last look, s.
    looked_at: f64,
    /// Smallest mechanical energy so far, J: no later state may have more, its elastic energy left out.
    available: f64,
    /// Largest kinetic energy so far, J.
    kinetic: f64,
    /// Smallest residual since the last look, in units of g h.
    residual: f64,
}

impl Watchdog {
    /// A watchdog that has seen nothing yet.
    pub fn new(settings: &Watch, simulation: &Simulation) -> Watchdog {
        Watchdog {
            settings: settings.clone(),
            closed: !simulation.world.surfaces.iter().any(|surface| surface.moves()),
            looked_at: simulation.world.time,
            available: f64::INFINITY,
            kinetic: 0.0,
            residual: f64::INFINITY,
        }
    }

    /// Takes note of a step; looks at the state where it is time to. What was noticed comes back, the gravest first.
    ///
    /// Between looks it allocates nothing, and a look no more than a pose a wall.
    pub fn observe(&mut self, simulation: &Simulation, report: &StepReport) -> Vec<Alarm> {
        let mut troubles = Vec::new();
        if self.settings.every == 0 {
            return troubles;
        }
        let unit = residual_unit(&simulation.world, simulation.settings.step);
        let solved = report.solve.reason != StopReason::NoContacts;
        self.residual = self.residual.min(if solved { report.solve.residuals.rms() / unit } else { 0.0 });
        if !simulation.steps.is_multiple_of(u64::from(self.settings.every)) {
            return troubles;
        }
        let mut note = |trouble: Option<Trouble>, reaction: Reaction| {
            if let Some(trouble) = trouble.filter(|_| reaction != Reaction::Ignore) {
                troubles.push(Alarm { trouble, reaction, step: simulation.steps, time: simulation.world.time });
            }
        };
        let lost = simulation.not_finite();
        note(lost.map(|grain| Trouble::NotFinite { grain }), Reaction::Stop);
        if lost.is_none() {
            note(self.escape(simulation), self.settings.on_escape);
            let [overlap, energy] = self.overlap_and_energy(simulation);
            note(overlap, self.settings.on_overlap);
            note(energy, self.settings.on_energy);
            note(self.stagnation(), self.settings.on_stagnation);
        }
        self.residual = f64::INFINITY;
        troubles
    }

    fn stagnation(&self) -> Option<Trouble> {
        let bound = self.settings.residual;
        (self.residual > bound).then_some(Trouble::Stagnation { residual: self.residual, bound })
    }

    fn escape(&self, simulation: &Simulation) -> Option<Trouble> {
        let (low, high) = simulation.world.domain;
        let outside = simulation.first_grain(|sphere, _| {
            let outside = |axis: usize| sphere.centre[axis] < low[axis] || sphere.centre[axis] > high[axis];
            (0..3).any(|axis| outside(axis) && !simulation.world.period.is_periodic(axis))
        })?;
        let position = simulation.world.spheres[simulation.places_by_id()[outside as usize] as usize].centre.into();
        Some(Trouble::Escape { grain: outside, position })
    }

    /// The deepest overlap and the gain of energy, from one pass over the contacts.
    fn overlap_and_energy(&mut self, simulation: &Simulation) -> [Option<Trouble>; 2] {
        let bound = self.settings.overlap;
        let ContactEnergy { elastic, cohesive, deepest } = simulation.contact_energy();
        let overlap =
            deepest.filter(|(share, _)| *share > bound).map(|(share, grain)| Trouble::Overlap { grain, share, bound });
        let world = &simulation.world;
        let energy = simulation.energy_of_grains();
        // Potential energy where the grains are half a step earlier: then a step without contacts changes nothing.
        let (half, momentum) = (0.5 * simulation.settings.step, simulation.momentum());
        let mechanical =
            energy.kinetic + energy.potential + cohesive + half * world.gravity.dot(&Vector3::from(momentum));
        let mass: f64 = world.bodies[..world.grains()].iter().map(|body| 1.0 / body.inverse_mass).sum();
        let weight = world.field.largest() * mass;
        self.kinetic = self.kinetic.max(energy.kinetic);
        let scale = self.kinetic + weight * world.largest_and_mean_radius().1;
        let (share, bound) = ((mechanical - self.available) / scale, self.settings.energy);
        // Gravity that changes gives energy, and takes it.
        let steady = world.field.is_constant(self.looked_at, world.time);
        self.looked_at = world.time;
        let gained = self.closed && steady && share > bound;
        // What was said is not said again.
        let present = mechanical + elastic;
        self.available = if gained || !steady { present } else { self.available.min(present) };
        let fastest = || {
            let squares =
                world.bodies[..world.grains()].iter().map(|body| body.velocity.iter().map(|v| v * v).sum::<f64>());
            let place = squares.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(place, _)| place);
            world.ids.get(place).copied().unwrap_or(0)
        };
        [overlap, gained.then(|| Trouble::Energy { grain: fastest(), share, bound })]
    }
}
