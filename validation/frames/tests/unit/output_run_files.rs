//! Unit tests of `src/output/run_files.rs`.

use super::*;

#[test]
fn only_files_of_a_run_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let ours =
        ["run.checkpoint", "run.held", "observables.csv", "frames.mkd", "measured-frames.mkd", "run.json.part12-3"];
    let others = ["run.json", "scene.toml", "observables.csv.bak", "frames.mkd.partial", "grains.pvd"];
    for name in ours.iter().chain(&others) {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let files = RunFiles::inside(folder.path());
    files.remove_drafts().unwrap();
    assert!(files.any());
    assert!(ours.iter().all(|name| folder.path().join(name).exists() != name.contains(DRAFT)));
    files.remove().unwrap();
    assert!(ours.iter().all(|name| !folder.path().join(name).exists()));
    assert!(others.iter().all(|name| folder.path().join(name).exists()));
    std::fs::remove_file(folder.path().join("run.json")).unwrap();
    assert!(!files.any());
    assert!(!RunFiles::inside(&folder.path().join("nowhere")).any());
}

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
