//! Unit tests of `src/templates.rs`.

use super::*;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::catalogue;
use std::path::Path;

#[test]
fn every_template_is_a_sound_scene_of_its_name_that_can_be_carried_out() {
    for template in TEMPLATES {
        let scene = MeasuredScene::parse(template.text).unwrap_or_else(|error| panic!("{}: {error}", template.name));
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
