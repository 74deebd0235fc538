//! Asking a simulation to stop inside a step.
//!
//! A step whose solve may be long looks between sweeps whether it was asked to stop. If so it is abandoned: nothing has moved,
//! velocities, spins and driven walls get back what they had when it began, impulses are those that the last step left, and no
//! contacts are laid out, as in a simulation that was resumed from a checkpoint. Later steps, and steps of what is resumed from a
//! checkpoint of that state, have the bits that they would have had.

use crate::scene::SolverSettings;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request to stop, shared by who asks and who is asked. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<Request>);

#[derive(Debug, Default)]
struct Request {
    made: AtomicBool,
}

impl Interrupt {
    /// One that was not asked for yet.
    pub fn new() -> Interrupt {
        Interrupt::default()
    }

    /// Asks for a stop; whether it had been asked for before.
    pub fn request(&self) -> bool {
        self.0.made.swap(true, Ordering::SeqCst)
    }

    /// Returns true if a stop was asked for.
    #[inline]
    pub fn is_requested(&self) -> bool {
        self.0.made.load(Ordering::Relaxed)
    }

    /// Takes the request back, between steps.
    pub fn clear(&self) {
        self.0.made.store(false, Ordering::SeqCst);
    }
}

/// Sweeps that a solve may take unasked: so few are over soon, and need nothing kept to go back to.
const UNASKED: u64 = 64;

/// Returns true if solves look for an interrupt.
pub(crate) fn polls_interrupt(settings: &SolverSettings) -> bool {
    u64::from(settings.stop.max_sweeps()) * u64::from(settings.inner_sweeps.max(1)) > UNASKED
}
