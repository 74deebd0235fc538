//! The simulation as Python has it; what is nicer to say in Python is added in `makadam/simulation.py`.

use crate::convert::plain;
use crate::errors::{exception, setting_error, start_error};
use crate::frame::{Frame, check_frames, vectors};
use crate::kept::{keep, unkeep};
use crate::scene::Scene;
use crate::settings::{Whole, adapted, execution, seed_of};
use crate::shared::Shared;
use crate::stepping::{self, beside};
use crate::views::{self, Pairs, State};
use makadam::GrainEntry;
use makadam::wall::WallMotion;
use makadam_validation::observables::measure_frames;
use makadam_validation::plan;
use makadam_validation::prepared::start;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// What `makadam.Simulation` is made of.
#[pyclass(frozen, subclass, module = "makadam._core", name = "Simulation")]
pub struct Simulation(Arc<Shared>);

/// A grain to insert: material, radius (m), position (m), velocity (m/s), angular velocity (rad/s).
type GrainRow = (String, f64, [f64; 3], [f64; 3], [f64; 3]);

fn rows(py: Python<'_>, what: &str, array: &PyReadonlyArray2<'_, f64>, grains: usize) -> PyResult<Vec<[f64; 3]>> {
    let shape = array.shape();
    if shape != [grains, 3] {
        let message =
            format!("{what} have the shape ({}, {}); give ({grains}, 3), a row for each grain", shape[0], shape[1]);
        return Err(exception(py, "InterventionError", &message));
    }
    Ok(array.as_array().rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect())
}

