//! Materials and populations of grains, by the numbers that grains have in frames.

use super::Scene;
use makadam::snapshot::Snapshot;

/// Grains of a scene in the order of their numbers: listed grains, then population after population.
#[derive(Clone, Debug)]
pub struct Roster {
    /// First number of each run of grains of one kind.
    runs: Vec<(u64, Kind)>,
    /// Number of grains of the scene.
    count: u64,
}

/// Material and population of a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kind {
    /// Number of the material, in the order of the scene's names.
    pub material: u8,
    /// Place of the population in the scene; absent for grains that the scene lists and for inserted grains.
    pub population: Option<u32>,
}

impl Roster {
    /// Reads the grains of a checked scene.
    pub fn new(scene: &Scene) -> Roster {
        // A checked scene names no material that is not there.
        let number = |name: &str| scene.material.keys().position(|material| material == name).unwrap_or(0) as u8;
        let mut runs: Vec<(u64, Kind)> = Vec::new();
        let mut count = 0;
        for entry in &scene.grain {
            let kind = Kind { material: number(&entry.material), population: None };
            if runs.last().is_none_or(|last| last.1 != kind) {
                runs.push((count, kind));
            }
            count += 1;
        }
        for (place, population) in (0..).zip(&scene.population) {
            runs.push((count, Kind { material: number(&population.material), population: Some(place) }));
            count += population.count as u64;
        }
        Roster { runs, count }
    }

    /// Material and population of a grain of a frame, by its id there.
    pub fn kind(&self, frame: &Snapshot, id: u32) -> Kind {
        match frame.origins.get(id as usize) {
            None => self.of_scene(u64::from(id)),
            Some(origin) => {
                let population =
                    (origin.number < self.count).then(|| self.of_scene(origin.number).population).flatten();
                Kind { material: origin.material, population }
            }
        }
    }

    /// Material and population of a grain of the scene, by its number.
    fn of_scene(&self, number: u64) -> Kind {
        let after = self.runs.partition_point(|(first, _)| *first <= number);
        after.checked_sub(1).map_or_else(Kind::default, |run| self.runs[run].1)
    }

    /// Materials of the scene's grains; some more than once.
    pub fn materials(&self) -> impl Iterator<Item = usize> + '_ {
        self.runs.iter().map(|(_, kind)| usize::from(kind.material))
    }
}

/// Number that a grain of a frame keeps over the run, by its id there: its number in the scene, or one that no other grain of the run has.
pub fn lasting_number(frame: &Snapshot, id: u32) -> u64 {
    frame.origins.get(id as usize).map_or(u64::from(id), |origin| origin.number)
}
