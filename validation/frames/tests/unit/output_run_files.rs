//! Unit tests of `src/output/run_files.rs`.

use super::*;

#[test]
fn only_files_of_a_run_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let ours = ["run.checkpoint", "observables.csv", "frames.mkd", "measured-frames.mkd", "run.json.part12-3"];
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
