//! Unit tests of `src/output/cells.rs`.

use super::*;

#[test]
fn what_begins_as_a_formula_is_text_and_numbers_stay() {
    let table = "name,value\n=1+2,-3.5e-7\n\"@a,b\",+inf\n-wall,-\nplain,=\n";
    let safe = String::from_utf8(without_formulas(table.into())).unwrap();
    assert_eq!(safe, "name,value\n'=1+2,-3.5e-7\n\"'@a,b\",+inf\n'-wall,'-\nplain,'=\n");
    let plain = b"name,value\na,-1\n".to_vec();
    assert_eq!(without_formulas(plain.clone()), plain, "not a byte changes without need");
    for cell in ["=1+2", "-wall", "plain", "'quoted"] {
        let table = String::from_utf8(without_formulas(format!("{cell}\n").into())).unwrap();
        assert_eq!(as_meant(table.trim_end()), cell);
    }
}

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
