//! A drum that turns: the angle at which its bed flows. `cargo run --release --example drum`
//!
//! The angle is that of the straight line through the highest grains, seen along the axis.

use makadam::{
    Axis, Error, Frame, Material, Motion, Population, RadiusDistribution, Region, Scene, Shape, Simulation, Wall,
};

/// Inner radius and length of the drum, m.
const RADIUS: f64 = 0.06;
const LENGTH: f64 = 0.04;
/// Angular velocity, rad/s.
const RATE: f64 = 2.0;
/// Width of the strips in which the highest grain is taken, m.
const STRIP: f64 = 0.01;

fn main() -> Result<(), Error> {
    let axis = [0.0, 1.0, 0.0];
    let shell = Shape::Cylinder { base: [0.0; 3], axis, radius: RADIUS, length: LENGTH };
    let turning = Motion::Rotating { point: [0.0; 3], axis, rate: RATE, start: 0.0, stop: None, reverse: None };
    let within = Region::Cylinder { base: [0.0; 3], axis, radius: RADIUS, length: LENGTH };
    let scene = Scene::builder()
        .name("drum")
        .duration(4.0)
        .material("glass", Material { friction: 0.6, ..Material::default() })
        .domain([-RADIUS, 0.0, -RADIUS], [RADIUS, LENGTH, RADIUS])
        .periodic(Axis::Y)
        .wall(Wall::new("shell", "glass", shell).moving(turning))
        .population(Population::new(400, "glass", RadiusDistribution::uniform(0.004, 0.05), within))
        .build()?;
    let mut simulation = Simulation::builder(&scene).seed(1).threads(2).build()?;
    let (mut angles, mut next) = (Vec::new(), 2.0);
    while simulation.time() < scene.duration {
        simulation.step();
        if simulation.time() >= next {
            angles.push(angle(&simulation.frame()));
            next += 0.05;
        }
    }
    let mean = angles.iter().sum::<f64>() / angles.len() as f64;
    println!("angle of the flowing surface {mean:.1} degrees, mean of {} frames", angles.len());
    Ok(())
}

/// Angle of the straight line that fits the highest grain of each strip across the drum best, degrees.
fn angle(frame: &Frame) -> f64 {
    let strips = (2.0 * RADIUS / STRIP) as usize;
    let mut highest = vec![None::<[f64; 3]>; strips];
    for &position in frame.positions() {
        let strip = (((position[0] + RADIUS) / STRIP) as usize).min(strips - 1);
        if highest[strip].is_none_or(|other| other[2] < position[2]) {
            highest[strip] = Some(position);
        }
    }
    let points: Vec<[f64; 3]> = highest.into_iter().flatten().collect();
    let mean = |of: usize| points.iter().map(|point| point[of]).sum::<f64>() / points.len() as f64;
    let (x, z) = (mean(0), mean(2));
    let covariance: f64 = points.iter().map(|point| (point[0] - x) * (point[2] - z)).sum();
    let variance: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    (covariance / variance).atan().to_degrees().abs()
}
