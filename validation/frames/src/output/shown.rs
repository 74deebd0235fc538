//! Texts on their way to a terminal.

use std::borrow::Cow;

/// Colour codes of the program, behind an escape character.
const COLOURS: [&str; 6] = ["[0m", "[31m", "[31;1m", "[32m", "[33m", "[34m"];

/// A text as it may go to a terminal: names, and words of other programs, can hold characters that a terminal obeys. They are spelt
/// out as JSON does, so that documents stay the same; line ends and tabs stay, and `colours` of the program's own.
pub fn shown(text: &str, colours: bool) -> Cow<'_, str> {
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
#[path = "../../tests/unit/output_shown.rs"]
mod tests;