impl Simulation {
    fn refused(py: Python<'_>, error: &makadam::InterventionError) -> PyErr {
        exception(py, "InterventionError", &error.to_string())
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, seed=None, *, threads=Whole::ONE, scheduler=None, instruction_set=None, time_step=None, precision=None, method=None, watch=true))]
    #[allow(clippy::too_many_arguments)] // They have names in Python.
    fn new(
        scene: &Bound<'_, PyAny>,
        seed: Option<Whole>,
        threads: Whole,
        scheduler: Option<&str>,
        instruction_set: Option<&str>,
        time_step: Option<f64>,
        precision: Option<&str>,
        method: Option<&str>,
        watch: bool,
    ) -> PyResult<Simulation> {
        let py = scene.py();
        // One that was resumed or copied is given its class of Python.
        if let Ok(simulation) = scene.cast::<Simulation>() {
            return Ok(Simulation(simulation.get().0.clone()));
        }
        let execution = execution(py, threads, scheduler, instruction_set)?;
        let scene = adapted(py, scene, time_step, precision, method)?;
        let seed = seed_of(py, seed)?.unwrap_or(scene.plan.seed);
        // A scene that prepares a flowing state takes its time to start.
        let begun = beside(py, || start(&scene.plan, seed, &scene.file, &execution, &|_| {}))?;
        let (simulation, _) = begun.map_err(|error| start_error(py, &error, scene.origin()))?;
        Ok(Simulation(Arc::new(Shared::new(simulation, scene, seed, watch))))
    }

    #[staticmethod]
    #[pyo3(signature = (class, scene, checkpoint, seed=None, threads=Whole::ONE, scheduler=None, instruction_set=None, time_step=None, precision=None, method=None, watch=true))]
    #[allow(clippy::too_many_arguments)] // They have names in Python.
    fn _resume<'py>(
        class: &Bound<'py, PyAny>,
        scene: &Bound<'py, PyAny>,
        checkpoint: &[u8],
        seed: Option<Whole>,
        threads: Whole,
        scheduler: Option<&str>,
        instruction_set: Option<&str>,
        time_step: Option<f64>,
        precision: Option<&str>,
        method: Option<&str>,
        watch: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = scene.py();
        let execution = execution(py, threads, scheduler, instruction_set)?;
        let scene = adapted(py, scene, time_step, precision, method)?;
        let seed = seed_of(py, seed)?;
        let (checkpoint, seed) = unkeep(py, &scene, seed, checkpoint)?;
        let mut simulation = py
            .detach(|| makadam::Simulation::resume(&scene.plan, checkpoint))
            .map_err(|error| exception(py, "CheckpointError", &error.to_string()))?;
        execution.apply(&mut simulation).map_err(|error| setting_error(py, &error))?;
        let shared = Shared::new(simulation, scene, seed, watch);
        class.call1((Bound::new(py, Simulation(Arc::new(shared)))?,))
    }

    /// Another simulation with the same state, which goes its own way.
    fn _copy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Simulation>> {
        let mut copy = self.0.lock(py)?.clone();
        copy.heed(makadam::Interrupt::new());
        let watched = self.0.watchdog.lock().is_ok_and(|watchdog| watchdog.is_some());
        Bound::new(py, Simulation(Arc::new(Shared::new(copy, self.0.scene.clone(), self.0.seed, watched))))
    }

    /// The scene, with the settings that were given in place of its own.
    #[getter]
    fn scene(&self) -> Scene {
        self.0.scene.clone()
    }

    /// Seed of the positions and radii at the start.
    #[getter]
    fn seed(&self) -> u64 {
        self.0.seed
    }

    /// Simulated time, s.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.0.lock(py)?.time())
    }

    /// Time step, s.
    #[getter]
    fn time_step(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.0.lock(py)?.time_step())
    }

    /// Steps taken.
    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.0.lock(py)?.steps_taken())
    }

    /// Contacts of the last step.
    #[getter]
    fn contact_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.0.lock(py)?.layout().contacts)
    }

    /// Number of times that the candidate list was built, and the rows of the arrays sorted anew.
    #[getter]
    fn rebuilds(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.0.lock(py)?.rebuilds())
    }

    /// Hash of the state (time, positions, velocities, spins, driven walls) as 16 hexadecimal digits: what `makadam run --json` prints.
    #[getter]
    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("{:016x}", self.0.lock(py)?.state_hash()))
    }

    /// Number of grains.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.0.lock(py)?.grains())
    }

    /// Mechanical energy, J: a dict of `kinetic`, `potential` (zero at the origin), `elastic` and `cohesive`.
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.lock(py)?.energy())
    }

    /// Momentum of the grains, kg m/s.
    fn momentum(&self, py: Python<'_>) -> PyResult<(f64, f64, f64)> {
        Ok(self.0.lock(py)?.momentum().into())
    }

    /// Wall time of each phase of the steps so far, s.
    fn phase_seconds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.lock(py)?.phase_seconds())
    }

    /// Keeps a ledger of energy, momentum and angular momentum from here on.
    fn open_ledger(&self, py: Python<'_>) -> PyResult<()> {
        self.0.lock(py)?.open_ledger();
        Ok(())
    }

    /// The ledger since it was opened, a dict (J, kg m/s and kg m2/s); None if it was not.
    fn balance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let balance = self.0.lock(py)?.balance();
        balance
            .map(|balance| {
                let dict = plain(py, &balance)?;
                // The document leaves out what nobody did.
                dict.call_method1("setdefault", ("outside", balance.outside))?;
                dict.call_method1("setdefault", ("outside_impulse", balance.outside_impulse.to_vec()))?;
                dict.call_method1("setdefault", ("outside_angular_impulse", balance.outside_angular_impulse.to_vec()))?;
                Ok(dict)
            })
            .transpose()
    }

    /// Asks the thread that steps this simulation to stop: it raises `makadam.Interrupted`. Without one, the next call of `step` does.
    fn interrupt(&self) {
        self.0.interrupt.request();
    }

    fn _step(&self, py: Python<'_>, steps: i64) -> PyResult<Vec<String>> {
        stepping::steps(py, &self.0, stepping::count(py, steps)?)
    }

    /// Has the watchdog look at the state, whether it is time to or not.
    fn _look(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        stepping::look(py, &self.0)
    }

    /// The state as a checkpoint: see `makadam.Simulation.resume`.
    fn checkpoint<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.0.lock(py)?.checkpoint();
        Ok(PyBytes::new(py, &keep(&self.0.scene, self.0.seed, &bytes)))
    }

    /// A copy of the grains by id, with the contacts of the last step.
    fn frame(&self, py: Python<'_>) -> PyResult<Frame> {
        Ok(Frame::of(self.0.lock(py)?.snapshot()))
    }

    #[getter]
    fn _positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::Positions)
    }

    #[getter]
    fn _velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::Velocities)
    }

    #[getter]
    fn _scaled_spins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::ScaledSpins)
    }

    /// View of the radii, m: (n,), row by row as the grains lie in memory; it cannot be written.
    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::Radii)
    }

    /// View of one over the masses, 1/kg: (n,), row by row as the grains lie in memory; it cannot be written.
    #[getter]
    fn inverse_masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::InverseMasses)
    }

    /// View of the ids, (n,) of uint32: which grain is in each row of the other views; it cannot be written.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::Ids)
    }

    /// Views that other code lives by: how many of them there are.
    #[getter]
    fn live_views(&self) -> usize {
        self.0.state_views.load(Ordering::SeqCst)
    }

    /// Pairs of grains that may touch, (m, 2) of uint32: rows of the views of grains. A view that cannot be written; the next step leaves it
    /// as it is.
    #[getter]
    fn pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::Grains)
    }

    /// What `pairs` bore in the last step, (m, 4), N s: the normal impulse, and the tangential impulse on the second grain; zero where two did
    /// not touch. A view that cannot be written; the next step leaves it as it is.
    #[getter]
    fn pair_impulses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::GrainImpulses)
    }

    /// Grains and faces of walls that may touch, (k, 2) of uint32: the row of the grain, and the number of the face, wall after wall. A view
    /// that cannot be written; the next step leaves it as it is.
    #[getter]
    fn wall_pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::Walls)
    }

    /// What `wall_pairs` bore in the last step, (k, 4), N s, the tangential impulse on the wall: as `pair_impulses`.
    #[getter]
    fn wall_impulses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::WallImpulses)
    }

    /// Angular velocities, rad/s: (n, 3), a copy, row by row as the grains lie in memory.
    fn _spins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut simulation = self.0.lock(py)?;
        let (spheres, bodies, _) = simulation.arrays();
        let spins = spheres.iter().zip(&*bodies).map(|(sphere, body)| body.scaled_spin.map(|one| one / sphere.radius));
        Ok(vectors(py, spins).into_any())
    }

    /// Forces (N) and torques (N m) of the next step, row by row as the grains lie in memory.
    #[pyo3(signature = (forces=None, torques=None))]
    fn _apply(
        &self,
        py: Python<'_>,
        forces: Option<PyReadonlyArray2<'_, f64>>,
        torques: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<()> {
        let mut simulation = self.0.lock(py)?;
        let ids: Vec<u32> = simulation.arrays().2.to_vec();
        let by_id = |what: &str, array: Option<PyReadonlyArray2<'_, f64>>| -> PyResult<Vec<[f64; 3]>> {
            let Some(array) = array else { return Ok(Vec::new()) };
            let mut list = vec![[0.0; 3]; ids.len()];
            for (row, &id) in rows(py, what, &array, ids.len())?.into_iter().zip(&ids) {
                list[id as usize] = row;
            }
            Ok(list)
        };
        let (forces, torques) = (by_id("forces", forces)?, by_id("torques", torques)?);
        simulation.apply_forces(&forces).map_err(|error| Simulation::refused(py, &error))?;
        simulation.apply_torques(&torques).map_err(|error| Simulation::refused(py, &error))
    }

    /// Moves a wall along (velocity, m/s) or about an axis (rate, rad/s).
    #[pyo3(signature = (wall, velocity=None, rate=None, about=None))]
    fn _move_wall(
        &self,
        py: Python<'_>,
        wall: u32,
        velocity: Option<[f64; 3]>,
        rate: Option<f64>,
        about: Option<([f64; 3], [f64; 3])>,
    ) -> PyResult<()> {
        let motion = match (velocity, rate) {
            (Some(velocity), None) => WallMotion::Translation { velocity },
            (None, Some(rate)) => WallMotion::Rotation { rate, about },
            _ => return Err(exception(py, "InterventionError", "give a wall either a velocity or a rate")),
        };
        self.0.lock(py)?.move_wall(wall, motion).map_err(|error| Simulation::refused(py, &error))
    }

    /// How far a wall that was moved has moved along (m) and turned (rad); None for others.
    fn _moved_by(&self, py: Python<'_>, wall: u32) -> PyResult<Option<([f64; 3], f64)>> {
        Ok(self.0.lock(py)?.moved_by(wall))
    }

    /// Inserts grains; returns the ids of the first and of the one behind the last.
    fn _insert(&self, py: Python<'_>, grains: Vec<GrainRow>) -> PyResult<(u32, u32)> {
        let entry =
            |(material, radius, position, velocity, spin)| GrainEntry { material, radius, position, velocity, spin };
        let grains: Vec<GrainEntry> = grains.into_iter().map(entry).collect();
        let _right = self.0.begin(py)?;
        let mut simulation = self.0.lock(py)?;
        self.0.refuse_views(py, "insert")?;
        self.0.release_pairs(&mut simulation);
        let ids = simulation.insert(&self.0.scene.plan, &grains).map_err(|error| Simulation::refused(py, &error))?;
        Ok((ids.start, ids.end))
    }

    /// Removes grains by id; returns the new id of each old one, -1 for those that are gone.
    fn _remove(&self, py: Python<'_>, ids: Vec<u32>) -> PyResult<Vec<i64>> {
        let _right = self.0.begin(py)?;
        let mut simulation = self.0.lock(py)?;
        self.0.refuse_views(py, "remove")?;
        self.0.release_pairs(&mut simulation);
        let new_ids = simulation.remove(&ids).map_err(|error| Simulation::refused(py, &error))?;
        Ok(new_ids.into_iter().map(|id| id.map_or(-1, i64::from)).collect())
    }

    /// The grains as a scene would list them now.
    fn grains<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let entries = self.0.lock(py)?.grain_entries(&self.0.scene.plan);
        plain(py, &entries)
    }

    /// What the judge measures of frames of this simulation.
    fn _measure<'py>(&self, py: Python<'py>, frames: Vec<PyRef<'py, Frame>>) -> PyResult<Bound<'py, PyAny>> {
        let plan = self.measured_plan(py, &frames)?;
        let snapshots: Vec<_> = frames.iter().map(|frame| frame.0.clone()).collect();
        let measured = py.detach(|| {
            let frames: Vec<_> = snapshots.iter().map(|snapshot| &**snapshot).collect();
            let Ok(measured) = measure_frames(&plan, &frames[..]);
            measured
        });
        plain(py, &measured.unwrap_or_default())
    }
}

