//! Unit tests of `src/study/campaign.rs`.

use super::*;
use std::sync::Mutex;

#[test]
fn results_keep_the_order_of_jobs() {
    let last = Mutex::new(0.0_f64);
    let progress = |fraction: f64| {
        let mut last = last.lock().unwrap();
        *last = last.max(fraction);
    };
    let square = |job: &f64, done: &(dyn Fn(f64) + Sync)| {
        done(0.5);
        if *job < 0.0 { Err("negative") } else { Ok(job * job) }
    };
    assert_eq!(run_jobs(&[3.0, 1.0, 2.0], |job| *job, &progress, square), Ok(vec![9.0, 1.0, 4.0]));
    assert!((*last.lock().unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(run_jobs(&[3.0, -1.0], |job| *job, &|_| (), square), Err("negative"));
}

#[test]
fn a_run_is_taken_up_by_its_own_key_alone_and_only_if_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let cache = |again| RunCache::open(&folder.path().join("runs"), again).unwrap();
    let key = |build: &str| Key::new("case-s1".into(), &["a scene", "1", build]);
    let take = |build: &str, again, number: u32| cache(again).take(&key(build), || Ok(number)).unwrap();
    assert_eq!(take("one", false, 1), 1);
    assert_eq!(take("one", false, 2), 1, "it is kept");
    assert_eq!(take("one", true, 3), 3, "it is made again");
    assert_eq!(take("two", false, 4), 4, "another build has made it");
    assert_eq!(take("one", false, 5), 5, "and written over it");
    let file = folder.path().join("runs/case-s1.json");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("\"Ok\": 5", "\"Ok\": 6")).unwrap();
    assert_eq!(take("one", false, 7), 7, "a number that was changed is not what was kept");
    let cache = cache(false);
    assert_ne!(cache.file(&key("one").apart()), cache.file(&key("two").apart()));
    // Numbers that are invalid stay so, and numbers that JSON does not have are not stored.
    let invalid = || cache.take::<f64>(&key("three"), || Err(RunError::Invalid("grains overlap".into())));
    assert!(matches!(invalid(), Err(RunError::Invalid(_))));
    let again = cache.take(&key("three"), || Ok(1.0));
    assert!(matches!(again, Err(RunError::Invalid(problem)) if problem == "grains overlap"));
    assert!(cache.take(&key("four"), || Ok(f64::NAN)).unwrap().is_nan());
    assert_eq!(cache.take(&key("four"), || Ok(2.0)).unwrap(), 2.0);
    assert_eq!(cache.counts(), [1, 0]);
}
