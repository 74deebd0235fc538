//! Unit tests of `src/qualify/scenes.rs`.

use super::*;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn equal_jobs_run_in_turn_and_a_failure_ends_all() {
    let (busy, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let job = |identity: &str, weight| Job {
        identity: identity.into(),
        weight,
        alone: false,
        work: Box::new(|| {
            assert_eq!(busy.fetch_add(1, Ordering::SeqCst), 0, "two of the same at a time");
            std::thread::sleep(std::time::Duration::from_millis(1));
            busy.fetch_sub(1, Ordering::SeqCst);
            done.fetch_add(1, Ordering::SeqCst);
            Ok(())
        }),
    };
    run((0..20).map(|number| job("same", f64::from(number))).collect()).unwrap();
    assert_eq!(done.load(Ordering::SeqCst), 20);
    let fails =
        Job { identity: "fails".into(), weight: 9.0, alone: false, work: Box::new(|| Err(RunError::Interrupted)) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let ended = pool.install(|| run(vec![job("later", 1.0), fails, job("first", 10.0)]));
    assert!(matches!(ended, Err(RunError::Interrupted)));
    assert_eq!(done.load(Ordering::SeqCst), 21, "the longest came first, and nothing after the failure");
}
