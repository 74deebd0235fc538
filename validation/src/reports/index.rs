//! Reports in order, the newest first, with what changed from each to the next of its kind.

use super::find::Found;
use crate::draw::numbers::duration;
use crate::report::{self, Changes, Qualification, Standing};
use crate::study::{Table, cells};
use serde::Serialize;
use std::path::Path;

/// One report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Its `report.json`, below the folder of the index.
    pub file: String,
    /// Its page beside that, if it is there.
    pub page: Option<String>,
    /// When it was made, UTC; absent where it does not say.
    pub date: Option<String>,
    /// Its tier; "compare" where one scene was compared.
    pub tier: String,
    /// Its title.
    pub title: String,
    /// What it comes to.
    pub standing: Standing,
    /// The verdict in words.
    pub sentence: String,
    /// Tests that passed.
    pub passed: usize,
    /// All tests.
    pub tests: usize,
    /// Version of Makadam.
    pub version: Option<String>,
    /// Commit of its sources.
    pub commit: Option<String>,
    /// Processor that it was made on.
    pub processor: Option<String>,
    /// Wall time, s.
    pub wall_seconds: f64,
    /// What changed against the report of its kind before it; absent for the first one.
    pub against: Option<Change>,
}

/// What changed from one report to the next.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Change {
    /// The earlier `report.json`, below the folder of the index.
    pub file: String,
    /// What is different.
    pub changes: Changes,
}

/// What could not be read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unreadable {
    /// File or folder, below the folder of the index.
    pub file: String,
    /// What is wrong with it.
    pub problem: String,
}

/// All reports below a folder.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Index {
    /// Those that could be read, the newest first.
    pub reports: Vec<Entry>,
    /// Files and folders that could not.
    pub unreadable: Vec<Unreadable>,
}

impl Index {
    /// Reads what was found below a folder.
    pub fn read(folder: &Path, found: &Found) -> Index {
        let below = |path: &Path| path.strip_prefix(folder).unwrap_or(path).display().to_string();
        let mut unreadable = Vec::new();
        let mut read: Vec<(Entry, Qualification)> = Vec::new();
        for path in &found.reports {
            match read_file(path) {
                Ok(qualification) => {
                    let page = path.with_file_name("report.html");
                    let page = page.is_file().then(|| below(&page));
                    read.push((entry(below(path), page, &qualification), rows_alone(qualification)));
                }
                Err(problem) => {
                    // The file is named once, from the folder on.
                    let named = format!("{}: ", path.display());
                    let problem = problem.strip_prefix(&named).unwrap_or(&problem).to_string();
                    unreadable.push(Unreadable { file: below(path), problem });
                }
            }
        }
        let unseen = found.unseen.iter();
        unreadable.extend(unseen.map(|(path, problem)| Unreadable { file: below(path), problem: problem.clone() }));
        // One that has no date is older than all that have one; of equal dates the paths decide.
        read.sort_by(|(one, _), (other, _)| (&other.date, &one.file).cmp(&(&one.date, &other.file)));
        let against: Vec<Option<Change>> = (0..read.len()).map(|place| against(&read, place)).collect();
        let reports = read.into_iter().zip(against).map(|((entry, _), against)| Entry { against, ..entry });
        Index { reports: reports.collect(), unreadable }
    }

    /// As a table for a terminal, with what changed below it.
    pub fn text(&self) -> String {
        let table = Table::new(&["date", "tier", "verdict"], &["tests"])
            .with_words("version")
            .with_numbers(["wall time"])
            .with_words("report");
        let mut text = table
            .of(&self.reports, |entry| {
                cells![
                    entry.day(),
                    &entry.tier,
                    entry.standing.words(),
                    entry.count(),
                    entry.build(),
                    duration(entry.wall_seconds),
                    &entry.file,
                ]
            })
            .text();
        for entry in &self.reports {
            let Some(Change { file, changes }) = &entry.against else { continue };
            let lines = changes.lines();
            if !lines.is_empty() {
                text += &format!("\n{} against {file}:\n  {}\n", entry.file, lines.join("\n  "));
            }
        }
        text
    }
}

/// Reads a report out of a regular file: a pipe might never answer.
fn read_file(path: &Path) -> Result<Qualification, String> {
    match path.metadata() {
        Ok(there) if !there.is_file() => Err("it is no regular file, such as a folder, a pipe or a device".into()),
        _ => report::read(path),
    }
}

impl Entry {
    /// When it was made, to the minute.
    pub(super) fn day(&self) -> String {
        let date = self.date.as_deref().unwrap_or("no date");
        date.get(..16).map_or(date.into(), |minute| minute.replace('T', " "))
    }

    /// Tests that passed, of all.
    pub(super) fn count(&self) -> String {
        match self.tests {
            0 => "none".into(),
            tests => format!("{} of {tests}", self.passed),
        }
    }

    /// Version and commit in short.
    pub(super) fn build(&self) -> String {
        build(self.version.as_deref(), self.commit.as_deref())
    }
}

fn entry(file: String, page: Option<String>, qualification: &Qualification) -> Entry {
    let verdict = qualification.verdict();
    let named = |name: &str| qualification.provenance.get(name).filter(|value| !value.is_empty()).cloned();
    Entry {
        file,
        page,
        date: named("date"),
        tier: qualification.tier.clone(),
        title: qualification.title.clone(),
        standing: verdict.standing,
        passed: verdict.passed(),
        tests: verdict.tests(),
        sentence: verdict.sentence,
        version: named("version"),
        commit: named("commit"),
        processor: named("processor"),
        wall_seconds: qualification.wall_seconds,
        against: None,
    }
}

/// What two reports are held against each other by: many of them are in memory at a time.
fn rows_alone(mut qualification: Qualification) -> Qualification {
    for comparison in &mut qualification.comparisons {
        (comparison.series, comparison.forces, comparison.final_states) = Default::default();
    }
    qualification
}

/// What changed in a report against the next older one of its tier and title: comparisons of other scenes have other titles.
fn against(read: &[(Entry, Qualification)], place: usize) -> Option<Change> {
    let (entry, now) = &read[place];
    let kind = |entry: &Entry| (entry.tier.clone(), entry.title.clone());
    let (earlier, then) = read[place + 1..].iter().find(|(other, _)| kind(other) == kind(entry))?;
    Some(Change { file: earlier.file.clone(), changes: Changes::between(then, now) })
}

/// Version and the first digits of the commit, with what is said behind it.
fn build(version: Option<&str>, commit: Option<&str>) -> String {
    let (version, commit) = (version.unwrap_or("unknown"), commit.unwrap_or("unknown"));
    let digits = commit.chars().take_while(char::is_ascii_hexdigit).count();
    match digits > 8 {
        true => format!("{version} ({}{})", &commit[..8], &commit[digits..]),
        false => format!("{version} ({commit})"),
    }
}

#[cfg(test)]
mod tests {
    use super::build;

    #[test]
    fn a_build_is_told_in_short() {
        let known = "05d7833e3a726d55954a288b26e5df43aa47223c, changed";
        assert_eq!(build(Some("0.2.0"), Some(known)), "0.2.0 (05d7833e, changed)");
        assert_eq!(build(Some("0.2.0"), Some("unknown, changes unknown")), "0.2.0 (unknown, changes unknown)");
        assert_eq!(build(None, None), "unknown (unknown)");
    }
}
