//! Solver settings of a scene: one typed setting with one default for each choice.

use crate::lanes::InstructionSet;
use crate::laws::compliance::NormalLaw;
use serde::{Deserialize, Serialize};

/// Settings of the time step and of the contact solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SolverSettings {
    /// Time step, s; default from gravity, grain size and speeds (`docs/settings.md`). In code, 0 stands for the default.
    #[serde(skip_serializing_if = "crate::is_default")]
    pub step: f64,
    /// Stopping rule of a solve.
    pub stop: Stop,
    /// Solution method.
    #[serde(skip_serializing_if = "crate::is_default")]
    pub method: SolverMethod,
    /// Number of sweeps over each cached box per sweep over all boxes.
    pub inner_sweeps: u32,
    /// Over-relaxation factor of the sweeps; 1 within a solve with a growing residual. Methods without sweeps ignore it, and `inner_sweeps`.
    pub over_relaxation: f64,
    /// Precision of the sweeps; all other computations are in double precision. Single precision requires Gauss-Seidel.
    #[serde(skip_serializing_if = "crate::is_default")]
    pub precision: Precision,
    /// Law of the normal contact.
    pub normal_law: NormalLaw,
    /// Tangential law of the sticking contact.
    #[serde(skip_serializing_if = "crate::is_default")]
    pub tangential_law: TangentialLaw,
    /// Damping time of the stabilisation over the time step (tau / h).
    pub damping_steps: f64,
    /// Speed below which an unresolved impact is a contact at rest, m/s; default from gravity, step and grain size: see
    /// [`SolverSettings::slowest_impact`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution_threshold: Option<f64>,
    /// Smallest skin of the candidate list over the mean radius; a long step uses more: see [`SolverSettings::reach`].
    pub skin: f64,
    /// Fraction of the last step's impulses at the start of a solve.
    pub warm_start: f64,
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self {
            step: 0.0,
            stop: Stop::Sweeps { sweeps: 10 },
            method: SolverMethod::default(),
            inner_sweeps: 1,
            over_relaxation: 1.3,
            precision: Precision::Double,
            normal_law: NormalLaw::Hertz,
            tangential_law: TangentialLaw::Rigid,
            damping_steps: 1.0,
            restitution_threshold: None,
            skin: 0.6,
            warm_start: 1.0,
        }
    }
}

/// Tangential law of a sticking contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum TangentialLaw {
    /// No compliance.
    #[default]
    Rigid,
    /// Spring capped by Coulomb's law; requires a compliant normal contact, Gauss-Seidel and double precision.
    Spring {
        /// Ratio of the tangential to the normal stiffness; default: Mindlin's, from Poisson's ratios.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stiffness_ratio: Option<f64>,
    },
}

/// Optimal cutoff of a candidate list beyond contact for long steps, over the mean radius and the root of
/// `h sqrt(g/r)`: measured on drum and packing at 1 and 2 ms.
const REACH: f64 = 4.0;
/// Upper limit of the cutoff beyond contact for long steps, over the mean radius: longer steps were not measured.
const LONGEST_REACH: f64 = 1.5;

/// Ratio of the speed of the slowest impact to the velocity increment by gravity per step: a bounce of ten steps.
const SLOWEST_BOUNCE: f64 = 5.0;
/// Ratio of the speed of the slowest impact to `sqrt(g d)`: the speed after a free fall of 1/78 of a diameter.
const SHORTEST_FALL: f64 = 0.16;

impl SolverSettings {
    /// Returns the approach speed (m/s) above which a contact with an unresolved impact has restitution, for a mean
    /// radius (m) and gravity (m/s2).
    ///
    /// The speed is `restitution_threshold` if present, otherwise the larger of `5 g h` and `0.16 sqrt(g d)`. A bounce
    /// of fewer than ten steps is not resolved (`5 g h`), and grains in a bed at rest that settle by a hundredth of a
    /// diameter have such speeds (`0.16 sqrt(g d)`). Without gravity, no bed comes to rest, and the speed is 0.
    pub fn slowest_impact(&self, radius: f64, gravity: f64) -> f64 {
        let by_scales = (SLOWEST_BOUNCE * gravity * self.step).max(SHORTEST_FALL * (gravity * 2.0 * radius).sqrt());
        self.restitution_threshold.unwrap_or(by_scales)
    }

