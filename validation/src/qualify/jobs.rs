//! Jobs side by side: as many at a time as there are threads, the longest first, none done twice.

use super::QualifyError;
use crate::plan::Scene;
use makadam::scene::Stop;
use rayon::prelude::*;
use std::sync::Mutex;

/// Sweeps of a solve that stops by itself, where its cost is guessed.
const GUESSED_SWEEPS: u32 = 20;

/// Something to be done on one core, which keeps what comes of it.
pub(super) struct Job<'a> {
    /// What is computed: of jobs of the same name the first computes, and the others find what it has kept.
    pub(super) identity: String,
    /// How much work it is, in any unit that all jobs share.
    pub(super) weight: f64,
    /// Does it.
    pub(super) work: Box<dyn FnOnce() -> Result<(), QualifyError> + Send + 'a>,
}

/// Does all jobs.
///
/// # Errors
/// That of a job that failed; no other is begun after it.
pub(super) fn carry_out(jobs: Vec<Job<'_>>) -> Result<(), QualifyError> {
    let mut tasks: Vec<Vec<Job<'_>>> = Vec::new();
    for job in jobs {
        match tasks.iter_mut().find(|task| task[0].identity == job.identity) {
            Some(task) => task.push(job),
            None => tasks.push(vec![job]),
        }
    }
    tasks.par_sort_by(|one, other| other[0].weight.total_cmp(&one[0].weight));
    let failure: Mutex<Option<QualifyError>> = Mutex::new(None);
    let failed = || failure.lock().expect("nothing panics while it holds the lock").is_some();
    // First in, first out: whichever thread is free takes the longest task that is left.
    rayon::scope_fifo(|scope| {
        for job in tasks {
            let (failure, failed) = (&failure, &failed);
            scope.spawn_fifo(move |_| {
                for job in job {
                    if failed() {
                        return;
                    }
                    if let Err(error) = (job.work)() {
                        failure.lock().expect("nothing panics while it holds the lock").get_or_insert(error);
                    }
                }
            });
        }
    });
    failure.into_inner().expect("nothing panics while it holds the lock").map_or(Ok(()), Err)
}

/// How much work the run of a scene is: grains times steps times sweeps.
pub(super) fn weight(scene: &Scene) -> f64 {
    let sweeps = match scene.solver.stop {
        Stop::Sweeps { sweeps } => sweeps,
        _ => GUESSED_SWEEPS,
    };
    scene.grain_count() as f64 * scene.duration / scene.solver.step * f64::from(sweeps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn of_the_same_one_is_done_after_the_other_and_a_failure_ends_all() {
        let (busy, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let job = |identity: &str, weight| Job {
            identity: identity.into(),
            weight,
            work: Box::new(|| {
                assert_eq!(busy.fetch_add(1, Ordering::SeqCst), 0, "two of the same at a time");
                std::thread::sleep(std::time::Duration::from_millis(1));
                busy.fetch_sub(1, Ordering::SeqCst);
                done.fetch_add(1, Ordering::SeqCst);
                Ok(())
            }),
        };
        carry_out((0..20).map(|number| job("same", f64::from(number))).collect()).unwrap();
        assert_eq!(done.load(Ordering::SeqCst), 20);
        let fails = Job { identity: "fails".into(), weight: 9.0, work: Box::new(|| Err(QualifyError::Interrupted)) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let ended = pool.install(|| carry_out(vec![job("later", 1.0), fails, job("first", 10.0)]));
        assert!(matches!(ended, Err(QualifyError::Interrupted)));
        assert_eq!(done.load(Ordering::SeqCst), 21, "the longest came first, and nothing after the failure");
    }
}
