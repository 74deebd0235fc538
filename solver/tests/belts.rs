//! Surface velocity of walls: belts.

use makadam::Simulation;
use makadam::scene::{Motion, Scene};

const BELT: [f64; 3] = [0.35, 0.0, 0.0];

/// A grain on a plane whose surface moves along itself.
fn scene() -> Scene {
    let text = r#"
        name = "belt"
        description = "a grain on a belt"
        duration = 1.0
        domain = { min = [-1.0, -1.0, -0.1], max = [1.0, 1.0, 0.1] }
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.3
        [[wall]]
        name = "belt"
        material = "glass"
        shape = { kind = "plane", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
        surface_velocity = [0.35, 0.0, 0.0]
        [[grain]]
        material = "glass"
        radius = 0.005
        position = [0.0, 0.0, 0.005]
    "#;
    Scene::parse(text).unwrap()
}

fn after(scene: &Scene, steps: usize) -> ([f64; 3], [f64; 3]) {
    let mut simulation = Simulation::new(scene, 1).unwrap();
    (0..steps).for_each(|_| {
        simulation.step();
    });
    let frame = simulation.frame();
    (frame.positions()[0], frame.velocities()[0])
}

#[test]
fn a_grain_on_a_belt_ends_at_two_sevenths_of_its_velocity() {
    // Friction turns and moves a solid sphere until its surface has the velocity of the belt: v = 2/7 b.
    let (_, velocity) = after(&scene(), 400);
    assert!((velocity[0] - 0.1).abs() < 1e-9, "{velocity:?}");
    assert!(velocity[2].abs() < 1e-9, "{velocity:?}");
}

#[test]
fn a_belt_moves_a_grain_as_a_plane_that_translates_does() {
    let mut translating = scene();
    translating.wall[0].surface_velocity = [0.0; 3];
    translating.wall[0].motion = Motion::Translating { velocity: BELT, start: 0.0, stop: None };
    let ((place, velocity), (moved, its_velocity)) = (after(&scene(), 60), after(&translating, 60));
    (0..3).for_each(|axis| {
        assert!((place[axis] - moved[axis]).abs() < 1e-12 && (velocity[axis] - its_velocity[axis]).abs() < 1e-12)
    });
    assert!(place[0] > 1e-4, "{place:?}");
}

#[test]
fn the_component_along_the_normal_does_not_push() {
    let mut tilted = scene();
    tilted.wall[0].surface_velocity = [0.35, 0.0, 2.0];
    assert_eq!(after(&tilted, 100), after(&scene(), 100));
}

#[test]
fn a_belt_does_work_that_the_ledger_enters() {
    let mut simulation = Simulation::new(&scene(), 1).unwrap();
    simulation.open_ledger();
    (0..400).for_each(|_| {
        simulation.step();
    });
    let balance = simulation.balance().unwrap();
    let kinetic = simulation.energy().kinetic;
    assert!(kinetic > 0.0 && balance.walls > kinetic, "{balance:?}");
    assert!(balance.closure.abs() < 1e-9 * balance.walls, "{balance:?}");
}

#[test]
fn a_wall_on_a_drive_has_no_belt() {
    let text = toml::to_string(&scene())
        .unwrap()
        .replace("kind = \"fixed\"", "kind = \"force-driven\"\naxis = [0.0, 0.0, 1.0]\nforce = 1.0\nmass = 1.0");
    let error = Scene::parse(&text).unwrap_err().to_string();
    assert!(error.contains("wall[0].surface_velocity") && error.contains("leave it out"), "{error}");
}

#[test]
fn the_watchdog_counts_the_work_of_a_belt() {
    let mut scene = scene();
    scene.watch.every = 1;
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    let mut watchdog = makadam::watch::Watchdog::new(&scene.watch, &simulation);
    for _ in 0..400 {
        let report = simulation.step();
        assert_eq!(watchdog.observe(&simulation, &report).first(), None);
    }
}
