//! Makadam: granular matter by non-smooth contact dynamics.
pub mod scene;
pub mod snapshot;
