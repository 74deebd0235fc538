//! Content of a study and its renderers: plain text for a terminal, a page, Markdown; figures with their bounds.

use super::Table;
use makadam_view::draw::figure::Figure;
use minijinja::{AutoEscape, Environment, context};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;

/// Answer to the question of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// Style class of its mark: "agree", "disagree" or "undecided".
    pub class: &'static str,
    /// Answer in a few words, with a full stop.
    pub word: String,
    /// Numbers, in sentences.
    pub sentence: String,
}

impl Answer {
    /// Returns the answer of tests, which pass together or not.
    pub fn of(pass: bool, word: String, sentence: String) -> Answer {
        Answer { class: if pass { "agree" } else { "disagree" }, word, sentence }
    }
}

/// Content of a study, apart from its figures and files.
pub struct Report {
    /// Line above the title.
    pub kind: &'static str,
    /// Title of the page and of the terminal.
    pub title: String,
    /// Problem, machine and version, in a few words each.
    pub facts: Vec<String>,
    /// Answer to the question of the study.
    pub answer: Answer,
    /// Findings, one sentence each.
    pub findings: Vec<String>,
    /// Tables, in the order of the page.
    pub sections: Vec<Section>,
    /// Failures and warnings, one sentence each; behind the tables.
    pub notes: Vec<String>,
    /// Method and limits, one sentence each.
    pub limits: Vec<String>,
    /// Provenance as names and values.
    pub provenance: Vec<(String, String)>,
    /// Names of the data files next to the page.
    pub files: &'static str,
}

/// A table with its title and description.
pub struct Section {
    title: String,
    text: String,
    table: Table,
    medium: Medium,
}

/// Renderers that show a section; Markdown has the sections of the page.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Medium {
    /// In the terminal and on the page.
    Both,
    /// On the page alone.
    Page,
    /// In the terminal alone.
    Terminal,
}

impl Section {
    /// Returns a table for both renderers; its description is on the page alone.
    pub fn new(title: impl Into<String>, text: impl Into<String>, table: Table) -> Section {
        Section { title: title.into(), text: text.into(), table, medium: Medium::Both }
    }

    /// Restricts the section to one renderer.
    pub fn only(self, medium: Medium) -> Section {
        Section { medium, ..self }
    }
}

impl Report {
    /// Plain text: the answer, the tables, the findings.
    pub fn text(&self) -> String {
        let Answer { word, sentence, .. } = &self.answer;
        let mut text = format!("{}: {}\n{word} {sentence}\n", self.title, self.facts.join(", "));
        for section in self.shown(Medium::Terminal) {
            text += &format!("\n{}\n{}", section.title, section.table.text());
        }
        text += "\n";
        self.findings.iter().chain(&self.notes).for_each(|sentence| text += &format!("{sentence}\n"));
        text
    }

    /// Markdown: the answer, the tables of the page, the findings.
    pub fn markdown(&self) -> String {
        let Answer { word, sentence, .. } = &self.answer;
        let mut text = format!("# {}\n\n{}\n\n{word} {sentence}\n", self.title, self.facts.join(", "));
        for Section { title, text: description, table, .. } in self.shown(Medium::Page) {
            let description = if description.is_empty() { String::new() } else { format!("{description}\n\n") };
            text += &format!("\n## {title}\n\n{description}{}", table.markdown());
        }
        let sentences = self.findings.iter().chain(&self.notes).map(|sentence| format!("- {sentence}\n"));
        text + "\n" + &sentences.collect::<String>()
    }

    /// Returns a page with these figures.
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
        let mut environment = environment()?;
        environment.add_template("page", include_str!("study.html"))?;
        let provenance = self.provenance.iter().map(|(key, value)| (key.replace('_', " "), value));
        let provenance = provenance.collect::<Vec<_>>();
        let frame = context! { title => self.title, style => style(), figures, provenance };
        environment.get_template("page")?.render(context! { ..frame, ..others })
    }

    fn shown(&self, medium: Medium) -> impl Iterator<Item = &Section> {
        let own = move |section: &&Section| section.medium == Medium::Both || section.medium == medium;
        self.sections.iter().filter(own).filter(|section| !section.table.is_empty())
    }
}

/// Style sheet of a page with figures.
pub fn style() -> &'static str {
    concat!(include_str!("../../../view/src/draw/figure.css"), include_str!("page.css"))
}

/// Templates that escape every value, with the parts common to all pages: "head" takes `title` and `style`,
/// "answer" takes `answer`, "figures" takes `figures`, "provenance" takes pairs.
pub fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("head", include_str!("head.html"))?;
    environment.add_template("answer", include_str!("answer.html"))?;
    environment.add_template("figures", include_str!("figures.html"))?;
    environment.add_template("provenance", include_str!("provenance.html"))?;
    Ok(environment)
}

/// Measured figure, and the bounds of the expected outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Name.
    pub what: String,
    /// Unit; empty for a pure number.
    pub unit: Cow<'static, str>,
    /// Value.
    #[serde(deserialize_with = "or_nan")]
    pub value: f64,
    /// Lower bound.
    pub low: Option<f64>,
    /// Upper bound.
    pub high: Option<f64>,
}

/// Reads a value that may be `null`: JSON represents only finite numbers.
fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

impl Finding {
    /// Returns a figure without bounds and unit, which is reported only.
    pub(crate) fn reported(what: impl Into<String>, value: f64) -> Finding {
        Finding { what: what.into(), unit: "".into(), value, low: None, high: None }
    }

    pub(crate) fn between(what: impl Into<String>, value: f64, low: f64, high: f64) -> Finding {
        Finding { low: Some(low), high: Some(high), ..Finding::reported(what, value) }
    }

    /// Returns a figure with a target and a tolerated deviation from it.
    pub(crate) fn near(what: impl Into<String>, value: f64, target: f64, deviation: f64) -> Finding {
        Finding::between(what, value, target - deviation, target + deviation)
    }

    pub(crate) fn at_most(what: impl Into<String>, value: f64, high: f64) -> Finding {
        Finding { high: Some(high), ..Finding::reported(what, value) }
    }

    pub(crate) fn at_least(what: impl Into<String>, value: f64, low: f64) -> Finding {
        Finding { low: Some(low), ..Finding::reported(what, value) }
    }

    pub(crate) fn in_unit(self, unit: &'static str) -> Finding {
        Finding { unit: unit.into(), ..self }
    }

    /// Returns true within the bounds; false for NaN.
    pub fn holds(&self) -> bool {
        !self.value.is_nan()
            && self.low.is_none_or(|low| self.value >= low)
            && self.high.is_none_or(|high| self.value <= high)
    }

    /// Returns the relative distance from the exceeded bound, 0 inside: the order of findings by their error.
    pub fn excess(&self) -> f64 {
        let exceeded = self.high.filter(|high| self.value > *high).or(self.low);
        match exceeded {
            _ if self.holds() => 0.0,
            Some(bound) if self.value.is_finite() => (self.value - bound).abs() / bound.abs().max(1e-300),
            _ => f64::INFINITY,
        }
    }
}
