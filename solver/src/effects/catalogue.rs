//! All effects as data: how a scene calls for each, what it says of it, and what becomes of a scene without it.
//!
//! The descriptor of an effect stands in its own file, beside its law. Ranges of coefficients, the combination of two materials, the
//! effects that a simulation is compiled for, the list of `makadam effects`, its ablation, and what other codes refuse go by
//! [`CATALOGUE`]; `docs/effects.md` shows it as a table, which a test holds against it.

use super::EffectSet;
pub use super::cohesion::COHESION;
pub use super::compliance::{COMPLIANCE, VISCOSITY};
pub use super::drive::DRIVEN_WALLS;
pub use super::friction::{FRICTION, KINETIC_FRICTION, SPIN};
pub use super::gravity::{CHANGING_GRAVITY, GRAVITY};
pub use super::period::PERIODIC_AXES;
pub use super::resistance::{ROLLING, TWISTING};
pub use super::restitution::{FALLING_RESTITUTION, RESTITUTION};
pub use super::size_spread::SIZE_SPREAD;
pub use super::spring::TANGENTIAL_SPRING;
pub use super::vibration::WALL_MOTION;
use crate::scene::{Checked, ContactCoefficients, DocumentPath, Material, PairRule, Scene};

/// All effects, in the order in which a step meets them. A coefficient stands behind those that bound it.
pub static CATALOGUE: [&Effect; 17] = [
    &GRAVITY,
    &CHANGING_GRAVITY,
    &WALL_MOTION,
    &DRIVEN_WALLS,
    &SIZE_SPREAD,
    &PERIODIC_AXES,
    &COMPLIANCE,
    &VISCOSITY,
    &RESTITUTION,
    &FALLING_RESTITUTION,
    &FRICTION,
    &KINETIC_FRICTION,
    &TANGENTIAL_SPRING,
    &SPIN,
    &COHESION,
    &ROLLING,
    &TWISTING,
];

/// An effect.
#[derive(Debug)]
pub struct Effect {
    /// Its name in tables and messages.
    pub name: &'static str,
    /// Coefficients that materials and rules of pairs give; empty where a scene calls for it elsewhere.
    pub coefficients: &'static [Coefficient],
    /// Combination of two materials; absent where it has no coefficients.
    pub combination: Option<Combination>,
    /// Condition under which a scene has it.
    pub trigger: Trigger,
    /// Change that switches it off; absent where there is no such scene to compare with.
    pub off: Option<Change>,
    /// Change that switches it on for an ablation; absent where there is none.
    pub tried: Option<Change>,
    /// Member of [`EffectSet`]; absent where nothing is compiled, laid out or passed over for it.
    pub(crate) member: Option<fn(&mut EffectSet) -> &mut bool>,
}

/// A number that a material or a rule of a pair may give.
#[derive(Debug)]
pub struct Coefficient {
    /// Its key; behind a dot, in a table of its own.
    pub key: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Least and largest value.
    pub range: [f64; 2],
    /// Upper bound by another coefficient.
    pub ceiling: Option<Ceiling>,
    /// Value of a material that does not give it.
    pub absent: Absent,
    /// Value without effect, if there is one.
    pub off: Option<f64>,
    /// Value of a material.
    pub of_material: fn(&Material) -> Option<f64>,
    /// Value of a rule.
    pub of_rule: fn(&PairRule) -> Option<f64>,
}

/// Another coefficient that one must not exceed.
#[derive(Debug)]
pub struct Ceiling {
    /// Description.
    pub words: &'static str,
    /// That of a material.
    pub of_material: fn(&Material) -> f64,
    /// That of two materials.
    pub of_contact: fn(&ContactCoefficients) -> f64,
}

/// Value of a coefficient that a material does not give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// It must be given.
    Refused,
    /// This value.
    Value(f64),
    /// The value of another key.
    SameAs(&'static str),
    /// None: the effect is off.
    Off,
}

/// Rule by which the coefficients of a contact follow from two materials.
#[derive(Debug)]
pub struct Combination {
    /// The rule in words.
    pub words: &'static str,
    /// Enters what the contact has.
    pub combine: fn(&Meeting<'_>, &mut ContactCoefficients),
}

/// The rule of most coefficients: see [`Meeting::value`].
pub const SMALLER: &str = "a pair's own; else the wall's, or the smaller of two grains";

/// Two materials that meet.
#[derive(Clone, Copy, Debug)]
pub struct Meeting<'a> {
    /// The first one, of a grain.
    pub first: &'a Material,
    /// The second one.
    pub second: &'a Material,
    /// The scene's rule of the two.
    pub rule: Option<&'a PairRule>,
    /// True if the second one is a wall's.
    pub wall: bool,
}

