//! Python interface of the simulation; `makadam/simulation.py` adds the parts written in Python.

use crate::convert::plain;
use crate::errors::{exception, setting_error, start_error};
use crate::frame::{Frame, scene_of_frames, snapshots, vectors};
use crate::kept::{Kept, keep, unkeep};
use crate::pictures::{Frames, PageRequest, PictureRequest};
use crate::scene::Scene;
use crate::settings::{Real, Whole, adapted, execution, seed_of};
use crate::shared::Shared;
use crate::stepping::{self, beside};
use crate::views::{self, Pairs, State};
use makadam::wall::WallMotion;
use makadam::{GrainEntry, InterventionError};
use makadam_compare::prepared::start;
use makadam_measure::observables::measure_frames;
use numpy::{PyArray3, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Implementation of `makadam.Simulation`.
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

fn refused(py: Python<'_>, error: &InterventionError) -> PyErr {
    exception(py, "InterventionError", &error.to_string())
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
        time_step: Option<Real>,
        precision: Option<&str>,
        method: Option<&str>,
        watch: bool,
    ) -> PyResult<Simulation> {
        let py = scene.py();
        // A resumed or copied simulation is converted to its Python class.
        if let Ok(simulation) = scene.cast::<Simulation>() {
            return Ok(Simulation(simulation.get().0.clone()));
        }
        let execution = execution(py, threads, scheduler, instruction_set)?;
        let scene = adapted(py, scene, time_step, precision, method)?;
        let seed = seed_of(py, seed)?.unwrap_or(scene.plan.seed);
        // A scene with a prepared flowing state takes time to start.
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
        time_step: Option<Real>,
        precision: Option<&str>,
        method: Option<&str>,
        watch: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = scene.py();
        let execution = execution(py, threads, scheduler, instruction_set)?;
        let scene = adapted(py, scene, time_step, precision, method)?;
        let seed = seed_of(py, seed)?;
        let Kept { simulation: checkpoint, seed, remainder } = unkeep(py, &scene, seed, checkpoint)?;
        let mut simulation = py
            .detach(|| makadam::Simulation::resume(&scene.plan, checkpoint))
            .map_err(|error| exception(py, "CheckpointError", &error.to_string()))?;
        execution.apply(&mut simulation).map_err(|error| setting_error(py, &error))?;
        let shared = Shared::new(simulation, scene, seed, watch).with_remainder(remainder);
        class.call1((Bound::new(py, Simulation(Arc::new(shared)))?,))
    }

    /// Returns an independent copy with the same state.
    fn _copy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Simulation>> {
        let mut copy = self.0.with_settled(py, |simulation| simulation.clone())?;
        copy.set_interrupt(makadam::Interrupt::new());
        let watched = self.0.watchdog.lock().is_ok_and(|watchdog| watchdog.is_some());
        let shared = Shared::new(copy, self.0.scene.clone(), self.0.seed, watched);
        // Unchecked writes to this simulation are checked by the copy's first step.
        shared.taken_to_write.store(self.0.taken_to_write.load(Ordering::SeqCst), Ordering::SeqCst);
        Bound::new(py, Simulation(Arc::new(shared.with_remainder(self.0.remainder()))))
    }

    /// The scene, including the settings given by the caller.
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
        self.0.with(py, |simulation| simulation.time())
    }

    /// Time step, s.
    #[getter]
    fn time_step(&self, py: Python<'_>) -> PyResult<f64> {
        self.0.with(py, |simulation| simulation.time_step())
    }

    /// Number of steps taken.
    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.0.with(py, |simulation| simulation.steps_taken())
    }

    /// Number of contacts of the last step.
    #[getter]
    fn contact_count(&self, py: Python<'_>) -> PyResult<usize> {
        self.0.with(py, |simulation| simulation.layout().contacts)
    }

    /// Number of times that the candidate list was built and the rows of the arrays were sorted.
    #[getter]
    fn rebuilds(&self, py: Python<'_>) -> PyResult<u64> {
        self.0.with(py, |simulation| simulation.rebuilds())
    }

    /// Hash of the state (time, positions, velocities, spins, dynamic walls) as 16 hexadecimal digits, as printed by `makadam run --json`.
    #[getter]
    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        self.0.with(py, |simulation| format!("{:016x}", simulation.state_hash()))
    }

    /// Number of grains.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.0.with(py, |simulation| simulation.grains())
    }

    /// Mechanical energy, J: a dict of `kinetic`, `potential` (zero at the origin), `elastic` and `cohesive`.
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.with(py, |simulation| simulation.energy())?)
    }

    /// Momentum of the grains, kg m/s.
    fn momentum(&self, py: Python<'_>) -> PyResult<(f64, f64, f64)> {
        self.0.with(py, |simulation| simulation.momentum().into())
    }

    /// Wall time of each phase of the steps so far, s.
    fn phase_seconds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.with(py, |simulation| simulation.phase_seconds())?)
    }

    /// Opens a ledger of energy, momentum and angular momentum.
    fn open_ledger(&self, py: Python<'_>) -> PyResult<()> {
        self.0.with(py, makadam::Simulation::open_ledger)
    }

    /// The ledger since it was opened, a dict (J, kg m/s and kg m2/s); None without a ledger.
    fn balance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let balance = self.0.with_settled(py, |simulation| simulation.balance())?;
        balance
            .map(|balance| {
                let dict = plain(py, &balance)?;
                // Serialization omits external entries without actions of the caller.
                dict.call_method1("setdefault", ("outside", balance.outside))?;
                dict.call_method1("setdefault", ("outside_impulse", balance.outside_impulse.to_vec()))?;
                dict.call_method1("setdefault", ("outside_angular_impulse", balance.outside_angular_impulse.to_vec()))?;
                dict.call_method1("setdefault", ("inflow", balance.inflow))?;
                dict.call_method1("setdefault", ("outflow", balance.outflow))?;
                Ok(dict)
            })
            .transpose()
    }

    /// The grains that have come from the sources and gone into the sinks of the scene, a dict of `inserted` and `removed` (a dict of
    /// `grains` and `mass`, kg, for each), `lags` of the sources, s, and `usual_lag`, s; None for a scene without any.
    fn flow<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.with(py, |simulation| simulation.flow())?)
    }

    /// Name of the stage of the last step; None for a scene without stages.
    #[getter]
    fn stage(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.0.with(py, |simulation| simulation.stages().pop().map(|stage| stage.name))
    }

    /// True once the last stage of the scene has ended.
    #[getter]
    fn ended(&self, py: Python<'_>) -> PyResult<bool> {
        self.0.with(py, |simulation| simulation.has_ended())
    }

    /// The stages that have begun, a list of dicts of `name`, `start` and `end` (s), `steps` and `ended`.
    fn stages<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.with(py, |simulation| simulation.stages())?)
    }

    /// Requests a stop of the stepping thread, which raises `makadam.Interrupted`. Without such a thread, the next call of `step` raises.
    fn interrupt(&self) {
        self.0.interrupt.request();
    }

    /// Clears a stop request, once the end of the steps has answered the request.
    fn _forget_interrupt(&self) {
        self.0.interrupt.clear();
    }

    /// Returns the number of whole steps that brings the simulation nearest to the sum of all requested durations (s), this one included.
    fn _steps_of(&self, py: Python<'_>, duration: f64) -> PyResult<u64> {
        let h = self.0.with(py, |simulation| simulation.time_step())?;
        Ok(self.0.steps_of(duration, h))
    }

    fn _step(&self, py: Python<'_>, steps: i64) -> PyResult<Vec<String>> {
        stepping::steps(py, &self.0, stepping::count(py, steps)?)
    }

    /// Runs the watchdog check on the present state, independent of its interval.
    fn _look(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        stepping::look(py, &self.0)
    }

    /// Returns the state as a checkpoint: see `makadam.Simulation.resume`.
    fn checkpoint<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.0.with_settled(py, |simulation| simulation.checkpoint())?;
        Ok(PyBytes::new(py, &keep(&self.0.scene, self.0.seed, self.0.remainder(), &bytes)))
    }

    /// Returns a copy of the grains by id, with the contacts of the last step.
    fn frame(&self, py: Python<'_>) -> PyResult<Frame> {
        self.0.with(py, |simulation| Frame::of(simulation.snapshot()))
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

    /// Read-only view of the radii, m: (n,), rows in memory order.
    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::Radii)
    }

    /// Read-only view of the inverse masses, 1/kg: (n,), rows in memory order.
    #[getter]
    fn inverse_masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::InverseMasses)
    }

    /// Read-only view of the ids, (n,) of uint32: id of the grain in each row of the other views.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::state(py, &self.0, State::Ids)
    }

    /// Number of live views of the state.
    #[getter]
    fn live_views(&self) -> usize {
        self.0.state_views.load(Ordering::SeqCst)
    }

    /// Candidate pairs of grains, (m, 2) of uint32: rows of the views of grains. A read-only view that the next step leaves
    /// unchanged.
    #[getter]
    fn pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::Grains)
    }

    /// Impulses of `pairs` in the last step, (m, 4), N s: the normal impulse, and the tangential impulse on the second grain; zero without
    /// contact. A read-only view that the next step leaves unchanged.
    #[getter]
    fn pair_impulses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::GrainImpulses)
    }

    /// Candidate grains and faces of walls, (k, 2) of uint32: the row of the grain, and the number of the face, wall after wall.
    /// A read-only view that the next step leaves unchanged.
    #[getter]
    fn wall_pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::Walls)
    }

    /// Impulses of `wall_pairs` in the last step, (k, 4), N s, with the tangential impulse on the wall: see `pair_impulses`.
    #[getter]
    fn wall_impulses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        views::pairs(py, &self.0, Pairs::WallImpulses)
    }

    /// Returns a copy of the angular velocities, rad/s: (n, 3), rows in memory order.
    fn _spins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let spins: Vec<[f64; 3]> = self.0.with(py, |simulation| {
            let (spheres, bodies, _) = simulation.arrays();
            let each = spheres.iter().zip(&*bodies);
            each.map(|(sphere, body)| body.scaled_spin.map(|one| one / sphere.radius)).collect()
        })?;
        Ok(vectors(py, spins.into_iter()).into_any())
    }

    /// Sets forces (N) and torques (N m) of the next step, rows in memory order; replaces the applied ones or adds to them.
    #[pyo3(signature = (forces=None, torques=None, on_top=false))]
    fn _apply(
        &self,
        py: Python<'_>,
        forces: Option<PyReadonlyArray2<'_, f64>>,
        torques: Option<PyReadonlyArray2<'_, f64>>,
        on_top: bool,
    ) -> PyResult<()> {
        let ids: Vec<u32> = self.0.with(py, |simulation| simulation.arrays().2.to_vec())?;
        let by_id = |what: &str, array: Option<PyReadonlyArray2<'_, f64>>| -> PyResult<Vec<[f64; 3]>> {
            let Some(array) = array else { return Ok(Vec::new()) };
            let mut list = vec![[0.0; 3]; ids.len()];
            for (row, &id) in rows(py, what, &array, ids.len())?.into_iter().zip(&ids) {
                list[id as usize] = row;
            }
            Ok(list)
        };
        let (forces, torques) = (by_id("forces", forces)?, by_id("torques", torques)?);
        let given = self.0.with(py, |simulation| match on_top {
            true => simulation.add_loads(&forces, &torques),
            false => simulation.apply_loads(&forces, &torques),
        })?;
        given.map_err(|error| refused(py, &error))
    }

    /// Moves a wall along a direction (velocity, m/s) or about an axis (rate, rad/s).
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
        self.0.with(py, |simulation| simulation.move_wall(wall, motion))?.map_err(|error| refused(py, &error))
    }

    /// Returns the displacement (m) and rotation (rad) of a wall moved by the caller; None for others.
    fn _moved_by(&self, py: Python<'_>, wall: u32) -> PyResult<Option<([f64; 3], f64)>> {
        self.0.with(py, |simulation| simulation.moved_by(wall))
    }

    /// Returns the displacement (m) and rotation (rad) of a wall from its pose in the scene.
    fn _displacement(&self, py: Python<'_>, wall: u32) -> PyResult<([f64; 3], f64)> {
        self.0.with(py, |simulation| simulation.wall_displacement(wall))?.map_err(|error| refused(py, &error))
    }

    /// Inserts grains; returns their range of ids as the first id and the end.
    fn _insert(&self, py: Python<'_>, grains: Vec<GrainRow>) -> PyResult<(u32, u32)> {
        let entry =
            |(material, radius, position, velocity, spin)| GrainEntry { material, radius, position, velocity, spin };
        let grains: Vec<GrainEntry> = grains.into_iter().map(entry).collect();
        let ids = self.0.exchange(py, "insert", |simulation| simulation.insert(&self.0.scene.plan, &grains))?;
        Ok((ids.start, ids.end))
    }

    /// Removes grains by id; returns the new id of each old id, -1 for removed grains.
    fn _remove(&self, py: Python<'_>, ids: Vec<u32>) -> PyResult<Vec<i64>> {
        let new_ids = self.0.exchange(py, "remove", |simulation| simulation.remove(&ids))?;
        Ok(new_ids.into_iter().map(|id| id.map_or(-1, i64::from)).collect())
    }

    /// Returns the present grains as scene entries.
    fn grains<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.with(py, |simulation| simulation.grain_entries(&self.0.scene.plan))?)
    }

    /// Measures frames of this simulation.
    fn _measure<'py>(&self, py: Python<'py>, frames: Vec<PyRef<'py, Frame>>) -> PyResult<Bound<'py, PyAny>> {
        let snapshots = snapshots(&frames);
        let purpose = "describe its motion in the scene to measure, or compute from `frame()`";
        let plan = scene_of_frames(py, &self.0, &snapshots, true, purpose)?;
        let measured = py.detach(|| {
            let frames: Vec<_> = snapshots.iter().map(|snapshot| &**snapshot).collect();
            let Ok(measured) = measure_frames(&plan, &frames[..]);
            measured
        });
        plain(py, &measured.unwrap_or_default().measurements)
    }

    /// Writes frames, or the present state, into a folder like `makadam run`: for ParaView, and for `makadam view`, `animate`,
    /// `export` and `measure`.
    ///
    /// Args:
    ///     folder: The folder, which must not contain frames yet.
    ///     frames: Frames of this simulation in the order of time; defaults to the present state.
    ///     walls: Writes the walls if True; must be False if the caller has moved walls.
    ///
    /// Raises:
    ///     makadam.JudgeError: The folder contains frames, or cannot be written.
    #[pyo3(signature = (folder, frames=None, *, walls=true))]
    fn save_frames(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        frames: Option<Vec<PyRef<'_, Frame>>>,
        walls: bool,
    ) -> PyResult<()> {
        self.frames(py, frames, walls)?.save(py, folder, walls)
    }

    /// Draws the present state, or a frame, without a screen.
    ///
    /// Args:
    ///     file: PNG file to write; no file by default.
    ///     frame: A frame of this simulation; defaults to the present state.
    ///     field: Field for the colour of grains, such as speed, pressure, force, coordination_number, diameter, material;
    ///         defaults to speed, or to pressure if all grains are at rest.
    ///     range: Values at the ends of the colour scale, in the field's unit.
    ///     view: Direction of view: natural, front, side, top, or "AZIMUTH,ELEVATION" in degrees.
    ///     clip: Plane that hides everything in front, such as "y=0.02" (m).
    ///     walls: Draws the walls if True; must be False if the caller has moved walls.
    ///     all_grains: Shows grains far from the walls, too.
    ///     size: Width and height, pixels.
    ///
    /// Returns:
    ///     The pixels, red, green and blue: (height, width, 3) of uint8, as accepted by `matplotlib.pyplot.imshow`.
    ///
    /// Raises:
    ///     makadam.JudgeError: The arguments are invalid, or the file cannot be written.
    #[pyo3(signature = (file=None, frame=None, *, field=None, range=None, view="natural", clip=None, walls=true, all_grains=false, size=[1200, 900]))]
    #[allow(clippy::too_many_arguments)] // They have names in Python.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        file: Option<PathBuf>,
        frame: Option<PyRef<'py, Frame>>,
        field: Option<String>,
        range: Option<[f64; 2]>,
        view: &str,
        clip: Option<&str>,
        walls: bool,
        all_grains: bool,
        size: [usize; 2],
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let request = PictureRequest { field, range, view, clip, walls, all_grains, size };
        self.frames(py, frame.map(|frame| vec![frame]), walls)?.picture(py, file, request)
    }

    /// Writes frames, or the present state, as one HTML file to turn, cut and play in a browser. A `makadam.MakadamWarning`
    /// reports omissions for size.
    ///
    /// Args:
    ///     file: HTML file to write.
    ///     frames: Frames of this simulation in the order of time, such as those of `record`; defaults to the present state.
    ///     fields: Fields for the colour of grains, the first one at the start; defaults to speed and pressure.
    ///     every: Interval of the shown frames; defaults to as many frames as fit.
    ///     megabytes: Size limit of the content, MB: contacts are omitted first, then frames.
    ///     contacts: Shows contacts and force chains.
    ///     walls: Shows the walls if True; must be False if the caller has moved walls.
    ///     all_grains: Starts the view with all grains, including those far from the walls.
    ///
    /// Raises:
    ///     makadam.JudgeError: The frames lack a field, or the file cannot be written.
    #[pyo3(signature = (file, frames=None, *, fields=None, every=None, megabytes=200.0, contacts=true, walls=true, all_grains=false))]
    #[allow(clippy::too_many_arguments)] // They have names in Python.
    fn view(
        &self,
        py: Python<'_>,
        file: PathBuf,
        frames: Option<Vec<PyRef<'_, Frame>>>,
        fields: Option<Vec<String>>,
        every: Option<usize>,
        megabytes: f64,
        contacts: bool,
        walls: bool,
        all_grains: bool,
    ) -> PyResult<()> {
        let request = PageRequest { fields, every, megabytes, contacts, walls, all_grains };
        self.frames(py, frames, walls)?.view(py, file, request)
    }
}

impl Simulation {
    /// Returns frames of this simulation, or its present state, with their scene.
    fn frames(&self, py: Python<'_>, frames: Option<Vec<PyRef<'_, Frame>>>, walls: bool) -> PyResult<Frames> {
        let frames = match frames {
            Some(frames) => snapshots(&frames),
            None => vec![self.frame(py)?.0],
        };
        let scene = scene_of_frames(py, &self.0, &frames, walls, "give walls=False to leave walls out")?;
        Ok(Frames { scene, frames })
    }
}
