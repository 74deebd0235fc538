//! Unit tests of `src/output/shown.rs`.

use super::shown;

#[test]
fn a_terminal_is_told_nothing_by_names() {
    assert_eq!(shown("a\tplain\nname \u{b0}", false), "a\tplain\nname \u{b0}");
    assert_eq!(shown("\x1b]0;title\x07\x1b[2J\u{9b}1m\r", true), r"\u001b]0;title\u0007\u001b[2J\u009b1m\u000d");
    assert_eq!(shown("\x1b[31mdisagree\x1b[0m", true), "\x1b[31mdisagree\x1b[0m", "colours are the program's own");
    assert_eq!(shown("\x1b[31mdisagree", false), r"\u001b[31mdisagree");
    assert_eq!(shown("\u{202e}txt", false), r"\u202etxt");
    // A document in JSON stays the same document.
    let document = serde_json::to_string(&"\u{9b}x").unwrap();
    assert_eq!(serde_json::from_str::<String>(&shown(&document, false)).unwrap(), "\u{9b}x");
}
