//! Which effects a scene calls for, what each costs, and whether it matters.
//!
//! ```text
//! scene ─> called ────────────────────────────────> which are on, by which line
//!       ├> flowing state ─> costs, look ──────────> nanoseconds and bytes a contact, what the numbers warn of
//!       └> each effect off or on, seeds ─> ablation > needed, not needed, undecided
//! ```

mod ablation;
mod cost;
mod look;
mod study;

pub use ablation::{Ablated, Ablation, Need, Plan, Variation, variations};
pub use cost::{Cost, Costs};
pub use look::{Called, Look, called, warnings};
pub use study::{Study, table};
