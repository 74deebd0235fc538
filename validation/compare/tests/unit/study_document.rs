//! Unit tests of `src/study/document.rs`.

use super::*;

#[test]
fn a_full_disk_is_named() {
    let error =
        DocumentError::Io { path: "out/report.html".into(), source: std::io::Error::from(ErrorKind::StorageFull) };
    assert!(error.to_string().contains("out/report.html"), "{error}");
    assert!(error.to_string().contains("the disk is full"), "{error}");
}
