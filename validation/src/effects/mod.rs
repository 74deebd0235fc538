//! Which effects a scene calls for, what each costs, and whether it matters.
//!
//! ```text
//! scene ─> called ────────────────────────────────> which are on, by which line
//!       ├> flowing state ─> costs, look ──────────> nanoseconds and bytes a contact, what the numbers warn of
//!       └> each effect off or on, seeds ─> ablation > needed, not needed, undecided
//! ```

mod ablation;
mod called;
mod cost;
mod look;
mod markdown;
mod study;
mod terminal;
mod variations;

pub use ablation::{Ablated, Ablation, Need, Plan};
pub use called::{Called, called};
pub use cost::{Cost, Costs};
pub use look::{Look, warnings};
pub use markdown::markdown;
pub use study::Study;
pub use terminal::table;
pub use variations::{Variation, variations};
