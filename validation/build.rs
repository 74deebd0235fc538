//! Captures where the build came from (commit, dirty flag, compiler, target, profile, key of the judge's sources), and takes in the
//! reference scenes.

mod build_key;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let commit = output("git", &["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".into());
    let dirty = match output("git", &["status", "--porcelain", "--untracked-files=no"]) {
        Some(changes) => (!changes.is_empty()).to_string(),
        None => "unknown".into(),
    };
    let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let compiler = output(&compiler, &["--version"]).unwrap_or_else(|| "unknown".into());
    println!("cargo::rustc-env=MAKADAM_COMMIT={commit}");
    println!("cargo::rustc-env=MAKADAM_DIRTY={dirty}");
    println!("cargo::rustc-env=MAKADAM_COMPILER={compiler}");
    for (name, variable) in [("MAKADAM_TARGET", "TARGET"), ("MAKADAM_PROFILE", "PROFILE")] {
        println!("cargo::rustc-env={name}={}", std::env::var(variable).unwrap_or_default());
    }
    let folder = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo says it"));
    println!("cargo::rustc-env=MAKADAM_JUDGE_KEY={:016x}", build_key::build_key(&folder));
    // The commit and the dirty flag change with the sources, the index and the head.
    for path in ["src", "build.rs", "build_key.rs", "Cargo.toml", "../solver", "../Cargo.toml", "../Cargo.lock"] {
        println!("cargo::rerun-if-changed={path}");
    }
    hold_scenes();
    for name in ["HEAD", "index", "logs/HEAD"] {
        if let Some(path) = output("git", &["rev-parse", "--path-format=absolute", "--git-path", name]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}

/// Writes `scenes.rs`: every reference scene and every table recorded on it, by its path under `reference-scenes`.
fn hold_scenes() {
    let manifest = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo says it"));
    let root = manifest.join("reference-scenes");
    println!("cargo::rerun-if-changed={}", root.display());
    let mut files = Vec::new();
    for scene in entries(&root) {
        if scene.join("scene.toml").is_file() {
            files.push(scene.join("scene.toml"));
            let tables = entries(&scene.join("reference")).into_iter();
            files.extend(tables.filter(|file| file.extension().is_some_and(|extension| extension == "csv")));
        }
    }
    if files.is_empty() {
        println!("cargo::warning=no reference scenes beside the sources: the program will hold none");
    }
    let mut text = String::from("static HELD: &[Held] = &[\n");
    for file in files {
        let name = file.strip_prefix(&root).expect("it lies below").to_str().expect("names are plain").to_string();
        let _ = writeln!(text, "    ({name:?}, include_bytes!({file:?})),");
    }
    text += "];\n";
    let output = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo says it"));
    std::fs::write(output.join("scenes.rs"), text).expect("the build folder can be written");
}

/// Lists the content of a folder, sorted; empty if there is no folder.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let read = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = read.map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    // Git would write its index anew, which is one of the files that make this run again.
    let output = Command::new(program).args(arguments).env("GIT_OPTIONAL_LOCKS", "0").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
}
