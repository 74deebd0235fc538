//! The hard cases, group by group.
//!
//! Each case says what is right and why. Bounds come from closed forms, conservation laws or what the wall of a container is
//! for, never from what a code happened to give.

mod contacts;
mod drums;
mod impacts;
mod loads;
mod starts;

use super::Case;

/// All cases, in the order in which they are shown.
pub fn catalogue() -> Vec<Case> {
    [loads::cases(), starts::cases(), impacts::cases(), contacts::cases(), drums::cases()]
        .into_iter()
        .flatten()
        .collect()
}

#[cfg(test)]
#[path = "../../../tests/unit/stability_catalogue.rs"]
mod tests;
