//! Execution of a campaign: jobs of (scene, code, seed, settings) on the thread pool, their results in the order of the jobs.
//!
//! A job takes its result from a [`RunCache`](super::RunCache) where an earlier start has stored it, so that a campaign resumes.

use super::DocumentError;
use crate::codes::CodeError;
use crate::scenes::SceneError;
use makadam_frames::output::WriteError;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Error that ended a run; finished runs stay stored.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The code is missing or failed.
    #[error(transparent)]
    Code(CodeError),
    /// The run came to a state that invalidates its numbers, and would do so again.
    #[error("{0}")]
    Invalid(String),
    /// The run cannot be stored.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A solver or a document outside the runs failed.
    #[error("{0}")]
    Failed(String),
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl RunError {
    /// Returns true if no other run may follow: the user asked to stop, or nothing can be stored.
    pub fn ends_all(&self) -> bool {
        matches!(self, RunError::Write(_) | RunError::Interrupted)
    }
}

impl From<CodeError> for RunError {
    fn from(error: CodeError) -> RunError {
        match error {
            CodeError::Scene(error) => RunError::Scene(error),
            CodeError::Interrupted { .. } => RunError::Interrupted,
            CodeError::InvalidState { .. } => RunError::Invalid(error.to_string()),
            other => RunError::Code(other),
        }
    }
}

impl From<DocumentError> for RunError {
    fn from(error: DocumentError) -> RunError {
        RunError::Failed(error.to_string())
    }
}

/// Runs jobs on the thread pool, those with the most work first; `progress` receives the fraction of the work that is done.
///
/// # Errors
/// That of a job; the other jobs that have begun end first.
pub fn run_jobs<J: Sync, R: Send, E: Send>(
    jobs: &[J],
    work: impl Fn(&J) -> f64,
    progress: &(dyn Fn(f64) + Sync),
    run: impl Fn(&J, &(dyn Fn(f64) + Sync)) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let works: Vec<f64> = jobs.iter().map(work).collect();
    let total: f64 = works.iter().sum();
    let fractions: Vec<AtomicU64> = jobs.iter().map(|_| AtomicU64::new(0)).collect();
    let one = |number: usize| {
        let done = |fraction: f64| {
            fractions[number].store(fraction.to_bits(), Ordering::Relaxed);
            let done = fractions.iter().map(|fraction| f64::from_bits(fraction.load(Ordering::Relaxed)));
            progress(done.zip(&works).map(|(fraction, work)| fraction * work).sum::<f64>() / total);
        };
        let result = run(&jobs[number], &done)?;
        done(1.0);
        Ok((number, result))
    };
    // A long job that begins last would run alone.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by(|&a, &b| works[b].total_cmp(&works[a]));
    let mut results = order.into_iter().par_bridge().map(one).collect::<Result<Vec<_>, E>>()?;
    results.sort_by_key(|(number, _)| *number);
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

#[cfg(test)]
#[path = "../../tests/unit/study_campaign.rs"]
mod tests;
