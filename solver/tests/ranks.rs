//! Runs on several ranks have the bits of one: here, ranks are threads that pass messages through channels. `tests/mpi` of the command
//! starts processes.

use makadam::messages::{Messages, Parcel};
use makadam::{Scene, Scheduler, Simulation, dismiss, follow};
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

    fn exchange(&self, sent: &[Parcel], received: &mut [Parcel]) {
        sent.iter().for_each(|(rank, bytes)| self.send(*rank, bytes.clone()));
        for (rank, bytes) in received {
            let length = bytes.len();
            *bytes = self.receive(*rank);
            assert_eq!(bytes.len(), length, "from rank {rank} to rank {}", self.own);
        }
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
    std::thread::scope(|scope| {
        // A follower that fails takes its end of the channels with it, so that the others fail too.
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
        let threads = 1 + count % 2;
        start.use_team(Scheduler::WorkStealing, threads).unwrap();
        let (found, state) = on_ranks(count, scene, start, |simulation| {
            (course(simulation, steps, steps / 2), simulation.checkpoint())
        });
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found, expected, "{}, {count} ranks", scene.name);
        }
        assert!(state == checkpoint, "{}, {count} ranks: another checkpoint", scene.name);
    }
}

/// The reference scenes that simulate what ranks must exchange: grains over borders, periods, meshes, sources and sinks, dynamic walls,
/// stages, moving walls, torques.
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
        ("cooling-gas", 10, 60),
        ("cohesive-heap", 300, 40),
        ("oedometer", 300, 40),
        ("vibrated-bed", 300, 40),
        ("packing-20k", 200, 20),
    ] {
        let clock = std::time::Instant::now();
        same_on_any_number_of_ranks(&reference_scene(name), before, steps, |_| ());
        eprintln!("{name}: {:.1} s", clock.elapsed().as_secs_f64());
    }
}
