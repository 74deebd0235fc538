//! Periodic axes, with the distances of [`laws::period`](crate::laws::period).

use super::catalogue::{Call, Change, Effect};
pub use crate::laws::period::Period;
use crate::scene::DocumentPath;

/// Periodic axes.
pub static PERIODIC_AXES: Effect = Effect {
    off: Some(Change { words: "off", apply: |scene| scene.domain.periodic.clear() }),
    ..Effect::of_scene("periodic axes", |scene| {
        let axes: Vec<&str> = scene.domain.periodic.iter().map(|axis| axis.name()).collect();
        match axes.is_empty() {
            true => Err("the domain ends on all sides"),
            false => {
                let place = DocumentPath::default().key("domain").key("periodic");
                Ok(Call { why: format!("domain.periodic = {}", axes.join(", ")), place })
            }
        }
    })
};
