//! Elastic compliance and viscosity of contacts, by the law of [`laws::compliance`](crate::laws::compliance).

use super::catalogue::{Call, Change, Effect};
pub use crate::laws::compliance::{NormalConstraint, NormalContact, NormalLaw, NormalScheme, damping_ratio};
use crate::scene::DocumentPath;

/// Elastic compliance.
pub static COMPLIANCE: Effect = Effect {
    off: Some(Change { words: "off: rigid", apply: |scene| scene.solver.normal_law = NormalLaw::Rigid }),
    ..Effect::of_scene("elastic compliance", |scene| {
        let why = match scene.solver.normal_law {
            NormalLaw::Rigid => return Err("solver.normal_law is rigid"),
            NormalLaw::Linear { stiffness } => format!("linear, {stiffness} N/m"),
            NormalLaw::Hertz => {
                let modulus = scene.material.values().map(|one| one.youngs_modulus).fold(0.0, f64::max);
                format!("Hertz, stiffest material {modulus:e} Pa")
            }
        };
        Ok(Call { why, place: DocumentPath::default().key("solver").key("normal_law") })
    })
};

/// Viscosity: damping of resolved impacts.
pub static VISCOSITY: Effect = Effect::of_scene("contact viscosity", |scene| {
    if scene.solver.normal_law == NormalLaw::Rigid {
        return Err("rigid contacts have restitution alone");
    }
    let damped = scene.material.iter().find(|(_, one)| one.restitution < 1.0);
    let (name, one) = damped.ok_or("every restitution is 1")?;
    let why = format!("damps impacts that the step resolves to the restitution {} of '{name}'", one.restitution);
    Ok(Call { why, place: DocumentPath::default().key("material").name(name).key("restitution") })
});
