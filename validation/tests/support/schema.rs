//! Check of a document against a JSON Schema (draft 2020-12), for the keywords of the schemas of this project.

use serde_json::Value;

/// Keywords without a condition.
const ANNOTATIONS: [&str; 6] = ["$schema", "$defs", "title", "description", "default", "format"];

/// Lists the faults of a document, each with its place.
///
/// # Panics
/// If the schema has a keyword without a rule here.
pub fn faults(schema: &Value, document: &Value) -> Vec<String> {
    let mut faults = Vec::new();
    Check { root: schema, faults: &mut faults }.of(schema, document, "");
    faults
}

struct Check<'a> {
    /// Schema that references lead into.
    root: &'a Value,
    faults: &'a mut Vec<String>,
}

impl Check<'_> {
    fn of(&mut self, schema: &Value, value: &Value, place: &str) {
        match schema {
            Value::Bool(true) => {}
            Value::Bool(false) => self.note(place, "nothing is allowed here".into()),
            schema => {
                for (keyword, rule) in schema.as_object().expect("a schema is an object or a truth value") {
                    self.apply(keyword, rule, schema, value, place);
                }
            }
        }
    }

    fn note(&mut self, place: &str, fault: String) {
        self.faults.push(format!("{place}: {fault}"));
    }

    fn apply(&mut self, keyword: &str, rule: &Value, schema: &Value, value: &Value, place: &str) {
        let list = || rule.as_array().unwrap_or_else(|| panic!("{keyword} is a list"));
        let count = || rule.as_u64().unwrap_or_else(|| panic!("{keyword} is a count")) as usize;
        let items = value.as_array();
        let entries = || value.as_object().into_iter().flatten();
        match keyword {
            "$ref" => {
                let target = rule.as_str().and_then(|target| self.root.pointer(target.strip_prefix('#')?));
                self.of(target.unwrap_or_else(|| panic!("{rule} leads nowhere")), value, place);
            }
            "type" => {
                let is_of = |name: &Value| has_type(value, name.as_str().expect("a name of a type"));
                if !rule.as_array().map_or_else(|| is_of(rule), |names| names.iter().any(is_of)) {
                    self.note(place, format!("{value} is not of type {rule}"));
                }
            }
            "const" if value != rule => self.note(place, format!("{value} is not {rule}")),
            "minimum" if value.as_f64() < rule.as_f64() && value.is_number() => {
                self.note(place, format!("{value} is less than {rule}"));
            }
            "minItems" if items.is_some_and(|items| items.len() < count()) => {
                self.note(place, format!("fewer than {rule} items"));
            }
            "maxItems" if items.is_some_and(|items| items.len() > count()) => {
                self.note(place, format!("more than {rule} items"));
            }
            "const" | "minimum" | "minItems" | "maxItems" => {}
            "items" => {
                for (number, item) in items.into_iter().flatten().enumerate() {
                    self.of(rule, item, &format!("{place}/{number}"));
                }
            }
            "required" => {
                let is_missing = |key: &&Value| value.is_object() && value.get(key.as_str().expect("a key")).is_none();
                for key in list().iter().filter(is_missing) {
                    self.note(place, format!("{key} is a required property"));
                }
            }
            "properties" => {
                for (key, own) in entries() {
                    rule.get(key).into_iter().for_each(|rule| self.of(rule, own, &format!("{place}/{key}")));
                }
            }
            "additionalProperties" => {
                for (key, own) in entries().filter(|(key, _)| schema["properties"].get(key.as_str()).is_none()) {
                    self.of(rule, own, &format!("{place}/{key}"));
                }
            }
            "oneOf" | "anyOf" => {
                let is_met = |schema: &&Value| {
                    let mut faults = Vec::new();
                    Check { root: self.root, faults: &mut faults }.of(schema, value, place);
                    faults.is_empty()
                };
                let met = list().iter().filter(is_met).count();
                if met == 0 || (keyword == "oneOf" && met > 1) {
                    self.note(place, format!("{value} is in {met} of the alternatives"));
                }
            }
            _ => assert!(ANNOTATIONS.contains(&keyword), "no rule for the keyword {keyword} at {place}"),
        }
    }
}

fn has_type(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        _ => panic!("no type is named {name}"),
    }
}
