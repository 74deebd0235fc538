//! Hashes of scenes, by which stored results are found again.

use super::MeasuredScene;
use makadam::checkpoint::checksum;
use makadam::scene::Watch;
use serde::Serialize;

/// Hash of everything that a scene says of what is simulated (64-bit FNV-1a over its JSON form), the same on every machine. What a
/// run watches for is left out: it changes when a run ends, and nothing of what came before.
pub fn scene_hash(scene: &MeasuredScene) -> u64 {
    let MeasuredScene { simulated, prepare, measure, output, compare } = scene;
    let simulated = json(&makadam::scene::Scene { watch: Watch::default(), ..simulated.clone() });
    let accuracy =
        scene.accuracy.as_ref().map_or(String::new(), |accuracy| format!(",\"accuracy\":{}", json(accuracy)));
    let settings = format!("{accuracy},\"solver\":{}", json(&scene.solver));
    // Recorded hashes were taken with `prepare` before the settings of the solver, which stand last.
    let physics = simulated.strip_suffix(&format!("{settings}}}")).expect("settings end a simulated scene");
    let output = output.as_ref().map_or(String::new(), |output| format!(",\"output\":{}", json(output)));
    let (prepare, measure, compare) = (json(prepare), json(measure), json(compare));
    let text =
        format!("{physics},\"prepare\":{prepare}{settings},\"measure\":{measure}{output},\"compare\":{compare}}}");
    checksum(text.as_bytes())
}

fn json(part: &impl Serialize) -> String {
    serde_json::to_string(part).expect("a checked scene holds only finite numbers and plain text")
}

/// Hash of what every code is given of a scene and of the times at which it is measured, 16
/// hexadecimal digits. Names, Makadam's own settings and output, margins and registered seeds are left out: they
/// may change without a new recording.
pub fn physics_hash(scene: &MeasuredScene) -> String {
    hash_without(scene, &[], &["observables", "seeds", "rest_energy"])
}

/// Hash of the physics of a scene alone, 16 hexadecimal digits: what is measured and how long it is run are left out, too.
pub fn setup_hash(scene: &MeasuredScene) -> String {
    hash_without(scene, &["measure", "duration"], &[])
}

/// Hash of a scene without what only Makadam is told, and without further keys of it and of its table `measure`.
fn hash_without(scene: &MeasuredScene, keys: &[&str], of_measure: &[&str]) -> String {
    let mut physics = serde_json::to_value(scene).expect("a checked scene holds finite numbers");
    let mut remove = |table: &str, keys: &[&str]| {
        if let Some(table) = physics.pointer_mut(table).and_then(|table| table.as_object_mut()) {
            keys.iter().for_each(|key| _ = table.remove(*key));
        }
    };
    remove("", &["name", "description", "seed", "solver", "accuracy", "watch", "output", "compare"]);
    remove("", keys);
    remove("/measure", of_measure);
    format!("{:016x}", checksum(physics.to_string().as_bytes()))
}

#[cfg(test)]
#[path = "../../tests/unit/plan_hashes.rs"]
mod tests;
