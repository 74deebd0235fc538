//! Materials and populations of grains, by the grain numbers of frames.

use super::MeasuredScene;
use makadam::snapshot::Snapshot;

/// Grains of a scene in the order of their numbers: listed grains, then population after population.
#[derive(Clone, Debug)]
pub struct Roster {
    /// Number of populations.
    populations: u32,
    /// Groups of identical grains, in the order of their numbers.
    pub groups: Vec<Alike>,
}

/// Grains of a scene that are identical except for their positions.
#[derive(Clone, Debug)]
pub struct Alike {
    /// Number of the first grain.
    pub first: u64,
    /// Number of grains.
    pub count: u64,
    /// Smallest and largest radius, m.
    pub radii: (f64, f64),
    /// Material and population.
    pub kind: Kind,
}

/// Material and population of a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kind {
    /// Number of the material, in the order of the scene's names.
    pub material: u8,
    /// Index of the population in the scene, or that of the source after all populations; absent for listed grains and for
    /// grains that a program inserted.
    pub population: Option<u32>,
}

impl Roster {
    /// Reads the grains of a checked scene.
    pub fn new(scene: &MeasuredScene) -> Roster {
        // In a checked scene all named materials exist.
        let number = |name: &str| scene.material.keys().position(|material| material == name).unwrap_or(0) as u8;
        let listed = scene.listed().map(|grain| (1, (grain.radius, grain.radius), &grain.material, None));
        let placed = (0..).zip(&scene.population).filter(|(_, population)| population.count > 0);
        let placed = placed.map(|(index, population)| {
            (population.count as u64, population.radius.bounds(), &population.material, Some(index))
        });
        let (mut groups, mut first) = (Vec::<Alike>::new(), 0);
        for (count, radii, material, population) in listed.chain(placed) {
            let kind = Kind { material: number(material), population };
            match groups.last_mut().filter(|last| population.is_none() && (last.radii, last.kind) == (radii, kind)) {
                Some(last) => last.count += count,
                None => groups.push(Alike { first, count, radii, kind }),
            }
            first += count;
        }
        Roster { populations: scene.population.len() as u32, groups }
    }

    /// Returns the material and population of a grain of a frame, by its id there.
    pub fn kind(&self, frame: &Snapshot, id: u32) -> Kind {
        let of_scene = |number| self.group(number).map(|group| group.kind);
        match frame.origins.get(id as usize) {
            None => of_scene(u64::from(id)).unwrap_or_default(),
            Some(origin) => {
                let of_source = origin.source.map(|source| self.populations + u32::from(source));
                let population = of_source.or_else(|| of_scene(origin.number).and_then(|kind| kind.population));
                Kind { material: origin.material, population }
            }
        }
    }

    /// Returns the group of a scene's grain, by its number; `None` if the scene has no grain of this number.
    pub fn group(&self, number: u64) -> Option<&Alike> {
        let after = self.groups.partition_point(|group| group.first <= number);
        self.groups[..after].last().filter(|group| number < group.first + group.count)
    }
}

/// Returns a number that is constant over the run, from a grain's id in a frame: its number in the scene, or one that no other grain of the run has.
pub fn lasting_number(frame: &Snapshot, id: u32) -> u64 {
    frame.origins.get(id as usize).map_or(u64::from(id), |origin| origin.number)
}
