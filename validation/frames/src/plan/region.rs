//! Regions whose grains are counted.

use super::MeasuredScene;
use makadam::scene::{Checked, DocumentPath, Region};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Region whose grains are counted in each frame: those with their centre inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CountedRegion {
    /// Name, as in `grain_count(NAME)`.
    pub name: String,
    /// Region.
    pub within: Region,
    /// Name of the material of the counted grains; default: all grains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// Checks the regions of a scene: names of their own, and known materials.
pub(super) fn check(scene: &MeasuredScene) -> Checked {
    let root = DocumentPath::default();
    for (index, region) in scene.measure.region.iter().enumerate() {
        let at = root.key("measure").key("region").index(index);
        let is_named = |other: &CountedRegion| other.name == region.name;
        if region.name.is_empty() || scene.measure.region[..index].iter().any(is_named) {
            let problem = format!("'{}' is empty or the name of another region", region.name);
            return Err(at.key("name").fault(problem, "give each region a name of its own"));
        }
        region.within.check(&at.key("within"))?;
        if let Some(material) = region.material.as_ref().filter(|name| !scene.material.contains_key(*name)) {
            let known: Vec<&str> = scene.material.keys().map(String::as_str).collect();
            let problem = format!("there is no material '{material}'");
            return Err(at.key("material").fault(problem, &format!("name one of: {}", known.join(", "))));
        }
    }
    Ok(())
}
