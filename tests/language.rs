//! Language rules: openings of doc comments, words and sentence lengths of Markdown pages.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Words at which no doc comment begins: a verb in the third person or a noun of the field stands there.
const OPENINGS: [&str; 7] = ["What", "Whether", "How", "Where", "Why", "Those", "The same"];

/// Words and phrases that have a standard term in the field, with that term.
const DIALECT: [(&str, &[&str]); 26] = [
    ("validation, compare, test", &["judge", "judges", "judged", "judging", "judgement", "referee"]),
    ("reference code", &["peer", "peers"]),
    ("carry, transmit, active", &["bear", "bears", "bore", "borne", "bearable"]),
    ("stored, saved, recorded", &["kept", "unkept"]),
    ("fix", &["mend", "mends", "mended"]),
    ("the caller, no caller", &["whoever", "nobody", "somebody"]),
    ("again, rebuilt", &["anew"]),
    ("instead of", &["in place of"]),
    ("next to, in addition to", &["beside", "besides"]),
    ("invalid", &["worthless"]),
    ("fatal", &["grave"]),
    ("poll, honour", &["heed", "heeds", "heeded"]),
    ("so", &["thus", "hence", "whereof"]),
    ("report, print, state", &["told", "untold", "tell", "tells"]),
    ("inconsistent", &["at odds"]),
    ("baseline", &["on record"]),
    ("module", &["room", "rooms"]),
    ("code base", &["house"]),
    ("run, execute", &["carry out", "carries out", "carried out"]),
    ("compared with", &["held against"]),
    ("stress tests", &["hard case", "hard cases"]),
    ("resume, continue", &["go on", "goes on", "gone on"]),
    ("request", &["ask for", "asks for", "asked for"]),
    ("enable", &["call for", "calls for", "called for"]),
    ("overdamped contacts", &["calm contact", "calm contacts"]),
    ("not a number", &["is no number"]),
];

/// Most words of a sentence.
const LONGEST_SENTENCE: usize = 35;
/// Largest mean number of words of a sentence.
const MEAN_SENTENCE: f64 = 18.0;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Lists the files of the repository that match a pattern.
fn files(pattern: &str) -> Vec<String> {
    let output = Command::new("git").args(["ls-files", pattern]).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "git ls-files {pattern}");
    let listed = String::from_utf8(output.stdout).unwrap();
    listed.lines().filter(|file| root().join(file).exists()).map(String::from).collect()
}

/// Returns the first line of each doc comment of a source, with its line number.
fn openings(source: &str) -> Vec<(usize, &str)> {
    let doc = |line: &str| ["///", "//!"].iter().any(|mark| line.trim_start().starts_with(mark));
    let mut found = Vec::new();
    let mut inside = false;
    for (number, line) in source.lines().enumerate() {
        if doc(line) && !inside {
            found.push((number + 1, line.trim_start()[3..].trim_start()));
        }
        inside = doc(line);
    }
    found
}

fn begins_badly(opening: &str) -> bool {
    let rest = |word: &&str| opening.strip_prefix(*word);
    OPENINGS.iter().filter_map(rest).any(|rest| !rest.starts_with(|letter: char| letter.is_alphanumeric()))
}

#[test]
fn doc_comments_open_with_a_verb_or_noun() {
    let mut found = Vec::new();
    for file in files("*.rs") {
        let text = fs::read_to_string(root().join(&file)).unwrap();
        let bad = openings(&text).into_iter().filter(|(_, opening)| begins_badly(opening));
        found.extend(bad.map(|(line, opening)| format!("{file}:{line}: {opening}")));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Returns the prose of a page by line: without code, targets of links and quotations of messages.
fn prose(page: &str) -> Vec<String> {
    let mut fenced = false;
    let line = |line: &str| {
        if line.starts_with("```") {
            fenced = !fenced;
            return String::new();
        }
        if fenced || line.starts_with("    ") {
            return String::new();
        }
        let words: Vec<String> = line
            .split('`')
            .enumerate()
            .map(|(part, text)| if part % 2 == 0 { text.to_string() } else { "X".into() })
            .collect();
        let mut parts = words.concat();
        while let Some(start) = parts.find("](") {
            let end = parts[start..].find(')').map_or(parts.len(), |end| start + end + 1);
            parts.replace_range(start..end, "");
        }
        parts
    };
    page.lines().map(line).collect()
}

/// Returns true if a text has a phrase as whole words, in any case.
fn has(text: &str, phrase: &str) -> bool {
    let text = text.to_lowercase();
    let is_edge = |letter: Option<char>| letter.is_none_or(|letter| !letter.is_alphanumeric() && letter != '-');
    text.match_indices(phrase).any(|(start, _)| {
        is_edge(text[..start].chars().next_back()) && is_edge(text[start + phrase.len()..].chars().next())
    })
}

/// Pages under the language rules: all except the record of changes.
fn pages() -> Vec<String> {
    files("*.md").into_iter().filter(|page| page != "CHANGELOG.md").collect()
}

#[test]
fn pages_use_standard_terms() {
    let mut found = Vec::new();
    for page in pages() {
        let text = fs::read_to_string(root().join(&page)).unwrap();
        for (number, line) in prose(&text).iter().enumerate() {
            for (standard, phrases) in DIALECT {
                let bad = phrases.iter().filter(|phrase| has(line, phrase));
                found.extend(bad.map(|phrase| format!("{page}:{}: '{phrase}': {standard}", number + 1)));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Returns the sentences of a page's paragraphs and lists; tables, headings and pictures are left out.
fn sentences(page: &str) -> Vec<String> {
    let mut paragraphs = vec![String::new()];
    for line in prose(page) {
        let item = line.trim_start().starts_with("- ");
        if line.trim().is_empty() || item || line.starts_with(['|', '#', '!', '<']) {
            paragraphs.push(String::new());
        }
        if !line.starts_with(['|', '#', '!', '<']) {
            let last = paragraphs.last_mut().unwrap();
            *last += line.trim().trim_start_matches("- ");
            last.push(' ');
        }
    }
    let ends = |paragraph: &String| {
        let mut text = paragraph.clone();
        for end in [". ", "? ", ": ", "; "] {
            text = text.replace(end, &format!("{}\n", end.trim_end()));
        }
        text.lines().map(String::from).collect::<Vec<_>>()
    };
    paragraphs.iter().flat_map(ends).filter(|sentence| sentence.split_whitespace().count() > 2).collect()
}

#[test]
fn sentences_are_short() {
    let (mut words, mut count, mut long) = (0, 0, Vec::new());
    for page in pages() {
        for sentence in sentences(&fs::read_to_string(root().join(&page)).unwrap()) {
            let length = sentence.split_whitespace().count();
            (words, count) = (words + length, count + 1);
            if length > LONGEST_SENTENCE {
                long.push(format!("{page}: {length} words: {sentence}"));
            }
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
    let mean = words as f64 / count as f64;
    assert!(mean < MEAN_SENTENCE, "{mean} words per sentence");
}
