//! Watchdogs: conditions that they report, and conditions that they do not.

use crate::common::{FLOOR, Setup, grain, run_until};
use makadam::scene::{Reaction, Scene, Watch};
use makadam::watch::{Alarm, Trouble, Watchdog};
use makadam::{Simulation, StepReport};

const RADIUS: f64 = 0.005;

/// Lists the reports until a time (s), the last step included.
fn alarms(scene: &Scene, until: f64) -> Vec<Alarm> {
    let mut simulation = Simulation::new(scene, 1).unwrap();
    let mut watchdog = Watchdog::new(&scene.watch, &simulation);
    let mut alarms = Vec::new();
    while simulation.time() < until - 0.5 * simulation.time_step() {
        let report = simulation.step();
        alarms.extend(watchdog.observe(&simulation, &report));
    }
    alarms.extend(watchdog.last(&simulation));
    alarms
}

fn wall(name: &str, shape: &str, motion: &str) -> String {
    format!("[[wall]]\nname = '{name}'\nmaterial = 'wall'\nshape = {{ {shape} }}\nmotion = {{ {motion} }}\n")
}

fn energy(alarms: &[Alarm]) -> Vec<f64> {
    let share = |alarm: &Alarm| match alarm.trouble {
        Trouble::Energy { share, .. } => Some(share),
        _ => None,
    };
    alarms.iter().filter_map(share).collect()
}

#[test]
fn the_last_step_of_a_run_is_looked_at() {
    // It leaves the domain after 40 steps of 63, and no step is a multiple of 64.
    let body = grain(RADIUS, [9.996, 0.0, 5.0], [1.0, 0.0, 0.0]);
    let scene = Setup { gravity: [0.0; 3], body, ..Setup::default() }.scene();
    let found = alarms(&scene, 0.0063);
    assert!(matches!(found[..], [Alarm { trouble: Trouble::Escape { grain: 0, .. }, step: 63, .. }]), "{found:?}");
    assert_eq!(found[0].reaction, Reaction::Stop);
    assert!(found[0].trouble.is_fatal());
}

#[test]
fn a_state_is_looked_at_once_and_solves_are_judged_when_it_is_time_to() {
    let body = grain(RADIUS, [20.0, 0.0, 5.0], [0.0; 3]);
    let domain = |scene: &mut Scene| (scene.domain.min, scene.domain.max) = ([-30.0; 3], [30.0; 3]);
    let mut scene = Setup { gravity: [0.0; 3], body, ..Setup::default() }.scene();
    domain(&mut scene);
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    let outside = Setup { gravity: [0.0; 3], ..Setup::default() }.scene();
    let watch = Watch { residual: 1e-9, ..outside.watch };
    let mut watchdog = Watchdog::new(&watch, &simulation);
    let report = simulation.step();
    assert!(watchdog.observe(&simulation, &report).is_empty());
    // Without a step that was seen there is nothing to say of solves.
    let mut blind = Watchdog::new(&watch, &simulation);
    simulation.step();
    assert!(blind.last(&simulation).is_empty());
    // A solve that came to nothing.
    let mut bad = StepReport::default();
    bad.solve.reason = makadam::solve::StopReason::MaxSweeps;
    bad.solve.residuals.normal.rms = 1.0;
    let begun = Watch { every: simulation.steps_taken() as u32, ..watch.clone() };
    let mut watchdog = Watchdog::new(&begun, &simulation);
    simulation.step();
    assert!(watchdog.observe(&simulation, &bad).is_empty() && watchdog.look(&simulation).is_empty());
    let last = watchdog.last(&simulation);
    assert!(matches!(last[..], [Alarm { trouble: Trouble::Stagnation { .. }, .. }]), "{last:?}");
    assert!(!last[0].trouble.is_fatal() && watchdog.last(&simulation).is_empty());
    // Begun between two checks, as on a resume: the solves before are unknown.
    let mut late = Watchdog::new(&Watch { every: 64, ..watch }, &simulation);
    simulation.step();
    assert!(late.observe(&simulation, &bad).is_empty() && late.last(&simulation).is_empty());
}

