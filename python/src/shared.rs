//! Simulation shared by Python objects: the simulation, its views and the threads that step it.
//!
//! A step runs without the interpreter's lock, so that other threads may call the simulation meanwhile. Access requires the lock
//! in this module; waiting for this lock releases the interpreter's. The stepping thread admits others between two steps.

use crate::errors::exception;
use crate::scene::Scene;
use makadam::watch::Watchdog;
use makadam::{Interrupt, InterventionError, PairsInList, Simulation};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError, Weak};
use std::time::Duration;

/// Simulation with its lock and its views.
pub struct Shared {
    simulation: Mutex<Simulation>,
    /// Scene of the simulation, including the given settings.
    pub scene: Scene,
    /// Seed of the positions and radii.
    pub seed: u64,
    /// Interrupt of a step from another thread.
    pub interrupt: Interrupt,
    /// Watchdog of the steps, if enabled.
    pub watchdog: Mutex<Option<Watchdog>>,
    /// True while a thread is in `step`.
    stepping: AtomicBool,
    /// Number of threads that wait for the simulation.
    waiting: AtomicUsize,
    /// Number of live views of positions, velocities, spins, radii, masses and ids.
    pub state_views: AtomicUsize,
    /// Number of writable views.
    pub writable_views: AtomicUsize,
    /// True if a writable view was taken since the last step, even if it no longer exists.
    pub taken_to_write: AtomicBool,
    /// Arrays of the candidate list in views taken since the last step.
    pub pairs: Mutex<Weak<HeldPairs>>,
    /// Requested but not yet simulated time, s: the remainder of a run below a step.
    remainder: Mutex<f64>,
}

/// Arrays of a candidate list: owned by the simulation until a step would change them.
#[derive(Debug, Default)]
pub struct HeldPairs(Mutex<Option<PairsInList>>);

/// Sleep between two attempts to lock a simulation that is being stepped.
const NAP: Duration = Duration::from_micros(100);

impl Shared {
    pub fn new(simulation: Simulation, scene: Scene, seed: u64, watched: bool) -> Shared {
        Shared {
            interrupt: simulation.interrupt_handle(),
            watchdog: Mutex::new(watched.then(|| Watchdog::new(&scene.plan.watch, &simulation))),
            simulation: Mutex::new(simulation),
            scene,
            seed,
            stepping: AtomicBool::new(false),
            waiting: AtomicUsize::new(0),
            state_views: AtomicUsize::new(0),
            writable_views: AtomicUsize::new(0),
            taken_to_write: AtomicBool::new(false),
            pairs: Mutex::new(Weak::new()),
            remainder: Mutex::new(0.0),
        }
    }

    /// Sets the remainder of an earlier run below a step, s.
    pub fn with_remainder(self, remainder: f64) -> Shared {
        Shared { remainder: Mutex::new(remainder), ..self }
    }

    /// Requested but not yet simulated time, s.
    pub fn remainder(&self) -> f64 {
        *self.remainder.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Returns the number of whole steps of length `h` (s) that brings the simulation nearest to the sum of all durations, this one (s) included.
    pub fn steps_of(&self, duration: f64, h: f64) -> u64 {
        let mut remainder = self.remainder.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let asked = *remainder + duration;
        let steps = (asked / h).round_ties_even().max(0.0);
        *remainder = asked - steps * h;
        steps as u64
    }

    /// Runs a function on the simulation, once no other thread uses it.
    ///
    /// No Python code runs meanwhile, since the function has no access to the interpreter (`Send` ensures this). A handler of
    /// warnings or signals, or a finalizer, that calls the simulation would wait for its own thread.
    pub fn with<R>(&self, py: Python<'_>, work: impl FnOnce(&mut Simulation) -> R + Send) -> PyResult<R> {
        Ok(work(&mut *self.lock(py)?))
    }

    /// Locks the simulation, once no other thread uses it.
    fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Simulation>> {
        let mut asked = false;
        let locked = loop {
            match self.simulation.try_lock() {
                Ok(simulation) => break Ok(simulation),
                Err(TryLockError::Poisoned(_)) => {
                    break Err(exception(
                        py,
                        "Error",
                        "an earlier step of this simulation ended in a panic; it is worth nothing",
                    ));
                }
                Err(TryLockError::WouldBlock) => {
                    if !std::mem::replace(&mut asked, true) {
                        self.waiting.fetch_add(1, Ordering::SeqCst);
                    }
                    py.detach(|| std::thread::sleep(NAP));
                }
            }
        };
        if asked {
            self.waiting.fetch_sub(1, Ordering::SeqCst);
        }
        locked
    }

    /// Locks the simulation for a thread without the interpreter's lock.
    pub fn lock_detached(&self) -> MutexGuard<'_, Simulation> {
        self.simulation.lock().unwrap_or_else(|_| panic!("an earlier step of this simulation ended in a panic"))
    }

