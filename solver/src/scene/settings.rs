//! Solver settings of a scene: one typed setting with one default for each choice.

use crate::lanes::InstructionSet;
use crate::laws::compliance::NormalLaw;
use serde::{Deserialize, Serialize};

/// Settings of the time step and of the contact solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SolverSettings {
    /// Time step, s.
    pub step: f64,
    /// Stopping rule of a solve.
    pub stop: Stop,
    /// Solution method.
    #[serde(skip_serializing_if = "is_default")]
    pub method: SolverMethod,
    /// Sweeps over each box while it is in the cache, for each sweep over all boxes.
    pub inner_sweeps: u32,
    /// Over-relaxation factor of the sweeps; 1 within a solve whose residual grows. Methods without sweeps ignore it, and `inner_sweeps`.
    pub over_relaxation: f64,
    /// Precision of the sweeps; all else has double precision. Single requires Gauss-Seidel.
    #[serde(skip_serializing_if = "is_default")]
    pub precision: Precision,
    /// Law of the normal contact.
    pub normal_law: NormalLaw,
    /// Law of the sticking contact across its normal.
    #[serde(skip_serializing_if = "is_default")]
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
            step: 5e-4,
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

/// Law of a sticking contact across its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum TangentialLaw {
    /// No compliance.
    #[default]
    Rigid,
    /// Spring capped by Coulomb's law; requires a compliant normal contact, Gauss-Seidel and double precision.
    Spring {
        /// Stiffness over that of the normal contact; default: Mindlin's, from Poisson's ratios.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stiffness_ratio: Option<f64>,
    },
}

/// Reach of a list beyond contact that is best for long steps, over the mean radius and the root of `h sqrt(g/r)`: measured on drum
/// and packing at 1 and 2 ms.
const REACH: f64 = 4.0;
/// The most that is taken for long steps, over the mean radius: no longer step was measured.
const LONGEST_REACH: f64 = 1.5;

/// Speed of the slowest impact over what gravity gives in a step: its bounce lasts for ten steps.
const SLOWEST_BOUNCE: f64 = 5.0;
/// Speed of the slowest impact over `sqrt(g d)`: its grain has fallen by 1/78 of a diameter.
const SHORTEST_FALL: f64 = 0.16;

impl SolverSettings {
    /// Speed of approach (m/s) from which on a contact whose impact the step does not resolve has its restitution, for grains of a mean
    /// radius (m) under gravity (m/s2).
    ///
    /// It is `restitution_threshold`. If that is absent, it is the larger of `5 g h`, because a bounce of fewer than ten steps is none,
    /// and `0.16 sqrt(g d)`, because a bed at rest moves at such speeds while its grains settle by a hundredth of a diameter. Without
    /// gravity there is no rest to protect: it is 0.
    pub fn slowest_impact(&self, radius: f64, gravity: f64) -> f64 {
        let by_scales = (SLOWEST_BOUNCE * gravity * self.step).max(SHORTEST_FALL * (gravity * 2.0 * radius).sqrt());
        self.restitution_threshold.unwrap_or(by_scales)
    }

    /// Reach of the candidate list beyond contact, m, for grains of a mean radius (m) under gravity (m/s2).
    ///
    /// Neighbours part at speeds of the order of `sqrt(g r)`, so that a list of reach `s` lives for some `s / (h sqrt(g r))` steps,
    /// while each step looks at candidates in proportion to `s`. The least work of both together is where `s` over the radius goes as
    /// the root of `h sqrt(g/r)`.
    pub fn reach(&self, radius: f64, gravity: f64) -> f64 {
        if radius <= 0.0 {
            return 0.0;
        }
        let long_step = REACH * (self.step * (gravity / radius).sqrt()).sqrt();
        self.skin.max(long_step.min(LONGEST_REACH)) * radius
    }
}

/// Returns true for defaults, which written scenes leave out, so that these keep the hash that recorded results carry.
pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Precision of the sweeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// `f64`, eight contacts at a time.
    #[default]
    Double,
    /// `f32`, sixteen contacts at a time: velocities within a step are good to 6e-8 of themselves.
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
        /// Fraction of each contact's own correction.
        #[serde(default = "jacobi_damping")]
        damping: f64,
    },
    /// Projected conjugate gradients, a historical baseline.
    ProjectedConjugateGradients,
}

/// Most iterations that Anderson's acceleration can remember.
pub const MOST_MEMORY: usize = 8;

const ANDERSON_MEMORY: u32 = 3;
const JACOBI_DAMPING: f64 = 0.3;

fn anderson_memory() -> u32 {
    ANDERSON_MEMORY
}

fn jacobi_damping() -> f64 {
    JACOBI_DAMPING
}

impl SolverMethod {
    /// All of them, with their default parameters.
    pub const ALL: [SolverMethod; 6] = [
        SolverMethod::GaussSeidel,
        SolverMethod::Anderson { memory: ANDERSON_MEMORY },
        SolverMethod::NonlinearConjugateGradients,
        SolverMethod::AcceleratedProjectedGradients,
        SolverMethod::Jacobi { damping: JACOBI_DAMPING },
        SolverMethod::ProjectedConjugateGradients,
    ];

    /// Its name, as a scene says it.
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
        /// Most sweeps.
        max_sweeps: u32,
    },
    /// When the wall time of a solve is spent, or after `max_sweeps`. Not reproducible bit for bit.
    TimeBudget {
        /// Wall time per solve, s.
        seconds: f64,
        /// Most sweeps.
        max_sweeps: u32,
    },
}

impl Stop {
    /// Most sweeps that a solve may take.
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
    /// The run ends and leaves a checkpoint from before.
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

/// Watchdogs. Violations that invalidate a run end it unless the scene says otherwise; a state that is not finite, or a crossed wall,
/// always does.
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
    /// Residual, in g h, that some solve between two checks must reach.
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
    /// The scene has what the method has no equations for.
    #[error("method {} does not go with {obstacle}; gauss-seidel does", method.name())]
    Method {
        /// Requested value.
        method: SolverMethod,
        /// Setting that excludes it.
        obstacle: Obstacle,
    },
    /// The system gives no more threads.
    #[error("cannot start {threads} threads: {reason}")]
    NoThreads {
        /// Requested value.
        threads: usize,
        /// Message of the system.
        reason: String,
    },
    /// Sweeps in single precision know nothing of what the scene or the method has.
    #[error("single precision does not go with {0}; double precision does")]
    SinglePrecision(Obstacle),
}

/// Setting or effect that a method, or single precision, cannot be combined with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Obstacle {
    /// Some material has rolling or twisting friction.
    #[error("contacts that bear torques against rolling or twisting")]
    Torques,
    /// A force or a torque drives a wall.
    #[error("driven walls")]
    DrivenWalls,
    /// Contacts that stick have a tangential spring.
    #[error("tangential springs")]
    TangentialSpring,
    /// The solves go by another method.
    #[error("methods other than gauss-seidel")]
    Method,
    /// The sweeps are in single precision.
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

/// Checks that a method can be combined with a precision and with a scene's effects: Gauss-Seidel can with all. Methods that combine states
/// need them in double precision, and only sweeps in double precision relax torques and driven walls.
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

/// Checks that a precision can be combined with a method and with a scene's effects, by the same rule.
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
