//! A steady step allocates nothing: memory is reused from step to step.

use makadam::Simulation;
use makadam::scene::{Precision, Scene, SolverMethod};
use makadam::schedule::Scheduler;
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// The system's allocator, counting what it is asked for.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call is handed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations in each of `steps` steps.
fn allocations(simulation: &mut Simulation, steps: usize) -> Vec<u64> {
    let mut counts = Vec::with_capacity(steps);
    for _ in 0..steps {
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        simulation.step();
        counts.push(ALLOCATIONS.load(Ordering::Relaxed) - before);
    }
    counts
}

/// One test, because the count is of the whole process.
#[test]
fn steady_steps_allocate_nothing() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let scene = Scene::load(&file).unwrap();
    let mut settled = Simulation::new(&scene, 1).unwrap();
    assert!(allocations(&mut settled, 2400).iter().sum::<u64>() > 0, "the count counts");
    let (lists, steps) = (settled.rebuilds(), 600);
    assert_eq!(allocations(&mut settled, steps).iter().sum::<u64>(), 0, "a settled packing on one thread");
    println!("{} candidate lists in {steps} steps", settled.rebuilds() - lists);

    for scheduler in [Scheduler::CentralQueue, Scheduler::WorkStealing] {
        let mut simulation = settled.clone();
        simulation.use_team(scheduler, 2).unwrap();
        allocations(&mut simulation, 20);
        let counts = allocations(&mut simulation, steps);
        // Handing a step to the pool takes a block of its queue from time to time; nothing grows with the grains.
        let total: u64 = counts.iter().sum();
        println!("{scheduler:?}: {total} allocations in {steps} steps");
        assert!(total <= steps as u64 / 16, "{scheduler:?}: {total} allocations in {steps} steps");
    }

    settled.use_precision(Precision::Single).unwrap();
    assert!(allocations(&mut settled, steps).iter().sum::<u64>() > 0, "room for a copy in single precision");
    assert_eq!(allocations(&mut settled, steps).iter().sum::<u64>(), 0, "the same in single precision");
    settled.use_precision(Precision::Double).unwrap();

    // Every method reuses its memory. This is no copy: a copy has no room to spare.
    let mut simulation = settled;
    for method in SolverMethod::ALL {
        simulation.use_method(method).unwrap();
        assert!(allocations(&mut simulation, 100).iter().sum::<u64>() > 0, "{} has memory", method.name());
        let total: u64 = allocations(&mut simulation, 200).iter().sum();
        assert_eq!(total, 0, "{} in a settled packing", method.name());
    }

    // Where grains come and go, a step that rebuilds no list allocates nothing. These fall without a contact.
    let body = "[[insert]]\nmaterial = 'grain'\nradius = { kind = 'fixed', value = 0.004 }\nrate = 400\n\
                region = { kind = 'box', min = [0, 0, 0.3], max = [0.06, 0.06, 0.309] }\n\
                [[remove]]\nregion = { kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.05] }\n";
    let text = format!(
        "name = 'stream'\nduration = 1.0\ndomain = {{ min = [0, 0, 0], max = [0.06, 0.06, 0.4] }}\n\
         [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
         [solver]\nstep = 2e-4\nstop = {{ kind = 'sweeps', sweeps = 5 }}\n[watch]\non_escape = 'ignore'\n{body}"
    );
    let mut stream = Simulation::new(&Scene::parse(&text).unwrap(), 1).unwrap();
    allocations(&mut stream, 2500);
    let (mut quiet, mut lists) = (0, 0);
    for _ in 0..1000 {
        let before = stream.rebuilds();
        let count = allocations(&mut stream, 1)[0];
        let rebuilt = stream.rebuilds() > before;
        quiet += u32::from(count == 0 && !rebuilt);
        lists += u32::from(rebuilt);
    }
    println!("{quiet} quiet steps and {lists} lists");
    assert!(lists > 5 && stream.passed()[1].grains > 100, "{lists} lists");
    assert_eq!(quiet + lists, 1000, "a step without a new list allocates");

    // Where grains flow, lists are built all the time; their memory is found within the first of them.
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/drum/scene.toml");
    let scene = Scene::load(&file).unwrap();
    let mut flowing = Simulation::new(&scene, 1).unwrap();
    allocations(&mut flowing, 4000);
    let lists = flowing.rebuilds();
    let counts = allocations(&mut flowing, steps);
    let lists = flowing.rebuilds() - lists;
    let without = counts.iter().filter(|&&count| count == 0).count();
    println!("{lists} lists; {} of {steps} steps without allocation, {} in all", without, counts.iter().sum::<u64>());
    assert!(lists > 20, "the drum flows: {lists} lists");
    assert!(without >= steps * 9 / 10, "{without} of {steps} steps of a flowing drum allocate nothing");
}
