//! Hashes of the physics of a scene.

use super::Scene;
use makadam::checkpoint::checksum;

/// Hash of what every code is given of a scene and of the times at which it is measured, 16
/// hexadecimal digits. Names, Makadam's own settings and output, margins and registered seeds are left out: they
/// may change without a new recording.
pub fn physics_hash(scene: &Scene) -> String {
    let mut physics = physics_of(scene);
    if let Some(measure) = physics.get_mut("measure").and_then(|measure| measure.as_object_mut()) {
        for key in ["observables", "seeds", "rest_energy"] {
            measure.remove(key);
        }
    }
    format!("{:016x}", checksum(physics.to_string().as_bytes()))
}

/// Hash of the physics of a scene alone, 16 hexadecimal digits: what is measured and how long it is run are left out, too.
pub fn setup_hash(scene: &Scene) -> String {
    let mut physics = physics_of(scene);
    if let Some(table) = physics.as_object_mut() {
        table.remove("measure");
        table.remove("duration");
    }
    format!("{:016x}", checksum(physics.to_string().as_bytes()))
}

/// A scene without what only Makadam is told, and what is made of its numbers.
fn physics_of(scene: &Scene) -> serde_json::Value {
    let mut physics = serde_json::to_value(scene).expect("a checked scene holds finite numbers");
    if let Some(table) = physics.as_object_mut() {
        for key in ["name", "description", "seed", "solver", "accuracy", "watch", "output", "compare"] {
            table.remove(key);
        }
    }
    physics
}
