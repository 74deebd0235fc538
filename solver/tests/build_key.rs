//! The key of a build changes with all that decides bits, and with nothing else.

#[path = "../build_key.rs"]
mod key;

use key::build_key;
use std::fs::{create_dir_all, read_to_string, write};
use std::path::{Path, PathBuf};

const LOCK: &str = r#"version = 4

[[package]]
name = "clap"
version = "4.6.0"
checksum = "aaaa"

[[package]]
name = "libm"
version = "0.2.15"
checksum = "bbbb"

[[package]]
name = "makadam"
version = "0.2.0"
dependencies = [
 "clap",
 "libm",
 "rand_core 0.9.3",
]

[[package]]
name = "ppv"
version = "1.0.0"
checksum = "cccc"

[[package]]
name = "rand_core"
version = "0.6.4"
checksum = "dddd"

[[package]]
name = "rand_core"
version = "0.9.3"
checksum = "eeee"
dependencies = [
 "ppv",
]
"#;

/// A small package in a folder of its own below `base`.
fn package(base: &Path, name: &str) -> PathBuf {
    let folder = base.join(name).join("solver");
    create_dir_all(folder.join("src/sweep")).unwrap();
    write(folder.join("src/lib.rs"), "mod sweep;\n\npub const STEP: f64 = 1.0;\n").unwrap();
    write(folder.join("src/sweep/mod.rs"), "fn sweep() {\n    relax();\n}\n").unwrap();
    write(base.join(name).join("Cargo.lock"), LOCK).unwrap();
    folder
}

#[test]
fn a_key_changes_with_sources_effects_and_packages_that_compute_and_with_nothing_else() {
    let base = std::env::temp_dir().join(format!("makadam-build-key-{}", std::process::id()));
    let (one, other) = (package(&base, "one"), package(&base, "a longer name"));
    let expected = build_key(&one);
    assert_eq!(build_key(&other), expected, "it does not depend on the folder");

    let after = |file: &str, from: &str, to: &str| {
        let file = one.join(file);
        let text = read_to_string(&file).unwrap();
        assert!(text.contains(from), "{from}");
        write(&file, text.replace(from, to)).unwrap();
        let key = build_key(&one);
        write(&file, text).unwrap();
        key
    };
    assert_ne!(after("src/sweep/mod.rs", "relax()", "relax(0)"), expected, "a source below");
    assert_ne!(after("src/lib.rs", "1.0", "2.0"), expected, "a source");
    assert_ne!(after("../Cargo.lock", "0.2.15", "0.2.16"), expected, "a package that computes");
    assert_ne!(after("../Cargo.lock", "cccc", "cccd"), expected, "what such a package depends on");
    assert_eq!(after("../Cargo.lock", "4.6.0", "4.7.0"), expected, "a package that does not compute");
    assert_eq!(after("../Cargo.lock", "dddd", "ddde"), expected, "another version of one that does");
    assert_eq!(after("src/lib.rs", "pub const", "// Why.\n    /// What.\r\n\npub const"), expected, "comments");

    // A package on its own has its lock file beside it.
    std::fs::rename(base.join("one/Cargo.lock"), one.join("Cargo.lock")).unwrap();
    assert_eq!(build_key(&one), expected, "packaged");
    write(one.join("src/new.rs"), "").unwrap();
    assert_ne!(build_key(&one), expected, "a new source");
    std::fs::remove_file(one.join("src/new.rs")).unwrap();
    for bytes in [&b"# how another code is driven"[..], &[0xff, 0x00]] {
        write(one.join("src/driver.py"), bytes).unwrap();
        assert_ne!(build_key(&one), expected, "what is embedded");
    }
    std::fs::remove_dir_all(base).unwrap();
}

#[test]
fn the_build_says_its_version_and_the_key_of_these_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let key = build_key(folder);
    assert_eq!(makadam::BUILD, format!("{}-{key:016x}", env!("CARGO_PKG_VERSION")));
    let lock = read_to_string(key::lock_file(folder).unwrap()).unwrap();
    assert!(["libm", "nalgebra", "rand_chacha", "rand_core"].iter().all(|name| lock.contains(&format!("\"{name}\""))));
}
