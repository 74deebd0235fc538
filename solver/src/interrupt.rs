//! Requests to stop a simulation within a step.
//!
//! A step with a long solve polls for stop requests between sweeps. On a request, the step is abandoned: positions are
//! unchanged; velocities, spins and dynamic walls are restored to their state at its start; impulses are those of the
//! last step. No contacts are laid out, as after a resume from a checkpoint. Later steps, also after a resume from a
//! checkpoint of this state, have the same bits as without the request.

use crate::scene::SolverSettings;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Request to stop, shared by the caller and the simulation. All clones share one request.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Creates an interrupt without a request.
    pub fn new() -> Interrupt {
        Interrupt::default()
    }

    /// Requests a stop; returns true if a stop was already requested.
    pub fn request(&self) -> bool {
        self.0.swap(true, Ordering::SeqCst)
    }

    /// Returns true if a stop is requested.
    #[inline]
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Clears the request, between steps.
    pub fn clear(&self) {
        self.0.store(false, Ordering::SeqCst);
    }
}

/// Largest number of sweeps of a solve without polls: short solves end soon, and need no stored state.
const UNASKED: u64 = 64;

/// Returns true if solves poll for an interrupt.
pub(crate) fn polls_interrupt(settings: &SolverSettings) -> bool {
    u64::from(settings.stop.max_sweeps()) * u64::from(settings.inner_sweeps.max(1)) > UNASKED
}
