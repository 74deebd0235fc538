//! Unit tests of `src/compare/reference/merge.rs`.

use super::super::tests::sample;
use super::*;
use makadam_frames::plan::physics_hash;

/// The recorded runs of YADE with other seeds, for adding to a reference or for starting one.
fn with_seeds(seeds: [u64; 2]) -> (Reference, CodeRuns, String) {
    let (scene, reference) = sample();
    let mut code = reference.code("YADE").unwrap();
    for (run, seed) in code.runs.iter_mut().zip(seeds) {
        run.seed = seed;
    }
    code.series.iter_mut().for_each(|series| series.seed = seeds[0]);
    code.final_state.as_mut().unwrap().seed = seeds[0];
    (reference, code, physics_hash(&scene))
}

fn seeds(reference: &Reference) -> Vec<u64> {
    reference.of("YADE").map(|run| run.seed).collect()
}

#[test]
fn new_seeds_stand_beside_the_recorded_ones() {
    let (mut reference, code, hash) = with_seeds([3, 4]);
    let before = reference.clone();
    reference.add(code, &hash).unwrap();
    assert_eq!(seeds(&reference), [1, 2, 3, 4]);
    assert!(reference.of("YADE").all(|run| run.scene_hash == hash));
    let forces = |reference: &Reference, code: &str| reference.code(code).unwrap().forces.unwrap();
    assert_eq!(forces(&reference, "YADE").samples, 2 * forces(&before, "YADE").samples);
    assert_eq!(forces(&reference, "LIGGGHTS"), forces(&before, "LIGGGHTS"));
    // The first seed is still the one that was recorded.
    assert_eq!((&reference.series, &reference.final_states), (&before.series, &before.final_states));
}

#[test]
fn a_new_first_seed_brings_its_series_and_its_final_state() {
    let (mut reference, code, hash) = with_seeds([3, 4]);
    reference.replace(code, &hash);
    let (_, code, _) = with_seeds([1, 2]);
    reference.add(code, &hash).unwrap();
    let code = reference.code("YADE").unwrap();
    assert_eq!(seeds(&reference), [1, 2, 3, 4]);
    assert_eq!((code.series[0].seed, code.final_state.unwrap().seed), (1, 1));
}

#[test]
fn what_does_not_go_together_is_refused_and_changes_nothing() {
    let (reference, code, hash) = with_seeds([3, 4]);
    let refused = |code: CodeRuns, hash: &str| {
        let mut changed = reference.clone();
        let error = changed.add(code, hash).unwrap_err();
        assert_eq!(changed, reference);
        error
    };
    let mut version = code.clone();
    version.runs[1].version = "2.0".into();
    assert!(refused(version, &hash).contains("YADE, seed 4"));
    assert!(refused(code.clone(), "another").contains("YADE, seed 3"));
    let mut seed = code.clone();
    seed.runs[0].seed = 2;
    assert!(refused(seed, &hash).contains("YADE, seed 2"));
    let mut bins = code;
    bins.forces.as_mut().unwrap().force[0] = 0.5;
    assert!(refused(bins, &hash).contains("forces of YADE"));
}

#[test]
fn replacing_leaves_the_order_alone() {
    let (mut reference, _, hash) = with_seeds([1, 2]);
    let before = reference.clone();
    for code in ["LIGGGHTS", "YADE", "LIGGGHTS"] {
        reference.replace(before.code(code).unwrap(), &hash);
    }
    assert_eq!(reference, before);
}
