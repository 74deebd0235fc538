//! Unit tests of `src/stability/catalogue/mod.rs`.

use makadam::partition::BoxGrid;
use makadam::scene::Severity;
use nalgebra::Vector3;

/// Frictions that no two solids have are deliberate in some cases.
#[test]
fn no_case_is_refused_and_few_are_told_to_go_wrong() {
    let cases = super::catalogue();
    let findings: Vec<(String, String)> = (cases.iter())
        .flat_map(|case| case.scene.findings(None).into_iter().map(|finding| (case.name.clone(), finding)))
        .inspect(|(name, finding)| assert_eq!(finding.severity, Severity::Warning, "{name}: {finding}"))
        .map(|(name, finding)| (name, finding.to_string()))
        .filter(|(_, finding)| !finding.contains("more than any two dry solids have"))
        .collect();
    assert!(findings.len() < 10, "{findings:#?}");
}

#[test]
fn the_bed_in_one_box_lies_in_one_box() {
    let scene = super::one_box().scene;
    let domain = (Vector3::from(scene.domain.min), Vector3::from(scene.domain.max));
    let boxes = BoxGrid::new(
        &domain,
        &makadam::effects::period::Period::default(),
        50,
        super::RADIUS,
        scene.solver.reach(super::RADIUS, scene.gravity_field().largest()),
    );
    assert_eq!(boxes.boxes(), 1);
}
