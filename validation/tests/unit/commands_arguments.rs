//! Unit tests of `src/commands/arguments.rs`.

use super::*;

#[test]
fn a_bare_number_is_a_share_only_where_it_can_be_meant_as_one() {
    assert_eq!(accuracy("1%").unwrap().relative, Some(0.01));
    assert_eq!(accuracy("0.01").unwrap().relative, Some(0.01));
    assert_eq!(accuracy("angle=1").unwrap().angle, Some(1.0));
    assert_eq!(accuracy("100%").unwrap().relative, Some(1.0));
    for text in ["1", "0.5", "relative=1", "angle=1,2"] {
        let message = accuracy(text).unwrap_err();
        assert!(message.contains('%') && message.contains("angle="), "{message}");
    }
}

#[test]
fn a_bound_on_what_nothing_measures_is_refused_with_the_nearest_names() {
    assert_eq!(bound("packing-fraction=0.002").unwrap().observable, "packing_fraction");
    let message = bound("pakcing_fraction=0.002").unwrap_err();
    assert!(message.contains("packing_fraction"), "{message}");
}
