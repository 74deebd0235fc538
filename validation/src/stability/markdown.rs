//! A study as tables in Markdown: one a group, with what is right in each case and what came of it in each code.

use super::table::figure;
use super::{Outcome, Study, Verdict};
use crate::study::{Cell, Table};

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
            name.into_iter().chain(case.outcomes.iter().map(cell)).map(Cell::from).collect()
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
fn cell(outcome: &Outcome) -> String {
    let words = outcome.verdict.words();
    let verdict = if outcome.verdict == Verdict::NotAsStated { format!("**{words}**") } else { words.into() };
    match outcome.telling() {
        Some(finding) => format!("{verdict}: {} {}", finding.what, figure(finding.value, &finding.unit)),
        None => verdict,
    }
}
