//! Captures the commit that the program is built from, and whether the sources differ from it.

use std::process::Command;

fn main() {
    let commit = output("git", &["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".into());
    let dirty = match output("git", &["status", "--porcelain", "--untracked-files=no"]) {
        Some(changes) => (!changes.is_empty()).to_string(),
        None => "unknown".into(),
    };
    println!("cargo::rustc-env=MAKADAM_COMMIT={commit}");
    println!("cargo::rustc-env=MAKADAM_DIRTY={dirty}");
    // They change with the sources, the index and the head.
    for path in ["build.rs", "../solver", "../validation", "../Cargo.toml", "../Cargo.lock"] {
        println!("cargo::rerun-if-changed={path}");
    }
    for name in ["HEAD", "index", "logs/HEAD"] {
        if let Some(path) = output("git", &["rev-parse", "--path-format=absolute", "--git-path", name]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    // Git would write its index anew, which is one of the files that make this run again.
    let output = Command::new(program).args(arguments).env("GIT_OPTIONAL_LOCKS", "0").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
}
