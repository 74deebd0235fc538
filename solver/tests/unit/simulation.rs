//! Unit tests of `src/simulation/mod.rs`.

use super::*;

#[test]
fn set_up_fetches_ahead_what_is_too_large_for_the_cache() {
    let fetches = |count: usize| {
        let text = format!(
            "name = 'cloud'\ndescription = ''\nduration = 1\ngravity = [0, 0, 0]\n\
             domain = {{ min = [0, 0, 0], max = [1, 1, 1] }}\n\
             [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nrestitution = 0.5\nfriction = 0\n\
             [[population]]\ncount = {count}\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0 }}\n\
             region = {{ kind = 'box', min = [0, 0, 0], max = [1, 1, 1] }}\n"
        );
        let mut simulation = Simulation::new(&Scene::parse(&text).unwrap(), 1).unwrap();
        assert_eq!(simulation.step().contacts, 0, "bodies alone count");
        simulation.constrainer.fetches
    };
    assert!(!fetches(1_000), "64 KB of bodies");
    assert!(fetches(20_000), "1.3 MB of bodies");
}
