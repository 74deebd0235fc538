//! Unit tests of `src/commands/console.rs`.

use super::*;

#[test]
fn colours_are_for_terminals_without_no_color() {
    assert!(wants_colour(true, None) && wants_colour(true, Some(OsStr::new(""))));
    assert!(!wants_colour(true, Some(OsStr::new("1"))) && !wants_colour(false, None));
    assert_eq!((Colour::Plain.paint("a"), Colour::Red.paint("a")), ("a".into(), "\x1b[31;1ma\x1b[0m".into()));
}
