//! The key of a build: a hash of all that decides the bits of a simulation. It is worked out while the package is built.
//!
//! What is hashed: the sources in the order of their names, without comments, indents and blank lines, which decide nothing; whatever
//! else lies among them, such as the driver of another code, byte for byte; and the versions of the packages that compute, as
//! `Cargo.lock` has them. Folders, dates, commits, profiles, processors and targets are left out: the same sources give the same bits
//! wherever they are built.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Packages that compute; with what they depend on they decide bits.
const COMPUTE: [&str; 4] = ["libm", "nalgebra", "rand_chacha", "rand_core"];

/// The key of the package in a folder.
pub fn build_key(folder: &Path) -> u64 {
    let mut hash = Fnv::default();
    let mut sources = Vec::new();
    list(&folder.join("src"), "", &mut sources);
    sources.sort();
    for (name, file) in sources {
        hash.add(&name);
        let bytes = std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        if !name.ends_with(".rs") {
            hash.bytes(&bytes);
            continue;
        }
        let text = String::from_utf8(bytes).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        for line in text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")) {
            hash.add(line);
        }
    }
    let lock = lock_file(folder).and_then(|file| std::fs::read_to_string(file).ok()).unwrap_or_default();
    for package in computing(&lock) {
        hash.add(&package);
    }
    hash.0
}

/// `Cargo.lock` of the package, where it is on its own, or of the workspace that it lies in.
pub fn lock_file(folder: &Path) -> Option<PathBuf> {
    let candidates = ["Cargo.lock", "../Cargo.lock", "../../Cargo.lock"].map(|file| folder.join(file));
    candidates.into_iter().find(|file| file.is_file())
}

/// Names (with `/` between folders, whatever the system) and files of all sources in a folder and those below it.
fn list(folder: &Path, prefix: &str, sources: &mut Vec<(String, PathBuf)>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for entry in entries.map(|entry| entry.unwrap_or_else(|error| panic!("{}: {error}", folder.display()))) {
        let (path, name) = (entry.path(), format!("{prefix}{}", entry.file_name().to_string_lossy()));
        if path.is_dir() {
            list(&path, &format!("{name}/"), sources);
        } else {
            sources.push((name, path));
        }
    }
}

/// The packages of a lock file that compute, each with its version and checksum, in the order of their names.
fn computing(lock: &str) -> BTreeSet<String> {
    let packages: Vec<Package<'_>> = lock.split("[[package]]").skip(1).map(Package::of).collect();
    let own = packages.iter().find(|package| package.name == "makadam");
    let computes = |name: &&&str| COMPUTE.contains(&name.split(' ').next().unwrap_or_default());
    let mut open: Vec<&str> =
        own.into_iter().flat_map(|own| own.dependencies.iter().filter(computes)).copied().collect();
    let mut found = BTreeSet::new();
    while let Some(asked) = open.pop() {
        let is_asked =
            |package: &&Package<'_>| asked == package.name || asked == format!("{} {}", package.name, package.version);
        if let Some(package) = packages.iter().find(is_asked)
            && found.insert(format!("{} {} {}", package.name, package.version, package.checksum))
        {
            open.extend(&package.dependencies);
        }
    }
    found
}

/// A package of a lock file.
struct Package<'a> {
    name: &'a str,
    version: &'a str,
    checksum: &'a str,
    /// Names, each with a version behind it where several versions are locked.
    dependencies: Vec<&'a str>,
}

impl<'a> Package<'a> {
    fn of(text: &'a str) -> Package<'a> {
        let value = |key: &str| {
            let found =
                text.lines().find_map(|line| line.strip_prefix(key)?.trim().strip_prefix("= \"")?.strip_suffix('"'));
            found.unwrap_or_default()
        };
        let list = text.split_once("dependencies = [").and_then(|(_, rest)| rest.split_once(']'));
        let quoted = list.map_or("", |(list, _)| list).split('"').skip(1).step_by(2);
        Package {
            name: value("name"),
            version: value("version"),
            checksum: value("checksum"),
            dependencies: quoted.collect(),
        }
    }
}

/// FNV-1a, 64 bits, of lines that end where they end.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Fnv {
        Fnv(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn add(&mut self, line: &str) {
        self.bytes(line.as_bytes());
        self.bytes(&[0]);
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
