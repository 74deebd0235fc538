//! The book: its commands run, its scenes are read, its links lead somewhere.
//!
//! Blocks marked `sh` run one after the other in a folder of the page's own; those marked `sh ignore` install something, need another
//! code or take long. A block marked `toml` whose first line is a comment with a file's name is written to that file.

use makadam_frames::plan::MeasuredScene;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The pages of the book.
fn pages() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("docs")).unwrap();
    let mut pages: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    assert!(pages.len() >= 8, "{pages:?}");
    pages
}

/// A fenced block: what stands behind the fence, its lines, and where it begins.
struct Block {
    kind: String,
    text: String,
    line: usize,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut open = false;
    for (number, line) in page.lines().enumerate() {
        match line.strip_prefix("```") {
            Some(_) if open => open = false,
            Some(kind) => {
                open = true;
                blocks.push(Block { kind: kind.into(), text: String::new(), line: number + 1 });
            }
            None if open => {
                let text = &mut blocks.last_mut().unwrap().text;
                *text += line;
                *text += "\n";
            }
            None => {}
        }
    }
    assert!(!open, "a block does not end");
    blocks
}

/// Runs the blocks of a page in order, in one folder.
fn run(name: &str) {
    let text = std::fs::read_to_string(root().join("docs").join(name)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_makadam")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let mut ran = 0;
    for block in blocks(&text) {
        let place = format!("{name}:{}", block.line);
        match block.kind.as_str() {
            "sh" => {
                let output = Command::new("sh")
                    .args(["-e", "-c", &block.text])
                    .current_dir(folder.path())
                    .env("PATH", &path)
                    .env("XDG_CACHE_HOME", folder.path().join("cache"))
                    .output()
                    .unwrap();
                assert!(output.status.success(), "{place}: {}", String::from_utf8_lossy(&output.stderr));
                ran += 1;
            }
            "toml" => {
                MeasuredScene::parse(&block.text).unwrap_or_else(|error| panic!("{place}: {error}"));
                let first = block.text.lines().next().unwrap();
                let file = first.strip_prefix("# ").unwrap_or_else(|| panic!("{place}: no file is named"));
                std::fs::write(folder.path().join(file), &block.text).unwrap();
            }
            "sh ignore" | "text" => {}
            other => panic!("{place}: nobody tries a block marked '{other}'"),
        }
    }
    assert!(ran > 0, "{name} has no commands");
}

#[test]
fn the_first_hour_runs() {
    run("first-hour.md");
}

#[test]
fn the_recipes_run() {
    run("recipes.md");
}

#[test]
fn the_check_of_determinism_runs() {
    run("determinism.md");
}

#[test]
fn other_pages_have_no_untested_commands() {
    for page in pages() {
        let name = page.file_name().unwrap().to_str().unwrap();
        if !["first-hour.md", "recipes.md", "determinism.md"].contains(&name) {
            let text = std::fs::read_to_string(&page).unwrap();
            assert!(blocks(&text).iter().all(|block| ["sh ignore", "text"].contains(&block.kind.as_str())), "{name}");
        }
    }
}

/// Markdown pages of the repository, without build outputs.
fn all_pages() -> Vec<PathBuf> {
    let output = Command::new("git").args(["ls-files", "*.md"]).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "git ls-files");
    String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|page| root().join(page))
        .filter(|page| page.exists())
        .collect()
}

/// Anchors of a page's headings, as GitHub forms them.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let letter = |letter: char| match letter {
        ' ' => Some('-'),
        '-' | '_' => Some(letter),
        _ => letter.is_alphanumeric().then_some(letter),
    };
    headings.map(|heading| heading.to_lowercase().chars().filter_map(letter).collect()).collect()
}

#[test]
fn links_lead_to_files_and_headings() {
    let index = std::fs::read_to_string(root().join("docs/README.md")).unwrap();
    let mut broken = Vec::new();
    for page in all_pages() {
        let name = page.file_name().unwrap().to_str().unwrap();
        if page.parent().unwrap() == root().join("docs") && !["README.md", "SUMMARY.md"].contains(&name) {
            assert!(index.contains(&format!("({name})")), "{name} is not in the index");
        }
        let text = std::fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            if file.contains("://") {
                continue;
            }
            let path = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let is_missing = || !anchors(&std::fs::read_to_string(&path).unwrap()).iter().any(|one| one == anchor);
            if !path.exists() || (!anchor.is_empty() && is_missing()) {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}
