//! Content of a study and its two renderers: plain text for a terminal, and a page.

use super::{Table, page};
use crate::draw::figure::Figure;
use minijinja::context;
use serde::Serialize;

/// Answer to the question of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Answer {
    /// Style class of its mark: "agree", "disagree" or "undecided".
    pub(crate) class: &'static str,
    /// The answer in a few words, with a full stop.
    pub(crate) word: String,
    /// Its numbers, in sentences.
    pub(crate) sentence: String,
}

/// Content of a study, apart from its figures and files.
pub struct Report {
    /// Line above the title.
    pub(crate) kind: &'static str,
    /// Title of the page and of the terminal.
    pub(crate) title: String,
    /// Problem, machine and version, in a few words each.
    pub(crate) facts: Vec<String>,
    /// Answer to the question of the study.
    pub(crate) answer: Answer,
    /// Findings, one sentence each.
    pub(crate) findings: Vec<String>,
    /// Tables, in the order of the page.
    pub(crate) sections: Vec<Section>,
    /// Failures and warnings, one sentence each; behind the tables.
    pub(crate) notes: Vec<String>,
    /// Method and limits, one sentence each.
    pub(crate) limits: Vec<String>,
    /// Provenance as names and values.
    pub(crate) provenance: Vec<(String, String)>,
    /// Names of the data files next to the page.
    pub(crate) files: &'static str,
}

/// A table with its title and description.
pub(crate) struct Section {
    title: String,
    text: String,
    table: Table,
    medium: Medium,
}

/// The renderers that show a section.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Medium {
    Both,
    Page,
    Terminal,
}

impl Section {
    /// A table that both renderers show; its description is on the page alone.
    pub(crate) fn new(title: impl Into<String>, text: impl Into<String>, table: Table) -> Section {
        Section { title: title.into(), text: text.into(), table, medium: Medium::Both }
    }

    /// Restricts the section to one renderer.
    pub(crate) fn only(self, medium: Medium) -> Section {
        Section { medium, ..self }
    }
}

impl Report {
    /// Plain text: the answer, the tables, the findings.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{}: {}\n{}\n",
            self.title,
            self.facts.join(", "),
            self.answer.word.clone() + " " + &self.answer.sentence
        );
        for section in self.shown(Medium::Terminal) {
            text += &format!("\n{}\n{}", section.title, section.table.text());
        }
        text += "\n";
        self.findings.iter().chain(&self.notes).for_each(|sentence| text += &format!("{sentence}\n"));
        text
    }

    /// A page with these figures.
    ///
    /// # Errors
    /// [`minijinja::Error`] if the template does not fit.
    pub fn page(&self, figures: &[Figure]) -> Result<String, minijinja::Error> {
        let sections = self.shown(Medium::Page).map(|section| {
            context! { title => section.title, text => section.text, table => section.table.html() }
        });
        let others = context! {
            kind => self.kind,
            facts => self.facts.join(" · "),
            answer => self.answer,
            findings => self.findings,
            sections => sections.collect::<Vec<_>>(),
            notes => self.notes,
            limits => self.limits,
            files => self.files,
        };
        page(include_str!("study.html"), &self.title, figures, self.provenance.iter().cloned(), others)
    }

    fn shown(&self, medium: Medium) -> impl Iterator<Item = &Section> {
        let own = move |section: &&Section| section.medium == Medium::Both || section.medium == medium;
        self.sections.iter().filter(own).filter(|section| !section.table.is_empty())
    }
}
