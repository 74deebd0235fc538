//! The frames of a run, read back from its folder: grains, contacts and walls over time, whatever version of the program wrote them.

mod folder;
mod frame;
mod quantity;

pub(crate) use folder::rounded;
pub use folder::{RunFolderError, RunFrames};
pub use frame::{ContactLine, Grains, Repeats, RunFrame, Walls};
pub use quantity::{Quantity, unit_of};
