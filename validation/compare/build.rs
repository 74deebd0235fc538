//! Works out the key of the sources that measure and compare, and takes in the reference scenes.

mod build_key;

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Packages whose sources decide what is measured, where they lie beside this one.
const MEASURING: [&str; 4] = ["../frames", "../measure", "../compare", "../studies"];

fn main() {
    let folder = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo says it"));
    let packages = MEASURING.iter().map(|name| folder.join(name)).filter(|package| package.join("src").is_dir());
    let keys: String = packages.map(|package| format!("{:016x}", build_key::build_key(&package))).collect();
    println!("cargo::rustc-env=MAKADAM_COMPARE_KEY={keys}");
    for path in ["build.rs", "build_key.rs", "../../Cargo.lock"] {
        println!("cargo::rerun-if-changed={path}");
    }
    for package in MEASURING {
        println!("cargo::rerun-if-changed={package}/src");
    }
    hold_scenes();
}

/// Writes `scenes.rs`: every reference scene with its meshes and every table recorded on it, by its path under `reference-scenes`.
fn hold_scenes() {
    let manifest = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo says it"));
    let root = manifest.join("reference-scenes");
    println!("cargo::rerun-if-changed={}", root.display());
    let mut files = Vec::new();
    for scene in entries(&root) {
        if scene.join("scene.toml").is_file() {
            let extensions = ["toml", "stl", "obj"].map(Some);
            let is_held =
                |file: &PathBuf| extensions.contains(&file.extension().and_then(|extension| extension.to_str()));
            files.extend(entries(&scene).into_iter().filter(is_held));
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