impl Simulation {
    /// The scene as the judge has to see it: with the grains that there are now, and walls that stand where it thinks.
    fn measured_plan(&self, py: Python<'_>, frames: &[PyRef<'_, Frame>]) -> PyResult<plan::Scene> {
        let simulation = self.0.lock(py)?;
        let mut plan = self.0.scene.plan.clone();
        for (number, wall) in plan.wall.iter().enumerate() {
            // A wall that turns is measured as it stands only where turning leaves it in place, which the scene then says.
            let moved = simulation.moved_by(number as u32).is_some_and(|(shift, angle)| {
                shift != [0.0; 3] || (angle != 0.0 && !matches!(wall.motion, makadam::Motion::Rotating { .. }))
            });
            if moved {
                let message = format!(
                    "wall '{}' was moved by the caller, and observables take walls where the scene has them; describe its motion in the \
                     scene to measure, or compute from `frame()`",
                    wall.name
                );
                return Err(exception(py, "JudgeError", &message));
            }
        }
        if simulation.has_other_grains() {
            if let Some(frame) = frames.iter().find(|frame| frame.0.particles.len() != simulation.grains())
                && plan.material.len() > 1
            {
                let message = format!(
                    "the frame at {} s has {} grains and the simulation has {}: which materials they were of is not known; measure \
                     frames before grains come or go",
                    frame.0.time,
                    frame.0.particles.len(),
                    simulation.grains()
                );
                return Err(exception(py, "JudgeError", &message));
            }
            plan.grain = simulation.grain_entries(&plan);
            plan.population.clear();
        } else {
            check_frames(py, &self.0.scene, frames)?;
        }
        Ok(plan)
    }
}
