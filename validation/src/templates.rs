//! Starting scenes: commented, small, and valid without changes. `makadam new` writes one into a file.

/// Starting scene.
#[derive(Clone, Copy, Debug)]
pub struct Template {
    /// Name.
    pub name: &'static str,
    /// Text of the scene.
    pub text: &'static str,
}

macro_rules! templates {
    ($($name:literal),* $(,)?) => {
        /// All templates.
        pub const TEMPLATES: &[Template] =
            &[$(Template { name: $name, text: include_str!(concat!("../templates/", $name, ".toml")) }),*];
    };
}

templates!["box", "drum", "heap", "mixer", "shaker", "silo", "stages", "stream"];

/// Returns the template of a name.
pub fn template(name: &str) -> Option<&'static Template> {
    TEMPLATES.iter().find(|template| template.name == name)
}

#[cfg(test)]
#[path = "../tests/unit/templates.rs"]
mod tests;
