//! A study as tables in Markdown: one a group, with what is right in each case and what came of it in each code.

use super::table::figure;
use super::{CaseResult, Outcome, Study, Verdict};

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
    let mut group = "";
    for case in &study.cases {
        if case.group != group {
            group = case.group;
            text += &head(case);
        }
        let outcomes: Vec<String> = case.outcomes.iter().map(cell).collect();
        text += &format!("| `{}` | {} | {} |\n", case.name, case.right, outcomes.join(" | "));
    }
    text
}

/// The title of a group and the head of its table.
fn head(case: &CaseResult) -> String {
    let mut letters = case.group.chars();
    let title: String =
        letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default() + letters.as_str();
    let codes: Vec<&str> = case.outcomes.iter().map(|outcome| outcome.code.as_str()).collect();
    format!(
        "\n## {title}\n\n| case | what is right | {} |\n| --- | --- |{}\n",
        codes.join(" | "),
        " --- |".repeat(codes.len())
    )
}

/// The verdict, loud where the case did not end as stated, and the figure that tells most.
fn cell(outcome: &Outcome) -> String {
    let words = outcome.verdict.words();
    let verdict = if outcome.verdict == Verdict::NotAsStated { format!("**{words}**") } else { words.into() };
    match outcome.telling() {
        Some(finding) => format!("{verdict}: {} {}", finding.what, figure(finding.value, finding.unit)),
        None => verdict,
    }
}
