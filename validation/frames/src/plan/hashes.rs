//! Hashes of scenes, used as keys of stored results.

use super::MeasuredScene;
use makadam::checkpoint::checksum;
use makadam::scene::Watch;
use serde::Serialize;

/// Returns the hash of the simulated scene (64-bit FNV-1a over its JSON form), the same on every machine. The watchdog settings of a
/// run and the limits of its stages are excluded: they change the end of a run, and no earlier state.
pub fn scene_hash(scene: &MeasuredScene) -> u64 {
    let MeasuredScene { simulated, prepare, measure, output, compare } = scene;
    let mut simulated = makadam::scene::Scene { watch: Watch::default(), ..simulated.clone() };
    if !simulated.stage.is_empty() {
        simulated.duration = 0.0;
        simulated.stage.iter_mut().for_each(|stage| stage.at_most = None);
    }
    let simulated = json(&simulated);
    let accuracy =
        scene.accuracy.as_ref().map_or(String::new(), |accuracy| format!(",\"accuracy\":{}", json(accuracy)));
    let settings = format!("{accuracy},\"solver\":{}", json(&scene.solver));
    // Recorded hashes were taken with `prepare` before the solver settings, which are last.
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

/// Returns the hash of a scene's input for all codes and of its measurement times, 16
/// hexadecimal digits. Excluded are names, Makadam's own settings and output, margins and registered seeds: they
/// may change without a new recording.
pub fn physics_hash(scene: &MeasuredScene) -> String {
    hash_without(scene, &[], &["observables", "seeds", "rest_energy"])
}

/// Returns the hash of a scene's physics alone, 16 hexadecimal digits; measurements and duration are excluded, too.
pub fn setup_hash(scene: &MeasuredScene) -> String {
    hash_without(scene, &["measure", "duration"], &[])
}

/// Returns the hash of a scene without Makadam's own settings, and without further keys of the scene and of its table `measure`.
fn hash_without(scene: &MeasuredScene, keys: &[&str], of_measure: &[&str]) -> String {
    let mut physics = serde_json::to_value(scene).expect("a checked scene holds finite numbers");
    let mut remove = |table: &str, keys: &[&str]| {
        if let Some(table) = physics.pointer_mut(table).and_then(|table| table.as_object_mut()) {
            keys.iter().for_each(|key| _ = table.remove(*key));
        }
    };
    remove("", &["name", "description", "seed", "solver", "accuracy", "watch", "output", "compare"]);
    remove("", keys);
    for number in 0..scene.stage.len() {
        remove(&format!("/stage/{number}"), &["name", "solver", "output"]);
    }
    remove("/measure", of_measure);
    format!("{:016x}", checksum(physics.to_string().as_bytes()))
}

#[cfg(test)]
#[path = "../../tests/unit/plan_hashes.rs"]
mod tests;
