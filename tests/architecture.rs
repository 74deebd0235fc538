//! Architecture page compared with the code: paths, modules, order of imports, places of unsafe code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn page() -> String {
    fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap()
}

/// Returns the words between backticks in a text.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// Returns the rows of a section's table; modules of one row may import each other.
fn layers(page: &str, section: &str) -> Vec<Vec<String>> {
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

/// Returns true for a file of tests.
fn is_test(file: &Path) -> bool {
    if file.components().any(|part| part.as_os_str() == "tests") {
        return true;
    }
    file.file_name().is_some_and(|name| name == "tests.rs")
}

/// Returns the module of a file of a crate; none for `lib.rs` and `main.rs`.
fn module(source: &Path, file: &Path) -> Option<String> {
    let within = file.strip_prefix(source).unwrap();
    let name = within.components().next().unwrap().as_os_str().to_str().unwrap();
    let name = name.strip_suffix(".rs").unwrap_or(name);
    (!["lib", "main"].contains(&name)).then(|| name.to_string())
}

/// Returns the re-exports of a crate with the module of each.
fn reexports(front: &str) -> BTreeMap<String, String> {
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
    let layers = layers(&page, section);
    let layer_of = |module: &str| layers.iter().position(|layer| layer.iter().any(|one| one == module));
    let front = reexports(&code(&source.join("lib.rs")));
    let mut modules = BTreeSet::new();
    for file in sources(&source).iter().filter(|file| !is_test(file)) {
        let Some(own) = module(&source, file) else { continue };
        let own_layer = layer_of(&own).unwrap_or_else(|| panic!("module {own} is not in the table of {section}"));
        for name in imported(&code(file)) {
            let other = if layer_of(&name).is_some() { &name } else { front.get(&name).unwrap_or(&name) };
            let Some(layer) = layer_of(other) else { continue };
            assert!(layer <= own_layer, "{} imports {other}, which is below it in the page", file.display());
        }
        modules.insert(own);
    }
    let listed: BTreeSet<String> = layers.into_iter().flatten().collect();
    assert_eq!(listed, modules, "modules of the page and of {}", source.display());
}

#[test]
fn imports_of_the_solver_run_one_way() {
    imports_run_one_way("solver/src", "Modules of the solver");
}

#[test]
fn imports_of_the_validation_run_one_way() {
    for package in ["frames", "measure", "view", "compare", "studies", "qualification"] {
        imports_run_one_way(&format!("validation/{package}/src"), &format!("Modules of `makadam-{package}`"));
    }
    imports_run_one_way("validation/src", "Modules of the command");
}

#[test]
fn imports_of_the_python_package_run_one_way() {
    imports_run_one_way("python/src", "Modules of the Python package");
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
fn unsafe_code_is_where_the_page_says() {
    let page = page();
    let row = page.lines().find(|line| line.starts_with("| unsafe code is in")).unwrap();
    let places: Vec<PathBuf> = quoted(row.split('|').nth(1).unwrap()).map(|path| root().join(path)).collect();
    let files = ["solver/src", "validation", "python/src"].map(|folder| sources(&root().join(folder)));
    for file in files.iter().flatten() {
        let has =
            !is_test(file) && code(file).split(|letter: char| !letter.is_alphanumeric()).any(|word| word == "unsafe");
        let may = places.iter().any(|place| file.starts_with(place));
        assert!(may || !has, "{} has unsafe code", file.display());
    }
}
