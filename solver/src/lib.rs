//! Makadam: granular matter by non-smooth contact dynamics, solved by projected Gauss-Seidel.
//!
//! ```
//! use makadam::{Face, Material, Population, RadiusDistribution, Region, Scene, Shape, Simulation, Wall};
//!
//! # fn main() -> Result<(), makadam::Error> {
//! let [min, max] = [[0.0; 3], [0.08, 0.08, 0.2]];
//! let scene = Scene::builder()
//!     .material("glass", Material { friction: 0.4, ..Material::default() })
//!     .wall(Wall::new("box", "glass", Shape::cuboid(min, max, &[Face::Top])))
//!     .population(Population::new(300, "glass", RadiusDistribution::uniform(0.005, 0.05), Region::cuboid(min, max)))
//!     .build()?; // checked by the rules for scenes from files
//! let mut simulation = Simulation::builder(&scene).seed(1).threads(2).time_step(5e-4).build()?;
//! while simulation.time() < 0.5 {
//!     simulation.step();
//! }
//! let frame = simulation.frame(); // arrays by grain: positions(), velocities(), radii()
//! let highest = frame.positions().iter().map(|position| position[2]).fold(0.0, f64::max);
//! println!("{:.2} contacts per grain below {highest:.3} m", frame.coordination_number());
//! # assert!(frame.coordination_number() > 3.0 && highest < 0.1, "{} {highest}", frame.coordination_number());
//! let continued = Simulation::resume(&scene, &simulation.checkpoint())?;
//! assert_eq!(continued.state_hash(), simulation.state_hash());
//! # Ok(())
//! # }
//! ```
//!
//! A scene comes from code, as here, or from a file ([`Scene::load`]); [`Simulation`] steps it; [`Frame`] and
//! [`Snapshot`] contain results; [`watch`] detects invalid runs; [`Error`] covers all errors. Contact laws are in
//! [`effects`], walls in [`wall`], solution methods in [`methods`].
//!
//! ```text
//! scene.toml, builder -- scene --> world (grains, walls, materials, clock)
//!                                    v
//!    +------------------- step (simulation) --------------------+
//!    | detect ----> constrain ----> solve ----> move            | --> Frame, Snapshot, StepReport
//!    |    \            /               \                        |
//!    |     partition                    methods, sweep          |      order of contacts, write access
//!    |     schedule                                             |      assignment of tasks to threads
//!    +----------------------------------------------------------+
//! ```
//!
//! Each module imports only from modules to its left and below it; `ARCHITECTURE.md` lists all modules, and
//! [`docs/method.md`](method) describes the method: equations, stages, write access.
//!
//! **Same bits.** A scene and a seed give the same bits on any number of threads, with any scheduler and on any instruction set.
//! Boxes, stages and lane groups depend on the scene alone, and the lane width of eight is a part of the algorithm. Every lane
//! has the same IEEE operations, without fused multiply-add and without approximate division or roots.

/// Setters of a builder: name, value, and assignment of each setter.
macro_rules! setters {
    ($($(#[$about:meta])* $name:ident($value:ident: $kind:ty) |$builder:ident| $set:expr;)*) => {
        $($(#[$about])*
        pub fn $name(self, $value: $kind) -> Self {
            let mut $builder = self;
            $set;
            $builder
        })*
    };
}
pub(crate) use setters;

/// Getters: visibility, name, type and value of each.
macro_rules! getters {
    ($($(#[$about:meta])* $visibility:vis $name:ident: $kind:ty = |$own:ident| $value:expr;)*) => {
        $($(#[$about])*
        $visibility fn $name(&self) -> $kind {
            let $own = self;
            $value
        })*
    };
}
pub(crate) use getters;

/// Returns true for a default. Written scenes and results omit defaults, so that the hash of a scene agrees with the hash of stored results.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[doc(hidden)]
pub mod constrain;
mod contact;
mod convergence;
#[doc(hidden)]
pub mod detect;
#[doc(hidden)]
pub mod direct;
pub mod effects;
mod error;
mod execution;
#[doc(hidden)]
pub mod groups;
pub mod interrupt;
#[doc(hidden)]
pub mod lanes;
pub mod laws;
pub mod messages;
#[cfg(doc)]
#[doc = include_str!("../docs/method.md")]
pub mod method {}
pub mod methods;
#[doc(hidden)]
pub mod partition;
#[doc(hidden)]
pub mod probe;
pub mod problem;
pub mod scene;
#[doc(hidden)]
pub mod schedule;
mod simulation;
pub mod snapshot;
#[doc(hidden)]
pub mod solve;
pub mod surface;
#[doc(hidden)]
pub mod sweep;
pub mod wall;
pub mod watch;
#[doc(hidden)]
pub mod world;

pub use convergence::{ConvergencePoint, SolutionError};
pub use effects::EffectSet;
pub use error::Error;
pub use execution::{Execution, SimulationBuilder};

pub use interrupt::Interrupt;
pub use lanes::InstructionSet;
pub use partition::Portion;
pub use scene::{
    Axis, Cohesion, Domain, Face, Gauge, GrainEntry, Insertion, Material, Motion, NormalLaw, PairRule, Population,
    Precision, RadiusDistribution, Region, Removal, Scene, SceneBuilder, SceneError, SceneFileError, Shape,
    SolverMethod, SolverSettings, Stage, StageEnd, Stop, Wall,
};
pub use scene::{Obstacle, SettingError};
pub use schedule::{Scheduler, StepTrace};
#[doc(hidden)]
pub use simulation::checkpoint::KeptContact;
pub use simulation::energy::Energy;
pub use simulation::flow::{FlowReport, Passed};
pub use simulation::gauge::Passages;
#[doc(hidden)]
pub use simulation::intervention::PairsInList;
pub use simulation::intervention::{InterventionError, States};
pub use simulation::ledger::Balance;
pub use simulation::ranks::{dismiss, follow};
pub use simulation::stages::{PresentStage, StageReport};
pub use simulation::swept::{Crossing, Passage};
pub use simulation::wall_record::{FaceWear, WallLoad};
pub use simulation::{PhaseSeconds, Simulation, StepReport, checkpoint};
pub use snapshot::{Contact, Frame, Partner, Snapshot};
pub use solve::{NotConverged, SolveReport, StopReason};
pub use sweep::{Residual, Residuals};

/// Identifier of this build among all builds with possibly different bits: the version and, after a dash, 16 hexadecimal digits
/// of a hash over the sources of the solver and the numerical packages. All builds of the same sources have the same identifier
/// and give the same bits; stored states and results that a run can resume from contain this identifier.
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), "-", env!("MAKADAM_BUILD_KEY"));
