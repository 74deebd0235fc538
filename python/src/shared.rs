//! A simulation that Python's objects share: itself, its views and the threads that step it.
//!
//! A step runs without the interpreter's lock, so that another thread may ask for something meanwhile. Whoever works on the simulation
//! takes the lock in here; whoever waits for it lets go of the interpreter's. The thread that steps lets others in between two steps.

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
    /// The scene that it is a simulation of, with the settings that it was given.
    pub scene: Scene,
    /// Seed of the positions and radii.
    pub seed: u64,
    /// Interrupt of a step from another thread.
    pub interrupt: Interrupt,
    /// Watches the steps, if that is wanted.
    pub watchdog: Mutex<Option<Watchdog>>,
    /// True while a thread is in `step`.
    stepping: AtomicBool,
    /// Threads that wait for the simulation.
    waiting: AtomicUsize,
    /// Views of positions, velocities, spins, radii, masses and ids that live.
    pub state_views: AtomicUsize,
    /// Number of writable views.
    pub writable_views: AtomicUsize,
    /// True if a writable view was taken since the last step, even if it no longer exists.
    pub taken_to_write: AtomicBool,
    /// The arrays of the candidate list that views taken since the last step show.
    pub pairs: Mutex<Weak<HeldPairs>>,
    /// Simulated time that was asked for and not yet taken, s: what a run leaves below a step.
    remainder: Mutex<f64>,
}

/// Arrays of a candidate list: the simulation's own, until a step would change them.
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

    /// Adds the remainder below a step that an earlier run has left, s.
    pub fn with_remainder(self, remainder: f64) -> Shared {
        Shared { remainder: Mutex::new(remainder), ..self }
    }

    /// Simulated time that was asked for and not yet taken, s.
    pub fn remainder(&self) -> f64 {
        *self.remainder.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Whole steps of length `h` (s) that bring the simulation nearest to where all durations so far would, this one (s) included.
    pub fn steps_of(&self, duration: f64, h: f64) -> u64 {
        let mut remainder = self.remainder.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let asked = *remainder + duration;
        let steps = (asked / h).round_ties_even().max(0.0);
        *remainder = asked - steps * h;
        steps as u64
    }

    /// Works on the simulation, once no other thread does.
    ///
    /// Nothing of Python runs meanwhile, since the work has no access to the interpreter (`Send` sees to that): a handler of warnings or
    /// signals, or a finalizer, that asks the simulation for anything would wait for the thread that it runs on.
    pub fn with<R>(&self, py: Python<'_>, work: impl FnOnce(&mut Simulation) -> R + Send) -> PyResult<R> {
        Ok(work(&mut *self.lock(py)?))
    }

    /// The simulation, once no other thread works on it.
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

    /// The simulation, for a thread that does not hold the interpreter's lock.
    pub fn lock_detached(&self) -> MutexGuard<'_, Simulation> {
        self.simulation.lock().unwrap_or_else(|_| panic!("an earlier step of this simulation ended in a panic"))
    }

    /// Returns true if another thread waits for the simulation.
    pub fn is_awaited(&self) -> bool {
        self.waiting.load(Ordering::SeqCst) > 0
    }

    /// Lets those in who wait, for a while.
    pub fn let_in(&self) {
        for _ in 0..50 {
            if !self.is_awaited() {
                return;
            }
            std::thread::sleep(NAP);
        }
    }

    /// Takes the right to step, which one thread has at a time.
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

    /// Has grains come or go, while no thread steps and no view lives whose rows would be others.
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

    /// Works on the simulation as [`with`](Shared::with) does, once it knows of all that was written to views so far: whoever copies it,
    /// saves it, or asks for what it has exchanged wants that. Before its next step it is told again.
    pub fn with_settled<R>(&self, py: Python<'_>, work: impl FnOnce(&mut Simulation) -> R + Send) -> PyResult<R> {
        self.with(py, |simulation| {
            if self.may_be_written() {
                self.taken_to_write.store(true, Ordering::SeqCst);
                simulation.states_written();
            }
            work(simulation)
        })
    }

    /// Gives the arrays of the candidate list to who looks at them, and has the simulation go on with copies.
    pub fn release_pairs(&self, simulation: &mut Simulation) {
        let mut pairs = self.pairs.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(held) = std::mem::take(&mut *pairs).upgrade() {
            *held.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(simulation.hand_over_pairs());
        }
    }
}

/// The right to step a simulation.
pub struct Steps<'a>(&'a Shared);

impl Drop for Steps<'_> {
    fn drop(&mut self) {
        self.0.stepping.store(false, Ordering::SeqCst);
    }
}
