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