    /// Returns the cutoff of the candidate list beyond contact (m) for a mean radius (m) and gravity (m/s2).
    ///
    /// Neighbours separate at speeds of the order of `sqrt(g r)`. A list of cutoff `s` lives for about
    /// `s / (h sqrt(g r))` steps, and the number of candidates per step grows in proportion to `s`. The total work is
    /// least if `s` over the radius is proportional to the root of `h sqrt(g/r)`.
    pub fn reach(&self, radius: f64, gravity: f64) -> f64 {
        if radius <= 0.0 {
            return 0.0;
        }
        let long_step = REACH * (self.step * (gravity / radius).sqrt()).sqrt();
        self.skin.max(long_step.min(LONGEST_REACH)) * radius
    }
}

/// Precision of the sweeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// `f64`, eight contacts at a time.
    #[default]
    Double,
    /// `f32`, sixteen contacts at a time: velocities within a step have a relative error of 6e-8.
    Single,
}

/// Method for the contact problem of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum SolverMethod {
    /// Projected Gauss-Seidel.
    #[default]
    GaussSeidel,
    /// Gauss-Seidel with Anderson's acceleration.
    Anderson {
        /// Number of earlier iterations in the extrapolation.
        #[serde(default = "anderson_memory")]
        memory: u32,
    },
    /// Nonlinear conjugate gradients over Gauss-Seidel sweeps.
    NonlinearConjugateGradients,
    /// Accelerated projected gradients.
    AcceleratedProjectedGradients,
    /// Damped Jacobi, a historical baseline.
    Jacobi {
        /// Fraction of the correction of each contact that is applied.
        #[serde(default = "jacobi_damping")]
        damping: f64,
    },
    /// Projected conjugate gradients, a historical baseline.
    ProjectedConjugateGradients,
}

/// Largest number of iterations in the memory of Anderson's acceleration.
pub const MOST_MEMORY: usize = 8;

const fn anderson_memory() -> u32 {
    3
}

const fn jacobi_damping() -> f64 {
    0.3
}

impl SolverMethod {
    /// All methods, with their default parameters.
    pub const ALL: [SolverMethod; 6] = [
        SolverMethod::GaussSeidel,
        SolverMethod::Anderson { memory: anderson_memory() },
        SolverMethod::NonlinearConjugateGradients,
        SolverMethod::AcceleratedProjectedGradients,
        SolverMethod::Jacobi { damping: jacobi_damping() },
        SolverMethod::ProjectedConjugateGradients,
    ];

    /// Returns the name of the method in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            SolverMethod::GaussSeidel => "gauss-seidel",
            SolverMethod::Anderson { .. } => "anderson",
            SolverMethod::NonlinearConjugateGradients => "nonlinear-conjugate-gradients",
            SolverMethod::AcceleratedProjectedGradients => "accelerated-projected-gradients",
            SolverMethod::Jacobi { .. } => "jacobi",
            SolverMethod::ProjectedConjugateGradients => "projected-conjugate-gradients",
        }
    }
}

/// Stopping rule of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Stop {
    /// After a fixed number of sweeps.
    Sweeps {
        /// Number of sweeps.
        sweeps: u32,
    },
    /// When the root mean square residual is below a bound, or after `max_sweeps`.
    Residual {
        /// Bound, in units of `g h` (or m/s where there is no gravity).
        tolerance: f64,
        /// Largest number of sweeps.
        max_sweeps: u32,
    },
    /// When the wall time of a solve is spent, or after `max_sweeps`. Not reproducible bit for bit.
    TimeBudget {
        /// Wall time per solve, s.
        seconds: f64,
        /// Largest number of sweeps.
        max_sweeps: u32,
    },
}

impl Stop {
    /// Largest number of sweeps per solve.
    pub fn max_sweeps(&self) -> u32 {
        match *self {
            Stop::Sweeps { sweeps } => sweeps,
            Stop::Residual { max_sweeps, .. } | Stop::TimeBudget { max_sweeps, .. } => max_sweeps,
        }
    }
}

/// Reaction to a violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Reaction {
    /// The run ends and saves a checkpoint of an earlier step.
    Stop,
    /// The run continues with a warning.
    Warn,
    /// No reaction.
    Ignore,
}

impl Reaction {
    fn is_stop(&self) -> bool {
        *self == Reaction::Stop
    }
}

