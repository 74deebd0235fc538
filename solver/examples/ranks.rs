//! Prints the number of ranks of this launch, and the hash of the state of a scene every 100 steps.
//!
//! ```sh
//! cargo build --release -p makadam --features mpi --example ranks
//! mpirun -n 4 target/release/examples/ranks reference-scenes/drum/scene.toml 500
//! ```
//!
//! Further arguments: threads of each rank (1), seed (that of the scene).

use makadam::messages::Messages;
use makadam::messages::mpi::World;
use makadam::{Scene, Simulation, dismiss, follow};
use std::sync::Arc;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ranks: Arc<dyn Messages> = Arc::new(World::join().ok_or("MPI cannot be started")?);
    if ranks.rank() > 0 {
        follow(&ranks);
        return Ok(());
    }
    let mut arguments = std::env::args().skip(1);
    let scene = Scene::load(arguments.next().ok_or("name a scene")?)?;
    let mut number = |default| arguments.next().map_or(Ok(default), |text| text.parse::<u64>());
    let (steps, threads, seed) = (number(500)?, number(1)?, number(scene.seed)?);
    let mut simulation = Simulation::builder(&scene).seed(seed).threads(threads as usize).build()?;
    if ranks.ranks() > 1 {
        simulation.divide_among(&scene, &ranks)?;
    }
    println!("{} ranks of {threads} threads", ranks.ranks());
    let start = Instant::now();
    for step in 1..=steps {
        simulation.step();
        if step % 100 == 0 || step == steps {
            println!("{step} {:016x}", simulation.state_hash());
            eprintln!("{step} steps in {:.3} s", start.elapsed().as_secs_f64());
        }
    }
    eprintln!("{:.3?}, {:.3} s in messages", simulation.phase_seconds(), simulation.exchange_seconds());
    drop(simulation);
    dismiss(&ranks);
    Ok(())
}
