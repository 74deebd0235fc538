//! Unit tests of `src/output/lock.rs`.

use super::*;

#[test]
fn a_folder_is_taken_once_at_a_time_and_left_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let lock = FolderLock::take(&output).unwrap();
    assert!(lock.holds());
    let refused = FolderLock::take(&output).err().unwrap().to_string();
    assert!(refused.contains(&format!("process {}", std::process::id())), "{refused}");
    drop(lock);
    assert!(!output.exists());
    std::fs::create_dir(&output).unwrap();
    std::fs::write(output.join(NAME), "of a process that was killed").unwrap();
    drop(FolderLock::take(&output).unwrap());
    assert_eq!(std::fs::read_dir(&output).unwrap().count(), 0);
}
