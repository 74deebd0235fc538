//! The frames of a run: written to one store as the run goes, read back by pictures, pages, measurements and exports.

mod folder;
mod frame;
mod store;

pub use crate::output::Walls;
pub use folder::rounded;
pub use folder::{RunFolderError, RunFrames};
pub use frame::{ContactLine, Grains, Kind, Quantity, RunFrame, unit_of};
pub use store::Store;
pub use store::{StoreMark, StoreWriter};
