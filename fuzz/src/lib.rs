//! The readers of the property tests, for libFuzzer; `cargo run --bin seeds` writes their sound documents as corpora.

#[path = "../../validation/tests/support/readers/mod.rs"]
pub mod readers;

/// Lets the reader of a name read bytes.
pub fn read(name: &str, bytes: &[u8]) {
    (readers::named(name).read)(bytes);
}
