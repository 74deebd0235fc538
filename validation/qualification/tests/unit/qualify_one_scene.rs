//! Unit tests of `src/qualify/one_scene.rs`.

use super::*;

#[test]
fn codes_are_those_that_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    let usual = |live: bool| {
        let names = usual_codes(&file, live);
        names.iter().map(|name| name.code().name()).collect::<Vec<_>>().join(" ")
    };
    // Nothing is recorded: the lack of both referees will be told.
    assert_eq!(usual(false), "Makadam YADE LIGGGHTS");
    let reference = folder.path().join("reference");
    std::fs::create_dir(&reference).unwrap();
    std::fs::write(reference.join("runs.csv"), "code,version\nLIGGGHTS,3.8\n").unwrap();
    assert_eq!(usual(false), "Makadam LIGGGHTS");
    // Whatever became of its lines.
    std::fs::write(reference.join("final-state-lammps.csv"), "").unwrap();
    assert_eq!(usual(false), "Makadam LIGGGHTS LAMMPS");
    assert_eq!(usual(true), "Makadam YADE LIGGGHTS");
}
