//! Prints what the measurement code finds in recordings: `measure SCENE RECORDING...`

use makadam_validation::observables::{ForcePool, measure};
use makadam_validation::plan::Scene;
use makadam_validation::recording::Recording;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene_file, files @ ..] = arguments.as_slice() else {
        return Err("usage: measure SCENE.toml RECORDING.rec...".into());
    };
    let scene = Scene::load(Path::new(scene_file))?;
    let mut pools: Vec<ForcePool> = Vec::new();
    for file in files {
        let recording = Recording::load(Path::new(file))?;
        let start = Instant::now();
        let measurements = measure(&scene, &recording);
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{} {} seed {}: {} frames, measured in {seconds:.3} s",
            recording.code,
            recording.scene,
            recording.seed,
            recording.frames.len()
        );
        for measurement in &measurements {
            let error = measurement.standard_error.map_or(String::new(), |error| format!(" +- {error:.5}"));
            println!("  {:38} {:>12.5}{error} {}", measurement.observable, measurement.value, measurement.unit);
        }
        if !pools.iter().any(|pool| pool.code == recording.code) {
            pools.push(ForcePool::new(&recording.code));
        }
        pools
            .iter_mut()
            .filter(|pool| pool.code == recording.code)
            .for_each(|pool| pool.add_recording(&scene, &recording));
    }
    for (index, first) in pools.iter().enumerate() {
        for second in &pools[index + 1..] {
            println!(
                "{} and {}: Kolmogorov-Smirnov {:.4}, Wasserstein {:.4} ({} and {} forces)",
                first.code,
                second.code,
                first.kolmogorov_smirnov(second),
                first.wasserstein(second),
                first.samples(),
                second.samples()
            );
        }
    }
    Ok(())
}
