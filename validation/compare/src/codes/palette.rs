//! Materials as the codes want them: numbered, those of grains apart from those of walls.

use makadam::scene::{ContactCoefficients, Grain};
use makadam_frames::plan::Scene;

/// The numbered materials of a scene. One that both grains and walls use appears twice, since friction and
/// restitution follow other rules at walls.
pub(super) struct Palette<'a> {
    scene: &'a Scene,
    entries: Vec<(&'a str, bool)>,
}

impl<'a> Palette<'a> {
    pub fn new(scene: &'a Scene, grains: &[Grain]) -> Palette<'a> {
        let mut entries = Vec::new();
        for name in scene.material.keys() {
            if grains.iter().any(|grain| grain.material == *name) {
                entries.push((name.as_str(), false));
            }
        }
        for name in scene.material.keys() {
            if scene.wall.iter().any(|wall| wall.material == *name) {
                entries.push((name.as_str(), true));
            }
        }
        Palette { scene, entries }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Every pair of entries that can touch, the first not behind the second.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize, ContactCoefficients)> + '_ {
        let pairs = (0..self.len()).flat_map(|a| (a..self.len()).map(move |b| (a, b)));
        pairs.filter_map(|(a, b)| self.coefficients(a, b).map(|coefficients| (a, b, coefficients)))
    }

    /// Returns true if an entry is a material of walls; these come last.
    pub fn is_wall(&self, entry: usize) -> bool {
        self.entries[entry].1
    }

    /// Place of a material, from 0.
    pub fn index(&self, material: &str, wall: bool) -> usize {
        self.entries.iter().position(|entry| *entry == (material, wall)).unwrap_or_default()
    }

    /// The materials in order.
    pub fn materials(&self) -> impl Iterator<Item = &'a makadam::scene::Material> + '_ {
        self.entries.iter().map(|(name, _)| &self.scene.material[*name])
    }

    /// Coefficients of two entries; `None` for two walls, which never touch.
    pub fn coefficients(&self, first: usize, second: usize) -> Option<ContactCoefficients> {
        let ((a, a_wall), (b, b_wall)) = (self.entries[first], self.entries[second]);
        match (a_wall, b_wall) {
            (true, true) => None,
            (true, false) => Some(self.scene.contact_coefficients(b, a, true)),
            (false, wall) => Some(self.scene.contact_coefficients(a, b, wall)),
        }
    }
}
