//! Runs one job in one peer and saves the recording: `record SCENE CODE SEED RAYLEIGH_FRACTION OUTPUT`.
//!
//! A recording that is already there is left alone.

use makadam_validation::peers::{Code, Job, Liggghts, Purpose, Yade};
use makadam_validation::plan::Scene;
use makadam_validation::scenes;
use std::path::{Path, PathBuf};
use std::time::Duration;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, code, seed, fraction, output] = &arguments[..] else {
        return Err("usage: record SCENE CODE SEED RAYLEIGH_FRACTION OUTPUT".into());
    };
    let output = Path::new(output);
    if output.exists() {
        eprintln!("{} is there already", output.display());
        return Ok(());
    }
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let file = scenes::find(scene, &[root])?;
    let scene = Scene::load(&file)?;
    let code: Box<dyn Code> = match code.as_str() {
        "yade" => Box::new(Yade::default()),
        "liggghts" => Box::new(Liggghts::default()),
        other => return Err(format!("no code '{other}': use yade or liggghts").into()),
    };
    let work_folder = output.with_extension("run");
    let recording = code.simulate(&Job {
        scene: &scene,
        scene_file: &file,
        purpose: Purpose::Measuring,
        seed: seed.parse()?,
        stiffness_factor: 1.0,
        rayleigh_fraction: fraction.parse()?,
        work_folder: &work_folder,
        time_limit: Duration::from_secs(24 * 3600),
        progress: &|_| {},
    })?;
    recording.save(output)?;
    std::fs::remove_dir_all(&work_folder)?;
    println!(
        "{} {} seed {seed}: {:.1} s of wall time for {:.2} s, step {:.3e} s, {} frames",
        recording.code,
        recording.scene,
        recording.wall_seconds,
        recording.simulated_seconds,
        recording.time_step,
        recording.frames.len()
    );
    Ok(())
}
