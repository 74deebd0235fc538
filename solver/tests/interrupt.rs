//! Steps that are stopped from another thread: they leave no trace, at whichever sweep they were asked to.

use makadam::lanes::InstructionSet;
use makadam::scene::{Scene, SolverMethod};
use makadam::schedule::Scheduler;
use makadam::solve::StopReason;
use makadam::{Interrupt, Simulation, StepReport};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Sweeps of a step.
const SWEEPS: u64 = 500;

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

/// Asks for stops from another thread, when it is told to.
#[derive(Default)]
struct Asker {
    /// Time until the next request, ns; 0 where there is none.
    delay: AtomicU64,
    done: AtomicBool,
}

impl Asker {
    fn run(&self, interrupt: &Interrupt) {
        while !self.done.load(Ordering::SeqCst) {
            let delay = Duration::from_nanos(self.delay.load(Ordering::SeqCst));
            if delay.is_zero() {
                std::thread::yield_now();
                continue;
            }
            let clock = Instant::now();
            while clock.elapsed() < delay {
                std::hint::spin_loop();
            }
            interrupt.request();
            self.delay.store(0, Ordering::SeqCst);
        }
    }

    /// Takes a step that is asked to stop after a time: before it where that is zero.
    fn step(&self, simulation: &mut Simulation, interrupt: &Interrupt, delay: Duration) -> StepReport {
        match delay.as_nanos() as u64 {
            0 => drop(interrupt.request()),
            delay => self.delay.store(delay, Ordering::SeqCst),
        }
        let report = simulation.step();
        while self.delay.load(Ordering::SeqCst) > 0 {
            std::thread::yield_now();
        }
        interrupt.clear();
        report
    }
}

/// Takes steps that are stopped at any sweep, continues from what is left and from checkpoints of it, and compares with steps that are
/// not.
fn stops_leave_no_trace(scene: &Scene, adapt: impl Fn(&mut Simulation)) {
    let (asker, interrupt) = (Asker::default(), Interrupt::new());
    std::thread::scope(|scope| {
        scope.spawn(|| asker.run(&interrupt));
        let compared = catch_unwind(AssertUnwindSafe(|| compare_with_stopped(scene, adapt, &asker, &interrupt)));
        asker.done.store(true, Ordering::SeqCst);
        compared.unwrap_or_else(|panic| resume_unwind(panic));
    });
}

fn compare_with_stopped(scene: &Scene, adapt: impl Fn(&mut Simulation), asker: &Asker, interrupt: &Interrupt) {
    const STEPS: u64 = 40;
    let mut whole = Simulation::new(scene, 1).unwrap_or_else(|error| panic!("{error}"));
    whole.open_ledger();
    adapt(&mut whole);
    while whole.step().contacts < 20 {}
    let mut broken = whole.clone();
    broken.set_interrupt(interrupt.clone());
    whole.set_interrupt(Interrupt::new());
    let (mut stops, mut late, mut random, mut step) = (0_u64, 0_u64, 1_u64, 0);
    // More steps where the other thread is seldom in time.
    while step < STEPS || (late < 10 && step < 100 * STEPS) {
        let clock = Instant::now();
        whole.step();
        let duration = clock.elapsed();
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        // A quarter is asked before the step; the others up to half a step too late.
        let delay = duration.mul_f64((((random >> 33) % 1000) as f64 / 500.0 - 0.5).max(0.0));
        let before = (broken.state_hash(), broken.steps_taken());
        let report = asker.step(&mut broken, interrupt, delay);
        if report.solve.reason == StopReason::Interrupted {
            stops += 1;
            late += u64::from(report.solve.sweeps > 1);
            assert_eq!((broken.state_hash(), broken.steps_taken()), before, "all is as before the step");
            assert!(broken.snapshot().contacts.is_empty(), "nothing half solved is shown");
            if stops % 2 == 0 {
                broken = Simulation::resume(scene, &broken.checkpoint()).unwrap_or_else(|error| panic!("{error}"));
                adapt(&mut broken);
                broken.set_interrupt(interrupt.clone());
            }
            broken.step();
        }
        assert_eq!(broken.state_hash(), whole.state_hash(), "step {step}, {stops} stops");
        step += 1;
    }
    println!("{stops} stops in {step} steps, {late} of them after the first sweep");
    assert!(late >= 10 && whole.rebuilds() > 5, "{late} stops, {} lists", whole.rebuilds());
    assert_eq!(broken.checkpoint(), whole.checkpoint(), "all that later steps depend on");
    assert_eq!(broken.balance(), whole.balance());
}

#[test]
fn stopped_steps_leave_no_trace() {
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
fn inner_sweeps_end_on_request() {
    let mut simulation =
        Simulation::new(&pile("", "inner_sweeps = 1000\nstop = { kind = 'sweeps', sweeps = 1 }", ""), 1).unwrap();
    while simulation.step().contacts < 20 {}
    let (interrupt, before) = (Interrupt::new(), simulation.state_hash());
    simulation.set_interrupt(interrupt.clone());
    let stopped = Asker::default().step(&mut simulation, &interrupt, Duration::ZERO);
    assert_eq!((stopped.solve.reason, simulation.state_hash()), (StopReason::Interrupted, before));
    assert_eq!(simulation.step().solve.reason, StopReason::Sweeps);
}

#[test]
fn few_sweeps_poll_no_interrupt() {
    let scene = pile("", "stop = { kind = 'sweeps', sweeps = 64 }", "");
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    assert!(!simulation.interrupt_handle().request(), "for the first time");
    for _ in 0..100 {
        assert_ne!(simulation.step().solve.reason, StopReason::Interrupted);
    }
    assert_eq!(simulation.steps_taken(), 100);
}
