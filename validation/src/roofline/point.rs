//! A scene's sweep: how fast it is, how much arithmetic and how many bytes.

use super::machine::Roofs;
use crate::execution::Execution;
use crate::execution::MeasureError;
use crate::statistics::median;
use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::partition::TaskGroups;
use makadam::schedule::Scheduler;
use makadam::sweep::{Operations, SweepBytes};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Batches of sweeps; their median counts.
const BATCHES: usize = 15;
/// What a batch lasts at least, s.
const BATCH: f64 = 0.03;

/// The code that relaxes contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kernel {
    /// One contact at a time.
    Scalar,
    /// Eight at a time, on the run's instruction set.
    Lanes,
}

/// A measured sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Scene.
    pub scene: String,
    /// Number of grains.
    pub particles: usize,
    /// Number of contacts.
    pub contacts: usize,
    /// Kernel.
    pub kernel: Kernel,
    /// Number of threads.
    pub threads: usize,
    /// Contacts relaxed a second: the measurement.
    pub contact_sweeps_per_second: f64,
    /// The same as time, ns.
    pub nanoseconds_per_contact_sweep: f64,
    /// Operations of a contact sweep, pairs and walls as they are mixed here.
    pub flops_per_contact_sweep: f64,
    /// Bytes of a contact sweep: lane groups read, impulses written back, each grain read and written once a sweep.
    pub bytes_per_contact_sweep: f64,
    /// Lane groups and bodies, bytes.
    pub working_set_bytes: usize,
    /// The cache that holds them, or the memory.
    pub home: String,
    /// Operations a byte.
    pub flops_per_byte: f64,
    /// Operations a second.
    pub flops_per_second: f64,
    /// Bytes a second.
    pub bytes_per_second: f64,
    /// What the roofs allow, operations a second.
    pub roof_flops_per_second: f64,
    /// Share of it that is reached, 0 to 1.
    pub share_of_roof: f64,
}

/// Arithmetic and bytes of one sweep over all contacts.
struct Work {
    flops: f64,
    bytes: f64,
    working_set: usize,
}

impl Point {
    /// Measures the sweep of a state whose contacts are laid out.
    ///
    /// # Errors
    /// [`MeasureError`] if the system gives no threads.
    pub fn measure(
        scene: &str,
        state: &Simulation,
        kernel: Kernel,
        set: InstructionSet,
        roofs: &Roofs,
    ) -> Result<Point, MeasureError> {
        let mut simulation = state.clone();
        let scheduler = if roofs.threads > 1 { Scheduler::WorkStealing } else { Scheduler::Serial };
        Execution { scheduler, threads: roofs.threads, instruction_set: set, ..Execution::serial() }
            .apply(&mut simulation)?;
        simulation.use_scalar_sweeps(kernel == Kernel::Scalar);
        let rate = contact_sweeps_per_second(&mut simulation);
        let (particles, contacts) = (state.snapshot().particles.len(), state.layout().contacts);
        let work = Work::of(state);
        let (flops, bytes) = (work.flops / contacts as f64, work.bytes / contacts as f64);
        let home = roofs.home_of(work.working_set);
        let slope = home.map_or(f64::NAN, |level| level.bytes_per_second);
        let roof = roofs.peak_flops_per_second.min(slope * flops / bytes);
        Ok(Point {
            scene: scene.into(),
            particles,
            contacts,
            kernel,
            threads: roofs.threads,
            contact_sweeps_per_second: rate,
            nanoseconds_per_contact_sweep: 1e9 / rate,
            flops_per_contact_sweep: flops,
            bytes_per_contact_sweep: bytes,
            working_set_bytes: work.working_set,
            home: home.map_or(String::new(), |level| level.name.clone()),
            flops_per_byte: flops / bytes,
            flops_per_second: rate * flops,
            bytes_per_second: rate * bytes,
            roof_flops_per_second: roof,
            share_of_roof: rate * flops / roof,
        })
    }
}

impl Work {
    /// Padding lanes move bytes and do nothing.
    fn of(state: &Simulation) -> Work {
        let (pair, wall) = (f64::from(Operations::of_pair().total()), f64::from(Operations::of_wall().total()));
        let SweepBytes { touched, moved } = state.sweep_bytes();
        let mut work = Work { flops: 0.0, bytes: moved as f64, working_set: touched };
        for (_, TaskGroups { pair_sources, wall_sources, .. }) in state.layout().tasks() {
            let filled = |sources: &[makadam::groups::Sources]| {
                sources.iter().map(|group| group.occupied().count()).sum::<usize>() as f64
            };
            work.flops += pair * filled(pair_sources) + wall * filled(wall_sources);
        }
        work
    }
}

fn contact_sweeps_per_second(simulation: &mut Simulation) -> f64 {
    let mut batch = |sweeps: u32| {
        let clock = Instant::now();
        let done = simulation.sweep_times(sweeps) as f64;
        (done, clock.elapsed().as_secs_f64())
    };
    batch(2);
    let (_, seconds) = batch(4);
    let sweeps = (4.0 * BATCH / seconds).ceil().max(4.0) as u32;
    median((0..BATCHES).map(|_| {
        let (done, seconds) = batch(sweeps);
        done / seconds
    }))
}
