//! Unit tests of `src/stability/catalogue/starts.rs`.

use makadam::partition::BoxGrid;
use nalgebra::Vector3;

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
