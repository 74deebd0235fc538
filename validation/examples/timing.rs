//! Processor time of a reference code's stepping by its input for measuring and by that for timing, and what both measure:
//! `timing SCENE CODE RAYLEIGH_FRACTION DURATION [SEED]`. What the tables of `validation/docs/timing.md` are made from.

use makadam_compare::codes::{CodeName, Job, Purpose};
use makadam_compare::scenes;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::measure;
use std::path::PathBuf;
use std::time::Duration;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, code, fraction, duration, seed @ ..] = &arguments[..] else {
        return Err("usage: timing SCENE CODE RAYLEIGH_FRACTION DURATION [SEED]".into());
    };
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let file = scenes::find(scene, &[root])?;
    let mut scene = MeasuredScene::load(&file)?;
    scene.duration = duration.parse()?;
    let code = CodeName::of(code)?.code();
    for purpose in [Purpose::Measuring, Purpose::Timing] {
        let work_folder = std::env::temp_dir().join(format!("timing-{}", std::process::id()));
        let recording = code.simulate(&Job {
            scene: &scene,
            scene_file: &file,
            purpose,
            seed: seed.first().map_or(Ok(1), |seed| seed.parse())?,
            stiffness_factor: 1.0,
            rayleigh_fraction: fraction.parse()?,
            work_folder: &work_folder,
            time_limit: Duration::from_secs(24 * 3600),
            progress: &|_| {},
        })?;
        let _ = std::fs::remove_dir_all(&work_folder);
        let pace = recording.core_seconds.map(|seconds| seconds / recording.simulated_seconds);
        println!(
            "{} {} {purpose:?}: {pace:.3?} s of processor time, {:.3} s of wall time a simulated second",
            recording.code,
            recording.scene,
            recording.wall_seconds / recording.simulated_seconds
        );
        for measured in measure(&scene, &recording) {
            let error = measured.standard_error.map_or(String::new(), |error| format!(" +- {error:.4}"));
            println!("  {} {:.4}{error}", measured.observable, measured.value);
        }
    }
    Ok(())
}
