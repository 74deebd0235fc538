//! Output folder of a study: one study at a time writes there, and its tables are those of one study.

use super::study::{ParameterError, Plan};
use makadam_frames::output::{FolderLock, LockError};
use makadam_frames::plan::Scene;
use makadam_frames::provenance::scene_hash;
use serde_json::Value;
use std::path::Path;

/// Takes the output folder for a study.
///
/// The tables of an earlier study may be replaced only by those of a study that contains it: the same scene and keys, every
/// combination and every seed. `plan.again` lifts that.
pub fn take(plan: &Plan<'_>, scene: &Scene) -> Result<FolderLock, ParameterError> {
    let lock = FolderLock::take(plan.folder).map_err(|error| match error {
        LockError::Write(error) => ParameterError::Run(error.into()),
        taken @ LockError::Taken { .. } => ParameterError::Usage(taken.to_string()),
    })?;
    let earlier = read(plan.folder).filter(|_| !plan.again);
    match earlier.and_then(|earlier| difference(&earlier, plan, scene)) {
        None => Ok(lock),
        Some(difference) => Err(ParameterError::Usage(format!(
            "{} holds the tables of another sweep ({difference}); --output writes elsewhere, --restart replaces them",
            plan.folder.display()
        ))),
    }
}

/// Document of the study in a folder; none where there is none that can be read.
fn read(folder: &Path) -> Option<Value> {
    let document: Value = serde_json::from_slice(&std::fs::read(folder.join("sweep.json")).ok()?).ok()?;
    (document["command"] == "sweep").then_some(document)
}

/// Part of an earlier study that the planned one does not contain, in words.
fn difference(earlier: &Value, plan: &Plan<'_>, scene: &Scene) -> Option<String> {
    let words = |list: &Value| -> Vec<String> {
        list.as_array().into_iter().flatten().filter_map(|word| word.as_str().map(String::from)).collect()
    };
    let keys = words(&earlier["keys"]);
    if !keys.iter().eq(plan.ranges.iter().map(|range| &range.key)) {
        return Some(format!("over {}", keys.join(", ")));
    }
    let hash = &earlier["provenance"][format!("scene_hash_of_{}", scene.name)];
    if *hash != format!("{:016x}", scene_hash(scene)) {
        return Some("of another scene, or with another --set".into());
    }
    let points = || earlier["points"].as_array().into_iter().flatten();
    for point in points() {
        let values = words(&point["values"]);
        let planned = values.iter().zip(plan.ranges).all(|(value, range)| range.values.contains(value));
        if !planned {
            let pairs = keys.iter().zip(&values).map(|(key, value)| format!("{key}={value}"));
            return Some(format!("with {}", pairs.collect::<Vec<_>>().join(", ")));
        }
    }
    let mut seeds = points().flat_map(|point| point["runs"].as_array().into_iter().flatten());
    let missing = seeds.find_map(|run| run["seed"].as_u64().filter(|seed| !plan.seeds.contains(seed)));
    missing.map(|seed| format!("with seed {seed}"))
}
