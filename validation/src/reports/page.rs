//! The page: a table of all reports, and what changed from one to the next.

use super::index::{Change, Entry, Index};
use crate::draw::numbers::duration;
use crate::study::{Cell, DocumentError, Table, cells, environment, style, write_together};
use minijinja::{Value, context};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Name of the page.
const NAME: &str = "index.html";

/// By what an earlier page is known.
const HEADING: &str = "Makadam, all reports of a folder";

impl Index {
    /// Writes `index.html` into the folder that it is of; returns its path.
    ///
    /// # Errors
    /// [`DocumentError`] if it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, DocumentError> {
        write_together(folder, &[(NAME.to_string(), self.page()?.into_bytes())])?;
        Ok(folder.join(NAME))
    }

    /// Whether its page may be written into a folder: there is none, or one that was written by this.
    pub fn may_write(folder: &Path) -> bool {
        std::fs::read(folder.join(NAME)).map_or(true, |bytes| String::from_utf8_lossy(&bytes).contains(HEADING))
    }

    fn page(&self) -> Result<String, minijinja::Error> {
        let mut environment = environment()?;
        environment.add_template("page", include_str!("page.html"))?;
        let changed = self.reports.iter().enumerate().filter_map(|(place, entry)| {
            let Change { file, changes } = entry.against.as_ref()?;
            let lines = changes.lines();
            let heading = format!("{}, {}", entry.day(), entry.title);
            (!lines.is_empty()).then(|| context! { anchor => anchor(place), heading, file, lines })
        });
        let newest = self.reports.first().map(|entry| {
            let (word, class) = (entry.standing.words(), entry.standing.class());
            context! { word, class, day => entry.day(), tier => entry.tier, sentence => entry.sentence }
        });
        environment.get_template("page")?.render(context! {
            title => "Reports",
            heading => HEADING,
            style => style(),
            count => self.reports.len(),
            newest,
            table => table(&self.reports).html(),
            changed => changed.collect::<Vec<Value>>(),
            unreadable => self.unreadable,
        })
    }
}

/// All reports, one a row.
fn table(reports: &[Entry]) -> Table {
    let table = Table::new(&["date (UTC)", "tier", "verdict"], &["tests passed"]);
    let table = table.with_words("report").with_words("against the one before").with_words("version").of_class("wide");
    let mut table = table.with_numbers(["wall time"]).with_words("processor");
    for (place, entry) in reports.iter().enumerate() {
        let report = entry.page.as_ref().unwrap_or(&entry.file);
        table.row(cells![
            entry.day(),
            &entry.tier,
            Cell::from("").outcome(Some((entry.standing.class(), entry.standing.words()))),
            entry.count(),
            Cell::from(report).linked(address(report)),
            changes(entry, place),
            entry.build(),
            duration(entry.wall_seconds),
            entry.processor.as_deref(),
        ]);
    }
    table
}

/// How much changed, with a link to what.
fn changes(entry: &Entry, place: usize) -> Cell {
    let Some(Change { changes, .. }) = &entry.against else { return Cell::from("the first of its kind") };
    let kinds = [
        (changes.lost.len(), "lost"),
        (changes.gained.len(), "new"),
        (changes.outcomes.len(), "changed"),
        (changes.conditions.len(), "under other conditions"),
        (changes.moved.len(), "moved"),
    ];
    let kinds: Vec<String> =
        kinds.iter().filter(|(count, _)| *count > 0).map(|(count, word)| format!("{count} {word}")).collect();
    match kinds.is_empty() {
        true => Cell::from("the same"),
        false => Cell::from(kinds.join(", ")).linked(format!("#{}", anchor(place))),
    }
}

fn anchor(place: usize) -> String {
    format!("change-{}", place + 1)
}

/// The address of a file below the page: whatever is no letter or number may mean something else in it.
fn address(path: &str) -> String {
    let mut address = String::new();
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => address.push(char::from(byte)),
            _ => {
                let _ = write!(address, "%{byte:02X}");
            }
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_that_of_the_file_alone() {
        assert_eq!(address("a b/ü#1?.html"), "a%20b/%C3%BC%231%3F.html");
        assert_eq!(address("c:d"), "c%3Ad");
    }
}
