//! Unit tests of `src/study/cache.rs`.

use super::*;

#[test]
fn a_run_is_taken_up_by_its_own_key_alone_and_only_if_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let cache = RunCache::open(&folder.path().join("runs")).unwrap();
    let key = |build: &str| Key::new("case-s1".into(), &["a scene", "1", build]);
    let take =
        |build: &str, again, number: u32| cache.take(&key(build), again, || Ok::<u32, WriteError>(number)).unwrap();
    assert_eq!(take("one", false, 1), 1);
    assert_eq!(take("one", false, 2), 1, "it is kept");
    assert_eq!(take("one", true, 3), 3, "it is made again");
    assert_eq!(take("two", false, 4), 4, "another build has made it");
    assert_eq!(take("one", false, 5), 5, "and written over it");
    let file = folder.path().join("runs/case-s1.json");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("\"kept\": 5", "\"kept\": 6")).unwrap();
    assert_eq!(take("one", false, 7), 7, "a number that was changed is not what was kept");
    assert_eq!(damaged_below(folder.path()), [folder.path().join("runs/case-s1.damaged")]);
    assert_ne!(cache.file(&key("one").apart()), cache.file(&key("two").apart()));
}
