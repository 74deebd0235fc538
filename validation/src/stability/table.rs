//! A study of stress tests as text: for a terminal one row per case with the failures below, and in Markdown one table per group.

use super::{CaseResult, Outcome, Study, Verdict};
use crate::draw::columns;
use crate::study::{Cell, Finding, Table};

/// The cases by group as aligned text.
pub fn table(study: &Study) -> String {
    let codes: Vec<&str> = study.cases.first().map_or(Vec::new(), |case| codes(case));
    let head: Vec<String> = std::iter::once("case").chain(codes.iter().copied()).map(String::from).collect();
    let mut rows = vec![head];
    for case in &study.cases {
        rows.push(std::iter::once(case.name.clone()).chain(case.outcomes.iter().map(cell)).collect());
    }
    let mut text = String::new();
    let mut group = "";
    for (number, line) in columns(&rows, |_| true).lines().enumerate() {
        if number > 0 && study.cases[number - 1].group != group {
            group = study.cases[number - 1].group;
            text.push_str(&format!("\n{group}\n"));
        }
        text.push_str(&format!("{line}\n"));
    }
    text.push_str(&remarks(study));
    text.push_str(&summary(study));
    text
}

fn codes(case: &CaseResult) -> Vec<&str> {
    case.outcomes.iter().map(|outcome| outcome.code.as_str()).collect()
}

/// The figure that tells most of an outcome, with what it is; empty where nothing was measured.
pub fn telling(outcome: &Outcome) -> String {
    outcome
        .telling()
        .map_or(String::new(), |finding| format!("{} {}", finding.what, figure(finding.value, &finding.unit)))
}

/// Verdict and figure in a few words.
fn cell(outcome: &Outcome) -> String {
    match outcome.telling() {
        Some(finding) => format!("{} ({})", outcome.verdict.words(), figure(finding.value, &finding.unit)),
        None => outcome.verdict.words().to_string(),
    }
}

fn figure(value: f64, unit: &str) -> String {
    let size = value.abs();
    let number = match size == 0.0 || (1e-3..1e5).contains(&size) {
        true => format!("{value:.4}"),
        false => format!("{value:.2e}"),
    };
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// What of the cases is not as stated, with figures and bounds.
fn remarks(study: &Study) -> String {
    let mut text = String::new();
    for case in &study.cases {
        for outcome in case.outcomes.iter().filter(|outcome| outcome.verdict != Verdict::AsStated) {
            let found: Vec<String> = outcome.findings.iter().filter(|finding| !finding.holds()).map(sentence).collect();
            let why = outcome.reason.clone().unwrap_or_else(|| found.join("; "));
            text.push_str(&format!("\n{} in {}: {}: {why}", case.name, outcome.code, outcome.verdict.words()));
        }
    }
    if !text.is_empty() {
        text.push('\n');
    }
    text
}

fn sentence(finding: &Finding) -> String {
    let Finding { what, unit, value, low, high } = finding;
    let value = figure(*value, unit);
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{what} {value}, right is {} to {}", figure(*low, unit), figure(*high, unit)),
        (true, false) => format!("{what} {value}, right is at least {}", figure(*low, unit)),
        _ => format!("{what} {value}, right is at most {}", figure(*high, unit)),
    }
}

/// One line a code: how many cases ended how.
fn summary(study: &Study) -> String {
    let Some(first) = study.cases.first() else { return String::from("no cases\n") };
    let mut text = String::new();
    for (column, code) in codes(first).into_iter().enumerate() {
        let verdicts = study.cases.iter().map(|case| case.outcomes[column].verdict);
        let count = |wanted: Verdict| verdicts.clone().filter(|verdict| *verdict == wanted).count();
        let others = [Verdict::NotAsStated, Verdict::Crashed, Verdict::TookTooLong, Verdict::CannotBeExpressed];
        text.push_str(&format!("\n{code}: {} of {} as stated", count(Verdict::AsStated), study.cases.len()));
        for verdict in others {
            if count(verdict) > 0 {
                text.push_str(&format!(", {} {}", count(verdict), verdict.words()));
            }
        }
    }
    text
}

/// The cases by group.
pub fn markdown(study: &Study) -> String {
    let mut text = String::from("# Hard cases\n\n");
    let codes: Vec<String> = study.codes.iter().map(|(name, version)| format!("{name} {version}")).collect();
    text += &format!(
        "{} with a limit of {} s a run, on {}.\n",
        codes.join(", "),
        study.time_limit,
        study.provenance.get("processor").map_or("an unknown processor", String::as_str)
    );
    if !study.unfinished.is_empty() {
        text += &format!("\nNot finished: {}.\n", study.unfinished.join(", "));
    }
    for cases in study.cases.chunk_by(|one, next| one.group == next.group) {
        let codes: Vec<&str> = cases[0].outcomes.iter().map(|outcome| outcome.code.as_str()).collect();
        let table = Table::new(&["case", "what is right"], &[]).with_numbers(codes).of(cases, |case| {
            let name = [format!("`{}`", case.name), case.right.clone()];
            name.into_iter().chain(case.outcomes.iter().map(markdown_cell)).map(Cell::from).collect()
        });
        text += &format!("\n## {}\n\n{}", title(cases[0].group), table.markdown());
    }
    text
}

/// The name of a group with a capital.
fn title(group: &str) -> String {
    let mut letters = group.chars();
    letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default() + letters.as_str()
}

/// The verdict, loud where the case did not end as stated, and the figure that tells most.
fn markdown_cell(outcome: &Outcome) -> String {
    let words = outcome.verdict.words();
    let verdict = if outcome.verdict == Verdict::NotAsStated { format!("**{words}**") } else { words.into() };
    match outcome.telling() {
        Some(finding) => format!("{verdict}: {} {}", finding.what, figure(finding.value, &finding.unit)),
        None => verdict,
    }
}
