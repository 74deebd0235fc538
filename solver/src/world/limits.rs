//! Bounds of sizes and materials over all grains that a run can have.

use super::World;
use crate::scene::{Scene, sphere_volume};

/// Sizes and materials of the grains of a scene in which grains come and go: of all its grains and sources, not of those present.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Smallest and largest radius, m.
    pub radii: (f64, f64),
    /// Mean radius, m.
    pub mean: f64,
    /// Largest inverse mass, 1/kg.
    pub inverse_mass: f64,
    /// Numbers of the materials.
    pub materials: Vec<u8>,
}

impl Limits {
    /// Returns the limits of a scene in which grains come or go; `None` for other scenes, whose grains are their limits.
    pub fn of(scene: &Scene, number: impl Fn(&str) -> u8) -> Option<Limits> {
        if !scene.flows() {
            return None;
        }
        let none =
            Limits { radii: (f64::INFINITY, 0.0), mean: scene.mean_radius(), inverse_mass: 0.0, materials: Vec::new() };
        let mut limits = scene.grain_kinds().fold(none, |mut limits, (material, (smallest, largest))| {
            limits.radii = (limits.radii.0.min(smallest), limits.radii.1.max(largest));
            let lightest = 1.0 / (scene.material[material].density * sphere_volume(smallest));
            limits.inverse_mass = limits.inverse_mass.max(lightest);
            limits.materials.push(number(material));
            limits
        });
        limits.materials.sort_unstable();
        limits.materials.dedup();
        Some(limits)
    }

    /// Returns the reason why a grain is outside the limits, if it is.
    pub fn refuse(&self, radius: f64, material: u8) -> Option<String> {
        let (smallest, largest) = self.radii;
        if radius < smallest || radius > largest {
            return Some(format!(
                "has a radius of {radius} m, and the grains of the scene are from {smallest} to {largest} m"
            ));
        }
        (!self.materials.contains(&material)).then(|| "is of a material that no grain of the scene has".into())
    }
}

impl World {
    /// Returns the smallest radius, m; infinite without grains.
    pub(crate) fn smallest_radius(&self) -> f64 {
        let present = || self.spheres[..self.grains()].iter().map(|sphere| sphere.radius).fold(f64::INFINITY, f64::min);
        self.limits.as_ref().map_or_else(present, |limits| limits.radii.0)
    }

    /// Returns the largest inverse mass, 1/kg.
    pub(super) fn largest_inverse_mass(&self) -> f64 {
        let present = || self.bodies[..self.grains()].iter().map(|body| body.inverse_mass).fold(0.0, f64::max);
        self.limits.as_ref().map_or_else(present, |limits| limits.inverse_mass)
    }

    /// Returns the numbers of the materials of the grains, ascending.
    pub(super) fn materials_of_grains(&self) -> Vec<u8> {
        if let Some(limits) = &self.limits {
            return limits.materials.clone();
        }
        let mut known = [false; 256];
        self.materials[..self.grains()].iter().for_each(|&material| known[usize::from(material)] = true);
        (0..=u8::MAX).filter(|&material| known[usize::from(material)]).collect()
    }
}
