//! Unit tests of `src/codes/liggghts/turn.rs`.

use super::*;

#[test]
fn a_drum_about_y_lies_along_z_and_comes_back() {
    let drum = MeasuredScene::parse(include_str!("../../../templates/drum.toml")).unwrap();
    let turn = Turn::of(&drum);
    let turned = turn.scene(&drum);
    let shell = turned.wall.iter().find_map(|wall| match (&wall.shape, &wall.motion) {
        (Shape::Cylinder { axis, .. }, Motion::Rotating { axis: about, .. }) => Some((*axis, *about)),
        _ => None,
    });
    let (axis, about) = shell.unwrap();
    assert!(axis[2] != 0.0 && axis[0] == 0.0 && axis[1] == 0.0 && about[2] != 0.0, "{axis:?} {about:?}");
    assert!(turned.gravity[0] < 0.0, "down is -x");
    assert_eq!(turn.back(turn.forth([1.0, 2.0, 3.0])), [1.0, 2.0, 3.0]);
    assert_eq!(Turn::of(&turned), Turn(false));
    assert_eq!(turn.face("-z"), "-x");
}
