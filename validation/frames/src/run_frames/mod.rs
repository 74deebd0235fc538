//! Frames of a run: written to one store during the run, read back by pictures, pages, measurements and exports.

pub(crate) mod columns;
mod folder;
mod frame;
mod store;
mod walls;

pub use columns::Kind;
pub use folder::{RunFolderError, RunFrames, rounded};
pub use frame::{ContactLine, Grains, Quantity, RunFrame};
pub use store::{Store, StoreMark, StoreWriter};
pub use walls::Walls;
