//! Unit tests of `src/codes/run_folder.rs`.

use super::*;
use std::fs::{File, write};
use std::os::unix::fs::symlink;

#[test]
fn patterns_stay_below_the_folder() {
    for pattern in ["out.csv", "./out.csv", "out/*.csv", "**/grains_*.csv", "..csv", "a..b"] {
        assert_eq!(check_pattern(pattern), Ok(()));
    }
    for pattern in ["", "/tmp/out.csv", "../out.csv", "out/../../out.csv"] {
        let problem = check_pattern(pattern).unwrap_err();
        assert!(problem.contains("leads out of the folder of a run; name files below"), "{problem}");
    }
    assert!(check_pattern("out[.csv").unwrap_err().contains("is no pattern of files"));
}

#[test]
fn what_lay_in_the_folder_before_is_gone() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("run");
    std::fs::create_dir_all(path.join("old")).unwrap();
    write(path.join("out.csv"), "x").unwrap();
    let folder = RunFolder::fresh(&path, vec![("scene.json".into(), vec![1])]).unwrap();
    let left = |path: &Path| std::fs::read_dir(path).unwrap().count();
    assert_eq!(left(&path), 1);
    assert_eq!(folder.files("out.csv").unwrap_err(), "the run has left no file out.csv");
}

#[test]
fn files_that_the_run_did_not_make_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("run");
    let folder = RunFolder::fresh(&path, vec![("grains.csv".into(), vec![1])]).unwrap();
    write(path.join("b.csv"), "x").unwrap();
    symlink("b.csv", path.join("a.csv")).unwrap();
    assert_eq!(folder.files("[ab].csv").unwrap(), [path.join("a.csv"), path.join("b.csv")]);
    let refused = |pattern: &str, words: &str| {
        let problem = folder.files(pattern).unwrap_err();
        assert!(problem.contains(words), "{pattern}: {problem}");
    };
    refused("grains.csv", "grains.csv is what the run was given");
    refused("*.csv", "grains.csv is what the run was given");
    write(root.path().join("elsewhere.csv"), "x").unwrap();
    symlink("../elsewhere.csv", path.join("linked.csv")).unwrap();
    refused("linked.csv", "linked.csv is a link to");
    symlink(root.path(), path.join("up")).unwrap();
    refused("up/elsewhere.csv", "out of the folder of the run");
    // A pattern that begins with a dot can match the folder above.
    refused(".?/elsewhere.csv", "out of the folder of the run");
    let old = File::create(path.join("old.csv")).unwrap();
    old.set_modified(SystemTime::now() - Duration::from_secs(60)).unwrap();
    refused("old.csv", "before the run began");
    old.set_modified(SystemTime::now() - Duration::from_secs(1)).unwrap();
    assert_eq!(folder.files("old.csv").unwrap().len(), 1, "within what clocks are coarse by");
}
