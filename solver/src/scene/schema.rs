//! The JSON Schema of a scene's file, as far as it says what is simulated.

use super::Scene;
use super::document::Document;
use schemars::Schema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// The schema (draft 2020-12) of the file: its keys with types, defaults and meanings, and the tables under `$defs`.
pub fn schema() -> Schema {
    let generator = || SchemaSettings::draft2020_12().into_generator();
    let mut file = generator().into_root_schema_for::<Document>();
    // The file says which keys there are, the scene what they mean.
    let meanings = generator().into_root_schema_for::<Scene>();
    let meaning = |key: &str| meanings.get("properties")?.get(key)?.get("description").cloned();
    if let Some(Value::Object(keys)) = file.get_mut("properties") {
        for (key, value) in keys {
            if let (Value::Object(value), Some(meaning)) = (value, meaning(key)) {
                value.insert("description".into(), meaning);
            }
        }
    }
    file
}
