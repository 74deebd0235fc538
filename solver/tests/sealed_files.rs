//! Files that are written whole or not at all, and whose damage is noticed.

use makadam::checkpoint::{open, replace_with, seal, write_atomically};
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("makadam-draft-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[cfg(unix)]
#[test]
fn a_draft_never_follows_a_link_that_stands_in_its_place() {
    let folder = folder("links");
    let (file, victim) = (folder.join("state"), folder.join("victim"));
    std::fs::write(&victim, "untouched").unwrap();
    // Names that drafts have had, would have next, or would have in another process.
    for number in 0..200 {
        for name in [format!("state.part{}-{number}", std::process::id()), format!("state.part{}", std::process::id())]
        {
            let _ = std::os::unix::fs::symlink(&victim, folder.join(name));
        }
    }
    std::os::unix::fs::symlink(&victim, folder.join("state.part")).unwrap();
    std::os::unix::fs::symlink(&victim, &file).unwrap();
    write_atomically(&file, b"new").unwrap();
    assert_eq!(std::fs::read(&file).unwrap(), b"new");
    assert!(!file.is_symlink());
    assert_eq!(std::fs::read(&victim).unwrap(), b"untouched");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_cannot_be_written_leaves_the_old_file_and_no_draft() {
    let folder = folder("failure");
    let file = folder.join("state");
    write_atomically(&file, b"old").unwrap();
    let failed = replace_with(&file, |open| {
        open.write_all(b"half")?;
        Err(ErrorKind::StorageFull.into())
    });
    assert_eq!(failed.unwrap_err().kind(), ErrorKind::StorageFull);
    assert_eq!(std::fs::read(&file).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    std::fs::remove_dir_all(folder).unwrap();
}

const EXAMPLE: [u8; 8] = *b"example\x03";

#[test]
fn every_change_of_a_sealed_file_is_noticed() {
    let sealed = seal(EXAMPLE, b"some body");
    assert_eq!(open(EXAMPLE, &sealed).unwrap(), b"some body");
    for place in 0..sealed.len() {
        for bit in 0..8 {
            let mut changed = sealed.clone();
            changed[place] ^= 1 << bit;
            assert!(open(EXAMPLE, &changed).is_err(), "bit {bit} of byte {place}");
        }
        assert!(open(EXAMPLE, &sealed[..place]).is_err(), "cut at {place}");
    }
    let longer = [sealed.as_slice(), b"x"].concat();
    assert!(open(EXAMPLE, &longer).unwrap_err().contains("cut off"));
    assert!(open(*b"example\x04", &sealed).unwrap_err().contains("version 3"));
}
