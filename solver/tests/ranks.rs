//! Runs on several ranks have the bits of one: here, ranks are threads that pass messages through channels. `tests/mpi` of the command
//! starts processes.

use makadam::messages::Messages;
use makadam::scene::Accuracy;
use makadam::{Precision, Scene, Scheduler, Simulation, SolverMethod, Stop, dismiss, follow};
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};

/// Rank among threads.
#[derive(Debug)]
struct Thread {
    own: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Mutex<Receiver<Vec<u8>>>>,
}

impl Thread {
    /// All ranks of a run.
    fn all(count: usize) -> Vec<Arc<dyn Messages>> {
        let mut to: Vec<Vec<Sender<Vec<u8>>>> = (0..count).map(|_| Vec::new()).collect();
        let mut from: Vec<Vec<Mutex<Receiver<Vec<u8>>>>> = (0..count).map(|_| Vec::new()).collect();
        for to in &mut to {
            for from in &mut from {
                let (sender, receiver) = channel();
                to.push(sender);
                from.push(Mutex::new(receiver));
            }
        }
        let ranks = to.into_iter().zip(from).enumerate();
        ranks.map(|(own, (to, from))| Arc::new(Thread { own, to, from }) as Arc<dyn Messages>).collect()
    }

    fn send(&self, rank: usize, bytes: Vec<u8>) {
        self.to[rank].send(bytes).expect("the other rank lives");
    }

    fn receive(&self, rank: usize) -> Vec<u8> {
        self.from[rank].lock().unwrap().recv().expect("the other rank lives")
    }
}

impl Messages for Thread {
    fn rank(&self) -> usize {
        self.own
    }

    fn ranks(&self) -> usize {
        self.to.len()
    }

    fn exchange(&self, sent: &[(usize, &[u8])], received: &mut [(usize, &mut [u8])]) {
        sent.iter().for_each(|(rank, bytes)| self.send(*rank, bytes.to_vec()));
        received.iter_mut().for_each(|(rank, bytes)| bytes.copy_from_slice(&self.receive(*rank)));
    }

    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        (0..self.ranks()).for_each(|rank| self.send(rank, own.to_vec()));
        (0..self.ranks()).map(|rank| self.receive(rank)).collect()
    }

    fn broadcast(&self, bytes: &mut Vec<u8>, from: usize) {
        if from == self.own {
            (0..self.ranks()).for_each(|rank| self.send(rank, bytes.clone()));
        }
        *bytes = self.receive(from);
    }
}

/// Lets a run of a simulation act on several ranks.
fn on_ranks<R>(count: usize, scene: &Scene, mut simulation: Simulation, run: impl FnOnce(&mut Simulation) -> R) -> R {
    let mut ranks = Thread::all(count);
    let leading = ranks.remove(0);
    // A rank that fails takes its end of the channels with it, so that the others fail too.
    std::thread::scope(move |scope| {
        let followers: Vec<_> = ranks.into_iter().map(|rank| scope.spawn(move || follow(&rank))).collect();
        simulation.divide_among(scene, &leading).unwrap();
        let result = run(&mut simulation);
        dismiss(&leading);
        followers.into_iter().for_each(|follower| follower.join().unwrap());
        result
    })
}

fn reference_scene(name: &str) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    Scene::load(&file).unwrap_or_else(|error| panic!("{error}"))
}

/// Takes steps, and returns the hash of the state, the contacts and the energy every so many steps.
fn course(simulation: &mut Simulation, steps: usize, every: usize) -> Vec<String> {
    let mut course = Vec::new();
    for step in 1..=steps {
        let report = simulation.step();
        if step % every == 0 {
            let frame = simulation.snapshot();
            let contacts: Vec<String> = frame.contacts.iter().map(|contact| format!("{contact:?}")).collect();
            let hash = simulation.state_hash();
            course.push(format!("{step} {hash:016x} {:?} {:?} {}", report.solve, simulation.energy(), contacts.len()));
            course.push(contacts.join("\n"));
            course.push(format!("{:?} {:?}", simulation.wall_loads(), simulation.passed()));
        }
    }
    course
}

fn same_on_any_number_of_ranks(scene: &Scene, before: usize, steps: usize, change: impl Fn(&mut Simulation)) {
    let mut simulation = Simulation::new(scene, scene.seed).unwrap_or_else(|error| panic!("{error}"));
    change(&mut simulation);
    for _ in 0..before {
        simulation.step();
    }
    let start = simulation.checkpoint();
    let expected = course(&mut simulation, steps, steps / 2);
    assert!(simulation.layout().contacts > 0, "{}", scene.name);
    let checkpoint = simulation.checkpoint();
    for count in [1, 2, 3, 4, 7] {
        let mut start = Simulation::resume(scene, &start).unwrap();
        change(&mut start);
        let threads = 1 + count % 2;
        start.use_team(Scheduler::WorkStealing, threads).unwrap();
        let (found, state) =
            on_ranks(count, scene, start, |simulation| (course(simulation, steps, steps / 2), simulation.checkpoint()));
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found, expected, "{}, {count} ranks", scene.name);
        }
        assert!(state == checkpoint, "{}, {count} ranks: another checkpoint", scene.name);
    }
}