/// Watchdogs. Violations that invalidate a run end it unless the scene sets another reaction; a non-finite state or a
/// crossed wall always ends the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Watch {
    /// Steps between checks; 0: never.
    pub every: u32,
    /// Largest overlap of a contact over the smaller radius.
    pub overlap: f64,
    /// Reaction to an overlap above `overlap`.
    pub on_overlap: Reaction,
    /// Reaction to an overlap above the smaller radius and above `overlap`.
    #[serde(skip_serializing_if = "Reaction::is_stop")]
    pub on_deep_overlap: Reaction,
    /// Largest spurious gain of mechanical energy, over the largest kinetic energy so far plus the weight of the grains times their mean
    /// radius.
    pub energy: f64,
    /// Reaction to a gain above `energy`.
    pub on_energy: Reaction,
    /// Reaction to a grain outside the domain.
    pub on_escape: Reaction,
    /// Residual, in g h, that at least one solve between two checks must reach.
    pub residual: f64,
    /// Reaction to a residual above `residual`.
    pub on_stagnation: Reaction,
}

impl Default for Watch {
    fn default() -> Self {
        Self {
            every: 64,
            overlap: 0.5,
            on_overlap: Reaction::Warn,
            on_deep_overlap: Reaction::Stop,
            energy: 0.02,
            on_energy: Reaction::Stop,
            on_escape: Reaction::Stop,
            residual: 1.0,
            on_stagnation: Reaction::Warn,
        }
    }
}

/// Refusal of a setting; the simulation stays unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// The processor lacks an instruction set.
    #[error("this processor has no {}; it has {}", wanted.name(), names(available))]
    NoInstructionSet {
        /// Requested value.
        wanted: InstructionSet,
        /// Available value.
        available: Vec<InstructionSet>,
    },
    /// The method has no equations for a setting or effect of the scene.
    #[error("method {} does not go with {obstacle}; gauss-seidel does", method.name())]
    Method {
        /// Requested value.
        method: SolverMethod,
        /// Setting or effect that excludes the method.
        obstacle: Obstacle,
    },
    /// The system cannot start more threads.
    #[error("cannot start {threads} threads: {reason}")]
    NoThreads {
        /// Requested value.
        threads: usize,
        /// Message of the system.
        reason: String,
    },
    /// Single-precision sweeps have no equations for a setting or effect of the scene.
    #[error("single precision does not go with {0}; double precision does")]
    SinglePrecision(Obstacle),
    /// Only one rank can do this.
    #[error("several ranks do not go with {what}; leave it out, or start one rank")]
    Ranks {
        /// Setting.
        what: &'static str,
    },
}

/// Setting or effect that excludes a method or single precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Obstacle {
    /// Rolling or twisting friction of a material.
    #[error("contacts that bear torques against rolling or twisting")]
    Torques,
    /// Wall driven by a force or a torque.
    #[error("driven walls")]
    DrivenWalls,
    /// Tangential spring of sticking contacts.
    #[error("tangential springs")]
    TangentialSpring,
    /// Method other than Gauss-Seidel.
    #[error("methods other than gauss-seidel")]
    Method,
    /// Sweeps in single precision.
    #[error("single precision")]
    SinglePrecision,
}

impl Obstacle {
    /// Lists the settings and effects of a scene that require Gauss-Seidel in double precision.
    pub(crate) fn of_scene(torques: bool, driven_walls: bool, spring: bool) -> Option<Obstacle> {
        let torques = torques.then_some(Obstacle::Torques);
        torques.or(driven_walls.then_some(Obstacle::DrivenWalls)).or(spring.then_some(Obstacle::TangentialSpring))
    }
}

/// Checks that a method is compatible with a precision and with the effects of a scene. Gauss-Seidel is compatible with all.
/// Methods that combine states need double precision, and only double-precision sweeps solve for torques and dynamic walls.
pub(crate) fn method_goes_with(
    method: SolverMethod,
    precision: Precision,
    of_scene: impl FnOnce() -> Option<Obstacle>,
) -> Result<(), SettingError> {
    if method == SolverMethod::GaussSeidel {
        return Ok(());
    }
    let single = (precision == Precision::Single).then_some(Obstacle::SinglePrecision);
    of_scene().or(single).map_or(Ok(()), |obstacle| Err(SettingError::Method { method, obstacle }))
}

/// Checks that a precision is compatible with a method and with the effects of a scene, by the rule of [`method_goes_with`].
pub(crate) fn precision_goes_with(
    precision: Precision,
    method: SolverMethod,
    of_scene: impl FnOnce() -> Option<Obstacle>,
) -> Result<(), SettingError> {
    if precision == Precision::Double {
        return Ok(());
    }
    let other = (method != SolverMethod::GaussSeidel).then_some(Obstacle::Method);
    of_scene().or(other).map_or(Ok(()), |obstacle| Err(SettingError::SinglePrecision(obstacle)))
}

fn names(sets: &[InstructionSet]) -> String {
    sets.iter().map(|set| set.name()).collect::<Vec<_>>().join(", ")
}
