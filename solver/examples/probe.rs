//! Runs a scene and prints where its time went: `probe SCENE_FILE [SEED] [STEPS]`.
use makadam::{Simulation, scene::Scene};
use std::path::Path;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let file = Path::new(&arguments[1]);
    let seed = arguments.get(2).map_or(1, |text| text.parse().expect("a seed"));
    let mut scene = Scene::load(file).unwrap_or_else(|error| panic!("{error}"));
    for setting in &arguments[4.min(arguments.len())..] {
        let (key, value) = setting.split_once('=').expect("key=value");
        let number: f64 = value.parse().expect("a number");
        match key {
            "step" => scene.solver.step = number,
            "sweeps" => scene.solver.stop = makadam::scene::Stop::Sweeps { sweeps: number as u32 },
            "skin" => scene.solver.skin = number,
            "relaxation" => scene.solver.over_relaxation = number,
            "tau" => scene.solver.damping_steps = number,
            "stiffness" => scene = scene.with_stiffness_factor(number),
            _ => panic!("{key}"),
        }
    }
    let mut simulation = Simulation::new(&scene, seed, file).unwrap_or_else(|error| panic!("{error}"));
    let steps = arguments
        .get(3)
        .and_then(|text| text.parse().ok())
        .filter(|&steps| steps > 0)
        .unwrap_or((scene.duration / scene.solver.step).round() as u64);
    let start = std::time::Instant::now();
    let mut fell_back = 0;
    let mut report = Default::default();
    for step in 0..steps {
        report = simulation.step();
        fell_back += u32::from(report.solve.fell_back);
        if step % (steps / 5).max(1) == 0 {
            eprintln!("{:.3} s {:?}", simulation.time(), simulation.energy());
        }
    }
    let wall = start.elapsed().as_secs_f64();
    let phases = simulation.phase_seconds();
    println!(
        "wall {wall:.2} s, {:.2} s a simulated second, {:.2} ns a contact sweep, occupancy {:.3}, rebuilds {}, fell back {fell_back}, hash {:016x}",
        wall / simulation.time(),
        phases.sweep * 1e9 / simulation.contact_sweeps() as f64,
        simulation.layout().lane_occupancy(),
        simulation.rebuilds(),
        simulation.state_hash()
    );
    println!("{phases:?}\n{report:?}");
    let snapshot = simulation.snapshot();
    let top = snapshot.particles.iter().map(|p| p.position[2]).fold(f64::MIN, f64::max);
    let weight: f64 = scene.gravity[2].abs()
        * snapshot.particles.iter().map(|p| 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * p.radius.powi(3)).sum::<f64>();
    let up: f64 = snapshot
        .contacts
        .iter()
        .filter(|c| matches!(c.second, makadam::snapshot::Partner::Wall(_)))
        .map(|c| -(c.normal[2] * c.normal_force + c.tangential_force[2]))
        .sum();
    for ring in 0..16 {
        let (inner, outer) = (f64::from(ring) * 0.01, f64::from(ring + 1) * 0.01);
        let heights = snapshot.particles.iter().filter(|p| {
            let r = p.position[0].hypot(p.position[1]);
            r >= inner && r < outer
        });
        let (count, top) = heights.fold((0, 0.0_f64), |(n, top), p| (n + 1, top.max(p.position[2])));
        print!("[{count} {top:.3}] ");
    }
    println!();
    println!("top {top:.4}, walls / weight {:.6}, contacts {}", up / weight, snapshot.contacts.len());
}