/// Condition under which a scene has an effect.
#[derive(Debug)]
pub enum Trigger {
    /// By the coefficients of some contact.
    Contacts {
        /// Returns true if a contact has it.
        acts: fn(&ContactCoefficients) -> bool,
        /// Statement for scenes without it.
        without: &'static str,
    },
    /// By what it says elsewhere; an error is what is the case without it.
    Scene(fn(&Scene) -> Result<Call, &'static str>),
}

/// A scene's call for an effect.
#[derive(Clone)]
pub struct Call {
    /// Statement of the scene.
    pub why: String,
    /// Place in the document.
    pub place: DocumentPath,
}

/// A change of a scene.
#[derive(Debug)]
pub struct Change {
    /// The change in words.
    pub words: &'static str,
    /// Makes it.
    pub apply: fn(&mut Scene),
}

/// All coefficients that a material may give.
pub fn coefficients() -> impl Iterator<Item = &'static Coefficient> {
    CATALOGUE.iter().flat_map(|effect| effect.coefficients)
}

impl Change {
    /// A change that switches an effect off.
    pub(super) const fn off(apply: fn(&mut Scene)) -> Option<Change> {
        Some(Change { words: "off", apply })
    }
}

impl Effect {
    /// An effect of contacts, whose coefficients are combined by [`SMALLER`].
    pub(super) const fn of_contacts(
        name: &'static str,
        coefficients: &'static [Coefficient],
        combine: fn(&Meeting<'_>, &mut ContactCoefficients),
        acts: fn(&ContactCoefficients) -> bool,
        without: &'static str,
    ) -> Effect {
        let combination = Some(Combination { words: SMALLER, combine });
        let (off, tried, member) = (None, None, None);
        Effect { name, coefficients, combination, trigger: Trigger::Contacts { acts, without }, off, tried, member }
    }

    /// An effect without a coefficient.
    pub(super) const fn of_scene(name: &'static str, calls: fn(&Scene) -> Result<Call, &'static str>) -> Effect {
        let (off, tried, member) = (None, None, None);
        Effect { name, coefficients: &[], combination: None, trigger: Trigger::Scene(calls), off, tried, member }
    }

    /// Finds the statement of a scene that enables the effect.
    ///
    /// # Errors
    /// What is the case without it, where nothing does.
    pub fn called_by(&self, scene: &Scene) -> Result<Call, &'static str> {
        match &self.trigger {
            Trigger::Scene(calls) => calls(scene),
            Trigger::Contacts { acts, without } => match scene.possible_contacts().any(|contact| acts(&contact)) {
                true => Ok(self.first_that_says_so(scene, *acts)),
                false => Err(without),
            },
        }
    }

    /// The material, or else the rule, whose contacts have the effect.
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

    /// The coefficients that a table gives in words, and the place of the first.
    fn given(&self, at: &DocumentPath, of: impl Fn(&Coefficient) -> Option<f64>) -> Option<(String, DocumentPath)> {
        let given = || self.coefficients.iter().filter_map(|one| Some((one, of(one)?)));
        let words: Vec<String> = given().map(|(one, value)| format!("{} = {value}", one.key)).collect();
        given().next().map(|(first, _)| (words.join(", "), first.place(at)))
    }
}

impl Coefficient {
    /// A coefficient that every material has to give.
    pub(super) const fn new(
        key: &'static str,
        unit: &'static str,
        range: [f64; 2],
        of_material: fn(&Material) -> Option<f64>,
        of_rule: fn(&PairRule) -> Option<f64>,
    ) -> Coefficient {
        Coefficient { key, unit, range, ceiling: None, absent: Absent::Refused, off: None, of_material, of_rule }
    }

    /// Its place in the table of a material or a rule.
    pub(crate) fn place(&self, table: &DocumentPath) -> DocumentPath {
        self.key.split('.').fold(table.clone(), |place, key| place.key(key))
    }

    /// Refuses a value that a table gives out of its range; `ceiling` tells what bounds it besides.
    ///
    /// # Errors
    /// [`Fault`](crate::scene::Fault).
    pub(crate) fn check(&self, table: &DocumentPath, value: Option<f64>, ceiling: impl Fn(&Ceiling) -> f64) -> Checked {
        let ([least, most], Some(value)) = (self.range, value) else { return Ok(()) };
        let place = self.place(table);
        match &self.ceiling {
            Some(bound) => place.range(value, least, ceiling(bound), &format!("{}, {}", self.unit, bound.words)),
            None => place.range(value, least, most, self.unit),
        }
    }
}

impl Meeting<'_> {
    /// All coefficients of the contact.
    pub fn coefficients(&self) -> ContactCoefficients {
        let mut contact = ContactCoefficients::default();
        for combination in CATALOGUE.iter().filter_map(|effect| effect.combination.as_ref()) {
            (combination.combine)(self, &mut contact);
        }
        contact
    }

    /// The value of a rule; where it gives none, the wall's, or the smaller of those of two grains.
    pub fn value(&self, of_rule: fn(&PairRule) -> Option<f64>, of_material: fn(&Material) -> f64) -> f64 {
        self.rule.and_then(of_rule).unwrap_or_else(|| match self.wall {
            true => of_material(self.second),
            false => of_material(self.first).min(of_material(self.second)),
        })
    }
}

/// Changes all materials and all rules of a scene.
pub(super) fn change_coefficients(scene: &mut Scene, of_material: fn(&mut Material), of_rule: fn(&mut PairRule)) {
    scene.material.values_mut().for_each(of_material);
    scene.pair.iter_mut().for_each(of_rule);
}
