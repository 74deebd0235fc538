//! Frames on disk: scenes with their measurements, runs and their provenance, the native frame store, exports, and readers of
//! the files of other programs.

pub mod execution;
pub mod export;
pub mod import;
pub mod interrupt;
pub mod neighbours;
pub mod output;
pub mod plan;
pub mod provenance;
pub mod recording;
pub mod run_frames;
pub mod stepping;
