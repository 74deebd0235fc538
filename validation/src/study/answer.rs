//! What a study answers, said before all else.

use serde::Serialize;

/// The answer to the question that a study is made for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Answer {
    /// Style class of its mark: "agree", "disagree" or "undecided".
    pub(crate) class: &'static str,
    /// In a few words, with a full stop.
    pub(crate) word: String,
    /// The numbers behind it, in sentences.
    pub(crate) sentence: String,
}

impl Answer {
    /// As plain text.
    pub(crate) fn text(&self) -> String {
        format!("{} {}", self.word, self.sentence)
    }
}
