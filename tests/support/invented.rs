//! Invented records of YADE and LIGGGHTS, for tests of what is made of records.

use makadam_frames::plan::MeasuredScene;
use makadam_frames::plan::physics_hash;
use std::path::Path;

/// Writes what is recorded of both codes on a scene into a folder: three seeds of the force on walls over the weight, a little above 1.
pub fn record(folder: &Path, scene_file: &Path) {
    let hash = physics_hash(&MeasuredScene::load(scene_file).unwrap());
    std::fs::create_dir_all(folder).unwrap();
    let mut runs = String::from(
        "code,version,contact_law,seed,time_step,rayleigh_fraction,wall_seconds,simulated_seconds,processor,date,\
         scene_hash\n",
    );
    let mut measurements =
        String::from("code,version,seed,time_step,rayleigh_fraction,observable,unit,value,standard_error,frames\n");
    for code in ["YADE", "LIGGGHTS"] {
        for seed in 1..=3 {
            let law = "\"Hertz-Mindlin, damped\"";
            runs += &format!("{code},1.0,{law},{seed},1e-5,0.1,4.0,0.4,invented,2026-01-01T00:00:00Z,{hash}\n");
            let value = 1.0 + 0.001 * f64::from(seed);
            measurements += &format!("{code},1.0,{seed},1e-5,0.1,wall_force_over_weight,,{value},,1\n");
        }
    }
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("runs.csv", &runs);
    write("measurements.csv", &measurements);
    write("forces.csv", "code,force_over_mean,density,samples\n");
    write("series.csv", "code,seed,observable,time,value\n");
}
