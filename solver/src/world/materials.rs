//! Properties of pairs of materials, by material indices.

use crate::effects::EffectSet;
use crate::laws::cohesion::Pull;
use crate::laws::compliance::damping_ratio;
use crate::scene::{ContactCoefficients, Scene, TangentialLaw};
use std::ops::Deref;

/// Coefficients of a contact from its two materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMaterial {
    /// Coefficients by the rules of the scene.
    pub coefficients: ContactCoefficients,
    /// Damping ratio for this restitution.
    pub damping_ratio: f64,
    /// Effective modulus E*, Pa: `1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2` (Johnson, Contact Mechanics, 1985, 4.2).
    pub effective_modulus: f64,
    /// Ratio of tangential to normal stiffness, for a tangential spring.
    pub stiffness_ratio: f64,
}

impl Deref for ContactMaterial {
    type Target = ContactCoefficients;

    #[inline(always)]
    fn deref(&self) -> &ContactCoefficients {
        &self.coefficients
    }
}

impl ContactMaterial {
    /// Returns the cohesive force at an effective radius (m); zero without cohesion.
    pub fn pull(&self, effective_radius: f64) -> Pull {
        self.cohesion.map_or_else(Pull::default, |one| one.pull(effective_radius, self.effective_modulus))
    }
}

/// Contact properties of every pair of materials, for two grains and for a grain and a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialTable {
    names: Vec<String>,
    between_grains: Vec<ContactMaterial>,
    with_wall: Vec<ContactMaterial>,
    /// True if sticking contacts have a tangential spring.
    sprung: bool,
}

impl MaterialTable {
    pub(crate) fn new(scene: &Scene) -> MaterialTable {
        let names: Vec<String> = scene.material.keys().cloned().collect();
        let pairs = |wall: bool| {
            let mut table = Vec::with_capacity(names.len() * names.len());
            for first in &names {
                for second in &names {
                    let coefficients = scene.contact_coefficients(first, second, wall);
                    let softness = |name: &String| {
                        let material = &scene.material[name];
                        (1.0 - material.poisson_ratio * material.poisson_ratio) / material.youngs_modulus
                    };
                    let effective_modulus = 1.0 / (softness(first) + softness(second));
                    let damping_ratio = damping_ratio(coefficients.restitution);
                    let materials = [first, second].map(|name| &scene.material[name]);
                    let stiffness_ratio = scene.solver.tangential_law.stiffness_ratio(materials);
                    table.push(ContactMaterial { coefficients, damping_ratio, effective_modulus, stiffness_ratio });
                }
            }
            table
        };
        let sprung = scene.solver.tangential_law != TangentialLaw::Rigid;
        MaterialTable { between_grains: pairs(false), with_wall: pairs(true), names, sprung }
    }

    /// Returns the number of materials.
    pub(crate) fn materials(&self) -> usize {
        self.names.len()
    }

    /// Returns the index of a material, if the scene has the material.
    pub(crate) fn find(&self, name: &str) -> Option<u8> {
        self.names.iter().position(|known| known == name).map(|number| number as u8)
    }

    /// Returns the index of a material of a checked scene.
    ///
    /// # Panics
    /// Never for a checked scene.
    pub(super) fn number(&self, name: &str) -> u8 {
        let number = self.names.iter().position(|known| known == name);
        number.unwrap_or_else(|| panic!("the scene has no material '{name}', and was not checked")) as u8
    }

    /// Returns the properties of a contact between two grains.
    #[inline]
    pub fn between_grains(&self, first: u8, second: u8) -> &ContactMaterial {
        &self.between_grains[first as usize * self.names.len() + second as usize]
    }

    /// Returns the properties of contacts between grains, if they are the same for all.
    pub(crate) fn of_all_grains(&self) -> Option<&ContactMaterial> {
        let first = self.between_grains.first()?;
        self.between_grains.iter().all(|pair| pair == first).then_some(first)
    }

    /// Returns the properties of a contact between a grain and a wall.
    #[inline]
    pub fn with_wall(&self, grain: u8, wall: u8) -> &ContactMaterial {
        &self.with_wall[grain as usize * self.names.len() + wall as usize]
    }

    /// Returns the largest value of a property over the contacts of grains of some materials with each other and with
    /// walls of some materials; -inf without contacts.
    pub fn largest(&self, grains: &[u8], walls: &[u8], property: impl Fn(&ContactMaterial) -> f64) -> f64 {
        let of_grain = |&grain: &u8| {
            let others = grains.iter().map(move |&other| self.between_grains(grain, other));
            others.chain(walls.iter().map(move |&wall| self.with_wall(grain, wall)))
        };
        grains.iter().flat_map(of_grain).map(property).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the effects that at least one contact enables.
    pub fn effects(&self) -> EffectSet {
        let contacts = self.between_grains.iter().chain(&self.with_wall).map(|pair| &pair.coefficients);
        EffectSet::of(contacts).with_spring(self.sprung)
    }
}
