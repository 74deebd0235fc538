//! Language of scenes, from the types that read it: as a JSON Schema, which editors complete with, and as a page to read.

use makadam_frames::plan::Tables;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value};
use std::fmt::Write;

/// Returns the JSON Schema (draft 2020-12) of a scene.
pub fn schema() -> Value {
    let mut scene = makadam::scene::schema().to_value();
    let tables = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Tables>().to_value();
    for part in ["properties", "$defs"] {
        let more = tables.get(part).and_then(Value::as_object).cloned().unwrap_or_default();
        scene[part].as_object_mut().expect("a scene has both").extend(more);
    }
    scene["title"] = "Makadam scene".into();
    scene["description"] = "A scene of granular matter. Units are SI.".into();
    scene
}

/// Returns the reference page of the language, in Markdown: every table with its keys, their types, defaults and meanings.
pub fn page() -> String {
    let schema = schema();
    let mut page = String::from(
        "# Scene reference\n\nA scene is a TOML file. Units are SI: metres, seconds, kilograms, pascals, radians. This page is made from \
         the types that read scenes: `makadam print schema --markdown` prints it, `makadam print schema` prints the JSON Schema that editors \
         complete with.\n\n",
    );
    let root = schema.as_object().expect("a schema is an object");
    let _ = writeln!(page, "## The scene\n");
    table(&mut page, root, &[]);
    let none = Map::new();
    let definitions = root.get("$defs").and_then(Value::as_object).unwrap_or(&none);
    for (name, definition) in definitions {
        let Some(definition) = definition.as_object() else { continue };
        let _ = writeln!(page, "\n## {name}\n\n{}\n", description(definition));
        match definition.get("oneOf").or_else(|| definition.get("anyOf")).and_then(Value::as_array) {
            Some(variants) => variants.iter().filter_map(Value::as_object).for_each(|variant| kind(&mut page, variant)),
            None if definition.contains_key("properties") => table(&mut page, definition, &[]),
            None => page += &words(definition),
        }
    }
    page
}

/// Adds one of the possible forms of a table: a word, or a table of some kind.
fn kind(page: &mut String, variant: &Map<String, Value>) {
    let word = |value: &Value| value.get("const").and_then(Value::as_str).map(String::from);
    let properties = variant.get("properties").and_then(Value::as_object);
    match properties.and_then(|properties| word(properties.get("kind")?)) {
        Some(name) => {
            let _ = writeln!(page, "`kind = \"{name}\"`: {}\n", description(variant));
            if properties.is_some_and(|properties| properties.len() > 1) {
                table(page, variant, &["kind"]);
                page.push('\n');
            }
        }
        None => *page += &words(variant),
    }
}

/// Returns the words, or the key, that a value can be.
fn words(variant: &Map<String, Value>) -> String {
    let keys = |of: &Map<String, Value>| of.get("properties").and_then(Value::as_object).cloned().unwrap_or_default();
    if let Some((key, value)) = keys(variant).into_iter().next() {
        let value = value.as_object().cloned().unwrap_or_default();
        let parts = keys(&value);
        let names: Vec<&str> = parts.keys().map(String::as_str).collect();
        let form = if names.is_empty() { type_of(&value) } else { format!("{{ {} }}", names.join(", ")) };
        let of_parts =
            parts.iter().filter_map(|(name, part)| Some(format!(" {name}: {}", description(part.as_object()?))));
        return format!("- `{key} = {form}`: {}{}\n", description(variant), of_parts.collect::<String>());
    }
    let single = variant.get("const").into_iter();
    let listed = variant.get("enum").and_then(Value::as_array).into_iter().flatten();
    let words: Vec<String> = single.chain(listed).map(|word| format!("`{word}`")).collect();
    let meaning = if variant.contains_key("const") { format!(": {}", description(variant)) } else { String::new() };
    let form = if words.is_empty() { type_of(variant) } else { words.join(", ") };
    format!("- {form}{meaning}\n")
}

/// Adds the keys of a table, except those of some names.
fn table(page: &mut String, schema: &Map<String, Value>, without: &[&str]) {
    let none = Map::new();
    let properties = schema.get("properties").and_then(Value::as_object).unwrap_or(&none);
    let required: Vec<&str> =
        schema.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect();
    *page += "| key | type | default | meaning |\n| --- | --- | --- | --- |\n";
    for (key, value) in properties.iter().filter(|(key, _)| !without.contains(&key.as_str())) {
        let Some(value) = value.as_object() else { continue };
        let default = match (required.contains(&key.as_str()), value.get("default")) {
            (true, _) => "required".to_string(),
            (false, Some(Value::Null) | None) => "none".to_string(),
            (false, Some(default)) => format!("`{}`", shown(default)),
        };
        let _ = writeln!(page, "| `{key}` | {} | {default} | {} |", type_of(value), description(value));
    }
}

/// Returns a default in the notation of TOML.
pub fn shown(value: &Value) -> String {
    match value {
        Value::Object(table) => {
            let entries: Vec<String> = table.iter().map(|(key, value)| format!("{key} = {}", shown(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        Value::Array(values) => format!("[{}]", values.iter().map(shown).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

/// Returns the type of a value, with links to the tables.
fn type_of(schema: &Map<String, Value>) -> String {
    if let Some(reference) = schema.get("$ref").and_then(Value::as_str) {
        let name = reference.rsplit('/').next().unwrap_or(reference);
        return format!("[{name}](#{})", name.to_lowercase());
    }
    for several in ["anyOf", "oneOf", "allOf"] {
        if let Some(variants) = schema.get(several).and_then(Value::as_array) {
            let types = variants.iter().filter_map(Value::as_object).map(type_of).filter(|name| name != "null");
            return types.collect::<Vec<_>>().join(" or ");
        }
    }
    let of = |key: &str| schema.get(key).and_then(Value::as_object).map(type_of);
    let name = |kind: &str| match kind {
        "array" => match (schema.get("minItems"), schema.get("maxItems"), of("items")) {
            (Some(least), Some(most), Some(item)) if least == most => format!("{least} of {item}"),
            (_, _, Some(item)) => format!("list of {item}"),
            _ => "list".into(),
        },
        "object" => of("additionalProperties").map_or("table".into(), |item| format!("tables of {item} by name")),
        "string" => "text".into(),
        "boolean" => "true or false".into(),
        other => other.to_string(),
    };
    match schema.get("type") {
        Some(Value::String(kind)) => name(kind),
        Some(Value::Array(kinds)) => {
            let kinds = kinds.iter().filter_map(Value::as_str).filter(|kind| *kind != "null").map(name);
            kinds.collect::<Vec<_>>().join(" or ")
        }
        _ => "value".into(),
    }
}

/// Returns the description of a type or a key, on one line.
fn description(schema: &Map<String, Value>) -> String {
    let text = schema.get("description").and_then(Value::as_str).unwrap_or_default();
    without_links(&text.split_whitespace().collect::<Vec<_>>().join(" ")).replace('|', "\\|")
}

/// Replaces links to items of the library by their text: the links have no target outside it.
fn without_links(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('[') {
        plain += before;
        let Some((words, tail)) = after.split_once(']') else {
            return plain + "[" + after;
        };
        let after_target = tail.strip_prefix('(').and_then(|tail| tail.split_once(')')).map(|(_, tail)| tail);
        (plain, rest) = match words.starts_with('`') {
            true => (plain + words, after_target.unwrap_or(tail)),
            false => (format!("{plain}[{words}]"), tail),
        };
    }
    plain + rest
}

#[cfg(test)]
#[path = "../../tests/unit/scenes_schema.rs"]
mod tests;
