//! Effects of a scene: active ones, their costs, and the need for each.
//!
//! ```text
//! scene ─> called ────────────────────────────────> active effects with their lines
//!       ├> flowing state ─> costs, look ──────────> nanoseconds and bytes per contact, warnings
//!       └> each effect off or on, seeds ─> ablation > needed, not needed, undecided
//! ```

mod ablation;
mod cost;
mod look;
mod study;

pub use ablation::{Ablated, Ablation, Need, Plan};
pub use ablation::{Variation, variations};
pub use cost::Costs;
pub use look::{Called, Look, called, warnings};
pub use study::Study;
