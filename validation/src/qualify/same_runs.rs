//! Seeds of a judged code that are one and the same run: many of them would count as many, and tell no more than one.

use crate::compare::{Harvest, Simulated};
use crate::peers::CodeError;
use crate::plan::Scene;
use makadam::scene::{Grain, populate};
use makadam::snapshot::Particle;
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
        let same = kept.iter().find(|known| is_given_twice(scene, [known, &harvest])).map(|known| known.run.seed);
        match same {
            Some(known) => {
                failures.push((harvest.run.seed, CodeError::SameRun { code, seeds: [known, harvest.run.seed] }));
            }
            None => kept.push(harvest),
        }
    }
    Simulated { harvests: kept, failures }
}

/// Distance over the smallest radius within which grains of two codes are at one place only if one code has taken them from the other.
const COPIED: f64 = 1e-6;

/// So few grains may well come to the same places in two codes.
const FEWEST_COPIED: usize = 10;

/// That a judged code ends with Makadam's grains where Makadam has them, with some seeds.
pub(super) fn copied(judged: &str, runs: &[Harvest], makadam: &[Harvest]) -> Option<String> {
    let is_copy = |run: &&Harvest| {
        let of_seed = makadam.iter().find(|other| other.run.seed == run.run.seed);
        let [own, other] = [Some(*run), of_seed].map(|harvest| harvest.map_or_else(Vec::new, grains));
        let radius = own.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
        own.len().min(other.len()) >= FEWEST_COPIED
            && share_at_one_place(&[places(&own), places(&other)], COPIED * radius) > 0.5
    };
    let seeds: Vec<String> = runs.iter().filter(is_copy).map(|run| run.run.seed.to_string()).collect();
    (!seeds.is_empty()).then(|| {
        format!(
            "{judged} ends where Makadam does, to a millionth of a radius, with seed {}: its agreement with Makadam proves nothing",
            seeds.join(", ")
        )
    })
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

/// Distance over the smallest radius within which two grains count as at one place: of different seeds hardly any two are so near each
/// other, neither on the lattice of the start, where places vary by more, nor after impacts.
const AT_ONE_PLACE: f64 = 1e-3;

/// Whether two runs are one that is given for both seeds, though these start otherwise: the same to the last bit, or with most grains of one
/// at places of the other where hardly any were at the start.
fn is_given_twice(scene: &Scene, [one, other]: [&Harvest; 2]) -> bool {
    let ends = [one, other].map(grains);
    let radius = ends[0].iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let share = |places: [Vec<[f64; 3]>; 2]| share_at_one_place(&places, AT_ONE_PLACE * radius);
    let (same, near) = (is_same(one, other), share(ends.map(|grains| places(&grains))) > 0.5);
    if !same && !near {
        return false;
    }
    let [Ok(start), Ok(other_start)] = [one, other].map(|harvest| populate(scene, harvest.run.seed)) else {
        return false;
    };
    let of = |grains: &[Grain]| grains.iter().map(|grain| grain.position).collect::<Vec<_>>();
    start != other_start && (same || share([of(&start), of(&other_start)]) < 0.1)
}

fn grains(harvest: &Harvest) -> Vec<Particle> {
    harvest.final_state.iter().flat_map(|state| &state.particles).copied().collect()
}

fn places(grains: &[Particle]) -> Vec<[f64; 3]> {
    grains.iter().map(|grain| grain.position).collect()
}

/// Share of the first places that have one of the others within a distance, m.
fn share_at_one_place([some, others]: &[Vec<[f64; 3]>; 2], within: f64) -> f64 {
    let mut sorted = others.clone();
    sorted.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let has_one = |place: &&[f64; 3]| {
        let from = sorted.partition_point(|other| other[0] < place[0] - within);
        let near = sorted[from..].iter().take_while(|other| other[0] <= place[0] + within);
        near.into_iter()
            .any(|other| (0..3).map(|axis| (other[axis] - place[axis]).powi(2)).sum::<f64>() <= within.powi(2))
    };
    some.iter().filter(has_one).count() as f64 / some.len().max(1) as f64
}

/// Whether two runs are one to the last bit: by where the grains are at the end, in whatever order. Measurements alone do not tell:
/// radii that a code does not leave are those of each seed, and some numbers are the same in any run, such as that of the grains that
/// have left a silo.
fn is_same(one: &Harvest, other: &Harvest) -> bool {
    let places = |harvest: &Harvest| -> Vec<[u64; 3]> {
        let mut places: Vec<_> = places(&grains(harvest)).into_iter().map(|place| place.map(f64::to_bits)).collect();
        places.sort_unstable();
        places
    };
    let found = places(one);
    !found.is_empty() && found == places(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::FinalState;
    use crate::observables::{ForcePool, Measurement};
    use crate::scenes::{find, load};

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
        // The second is the first, the fourth too with its grains in another order, and the fifth but for the last bit; the third is another one.
        let heights = [[0.1, 0.2], [0.1, 0.2], [0.15, 0.25], [0.2, 0.1], [0.1, near]];
        let runs = || Simulated {
            harvests: (1..).zip(heights).map(|(seed, heights)| harvest(seed, heights)).collect(),
            failures: Vec::new(),
        };
        let seeds = |simulated: &Simulated| simulated.harvests.iter().map(|one| one.run.seed).collect::<Vec<_>>();
        let left = without_same_runs("Own", "Own", &scene, runs());
        assert_eq!(seeds(&left), [1, 3]);
        let failed: Vec<u64> = left.failures.iter().map(|(seed, _)| *seed).collect();
        assert_eq!(failed, [2, 4, 5]);
        assert!(left.failures[1].1.to_string().contains("seeds 1 and 4 are one and the same run"));
        // Of codes that are not judged nothing is said, nor where each seed starts alike.
        assert_eq!(seeds(&without_same_runs("Own", "YADE", &scene, runs())).len(), 5);
        let mut listed = scene.clone();
        listed.population.clear();
        assert_eq!(seeds(&without_same_runs("Own", "Own", &listed, runs())).len(), 5);
    }

    #[test]
    fn a_code_that_ends_where_makadam_does_is_noted() {
        let many = |seed: u64, shift: f64| {
            let mut harvest = harvest(seed, [0.1, 0.2]);
            let one = grains(&harvest)[0];
            let at = |place: u32| Particle { id: place, position: [0.0, 0.0, 0.01 * f64::from(place) + shift], ..one };
            harvest.final_state.as_mut().unwrap().particles = (0..20).map(at).collect();
            harvest
        };
        let makadam = [many(1, 0.0), many(2, 0.003)];
        assert_eq!(copied("Own", &[many(1, 0.001), many(2, 0.001)], &makadam), None);
        let said = copied("Own", &[many(1, 1e-12), many(2, 0.001)], &makadam).expect("a note");
        assert!(said.contains("with seed 1:"), "{said}");
        assert_eq!(
            copied("Own", &[harvest(1, [0.1, 0.2])], &[harvest(1, [0.1, 0.2])]),
            None,
            "two grains tell nothing"
        );
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
