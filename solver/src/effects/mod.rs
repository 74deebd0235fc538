//! The effects that a scene can call for, one small file each, with the equations and their source.
//!
//! The functions here are the only places where a contact law is written down; `constrain` calls them once a contact
//! and step, and the sweep kernel is compiled with those that the scene calls for.

pub mod compliance;
pub mod friction;
pub mod restitution;
