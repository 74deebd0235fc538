//! Which effects a scene calls for, and which of its lines says so.

use crate::plan::Scene;
use makadam::effects::CATALOGUE;
use serde::Serialize;

/// One effect: whether the scene calls for it, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Called {
    /// Its name.
    pub effect: &'static str,
    /// Whether it is simulated.
    pub on: bool,
    /// What the scene says, or what it does not.
    pub why: String,
    /// Line of the scene file, from 1; absent where the file leaves it to the default.
    pub line: Option<usize>,
}

/// All effects, in the order in which a step meets them. `text` is the scene file's.
pub fn called(scene: &Scene, text: &str) -> Vec<Called> {
    let called = CATALOGUE.iter().map(|effect| match effect.called_by(scene) {
        Ok(call) => Called { effect: effect.name, on: true, why: call.why, line: call.place.line(text) },
        Err(without) => Called { effect: effect.name, on: false, why: without.into(), line: None },
    });
    called.collect()
}
