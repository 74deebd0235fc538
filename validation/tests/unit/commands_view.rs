//! Unit tests of `src/commands/view.rs`.

use super::*;

#[test]
fn an_address_holds_no_character_that_ends_it() {
    assert_eq!(address(Path::new("/a b/50%/ö.html")), "file:///a%20b/50%25/%C3%B6.html");
}
