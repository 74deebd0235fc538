//! Unit tests of `src/observables/possible.rs`.

use super::*;

#[test]
fn what_a_scene_cannot_have_is_said_with_its_line() {
    let text = include_str!("../../../templates/silo.toml");
    let mut scene = MeasuredScene::parse(text).unwrap();
    assert_eq!(impossible(&scene, Some(text)), []);
    use Observable::{Discharge, DrivenWall, DrumFlow, DynamicAngleOfRepose, Intruder, PackingFraction};
    scene.measure.observables = vec![DynamicAngleOfRepose, DrumFlow, DrivenWall, PackingFraction, Discharge, Intruder];
    let found = impossible(&scene, Some(text));
    let said: Vec<&str> = found.iter().filter_map(|one| one.problem.split(' ').nth(1)).collect();
    assert_eq!(said, ["dynamic-angle-of-repose", "drum-flow", "driven-wall", "intruder"]);
    assert!(found.iter().all(|one| one.line.is_some()), "{found:?}");
    let left = unmeasured(&scene, &[Content::DrivenWalls], &Measured::default());
    assert!(left.iter().any(|one| one.observable == "wall_torque" && one.reason.contains("cylinder")));
    assert!(left.iter().any(|one| one.observable == "driven_wall_displacement" && one.reason.contains("driven")));
    assert!(left.iter().all(|one| one.observable != "gini"), "it was not asked for");
    scene.measure.observables = vec![Observable::SizeMixing];
    let alike = Measured { refusals: vec![(Observable::SizeMixing, "alike".into())], ..Measured::default() };
    let reasons: Vec<String> = unmeasured(&scene, &[], &alike).into_iter().map(|one| one.reason).collect();
    assert_eq!(
        reasons,
        ["alike", NO_DRUM, "the scene has fewer than two populations", "the scene has fewer than two populations"]
    );
}
