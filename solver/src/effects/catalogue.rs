//! Catalogue of all effects: the condition in a scene, the description, and the change of a scene that switches an effect off.
//!
//! The descriptor of an effect is in its own file, next to its law. The compilation of effects, `makadam effects`, its ablation
//! and the rejections of reference codes use [`CATALOGUE`]; a test compares it with the table of `docs/effects.md`.

use super::EffectSet;
pub use super::{
    CATALOGUE, CHANGING_GRAVITY, COHESION, COMPLIANCE, DRIVEN_WALLS, FALLING_RESTITUTION, FRICTION, GRAVITY, INFLOW,
    KINETIC_FRICTION, OUTFLOW, PERIODIC_AXES, RESTITUTION, ROLLING, SIZE_SPREAD, SPIN, TANGENTIAL_SPRING, TWISTING,
    VISCOSITY, WALL_MOTION,
};
use crate::scene::coefficients::Coefficients;
pub use crate::scene::coefficients::{Absent, Ceiling, Coefficient, Combination, Meeting, SMALLER, coefficients};
use crate::scene::{ContactCoefficients, DocumentPath, Material, PairRule, Scene};

/// Effect: its coefficients, its condition and its changes.
#[derive(Debug)]
pub struct Effect {
    /// Name in tables and messages.
    pub name: &'static str,
    /// Coefficients of materials and pair rules; empty if another part of a scene enables the effect.
    pub coefficients: &'static [Coefficient],
    /// Combination of two materials; absent for an effect without coefficients.
    pub combination: Option<Combination>,
    /// Condition under which a scene has the effect.
    pub trigger: Trigger,
    /// Change that switches the effect off; absent if no such scene exists for a comparison.
    pub off: Option<Change>,
    /// Change that switches the effect on for an ablation, if any.
    pub tried: Option<Change>,
    /// Member of [`EffectSet`]; absent if no kernel, memory layout or pass depends on the effect.
    pub(crate) member: Option<fn(&mut EffectSet) -> &mut bool>,
}

/// Condition under which a scene has an effect.
#[derive(Debug)]
pub enum Trigger {
    /// Coefficients of at least one contact.
    Contacts {
        /// Returns true if a contact has the effect.
        acts: fn(&ContactCoefficients) -> bool,
        /// Statement for scenes without it.
        without: &'static str,
    },
    /// Another part of the scene; the error describes the case without the effect.
    Scene(fn(&Scene) -> Result<Call, &'static str>),
}

/// Part of a scene that enables an effect.
#[derive(Clone)]
pub struct Call {
    /// Description of the part.
    pub why: String,
    /// Path in the document.
    pub place: DocumentPath,
}

/// Change of a scene.
#[derive(Debug)]
pub struct Change {
    /// Description of the change.
    pub words: &'static str,
    /// Applies the change.
    pub apply: fn(&mut Scene),
}

impl Change {
    /// Creates a change that switches an effect off.
    pub(super) const fn off(apply: fn(&mut Scene)) -> Option<Change> {
        Some(Change { words: "off", apply })
    }
}

impl Effect {
    /// Creates an effect of contacts.
    pub(super) const fn of_contacts(
        name: &'static str,
        (coefficients, combination): Coefficients,
        acts: fn(&ContactCoefficients) -> bool,
        without: &'static str,
    ) -> Effect {
        let (combination, trigger) = (Some(combination), Trigger::Contacts { acts, without });
        Effect { name, coefficients, combination, trigger, off: None, tried: None, member: None }
    }

    /// Creates an effect without a coefficient.
    pub(super) const fn of_scene(name: &'static str, calls: fn(&Scene) -> Result<Call, &'static str>) -> Effect {
        let (off, tried, member) = (None, None, None);
        Effect { name, coefficients: &[], combination: None, trigger: Trigger::Scene(calls), off, tried, member }
    }

    /// Finds the part of a scene that enables the effect.
    ///
    /// # Errors
    /// Description of the case without the effect.
    pub fn called_by(&self, scene: &Scene) -> Result<Call, &'static str> {
        match &self.trigger {
            Trigger::Scene(calls) => calls(scene),
            Trigger::Contacts { acts, without } => match scene.possible_contacts().any(|contact| acts(&contact)) {
                true => Ok(self.first_that_says_so(scene, *acts)),
                false => Err(without),
            },
        }
    }

    /// Returns the first material, or else the first pair rule, with contacts that have the effect.
    fn first_that_says_so(&self, scene: &Scene, acts: fn(&ContactCoefficients) -> bool) -> Call {
        let root = DocumentPath::default();
        let alone = |one| Meeting { first: one, second: one, rule: None, wall: true };
        let material = scene.material.iter().find(|(_, one)| acts(&alone(one).coefficients()));
        let of_material = material.map(|(name, one)| {
            let given = self.given(&root.key("material").name(name), |coefficient| (coefficient.of_material)(one));
            given.map(|(words, place)| Call { why: format!("material '{name}': {words}"), place })
        });
        let of_rule = || {
            scene.pair.iter().enumerate().find_map(|(index, rule)| {
                let [a, b] = &rule.between;
                let given = |coefficient: &Coefficient| (coefficient.of_rule)(rule);
                let (words, place) = self.given(&root.key("pair").index(index), given)?;
                let why = format!("pair '{a}', '{b}': {words}");
                acts(&scene.contact_coefficients(a, b, true)).then_some(Call { why, place })
            })
        };
        of_material.flatten().or_else(of_rule).unwrap_or_else(|| Call { why: String::new(), place: root })
    }

    /// Returns the coefficients of a table as text, and the path of the first one.
    fn given(&self, at: &DocumentPath, of: impl Fn(&Coefficient) -> Option<f64>) -> Option<(String, DocumentPath)> {
        let given = || self.coefficients.iter().filter_map(|one| Some((one, of(one)?)));
        let words: Vec<String> = given().map(|(one, value)| format!("{} = {value}", one.key)).collect();
        given().next().map(|(first, _)| (words.join(", "), first.place(at)))
    }
}

/// Changes all materials and all pair rules of a scene.
pub(super) fn change_coefficients(scene: &mut Scene, of_material: fn(&mut Material), of_rule: fn(&mut PairRule)) {
    scene.material.values_mut().for_each(of_material);
    scene.pair.iter_mut().for_each(of_rule);
}