    /// Returns true if another thread waits for the simulation.
    pub fn is_awaited(&self) -> bool {
        self.waiting.load(Ordering::SeqCst) > 0
    }

    /// Admits waiting threads for a limited time.
    pub fn let_in(&self) {
        for _ in 0..50 {
            if !self.is_awaited() {
                return;
            }
            std::thread::sleep(NAP);
        }
    }

    /// Acquires the exclusive right to step.
    pub fn begin(&self, py: Python<'_>) -> PyResult<Steps<'_>> {
        match self.stepping.swap(true, Ordering::SeqCst) {
            false => Ok(Steps(self)),
            true => Err(exception(
                py,
                "BusyError",
                "this simulation is being stepped: by another thread, or because this was called from one of its callbacks",
            )),
        }
    }

    /// Inserts or removes grains, while no thread steps and no live view would change its rows.
    pub fn exchange<R>(
        &self,
        py: Python<'_>,
        what: &str,
        work: impl FnOnce(&mut Simulation) -> Result<R, InterventionError> + Send,
    ) -> PyResult<R> {
        let _right = self.begin(py)?;
        let done = self.with_settled(py, |simulation| match self.state_views.load(Ordering::SeqCst) {
            0 => {
                self.release_pairs(simulation);
                Ok(work(simulation))
            }
            views => Err(views),
        })?;
        match done {
            Ok(done) => done.map_err(|error| exception(py, "InterventionError", &error.to_string())),
            Err(views) => {
                let message = format!(
                    "cannot {what} grains while {views} views of this simulation's arrays live, also those within the expression that \
                     asks for it; delete them (also what was made of them without copying), or give copies, and take them anew afterwards"
                );
                Err(exception(py, "ViewError", &message))
            }
        }
    }

    /// Returns true if positions, velocities or spins may have been written since the last call.
    pub fn may_be_written(&self) -> bool {
        self.taken_to_write.swap(false, Ordering::SeqCst) || self.writable_views.load(Ordering::SeqCst) > 0
    }

    /// Runs a function on the simulation like [`with`](Shared::with), after all writes to views have been declared. Copies,
    /// checkpoints and access to exchanged data require this. The declaration is repeated before the next step.
    pub fn with_settled<R>(&self, py: Python<'_>, work: impl FnOnce(&mut Simulation) -> R + Send) -> PyResult<R> {
        self.with(py, |simulation| {
            if self.may_be_written() {
                self.taken_to_write.store(true, Ordering::SeqCst);
                simulation.states_written();
            }
            work(simulation)
        })
    }

    /// Hands the arrays of the candidate list over to their views, and continues with copies.
    pub fn release_pairs(&self, simulation: &mut Simulation) {
        let mut pairs = self.pairs.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(held) = std::mem::take(&mut *pairs).upgrade() {
            *held.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(simulation.hand_over_pairs());
        }
    }
}

/// Exclusive right to step a simulation.
pub struct Steps<'a>(&'a Shared);

impl Drop for Steps<'_> {
    fn drop(&mut self) {
        self.0.stepping.store(false, Ordering::SeqCst);
    }
}
