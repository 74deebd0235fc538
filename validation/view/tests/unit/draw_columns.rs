//! Unit tests of `src/draw/mod.rs`.

use super::*;

#[test]
fn values_stand_below_each_other() {
    let rows = [("angle", 31.6741, Some(0.38), "degree"), ("gini_of_forces", 0.5, None, "")];
    assert_eq!(values(rows), "angle           31.67 ± 0.38 degree\ngini_of_forces  0.5\n");
    assert_eq!(values([]), "");
}
