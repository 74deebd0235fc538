//! Works out the key of the build: see `build_key.rs`.

mod build_key;

use std::path::Path;

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("cargo says where the package is");
    let folder = Path::new(&folder);
    println!("cargo::rustc-env=MAKADAM_BUILD_KEY={:016x}", build_key::build_key(folder));
    for path in ["src", "build.rs", "build_key.rs"] {
        println!("cargo::rerun-if-changed={path}");
    }
    if let Some(lock) = build_key::lock_file(folder) {
        println!("cargo::rerun-if-changed={}", lock.display());
    }
}
