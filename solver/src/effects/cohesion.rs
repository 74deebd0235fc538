//! Cohesion between two grains, or a grain and a wall, by the law of [`laws::cohesion`](crate::laws::cohesion).

use super::catalogue::{Change, Effect, change_coefficients};
pub use crate::laws::cohesion::{Cohesion, Pull};
use crate::scene::coefficients;

/// Cohesion.
pub static COHESION: Effect = Effect {
    off: Change::off(|scene| change_coefficients(scene, |one| one.cohesion = None, |rule| rule.cohesion = None)),
    member: Some(|set| &mut set.cohesion),
    ..Effect::of_contacts(
        "cohesion",
        coefficients::COHESION,
        |contact| contact.cohesion.is_some_and(|one| one.pull(1.0, 1.0).force > 0.0),
        "nothing pulls",
    )
};
