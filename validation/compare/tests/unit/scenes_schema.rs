//! Unit tests of `src/scenes/schema.rs`.

use super::*;
use crate::scenes;

#[test]
fn every_held_scene_has_only_keys_of_the_schema() {
    let schema = schema();
    let known = schema["properties"].as_object().unwrap();
    for name in scenes::names() {
        let text = scenes::text(&scenes::find(name, &[]).unwrap()).unwrap();
        let table: toml::Table = toml::from_str(&text).unwrap();
        assert!(table.keys().all(|key| known.contains_key(key)), "{name}");
    }
    for key in ["solver", "measure", "compare", "prepare", "material"] {
        assert!(known.contains_key(key), "{key}");
    }
}

#[test]
fn every_key_is_described() {
    let schema = schema();
    let tables = schema["$defs"].as_object().unwrap().values().chain([&schema]);
    for table in tables {
        for (key, value) in table["properties"].as_object().into_iter().flatten() {
            assert!(value["description"].is_string(), "{key} of {}", table["title"]);
        }
    }
}

#[test]
fn the_page_is_what_the_types_say() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene-reference.md");
    let written = std::fs::read_to_string(&file).unwrap_or_default();
    assert_eq!(written, page(), "make it anew: makadam print schema --markdown > docs/scene-reference.md");
}
