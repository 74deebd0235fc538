//! Seeds of a judged code that are one and the same run: many of them would count as many, and tell no more than one.

use crate::compare::{Harvest, Simulated};
use crate::peers::CodeError;
use crate::plan::Scene;
use makadam::scene::populate;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// The runs of the judged code without those that are the same as one of an earlier seed, which are failures. Runs of other codes, and
/// of scenes that start from the same grains with each seed, are left as they are.
pub(super) fn without_same_runs(judged: &str, code: &'static str, scene: &Scene, simulated: Simulated) -> Simulated {
    if code != judged || code == "Makadam" {
        return simulated;
    }
    let Simulated { harvests, mut failures } = simulated;
    let mut kept: Vec<Harvest> = Vec::new();
    for harvest in harvests {
        let same = kept.iter().find(|known| is_same(known, &harvest)).map(|known| known.run.seed);
        match same.filter(|known| depends_on_seed(scene, [*known, harvest.run.seed])) {
            Some(known) => {
                failures.push((harvest.run.seed, CodeError::SameRun { code, seeds: [known, harvest.run.seed] }));
            }
            None => kept.push(harvest),
        }
    }
    Simulated { harvests: kept, failures }
}

/// Seeds of Makadam that are one and the same run, each with the earlier one: all that was measured of both is the same to the last bit.
/// The scenes of the tiers start from other grains with each seed.
pub(super) fn twins(harvests: &[Harvest]) -> Vec<[u64; 2]> {
    let values = |harvest: &Harvest| -> Vec<u64> {
        harvest.run.measurements.iter().map(|measured| measured.value.to_bits()).collect()
    };
    let mut known: BTreeMap<Vec<u64>, u64> = BTreeMap::new();
    let mut twins = Vec::new();
    for harvest in harvests.iter().filter(|harvest| !harvest.run.measurements.is_empty()) {
        match known.entry(values(harvest)) {
            Entry::Occupied(earlier) => twins.push([*earlier.get(), harvest.run.seed]),
            Entry::Vacant(place) => _ = place.insert(harvest.run.seed),
        }
    }
    twins
}

/// Whether two runs are one to the last bit: by where the grains are at the end, in whatever order. Measurements alone do not tell:
/// radii that a code does not leave are those of each seed, and some numbers are the same in any run, such as that of the grains that
/// have left a silo.
fn is_same(one: &Harvest, other: &Harvest) -> bool {
    let places = |harvest: &Harvest| -> Vec<[u64; 3]> {
        let all = harvest.final_state.iter().flat_map(|state| &state.particles);
        let mut places: Vec<[u64; 3]> = all.map(|particle| particle.position.map(f64::to_bits)).collect();
        places.sort_unstable();
        places
    };
    let found = places(one);
    !found.is_empty() && found == places(other)
}

/// Whether the grains start otherwise with one seed than with the other: from other places, or with other radii, motions or materials.
fn depends_on_seed(scene: &Scene, seeds: [u64; 2]) -> bool {
    let [one, other] = seeds.map(|seed| populate(scene, seed).ok());
    let (Some(one), Some(other)) = (one, other) else { return false };
    one != other
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::FinalState;
    use crate::observables::{ForcePool, Measurement};
    use crate::scenes::{find, load};
    use makadam::snapshot::Particle;

    fn harvest(seed: u64, heights: [f64; 2]) -> Harvest {
        let grain = |(id, height): (u32, f64)| Particle {
            id,
            position: [0.0, 0.0, height],
            radius: 0.005 + 1e-5 * seed as f64,
            velocity: [0.0; 3],
            spin: [0.0; 3],
        };
        let run = serde_json::json!({
            "code": "Own", "version": "1", "seed": seed, "time_step": 1e-3, "rayleigh_fraction": null,
            "wall_seconds": seed as f64, "simulated_seconds": 0.6, "processor": "", "date": "", "scene_hash": "",
        });
        let particles = (0..).zip(heights).map(grain).collect();
        Harvest {
            run: serde_json::from_value(run).unwrap(),
            forces: ForcePool::new("Own"),
            series: Vec::new(),
            final_state: Some(FinalState { code: "Own".into(), seed, time: 0.6, particles }),
            alarms: Vec::new(),
            lacks: Vec::new(),
            notes: Vec::new(),
        }
    }

    #[test]
    fn a_run_that_is_given_for_two_seeds_counts_once() {
        let scene = load(&find("packing-100", &[]).unwrap()).unwrap();
        let near = f64::from_bits(0.2_f64.to_bits() + 1);
        // The second is the first, the fourth too with its grains in another order; the third differs in the last bit.
        let heights = [[0.1, 0.2], [0.1, 0.2], [0.1, near], [0.2, 0.1]];
        let runs = || Simulated {
            harvests: (1..).zip(heights).map(|(seed, heights)| harvest(seed, heights)).collect(),
            failures: Vec::new(),
        };
        let seeds = |simulated: &Simulated| simulated.harvests.iter().map(|one| one.run.seed).collect::<Vec<_>>();
        let left = without_same_runs("Own", "Own", &scene, runs());
        assert_eq!(seeds(&left), [1, 3]);
        let failed: Vec<u64> = left.failures.iter().map(|(seed, _)| *seed).collect();
        assert_eq!(failed, [2, 4]);
        assert!(left.failures[1].1.to_string().contains("seeds 1 and 4 are one and the same run"));
        // Of codes that are not judged nothing is said, nor where each seed starts alike.
        assert_eq!(seeds(&without_same_runs("Own", "YADE", &scene, runs())).len(), 4);
        let mut listed = scene.clone();
        listed.population.clear();
        assert_eq!(seeds(&without_same_runs("Own", "Own", &listed, runs())).len(), 4);
    }

    #[test]
    fn seeds_of_makadam_that_are_one_run_are_found() {
        let measured = |seed: u64, value: f64| {
            let mut harvest = harvest(seed, [0.1, 0.2]);
            harvest.run.measurements = ["packing_fraction", "gini"]
                .map(|name| {
                    let value = if name == "gini" { 0.4 } else { value };
                    Measurement { observable: name.into(), unit: String::new(), value, standard_error: None, frames: 1 }
                })
                .into();
            harvest
        };
        let near = f64::from_bits(0.6_f64.to_bits() + 1);
        let runs: Vec<Harvest> =
            (1..).zip([0.6, near, 0.6, 0.61, near]).map(|(seed, value)| measured(seed, value)).collect();
        assert_eq!(twins(&runs), [[1, 3], [2, 5]]);
        assert!(twins(&[harvest(1, [0.1, 0.2]), harvest(2, [0.1, 0.2])]).is_empty(), "nothing was measured");
    }

    /// On a lattice without room to vary, seeds differ in radii or velocities alone.
    #[test]
    fn seeds_may_differ_in_more_than_places() {
        let mut scene = load(&find("packing-100", &[]).unwrap()).unwrap();
        scene.population.iter_mut().for_each(|population| population.spacing = 1.0);
        let [one, other] = [1, 2].map(|seed| populate(&scene, seed).unwrap());
        assert!(one.iter().zip(&other).all(|(one, other)| one.position == other.position), "places depend on the seed");
        let heights = [[0.1, 0.2]; 2];
        let harvests = (1..).zip(heights).map(|(seed, heights)| harvest(seed, heights)).collect();
        let left = without_same_runs("Own", "Own", &scene, Simulated { harvests, failures: Vec::new() });
        assert_eq!((left.harvests.len(), left.failures.len()), (1, 1));
    }
}
