//! Study of stress tests: the outcomes of all cases, and their report.

use super::case::figure;
use super::{Campaign, Case, Outcome, Verdict};
use crate::study::{Answer, Cell, Document, Finding, Medium, Report, Section, Table};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::provenance::{account, facts, scene_hash};
use makadam_view::draw::numbers::bounds;
use serde::Serialize;
use std::collections::BTreeMap;

/// A case and its outcomes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseResult {
    /// Name of the case.
    pub name: String,
    pub group: &'static str,
    /// Expected outcome.
    pub right: String,
    /// Law, derivation or publication behind it.
    pub source: &'static str,
    /// True if it belongs to the long catalogue only.
    pub long: bool,
    /// Hash of the scene, 16 hexadecimal digits.
    pub scene_hash: String,
    /// Outcomes by code, in the order of the columns.
    pub outcomes: Vec<Outcome>,
}

impl CaseResult {
    /// Joins a case with its outcomes.
    pub fn new(case: &Case, outcomes: Vec<Outcome>) -> CaseResult {
        CaseResult {
            name: case.name.clone(),
            group: case.group,
            right: case.right.clone(),
            source: case.source,
            long: case.long,
            scene_hash: format!("{:016x}", scene_hash(&case.scene)),
            outcomes,
        }
    }
}

/// Content of `stability.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// Version of this document.
    pub version: u32,
    /// "stability".
    pub command: &'static str,
    /// True if all cases of Makadam ended as stated.
    pub as_stated: bool,
    /// Finished cases, in the order of the catalogue.
    pub cases: Vec<CaseResult>,
    /// Names of the other cases.
    pub unfinished: Vec<String>,
    /// Version of each code that ran.
    pub codes: BTreeMap<String, String>,
    /// Wall time after which a run was stopped, s.
    pub time_limit: f64,
    pub provenance: BTreeMap<String, String>,
}

impl Study {
    /// Starts the study of a campaign, without finished cases.
    pub(super) fn new(campaign: &Campaign<'_>) -> Study {
        let codes = campaign.codes.iter();
        Study {
            version: JSON_VERSION,
            command: "stability",
            as_stated: true,
            cases: Vec::new(),
            unfinished: campaign.cases.iter().map(|case| case.name.clone()).collect(),
            codes: codes.filter_map(|code| Some((code.name().to_string(), code.version()?))).collect(),
            time_limit: campaign.time_limit,
            provenance: account(rayon::current_num_threads(), &[]),
        }
    }

    /// Adds a finished case of a catalogue.
    pub(super) fn add(&mut self, result: CaseResult, catalogue: &[Case]) {
        self.unfinished.retain(|name| *name != result.name);
        self.cases.push(result);
        self.cases.sort_by_key(|result| catalogue.iter().position(|case| case.name == result.name));
        let outcomes = || self.cases.iter().flat_map(|case| &case.outcomes);
        self.as_stated =
            outcomes().filter(|outcome| outcome.code == "Makadam").all(|outcome| outcome.verdict == Verdict::AsStated);
    }

    /// Codes of the columns.
    fn columns(&self) -> Vec<&str> {
        self.cases.first().map_or(Vec::new(), |case| case.outcomes.iter().map(|one| one.code.as_str()).collect())
    }

    /// Number of cases by verdict in the code of a column, in a sentence.
    fn count(&self, column: usize, code: &str) -> String {
        let count =
            |wanted: &Verdict| self.cases.iter().filter(|case| case.outcomes[column].verdict == *wanted).count();
        let [as_stated, others @ ..] = Verdict::ALL;
        let others = others.iter().filter(|verdict| count(verdict) > 0);
        let others: String = others.map(|verdict| format!(", {} {}", count(verdict), verdict.words())).collect();
        format!("{code}: {} of {} as stated{others}.", count(&as_stated), self.cases.len())
    }
}

impl Document for Study {
    const NAME: &'static str = "stability";

    fn report(&self) -> Report {
        let columns = self.columns();
        let heads = |words: [&'static str; 2]| [words.as_slice(), &columns].concat();
        let mut short = Table::new(&heads(["group", "case"]), &[]);
        let mut sections = Vec::new();
        for cases in self.cases.chunk_by(|one, next| one.group == next.group) {
            short.group(cases[0].group, cases, |case| {
                [case.name.as_str().into()]
                    .into_iter()
                    .chain(case.outcomes.iter().map(|one| cell(one, false)))
                    .collect()
            });
            let table = Table::new(&heads(["case", "what is right"]), &[]).of(cases, |case| {
                let name = [&case.name, &case.right].map(Cell::from);
                name.into_iter().chain(case.outcomes.iter().map(|one| cell(one, true))).collect()
            });
            sections.push(Section::new(title(cases[0].group), "", table).only(Medium::Page));
        }
        sections.push(Section::new("Verdicts", "", short).only(Medium::Terminal));
        let codes = self.codes.iter().map(|(name, version)| format!("{name} {version}"));
        let counts: Vec<String> = columns.iter().enumerate().map(|(column, code)| self.count(column, code)).collect();
        let unfinished =
            (!self.unfinished.is_empty()).then(|| format!("Not finished: {}.", self.unfinished.join(", ")));
        let word = if self.as_stated { "As stated." } else { "Not as stated." };
        Report {
            kind: "Makadam, stress tests",
            title: "Stress tests".into(),
            facts: codes
                .chain([format!("limit {} s per run", self.time_limit)])
                .chain(facts(&self.provenance))
                .collect(),
            answer: Answer::of(self.as_stated, word.into(), counts.join(" ")),
            findings: Vec::new(),
            sections,
            notes: self.cases.iter().flat_map(remarks).chain(unfinished).collect(),
            limits: vec!["Bounds follow from closed forms, conservation laws and the geometry of containers.".into()],
            provenance: self.provenance.clone().into_iter().collect(),
            files: "stability.json",
        }
    }
}

/// Verdict of an outcome and its telling figure, with its name where there is room.
fn cell(outcome: &Outcome, named: bool) -> Cell {
    let text = match outcome.telling() {
        Some(finding) if !named => format!("{} ({})", outcome.verdict.words(), figure(finding.value, &finding.unit)),
        _ => outcome.text(),
    };
    Cell::from(text).strong(named && outcome.verdict == Verdict::NotAsStated)
}

/// Deviations of a case from its expected outcome, one per code, with figures and bounds.
fn remarks(case: &CaseResult) -> impl Iterator<Item = String> {
    let sentence = |finding: &Finding| {
        let number = |value: f64| figure(value, &finding.unit);
        format!("{} {}, right is {}", finding.what, number(finding.value), bounds([finding.low, finding.high], number))
    };
    let deviating = case.outcomes.iter().filter(|outcome| outcome.verdict != Verdict::AsStated);
    deviating.map(move |outcome| {
        let outside = outcome.findings.iter().filter(|finding| !finding.holds()).map(sentence);
        let why = outcome.reason.clone().unwrap_or_else(|| outside.collect::<Vec<_>>().join("; "));
        format!("{} in {}: {}: {why}", case.name, outcome.code, outcome.verdict.words())
    })
}

/// Name of a group with a capital.
fn title(group: &str) -> String {
    let mut letters = group.chars();
    letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default() + letters.as_str()
}
