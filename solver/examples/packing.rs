//! Grains that fall into a box: how many contacts they come to have. `cargo run --release --example packing`

use makadam::{
    Error, Face, Material, Partner, Population, RadiusDistribution, Region, Scene, Shape, Simulation, SolverSettings,
    Stop, Wall,
};

fn main() -> Result<(), Error> {
    let glass = Material { friction: 0.3, restitution: 0.3, ..Material::default() };
    let [min, max] = [[0.0; 3], [0.1, 0.1, 0.3]];
    let scene = Scene::builder()
        .name("packing")
        .material("glass", glass)
        .wall(Wall::new("box", "glass", Shape::cuboid(min, max, &[Face::Top])))
        .population(Population::new(1000, "glass", RadiusDistribution::uniform(0.005, 0.1), Region::cuboid(min, max)))
        .solver(SolverSettings { stop: Stop::Residual { tolerance: 0.01, max_sweeps: 2000 }, ..Default::default() })
        .build()?;
    let mut simulation = Simulation::builder(&scene).seed(1).threads(2).time_step(5e-4).build()?;
    while simulation.time() < 1.0 {
        // Nothing passes that has not converged.
        simulation.step().solve.require_converged()?;
    }
    let frame = simulation.frame();
    let walls = frame.contacts().iter().filter(|contact| matches!(contact.second, Partner::Wall(_))).count();
    println!("coordination number {:.3}, {walls} contacts with walls", frame.coordination_number());
    Ok(())
}
