//! Unit tests of `src/compare/reference/missing.rs`.

use super::super::tests::sample;
use super::*;
use makadam_frames::plan::physics_hash;

/// Lists what is missing where a piece of what is wanted is changed; two seeds are recorded, three are wanted.
fn missing(change: impl Fn(&mut Wanted<'_>)) -> Missing {
    let (scene, reference) = sample();
    let hash = physics_hash(&scene);
    let mut wanted = Wanted {
        code: "YADE",
        version: Some("1.0, Debian"),
        contact_law: "a law",
        scene_hash: &hash,
        rayleigh_fraction: 0.1,
        seeds: &[1, 2, 3],
    };
    change(&mut wanted);
    reference.missing(&wanted)
}

#[test]
fn only_seeds_that_are_not_recorded_are_missing() {
    let third = Missing { seeds: vec![3], replaces: None };
    assert_eq!(missing(|_| ()), third);
    assert_eq!(missing(|wanted| wanted.version = None), third, "a code that is not installed keeps its runs");
    assert!(missing(|wanted| wanted.seeds = &[1]).seeds.is_empty());
}

#[test]
fn a_code_without_runs_misses_all_seeds() {
    let all = Missing { seeds: vec![1, 2, 3], replaces: None };
    assert_eq!(missing(|wanted| wanted.code = "another"), all);
}

#[test]
fn runs_made_otherwise_are_all_replaced_and_the_reason_is_said() {
    let replaced = |missing: Missing, reason: &str| {
        assert_eq!(missing.seeds, [1, 2, 3]);
        let said = missing.replaces.unwrap();
        assert!(said.contains(reason), "{said}");
    };
    replaced(missing(|wanted| wanted.scene_hash = "another"), "scene has changed");
    replaced(missing(|wanted| wanted.version = Some("2.0")), "version 1.0, Debian, not 2.0");
    replaced(missing(|wanted| wanted.contact_law = "another"), "contact law 'a law', not 'another'");
    replaced(missing(|wanted| wanted.rayleigh_fraction = 0.2), "10% of the Rayleigh step, and 20%");
}
