//! Texts on their way to a terminal.

use std::borrow::Cow;

/// What the program itself writes between colours, behind an escape character.
const COLOURS: [&str; 6] = ["[0m", "[31m", "[31;1m", "[32m", "[33m", "[34m"];

/// A text as it may go to a terminal: names, and words of other programs, can hold characters that a terminal obeys. They are spelt
/// out as JSON does, so that documents stay the same; line ends and tabs stay, and `colours` of the program's own.
pub(crate) fn shown(text: &str, colours: bool) -> Cow<'_, str> {
    let obeyed = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\t')) || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len());
    for (at, c) in text.char_indices() {
        let own = colours && c == '\x1b' && COLOURS.iter().any(|colour| text[at + 1..].starts_with(colour));
        match obeyed(c) && !own {
            true => plain += &format!("\\u{:04x}", u32::from(c)),
            false => plain.push(c),
        }
    }
    Cow::Owned(plain)
}

#[cfg(test)]
mod tests {
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
}
