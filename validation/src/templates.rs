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
mod tests {
    use super::*;
    use crate::observables::catalogue;
    use crate::plan::Scene;
    use std::path::Path;

    #[test]
    fn every_template_is_a_sound_scene_of_its_name_that_can_be_carried_out() {
        for template in TEMPLATES {
            let scene = Scene::parse(template.text).unwrap_or_else(|error| panic!("{}: {error}", template.name));
            assert_eq!(scene.name, template.name);
            catalogue::check(&scene, template.text, Path::new(template.name)).unwrap();
            let findings = scene.findings(Some(template.text));
            assert!(findings.is_empty(), "{}: {findings:?}", template.name);
            let mut simulation = makadam::Simulation::new(&scene, scene.seed).unwrap();
            for _ in 0..20 {
                simulation.step();
            }
            assert!(simulation.not_finite().is_none());
        }
    }
}
