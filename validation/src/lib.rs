//! Command `makadam`, on top of the libraries below.
//!
//! ```text
//! solver -> frames -> measure -> compare -> studies -> qualification -> command
//!                 \-> view ---/
//! ```

pub mod commands;
mod forecast;
pub mod templates;

/// Sets the commit of this build for the provenance of results; programs call this function at their start.
pub fn state_commit() {
    makadam_frames::provenance::set_commit(env!("MAKADAM_COMMIT"), env!("MAKADAM_DIRTY").parse().ok());
}
