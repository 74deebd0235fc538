use super::*;
use crate::Simulation;
use crate::lanes::InstructionSet;
use crate::scene::{Scene, SolverMethod};
use crate::schedule::Scheduler;
use crate::solve::StopReason;

/// Sweeps of a step.
const SWEEPS: u64 = 80;

/// Grains that fall into a box; further keys of their material and of the solver, and walls.
fn pile(material: &str, solver: &str, walls: &str) -> Scene {
    let corners = "min = [-0.015, -0.015, 0.0], max = [0.015, 0.015, 0.2]";
    let text = format!(
        "name = 'pile'\ndescription = ''\nduration = 1\ngravity = [0, 0, -9.81]\n\
         domain = {{ min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.3] }}\n\
         [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nrestitution = 0.5\nfriction = 0.5\n{material}\n\
         [solver]\nstep = 5e-4\nnormal_law = {{ kind = 'hertz' }}\n{solver}\n\
         [[wall]]\nname = 'box'\nmaterial = 'grain'\nshape = {{ kind = 'box', {corners}, open = ['+z'] }}\n{walls}\n\
         [[population]]\ncount = 30\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.3 }}\n\
         region = {{ kind = 'box', {corners} }}\nagitation = 0.5\n"
    );
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

/// Takes steps that are stopped at any sweep, goes on from what is left and from checkpoints of it, and compares with steps that are
/// not.
fn stops_leave_no_trace(scene: &Scene, adapt: impl Fn(&mut Simulation)) {
    const STEPS: u64 = 300;
    let begin = || {
        let mut simulation = Simulation::new(scene, 1).unwrap_or_else(|error| panic!("{error}"));
        simulation.open_ledger();
        adapt(&mut simulation);
        simulation
    };
    let mut whole = begin();
    let (mut broken, mut stops, mut random) = (begin(), 0_u64, 1_u64);
    for step in 0..STEPS {
        whole.step();
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        // Two thirds of the steps are stopped, at any sweep, the last one among them.
        broken.interrupt.0.by_itself.store(1 + (random >> 33) % (SWEEPS + SWEEPS / 2), Ordering::SeqCst);
        let before = broken.state_hash();
        let report = broken.step();
        broken.interrupt.0.by_itself.store(0, Ordering::SeqCst);
        broken.interrupt.clear();
        if report.solve.reason == StopReason::Interrupted {
            stops += 1;
            assert_eq!((broken.state_hash(), broken.steps_taken()), (before, step), "all is as before the step");
            assert!(broken.snapshot().contacts.is_empty(), "nothing half solved is shown");
            if stops % 2 == 0 {
                broken = Simulation::resume(scene, &broken.checkpoint()).unwrap_or_else(|error| panic!("{error}"));
                adapt(&mut broken);
            }
            broken.step();
        }
        assert_eq!(broken.state_hash(), whole.state_hash(), "step {step}, {stops} stops");
    }
    assert!(stops > 100 && whole.rebuilds() > 5, "{stops} stops, {} lists", whole.rebuilds());
    assert_eq!(broken.checkpoint(), whole.checkpoint(), "all that later steps depend on");
    assert_eq!(broken.balance(), whole.balance());
}

#[test]
fn steps_that_are_stopped_leave_no_trace() {
    let sweeps = format!("stop = {{ kind = 'sweeps', sweeps = {SWEEPS} }}");
    stops_leave_no_trace(&pile("", &sweeps, ""), |_| ());
    let effects = "rolling_friction = 0.1\ntwisting_friction = 0.1\nkinetic_friction = 0.1\n\
                   cohesion = { kind = 'surface-energy', work = 0.05 }";
    stops_leave_no_trace(&pile(effects, &sweeps, ""), |_| ());
    let lid = "[[wall]]\nname = 'lid'\nmaterial = 'grain'\n\
               shape = { kind = 'plane', point = [0, 0, 0.25], normal = [0, 0, -1] }\n\
               motion = { kind = 'force-driven', axis = [0, 0, 1], force = -1, mass = 0.05, start = 0.02 }";
    stops_leave_no_trace(&pile("", &sweeps, lid), |_| ());
    stops_leave_no_trace(&pile("", &sweeps, ""), |simulation| {
        simulation.use_method(SolverMethod::Anderson { memory: 3 }).unwrap();
    });
    stops_leave_no_trace(&pile("", &sweeps, ""), |simulation| {
        simulation.use_instruction_set(InstructionSet::Generic).unwrap();
        simulation.use_team(Scheduler::WorkStealing, 2).unwrap();
    });
}

#[test]
fn a_step_of_endless_inner_sweeps_ends_when_it_is_asked_to() {
    let scene = pile("", "stop = { kind = 'sweeps', sweeps = 1 }", "");
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    // No scene may ask for so many.
    simulation.settings.inner_sweeps = u32::MAX;
    let interrupt = Interrupt::new();
    simulation.set_interrupt(interrupt.clone());
    interrupt.0.by_itself.store(10_000, Ordering::SeqCst);
    let mut reason = StopReason::NoContacts;
    while reason == StopReason::NoContacts {
        reason = simulation.step().solve.reason;
    }
    assert_eq!(reason, StopReason::Interrupted);
    assert!(interrupt.is_requested() && simulation.steps_taken() > 0, "it fell until something touched");
}

#[test]
fn solves_of_few_sweeps_do_not_look() {
    let scene = pile("", "stop = { kind = 'sweeps', sweeps = 64 }", "");
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    assert!(!simulation.interrupt_handle().request(), "for the first time");
    for _ in 0..100 {
        assert_ne!(simulation.step().solve.reason, StopReason::Interrupted);
    }
    assert_eq!(simulation.steps_taken(), 100);
}
