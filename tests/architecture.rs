//! The architecture page and the code say the same: paths exist, every room is listed, imports run one way, unsafe code stands where the
//! page says.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn page() -> String {
    fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap()
}

/// What stands between backticks in a text.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The floors of a section's table, from the ground up; rooms of one floor may import each other.
fn floors(page: &str, section: &str) -> Vec<Vec<String>> {
    let text = page.split(&format!("## {section}\n")).nth(1).unwrap_or_else(|| panic!("no section {section}"));
    let rows = text.split("\n## ").next().unwrap().lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| quoted(row.split('|').nth(1).unwrap()).map(String::from).collect()).collect()
}

/// All source files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => files.extend(sources(&path)),
            false if path.extension().is_some_and(|extension| extension == "rs") => files.push(path),
            false => {}
        }
    }
    files
}

/// The text of a source without comments and without its tests.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).map(|line| format!("{line}\n")).collect()
}

/// Whether a file holds tests alone.
fn is_test(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == "tests.rs")
}

/// The room of a file of a crate; none for the crate's own front and its main program.
fn room(source: &Path, file: &Path) -> Option<String> {
    let within = file.strip_prefix(source).unwrap();
    let name = within.components().next().unwrap().as_os_str().to_str().unwrap();
    let name = name.strip_suffix(".rs").unwrap_or(name);
    (!["lib", "main"].contains(&name)).then(|| name.to_string())
}

/// What a crate's front passes on, by the room that it comes from.
fn passed_on(front: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for statement in front.split("pub use ").skip(1) {
        let statement = statement.split(';').next().unwrap();
        let from = statement.split("::").next().unwrap().to_string();
        let names = statement.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        found.extend(names.filter(|name| !name.is_empty()).map(|name| (name.to_string(), from.clone())));
    }
    found
}

/// The names that follow `crate::` in a code, each with all that a brace holds.
fn imported(code: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let reach = match rest.strip_prefix('{') {
            Some(rest) => rest.split(';').next().unwrap(),
            None => rest.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next().unwrap(),
        };
        let each = reach.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        names.extend(each.filter(|name| !name.is_empty()).map(String::from));
    }
    names
}

fn imports_run_one_way(source: &str, section: &str) {
    let (source, page) = (root().join(source), page());
    let floors = floors(&page, section);
    let floor_of = |room: &str| floors.iter().position(|floor| floor.iter().any(|one| one == room));
    let front = passed_on(&code(&source.join("lib.rs")));
    let mut rooms = BTreeSet::new();
    for file in sources(&source).iter().filter(|file| !is_test(file)) {
        let Some(own) = room(&source, file) else { continue };
        let own_floor = floor_of(&own).unwrap_or_else(|| panic!("room {own} is not in the table of {section}"));
        for name in imported(&code(file)) {
            let other = if floor_of(&name).is_some() { &name } else { front.get(&name).unwrap_or(&name) };
            let Some(floor) = floor_of(other) else { continue };
            assert!(floor <= own_floor, "{} imports {other}, which stands below it in the page", file.display());
        }
        rooms.insert(own);
    }
    let listed: BTreeSet<String> = floors.into_iter().flatten().collect();
    assert_eq!(listed, rooms, "rooms of the page and of {}", source.display());
}

#[test]
fn imports_of_the_solver_run_one_way() {
    imports_run_one_way("solver/src", "Rooms of the solver");
}

#[test]
fn imports_of_the_judge_run_one_way() {
    imports_run_one_way("validation/src", "Rooms of the judge");
}

#[test]
fn imports_of_the_python_package_run_one_way() {
    imports_run_one_way("python/src", "Rooms of the Python package");
}

#[test]
fn paths_of_the_pages_exist() {
    for page in ["ARCHITECTURE.md", "solver/docs/method.md"] {
        let text = fs::read_to_string(root().join(page)).unwrap();
        let paths: Vec<&str> = quoted(&text).filter(|word| word.contains('/') && !word.contains([' ', '='])).collect();
        assert!(paths.len() > 10, "{page}: {paths:?}");
        for path in paths {
            assert!(root().join(path).exists(), "{page} names {path}, which is not there");
        }
    }
}

#[test]
fn unsafe_code_stands_where_the_page_says() {
    let page = page();
    let row = page.lines().find(|line| line.starts_with("| unsafe code stands")).unwrap();
    let places: Vec<PathBuf> = quoted(row.split('|').nth(1).unwrap()).map(|path| root().join(path)).collect();
    let files = ["solver/src", "validation/src", "python/src"].map(|folder| sources(&root().join(folder)));
    for file in files.iter().flatten() {
        let has =
            !is_test(file) && code(file).split(|letter: char| !letter.is_alphanumeric()).any(|word| word == "unsafe");
        let may = places.iter().any(|place| file.starts_with(place));
        assert!(may || !has, "{} has unsafe code", file.display());
    }
}