#[test]
fn what_walls_and_gravity_give_is_no_energy_from_nowhere() {
    let bed = "[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = { kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.2], \
               open = ['+z'] }\n[[population]]\ncount = 40\nmaterial = 'grain'\nradius = { kind = 'fixed', value = 0.005 }\n\
               spacing = 1.05\nregion = { kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.2] }\n";
    let side = "kind = 'plane', point = [0, 0, 0], normal = [1, 0, 0]";
    let lid = "kind = 'plane', point = [0.03, 0.03, 0.035], normal = [0, 0, -1]";
    let shell = "kind = 'cylinder', base = [0.03, -0.1, 0.03], axis = [0, 1, 0], radius = 0.05, length = 0.3";
    for (shape, motion) in [
        (side, "kind = 'vibrating', amplitude = [0.002, 0, 0], frequency = 30"),
        (side, "kind = 'translating', velocity = [0.2, 0, 0], start = 0.05, stop = 0.1"),
        (shell, "kind = 'rotating', point = [0.03, 0, 0.03], axis = [0, 1, 0], rate = 20"),
        (lid, "kind = 'force-driven', axis = [0, 0, 1], force = -5.0, mass = 0.1"),
    ] {
        for solver in [
            // Overlaps of rigid grains are pushed apart at up to the threshold, which is energy from nowhere.
            "step = 2e-4\nnormal_law = { kind = 'rigid' }\nstop = { kind = 'sweeps', sweeps = 200 }\n\
             restitution_threshold = 0.02",
            "step = 2e-4\nnormal_law = { kind = 'hertz' }",
        ] {
            let body = bed.to_string() + &wall("moving", shape, motion);
            let setup = Setup { solver: solver.into(), body, restitution: 0.9, ..Setup::default() };
            let mut scene = setup.scene();
            scene.watch = Watch { every: 4, ..Watch::default() };
            let found = alarms(&scene, 0.3);
            assert!(energy(&found).is_empty(), "{solver} {motion}: {:?} {found:?}", energy(&found));
        }
    }
}

#[test]
fn energy_from_nowhere_is_noticed_though_a_wall_moves() {
    // Two runs of a scene over a floor that turns, one of which throws its grain: seen as one, the grain is thrown by nothing.
    let floor = wall(
        "floor",
        "kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1]",
        "kind = 'rotating', point = [0, 0, 0], axis = [0, 0, 1], rate = 1.0",
    );
    let simulation = |speed: f64| {
        let body = floor.clone() + &grain(RADIUS, [0.0, 0.0, 2.0 * RADIUS], [speed, 0.0, 0.0]);
        Setup { body, ..Setup::default() }.start()
    };
    let (mut calm, mut thrown) = (simulation(0.0), simulation(1.0));
    let mut watchdog = Watchdog::new(&Watch { every: 1, ..Watch::default() }, &calm);
    for _ in 0..3 {
        thrown.step();
        let report = calm.step();
        assert!(watchdog.observe(&calm, &report).is_empty());
    }
    let report = thrown.step();
    let found = watchdog.observe(&thrown, &report);
    assert!(
        matches!(found[..], [Alarm { trouble: Trouble::Energy { .. }, reaction: Reaction::Stop, .. }]),
        "{found:?}"
    );
    assert!(found[0].trouble.is_fatal());
    // What was said is not said again; and who has missed a step begins anew.
    let report = thrown.step();
    assert!(watchdog.observe(&thrown, &report).is_empty());
    let mut calm = simulation(0.0);
    run_until(&mut calm, 0.01);
    let mut late = Watchdog::new(&Watch { every: 1, ..Watch::default() }, &calm);
    run_until(&mut thrown, 0.02);
    assert!(late.observe(&thrown, &report).is_empty());
}

#[test]
fn a_wall_that_grains_are_inside_of_makes_numbers_worthless() {
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.2 * RADIUS], [0.0; 3]));
    let mut scene =
        Setup { solver: "step = 1e-7\nnormal_law = { kind = 'hertz' }".into(), body, ..Setup::default() }.scene();
    scene.largest_start_overlap = 1.0;
    scene.watch.on_stagnation = Reaction::Ignore;
    let look = |scene: &Scene, sunk: f64| {
        let mut scene = scene.clone();
        scene.grain[0].position[2] = sunk;
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        let mut watchdog = Watchdog::new(&scene.watch, &simulation);
        let report = simulation.step();
        watchdog.observe(&simulation, &report);
        assert!((simulation.largest_overlap() - (1.0 - sunk / RADIUS)).abs() < 1e-3);
        watchdog.last(&simulation)
    };
    let found = look(&scene, 0.2 * RADIUS);
    assert!(
        matches!(found[..], [Alarm { trouble: Trouble::Overlap { .. }, reaction: Reaction::Warn, .. }]),
        "{found:?}"
    );
    scene.largest_start_overlap = 2.0;
    let found = look(&scene, -0.2 * RADIUS);
    let deep = matches!(found[..], [Alarm { trouble: Trouble::DeepOverlap { .. }, reaction: Reaction::Stop, .. }]);
    assert!(deep && found[0].trouble.is_fatal(), "{found:?}");
    scene.watch.on_deep_overlap = Reaction::Ignore;
    let found = look(&scene, -0.2 * RADIUS);
    assert!(
        matches!(found[..], [Alarm { trouble: Trouble::Overlap { .. }, reaction: Reaction::Warn, .. }]),
        "{found:?}"
    );
}

#[test]
fn a_scene_mentions_of_deep_overlaps_only_what_it_wants_otherwise() {
    let text = |watch: Watch| toml::to_string(&watch).unwrap();
    assert!(!text(Watch::default()).contains("deep"));
    assert!(text(Watch { on_deep_overlap: Reaction::Warn, ..Watch::default() }).contains("on_deep_overlap = \"warn\""));
}
