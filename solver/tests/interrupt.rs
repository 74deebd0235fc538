//! A step that takes long can be stopped inside, as if it had not begun.

mod common;
use common::Setup;
use makadam::scene::{Scene, SolverMethod};
use makadam::schedule::Scheduler;
use makadam::solve::StopReason;
use makadam::{Interrupt, Simulation};
use std::path::Path;
use std::time::{Duration, Instant};

/// Grains that fall into a box, solved by so many sweeps.
fn pile(sweeps: &str, materials: &str, walls: &str) -> Scene {
    let corners = "min = [-0.015, -0.015, 0.0], max = [0.015, 0.015, 0.2]";
    let scene = Setup {
        solver: format!("step = 5e-4\nnormal_law = {{ kind = 'hertz' }}\nstop = {{ kind = 'sweeps', {sweeps} }}"),
        body: format!(
            "[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = {{ kind = 'box', {corners}, open = ['+z'] }}\n{walls}\
             [[population]]\ncount = 30\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.3 }}\n\
             region = {{ kind = 'box', {corners} }}\nagitation = 0.5\n"
        ),
        ..Setup::default()
    };
    scene.scene_with(materials)
}

/// Asks for a stop after a while.
fn asked<R>(interrupt: &Interrupt, after: Duration, work: impl FnOnce() -> R) -> R {
    let asked = interrupt.clone();
    let asking = std::thread::spawn(move || {
        std::thread::sleep(after);
        asked.request();
    });
    let result = work();
    asking.join().unwrap();
    interrupt.clear();
    result
}

/// Takes steps that are stopped at any sweep, goes on from checkpoints of what is left, and compares with steps that are not.
fn stops_leave_no_trace(scene: &Scene, adapt: impl Fn(&mut Simulation)) {
    const STEPS: u64 = 120;
    let file = Path::new("pile.toml");
    let begin = || {
        let mut simulation = Simulation::new(scene, 1, file).unwrap_or_else(|error| panic!("{error}"));
        simulation.open_ledger();
        adapt(&mut simulation);
        simulation
    };
    let mut whole = begin();
    let clock = Instant::now();
    for _ in 0..STEPS {
        whole.step();
    }
    let step = clock.elapsed() / STEPS as u32;
    let (mut broken, mut stops, mut tries, mut random) = (begin(), 0, 0, 1_u64);
    while broken.steps_taken() < STEPS {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        // One step in three is left in peace, so that the run ends on a slow machine too.
        if tries % 3 == 2 {
            tries += 1;
            broken.step();
            continue;
        }
        tries += 1;
        let (before, list) = (broken.state_hash(), broken.steps_taken());
        let after = step.mul_f64((random >> 40) as f64 / (1 << 24) as f64);
        let report = asked(&broken.interrupt_handle(), after, || broken.step());
        if report.solve.reason != StopReason::Interrupted {
            continue;
        }
        stops += 1;
        assert_eq!((broken.state_hash(), broken.steps_taken()), (before, list), "all is as before the step");
        assert!(broken.snapshot().contacts.is_empty(), "nothing half solved is shown");
        if stops % 2 == 0 {
            broken = Simulation::resume(scene, &broken.checkpoint(), file).unwrap_or_else(|error| panic!("{error}"));
            adapt(&mut broken);
        }
    }
    assert!(stops > 10, "{stops} steps were stopped");
    assert_eq!(broken.state_hash(), whole.state_hash(), "{stops} stops");
    assert_eq!(broken.checkpoint(), whole.checkpoint(), "all that later steps depend on");
    assert_eq!(broken.balance(), whole.balance());
}

#[test]
fn steps_that_are_stopped_leave_no_trace() {
    stops_leave_no_trace(&pile("sweeps = 3000", "", ""), |_| ());
    let effects = "rolling_friction = 0.1\ntwisting_friction = 0.1\nkinetic_friction = 0.1\n\
                   cohesion = { kind = 'surface-energy', work = 0.05 }\n";
    stops_leave_no_trace(&pile("sweeps = 3000", effects, ""), |_| ());
    let lid = "[[wall]]\nname = 'lid'\nmaterial = 'wall'\n\
               shape = { kind = 'plane', point = [0, 0, 0.19], normal = [0, 0, -1] }\n\
               motion = { kind = 'force-driven', axis = [0, 0, 1], force = -1, mass = 0.05 }\n";
    stops_leave_no_trace(&pile("sweeps = 3000", "", lid), |_| ());
    stops_leave_no_trace(&pile("sweeps = 2000", "", ""), |simulation| {
        simulation.use_method(SolverMethod::Anderson { memory: 3 }).unwrap();
    });
    stops_leave_no_trace(&pile("sweeps = 1000", "", ""), |simulation| {
        simulation.use_team(Scheduler::WorkStealing, 2).unwrap();
    });
}

#[test]
fn a_step_of_endless_inner_sweeps_ends_when_it_is_asked_to() {
    let mut simulation =
        Simulation::new(&pile("sweeps = 1 }\ninner_sweeps = 4294967295\nwarm_start = 1.0 # {", "", ""), 1, Path::new("p"))
            .unwrap();
    let before = simulation.state_hash();
    let interrupt = Interrupt::new();
    simulation.heed(interrupt.clone());
    let mut reason = StopReason::NoContacts;
    asked(&interrupt, Duration::from_millis(300), || {
        while reason == StopReason::NoContacts && !interrupt.is_requested() {
            reason = simulation.step().solve.reason;
        }
    });
    assert_eq!(reason, StopReason::Interrupted);
    assert_ne!(simulation.state_hash(), before, "it fell until something touched");
}
