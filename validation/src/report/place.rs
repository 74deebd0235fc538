//! Folders that a report may be written into: what an earlier command, or somebody else, has left there stays.

use serde::Deserialize;
use std::path::Path;

/// Names of files that every report has; the first tells whose they are.
const NAMES: [&str; 9] = [
    "report.json",
    "report.html",
    "rows.csv",
    "junit.xml",
    "badge.svg",
    "differences.csv",
    "series.csv",
    "forces.csv",
    "grains.csv",
];

/// By what an earlier page is known.
const HEADING: &str = "Makadam, code-to-code comparison";

/// Tier of a report of one scene.
const COMPARISON: &str = "compare";

/// As much of a `report.json` as tells what it is of, in every version.
#[derive(Deserialize)]
struct Head {
    qualification: Tier,
}

#[derive(Deserialize)]
struct Tier {
    tier: String,
}

/// Whether the report of one scene may be written into a folder: there is none, or an earlier one of its kind.
///
/// # Errors
/// What it would replace, in words.
pub fn may_hold_comparison(folder: &Path) -> Result<(), String> {
    match held(folder)? {
        Some(tier) if tier != COMPARISON => Err(format!(
            "{} holds the report of a qualification (tier {tier}), which that of one scene does not replace; give another folder \
             with --output",
            folder.display()
        )),
        _ => Ok(()),
    }
}

/// Whether the report of a qualification may be written into a folder: there is none, or an earlier one of Makadam.
///
/// # Errors
/// What it would replace, in words.
pub fn may_hold_qualification(folder: &Path) -> Result<(), String> {
    held(folder).map(|_| ())
}

/// The tier of the report in a folder, if there is one.
///
/// # Errors
/// A file that has the name of one of a report and is of none, in words.
fn held(folder: &Path) -> Result<Option<String>, String> {
    let there = |name: &&str| folder.join(name).symlink_metadata().is_ok();
    let Some(first) = NAMES.into_iter().find(there) else { return Ok(None) };
    let foreign = |name: &str| {
        let file = folder.join(name);
        Err(format!("{} is of no report of Makadam; move it, or give another folder with --output", file.display()))
    };
    match tier(&folder.join(NAMES[0])) {
        None => foreign(first),
        Some(_) if there(&NAMES[1]) && !is_page(&folder.join(NAMES[1])) => foreign(NAMES[1]),
        held => Ok(held),
    }
}

/// Whether a folder holds a report.
pub fn is_in(folder: &Path) -> bool {
    tier(&folder.join(NAMES[0])).is_some()
}

/// The tier of a report; none of what is no report.
fn tier(file: &Path) -> Option<String> {
    let head: Head = serde_json::from_slice(&regular(file)?).ok()?;
    Some(head.qualification.tier)
}

fn is_page(file: &Path) -> bool {
    regular(file).is_some_and(|bytes| String::from_utf8_lossy(&bytes).contains(HEADING))
}

/// What a file holds; nothing of a pipe, which might never end.
fn regular(file: &Path) -> Option<Vec<u8>> {
    file.is_file().then(|| std::fs::read(file).ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_earlier_report_of_a_scene_may_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let put = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        let refused = |words: &str| {
            let message = may_hold_comparison(folder).unwrap_err();
            assert!(message.contains(words) && message.contains("another folder with --output"), "{message}");
        };
        may_hold_comparison(&folder.join("none")).unwrap();
        may_hold_comparison(folder).unwrap();
        put("notes.txt", "mine");
        may_hold_comparison(folder).unwrap();
        put("junit.xml", "<testsuites/>");
        refused("junit.xml is of no report");
        put("report.json", "{\"passed\": 3}");
        refused("report.json is of no report");
        put("report.json", "{\"version\": 1, \"qualification\": {\"tier\": \"quick\", \"title\": \"\"}}");
        refused("report of a qualification (tier quick)");
        put("report.json", "{\"version\": 1, \"qualification\": {\"tier\": \"compare\", \"title\": \"\"}}");
        may_hold_comparison(folder).unwrap();
        put("report.html", "<p>mine");
        refused("report.html is of no report");
        put("report.html", include_str!("page.html"));
        may_hold_comparison(folder).unwrap();
    }

    #[test]
    fn a_qualification_replaces_reports_of_makadam_alone() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let put = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        may_hold_qualification(folder).unwrap();
        put("report.html", "<p>mine");
        assert!(may_hold_qualification(folder).unwrap_err().contains("report.html is of no report"));
        put("report.json", "{\"version\": 1, \"qualification\": {\"tier\": \"quick\", \"title\": \"\"}}");
        assert!(may_hold_qualification(folder).unwrap_err().contains("report.html is of no report"));
        put("report.html", include_str!("page.html"));
        may_hold_qualification(folder).unwrap();
    }
}
