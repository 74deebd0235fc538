//! Scenes to begin with: commented, small, and sound as they are. `makadam new` writes one into a file.

/// A scene to begin with.
#[derive(Clone, Copy, Debug)]
pub struct Template {
    /// Its name.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! templates {
    ($($name:literal),* $(,)?) => {
        /// All of them.
        pub const TEMPLATES: &[Template] =
            &[$(Template { name: $name, text: include_str!(concat!("../templates/", $name, ".toml")) }),*];
    };
}

templates!["box", "drum", "heap", "mixer", "shaker", "silo"];

/// The template of a name.
pub fn template(name: &str) -> Option<&'static Template> {
    TEMPLATES.iter().find(|template| template.name == name)
}

#[cfg(test)]
#[path = "../tests/unit/templates.rs"]
mod tests;
