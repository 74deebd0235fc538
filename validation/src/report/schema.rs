//! The JSON Schema of `report.json`, from the types that write it.

use super::write::ReportDocument;
use crate::scenes;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// The JSON Schema (draft 2020-12) of what this version writes. A field that is always written is required, so that a reader knows what he
/// can rely on; a report of an earlier version may lack fields that came later.
pub fn schema() -> Value {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<ReportDocument>().to_value();
    // What the keys of a scene mean stands with those who read its file.
    let of_file = scenes::schema();
    let keys = schema.pointer_mut("/$defs/Scene/properties").and_then(Value::as_object_mut);
    for (key, value) in keys.into_iter().flatten() {
        if let (Value::Object(value), Some(meaning)) = (value, of_file["properties"][key].get("description")) {
            value.insert("description".into(), meaning.clone());
        }
    }
    schema["title"] = "Makadam report".into();
    schema["description"] = "What report.json of a qualification or a comparison holds. Units are SI.".into();
    schema
}