/// Reference scenes with what ranks exchange: grains over borders, meshes, sources and sinks, dynamic walls, stages, torques.
#[test]
fn reference_scenes_have_the_same_bits_on_ranks() {
    for (name, before, steps) in [
        ("drum", 300, 120),
        ("packing", 0, 200),
        ("heap", 400, 60),
        ("drum-segregation", 200, 40),
        ("hopper", 1500, 60),
        ("silo", 300, 60),
        ("triaxial", 600, 60),
        ("screw", 300, 40),
        ("drum-rolling", 200, 40),
        ("cohesive-heap", 300, 40),
    ] {
        same_on_any_number_of_ranks(&reference_scene(name), before, steps, |_| ());
    }
}

/// Around a period of two boxes, two boxes are neighbours on both sides.
#[test]
fn periodic_scenes_have_the_same_bits_on_ranks() {
    for (diameters, grains) in [(17.0, 2000), (25.0, 5000)] {
        same_on_any_number_of_ranks(&crate::periodic::gas(diameters, grains), 100, 60, |_| ());
    }
}

/// A stage that changes a setting starts the simulation anew.
#[test]
fn stages_have_the_same_bits_on_ranks() {
    for change in [
        "material.grain = { friction = 0.1 }",
        "gravity = [-4.0, 0.0, -9.0]",
        "solver = { step = 2e-4 }",
        "motion.box = { kind = 'translating', velocity = [0, 0, 0.1] }",
        "solver = { stop = { kind = 'residual', tolerance = 0.01, max_sweeps = 200 } }",
        "solver = { precision = 'single' }",
    ] {
        let text = format!(
            "name = 'trough'\ngravity = [4.0, 0.0, -9.0]\ndomain = {{ min = [-0.1, -0.1, -0.1], max = [1.1, 0.2, 0.5] }}\n\
             [material.grain]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n\
             [[wall]]\nname = 'box'\nmaterial = 'grain'\n\
             shape = {{ kind = 'box', min = [0.0, 0.0, 0.0], max = [1.0, 0.06, 0.2], open = ['+z'] }}\n\
             [[population]]\ncount = 400\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.2 }}\n\
             region = {{ kind = 'box', min = [0.0, 0.0, 0.0], max = [1.0, 0.06, 0.2] }}\n[solver]\nstep = 5e-4\n\
             [[stage]]\nname = 'a'\nduration = 0.03\n[[stage]]\nname = 'b'\nduration = 0.03\n{change}\n"
        );
        let scene = Scene::parse(&text).unwrap_or_else(|error| panic!("{change}: {error}"));
        same_on_any_number_of_ranks(&scene, 20, 100, |_| ());
    }
}

/// A scene with a target accuracy has a chosen step.
#[test]
fn an_accuracy_has_the_same_bits_on_ranks() {
    let mut scene = reference_scene("packing");
    scene.ask(Accuracy { relative: Some(0.05), ..Accuracy::default() });
    same_on_any_number_of_ranks(&scene, 0, 20, |_| ());
}

/// Fast grains meet walls and each other within a step, outside of the list.
#[test]
fn fast_grains_have_the_same_bits_on_ranks() {
    let mut scene = reference_scene("packing");
    scene.population.iter_mut().for_each(|population| population.agitation = 20.0);
    same_on_any_number_of_ranks(&scene, 0, 40, |_| ());
}

#[test]
fn single_precision_has_the_same_bits_on_ranks() {
    let single = |simulation: &mut Simulation| simulation.use_precision(Precision::Single).unwrap();
    same_on_any_number_of_ranks(&reference_scene("packing"), 100, 40, single);
}

/// The bits depend on the seed, so that equal hashes say something; and every rank has its share of the contacts.
#[test]
fn another_seed_has_other_bits_on_ranks() {
    let scene = crate::periodic::gas(25.0, 5000);
    let run = |seed: u64| {
        on_ranks(3, &scene, Simulation::new(&scene, seed).unwrap(), |simulation| {
            (0..150).for_each(|_| _ = simulation.step());
            let own: usize = simulation.layout().tasks().map(|(_, task)| task.contacts()).sum();
            let all = simulation.layout().contacts;
            assert!(own > all / 5 && own < all / 2, "rank 0 of 3 has {own} of {all} contacts");
            simulation.state_hash()
        })
    };
    assert_ne!(run(1), run(2));
}

#[test]
fn settings_for_one_rank_are_refused() {
    let scene = reference_scene("packing");
    let refusal = |change: fn(&mut Simulation)| {
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        change(&mut simulation);
        simulation.divide_among(&scene, &Thread::all(1)[0]).unwrap_err().to_string()
    };
    let text = refusal(Simulation::open_ledger);
    assert_eq!(text, "several ranks do not go with an energy ledger; leave it out, or start one rank");
    let text = refusal(|simulation| simulation.use_method(SolverMethod::Jacobi { damping: 0.3 }).unwrap());
    assert!(text.contains("a method other than Gauss-Seidel"), "{text}");
    let text = refusal(|simulation| simulation.use_stop(Stop::TimeBudget { seconds: 1.0, max_sweeps: 10 }));
    assert!(text.contains("a budget of wall time"), "{text}");
}
