//! Materials and pair rules: keys, ranges, and the coefficients of a contact between two materials.
//!
//! A coefficient is a field of [`Material`], [`PairRule`] and [`ContactCoefficients`], and an entry of [`TABLE`] with
//! its range and the combination rule. The descriptor of each effect refers to its entry.

use super::document::{Checked, DocumentPath};
use crate::laws::cohesion::Cohesion;
use serde::{Deserialize, Serialize};

/// Material of grains or walls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Mass density, kg/m3.
    pub density: f64,
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Coulomb friction coefficient of a sliding contact, at most `friction`; default: `friction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kinetic_friction: Option<f64>,
    /// Impact speed up to which restitution is constant, m/s; above it, restitution falls as the fourth root. Default: constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution_speed: Option<f64>,
    /// Coefficient of rolling friction: largest torque over effective radius times normal force. The effective radius
    /// is `r_a r_b / (r_a + r_b)`, or the grain's radius at a wall.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub rolling_friction: f64,
    /// Coefficient of twisting friction, defined like `rolling_friction` for the torque along the normal.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub twisting_friction: f64,
    /// Cohesion with nearby grains and walls.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<Cohesion>,
}

impl Default for Material {
    /// Softened glass beads of a laboratory: 2500 kg/m3, Young's modulus 10 MPa, Poisson's ratio 0.3, friction 0.5 and
    /// restitution 0.3; no resistance to rolling or twisting, no cohesion.
    fn default() -> Material {
        Material {
            density: 2500.0,
            youngs_modulus: 1e7,
            poisson_ratio: 0.3,
            friction: 0.5,
            restitution: 0.3,
            kinetic_friction: None,
            restitution_speed: None,
            rolling_friction: 0.0,
            twisting_friction: 0.0,
            cohesion: None,
        }
    }
}

/// Coefficients of a pair of materials.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PairRule {
    /// Names of the two materials, in any order.
    pub between: [String; 2],
    /// Coulomb friction coefficient of the pair.
    pub friction: Option<f64>,
    /// Coefficient of restitution of the pair.
    pub restitution: Option<f64>,
    /// Coulomb friction coefficient of the sliding pair; default: `friction` of this rule.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kinetic_friction: Option<f64>,
    /// Impact speed up to which the restitution of the pair is constant, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution_speed: Option<f64>,
    /// Coefficient of rolling friction of the pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling_friction: Option<f64>,
    /// Coefficient of twisting friction of the pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twisting_friction: Option<f64>,
    /// Cohesion of the pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<Cohesion>,
}

/// Coefficients of a contact between two materials by the rules of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactCoefficients {
    /// Coulomb friction.
    pub friction: f64,
    /// Coulomb friction of the sliding contact, at most `friction`.
    pub kinetic_friction: f64,
    /// Restitution, 0 to 1.
    pub restitution: f64,
    /// Impact speed above which restitution falls, m/s; infinite if restitution is constant.
    pub restitution_speed: f64,
    /// Rolling friction, over the effective radius.
    pub rolling_friction: f64,
    /// Twisting friction, over the effective radius.
    pub twisting_friction: f64,
    /// Cohesion; two grains have it if both materials do, with the values of the weaker material.
    pub cohesion: Option<Cohesion>,
}

/// Numerical coefficient of a material or a pair rule.
#[derive(Debug)]
pub struct Coefficient {
    /// Key; after a dot, the key in a subtable.
    pub key: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Least and largest value.
    pub range: [f64; 2],
    /// Upper bound given by another coefficient.
    pub ceiling: Option<Ceiling>,
    /// Value of a material without this key.
    pub absent: Absent,
    /// Value without effect, if there is one.
    pub off: Option<f64>,
    /// Returns the value of a material.
    pub of_material: fn(&Material) -> Option<f64>,
    /// Returns the value of a pair rule.
    pub of_rule: fn(&PairRule) -> Option<f64>,
}

/// Upper bound of one coefficient by another.
#[derive(Debug)]
pub struct Ceiling {
    /// Description.
    pub words: &'static str,
    /// Returns the bound of a material.
    pub of_material: fn(&Material) -> f64,
    /// Returns the bound of a contact.
    pub of_contact: fn(&ContactCoefficients) -> f64,
}

/// Value of a coefficient that is absent from a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// Error: the coefficient is required.
    Refused,
    /// Default value.
    Value(f64),
    /// Value of another key.
    SameAs(&'static str),
    /// None: the effect is off.
    Off,
}

/// Rule that combines the coefficients of two materials into those of a contact.
#[derive(Debug)]
pub struct Combination {
    /// Description of the rule.
    pub words: &'static str,
    /// Writes the combined coefficients into those of the contact.
    pub combine: fn(&Meeting<'_>, &mut ContactCoefficients),
}

/// Combination rule of most coefficients: see [`Meeting::value`].
pub const SMALLER: &str = "a pair's own; else the wall's, or the smaller of two grains";

/// Two materials in contact.
#[derive(Clone, Copy, Debug)]
pub struct Meeting<'a> {
    /// First material, of a grain.
    pub first: &'a Material,
    /// Second material.
    pub second: &'a Material,
    /// Pair rule of the scene for the two materials.
    pub rule: Option<&'a PairRule>,
    /// True if the second material is that of a wall.
    pub wall: bool,
}

/// Coefficients of one effect, and their combination.
pub(crate) type Coefficients = (&'static [Coefficient], Combination);

/// All coefficients of materials; each entry follows the entries that bound it.
static TABLE: [Coefficients; 7] =
    [RESTITUTION, FALLING_RESTITUTION, FRICTION, KINETIC_FRICTION, COHESION, ROLLING, TWISTING];

/// Dimensionless coefficient with the combination rule [`SMALLER`]: its key, largest value, and the value of a material without the key.
macro_rules! smaller {
    ($key:ident, $largest:expr, $absent:expr) => {
        (
            &[Coefficient {
                absent: $absent,
                off: Some(0.0),
                ..Coefficient::new(
                    stringify!($key),
                    "(no unit)",
                    [0.0, $largest],
                    |one| Some(one.$key),
                    |rule| rule.$key,
                )
            }],
            Combination {
                words: SMALLER,
                combine: |pair, contact| contact.$key = pair.value(|rule| rule.$key, |one| one.$key),
            },
        )
    };
}

/// Restitution.
pub(crate) const RESTITUTION: Coefficients = smaller!(restitution, 1.0, Absent::Refused);
/// Coulomb friction.
pub(crate) const FRICTION: Coefficients = smaller!(friction, 1e9, Absent::Refused);
/// Resistance to rolling.
pub(crate) const ROLLING: Coefficients = smaller!(rolling_friction, 1e9, Absent::Value(0.0));
/// Resistance to twisting.
pub(crate) const TWISTING: Coefficients = smaller!(twisting_friction, 1e9, Absent::Value(0.0));

/// Restitution that decreases with the impact speed.
pub(crate) const FALLING_RESTITUTION: Coefficients = (
    &[Coefficient {
        absent: Absent::Off,
        ..Coefficient::new(
            "restitution_speed",
            "m/s",
            [1e-6, 1e6],
            |one| one.restitution_speed,
            |rule| rule.restitution_speed,
        )
    }],
    Combination {
        words: SMALLER,
        combine: |pair, contact| {
            let of_material = |one: &Material| one.restitution_speed.unwrap_or(f64::INFINITY);
            contact.restitution_speed = pair.value(|rule| rule.restitution_speed, of_material);
        },
    },
);

/// Friction that is smaller for a sliding contact.
pub(crate) const KINETIC_FRICTION: Coefficients = (
    &[Coefficient {
        ceiling: Some(Ceiling {
            words: "the friction of what sticks",
            of_material: |one| one.friction,
            of_contact: |contact| contact.friction,
        }),
        absent: Absent::SameAs("friction"),
        ..Coefficient::new(
            "kinetic_friction",
            "(no unit)",
            [0.0, 1e9],
            |one| one.kinetic_friction,
            |rule| rule.kinetic_friction,
        )
    }],
    Combination {
        words: "the same, a pair's own `friction` counting for it; no more than `friction`",
        combine: |pair, contact| {
            let of_rule = |rule: &PairRule| rule.kinetic_friction.or(rule.friction);
            let of_material = |one: &Material| one.kinetic_friction.unwrap_or(one.friction);
            contact.kinetic_friction = pair.value(of_rule, of_material).min(contact.friction);
        },
    },
);

/// Coefficient of [`Cohesion`]: its key, unit, largest value, index in [`numbers`], value of a material without the
/// key, and value without effect.
macro_rules! of_cohesion {
    ($key:literal, $unit:literal, $largest:expr, $place:literal, $absent:expr, $off:expr) => {
        Coefficient {
            absent: $absent,
            off: $off,
            ..Coefficient::new(
                $key,
                $unit,
                [0.0, $largest],
                |one| numbers(one.cohesion?)[$place],
                |rule| numbers(rule.cohesion?)[$place],
            )
        }
    };
}

/// Cohesion.
pub(crate) const COHESION: Coefficients = (
    &[
        of_cohesion!("cohesion.force", "N", 1e9, 0, Absent::Off, Some(0.0)),
        of_cohesion!("cohesion.range", "m", 1.0, 1, Absent::Value(0.0), None),
        of_cohesion!("cohesion.work", "J/m2", 1e6, 2, Absent::Off, Some(0.0)),
    ],
    Combination {
        words: "a pair's own; else the wall's, or, where both grains have one, the weaker",
        combine: |pair, contact| {
            let both = pair.first.cohesion.zip(pair.second.cohesion).map(|(one, other)| one.weaker(other));
            let of_materials = if pair.wall { pair.second.cohesion } else { both };
            contact.cohesion = pair.rule.and_then(|rule| rule.cohesion).or(of_materials);
        },
    },
);

/// Returns force, range and work of adhesion, each if present.
fn numbers(cohesion: Cohesion) -> [Option<f64>; 3] {
    match cohesion {
        Cohesion::Constant { force, range } => [Some(force), Some(range), None],
        Cohesion::SurfaceEnergy { work, range } => [None, range, Some(work)],
    }
}

/// Returns all coefficients of materials.
pub fn coefficients() -> impl Iterator<Item = &'static Coefficient> {
    TABLE.iter().flat_map(|(coefficients, _)| *coefficients)
}

impl Coefficient {
    /// Coefficient that every material must define.
    const fn new(
        key: &'static str,
        unit: &'static str,
        range: [f64; 2],
        of_material: fn(&Material) -> Option<f64>,
        of_rule: fn(&PairRule) -> Option<f64>,
    ) -> Coefficient {
        Coefficient { key, unit, range, ceiling: None, absent: Absent::Refused, off: None, of_material, of_rule }
    }

    /// Path of the coefficient in the table of a material or a pair rule.
    pub(crate) fn place(&self, table: &DocumentPath) -> DocumentPath {
        self.key.split('.').fold(table.clone(), |place, key| place.key(key))
    }

    /// Checks the value of a table against its range; `ceiling` returns the additional upper bound.
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
    /// Returns all coefficients of the contact.
    pub fn coefficients(&self) -> ContactCoefficients {
        let mut contact = ContactCoefficients::default();
        for (_, combination) in &TABLE {
            (combination.combine)(self, &mut contact);
        }
        contact
    }

    /// Returns the value of the pair rule; without one, that of the wall, or the smaller value of two grains.
    pub fn value(&self, of_rule: fn(&PairRule) -> Option<f64>, of_material: fn(&Material) -> f64) -> f64 {
        self.rule.and_then(of_rule).unwrap_or_else(|| match self.wall {
            true => of_material(self.second),
            false => of_material(self.first).min(of_material(self.second)),
        })
    }
}
