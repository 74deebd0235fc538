//! Checkpoints: a run that is continued ends in the same bits; what is damaged or foreign is refused.

use crate::common::{FLOOR, Setup, grain};
use makadam::Simulation;
use makadam::scene::Scene;
use makadam::schedule::Scheduler;
use std::path::Path;

fn scene(name: &str) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../reference-scenes/{name}/scene.toml"));
    Scene::load(&file).unwrap()
}

fn steps(simulation: &mut Simulation, count: usize) {
    for _ in 0..count {
        simulation.step();
    }
}

fn resume(scene: &Scene, bytes: &[u8]) -> Result<Simulation, String> {
    Simulation::resume(scene, bytes).map_err(|error| error.to_string())
}

#[test]
fn a_continued_run_ends_in_the_same_bits() {
    for (name, first, again) in [("packing", 500, 7), ("drum", 700, 11), ("heap", 300, 13)] {
        let scene = scene(name);
        let mut undisturbed = Simulation::new(&scene, 1).unwrap();
        steps(&mut undisturbed, first);
        let mut broken = undisturbed.clone();
        steps(&mut undisturbed, 200);
        // Checkpoints at any place between two candidate lists, each continued from the one before, on other threads.
        for leg in 0..200_usize.div_ceil(again) {
            let bytes = broken.checkpoint();
            broken = resume(&scene, &bytes).unwrap();
            assert_eq!(broken.checkpoint(), bytes, "{name}: what was read is what was written");
            broken.use_team(Scheduler::WorkStealing, 1 + leg % 3).unwrap();
            steps(&mut broken, again.min(200 - leg * again));
        }
        assert_eq!(broken.state_hash(), undisturbed.state_hash(), "{name}");
        assert_eq!(broken.contact_sweeps(), undisturbed.contact_sweeps(), "{name}");
        assert_eq!(broken.time(), undisturbed.time(), "{name}");
        assert_eq!(broken.rebuilds(), undisturbed.rebuilds(), "{name}");
        assert_eq!(broken.checkpoint(), undisturbed.checkpoint(), "{name}");
    }
}

#[test]
fn a_run_can_be_continued_from_before_its_first_step() {
    let scene = scene("packing");
    let mut undisturbed = Simulation::new(&scene, 3).unwrap();
    let mut continued = resume(&scene, &undisturbed.checkpoint()).unwrap();
    steps(&mut undisturbed, 100);
    steps(&mut continued, 100);
    assert_eq!(continued.state_hash(), undisturbed.state_hash());
}

#[test]
fn a_flow_starts_from_a_checkpoint_with_its_impulses_scaled() {
    let mut scene = scene("packing");
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    steps(&mut simulation, 2400);
    let bytes = simulation.checkpoint();
    scene.solver.step *= 0.5;
    let mut finer = Simulation::start_from(&scene, &bytes).unwrap();
    assert_eq!((finer.time(), finer.steps_taken()), (0.0, 0));
    finer.step();
    // A bed at rest bears the same forces with half the step, so half the impulses: it stays at rest from the first step on.
    let fastest = finer.snapshot().particles.iter().map(|p| p.velocity[2].abs()).fold(0.0, f64::max);
    assert!(fastest < 0.5 * 9.81 * scene.solver.step, "{fastest}");
}

#[test]
fn one_grain_and_none_have_checkpoints_too() {
    for body in [String::from(FLOOR), format!("{FLOOR}{}", grain(0.005, [0.0, 0.0, 0.0052], [0.0; 3]))] {
        let setup = Setup { body, ..Setup::default() };
        let mut simulation = setup.start();
        steps(&mut simulation, 10);
        let mut continued = resume(&setup.scene(), &simulation.checkpoint()).unwrap();
        steps(&mut simulation, 200);
        steps(&mut continued, 200);
        assert_eq!(continued.state_hash(), simulation.state_hash());
    }
}

#[test]
fn what_is_damaged_or_foreign_is_refused() {
    let scene = scene("packing");
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    steps(&mut simulation, 600);
    let bytes = simulation.checkpoint();
    let refused = |bytes: &[u8], words: &str| {
        let message = resume(&scene, bytes).err().unwrap_or_else(|| panic!("accepted where {words} was expected"));
        assert!(message.contains(words) && message.contains("start anew"), "{message}");
    };
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 1;
    refused(&damaged, "damaged");
    refused(&bytes[..bytes.len() - 1], "cut off");
    refused(&bytes[..10], "too short");
    refused(b"something else that is long enough", "no such file");
    let mut older = bytes.clone();
    older[7] = 1;
    refused(&older, "version 1");

    let mut other = scene.clone();
    other.solver.step = 1e-3;
    assert!(resume(&other, &bytes).unwrap_err().contains("time step"));
    other = scene.clone();
    other.population[0].count -= 1;
    assert!(resume(&other, &bytes).unwrap_err().contains("2000 grains where the scene has 1999"));
    // Another reach makes another list.
    other = scene.clone();
    other.solver.skin *= 1.5;
    assert!(resume(&other, &bytes).unwrap_err().contains("another scene"));
}

#[test]
fn a_file_that_cannot_be_written_is_an_error_and_the_old_one_stays() {
    let folder = std::env::temp_dir().join(format!("makadam-checkpoint-{}", std::process::id()));
    let file = folder.join("run.checkpoint");
    let simulation = Setup { body: FLOOR.into(), ..Setup::default() }.start();
    simulation.save(&file).unwrap();
    assert_eq!(std::fs::read(&file).unwrap(), simulation.checkpoint());
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "no draft stays behind");
    let message = simulation.save(file.join("below-a-file")).unwrap_err().to_string();
    assert!(message.contains("below-a-file") && message.contains("disk has room"), "{message}");
    std::fs::remove_dir_all(&folder).unwrap();
}
