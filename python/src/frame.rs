//! Frames: copies of the state by id, and the contacts of the last step.

use crate::errors::exception;
use crate::scene::Scene;
use crate::shared::Shared;
use makadam::checkpoint::{open, seal};
use makadam::snapshot::{Contact, Partner, Snapshot};
use makadam_frames::plan;
use makadam_frames::recording::frame_belongs_to;
use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::Arc;

/// Magic bytes of a single frame; the last byte is the version of the format.
const MARK: [u8; 8] = *b"mkd-frm\x04";

/// Copy of grains and contacts at a time, independent of later changes. Rows are grains in id order.
#[pyclass(frozen, module = "makadam", name = "Frame")]
#[derive(Clone)]
pub struct Frame(pub Arc<Snapshot>);

impl Frame {
    pub fn of(snapshot: Snapshot) -> Frame {
        Frame(Arc::new(snapshot))
    }
}

/// Returns the snapshots of Python frames.
pub fn snapshots(frames: &[PyRef<'_, Frame>]) -> Vec<Arc<Snapshot>> {
    frames.iter().map(|frame| frame.0.clone()).collect()
}

/// Refuses frames that do not match the scene.
pub fn check_frames(py: Python<'_>, scene: &Scene, frames: &[Arc<Snapshot>]) -> PyResult<()> {
    let fits = frames.iter().try_for_each(|frame| frame_belongs_to(frame, &scene.plan));
    fits.map_err(|problem| {
        let way = "give the scene that the frames were made of (frames of a simulation in which grains came or went are measured by its \
                   own `measure`)";
        exception(py, "JudgeError", &format!("{problem}; {way}"))
    })
}

/// Returns the scene of frames of a simulation. Refuses relevant walls that the caller has moved: frames do not contain their
/// poses. `purpose` states the use of the frames.
pub fn scene_of_frames(
    py: Python<'_>,
    shared: &Shared,
    frames: &[Arc<Snapshot>],
    walls: bool,
    purpose: &str,
) -> PyResult<plan::MeasuredScene> {
    let refuse = |message: String| Err(exception(py, "JudgeError", &message));
    let plan = shared.scene.plan.clone();
    let (moved, others) = shared.with(py, |simulation| {
        // Frames with a turned wall are valid only if its rotation leaves its surface unchanged, as declared in the scene.
        let moved = plan.wall.iter().enumerate().find(|(number, wall)| {
            simulation.moved_by(*number as u32).is_some_and(|(shift, angle)| {
                shift != [0.0; 3] || (angle != 0.0 && !matches!(wall.motion, makadam::Motion::Rotating { .. }))
            })
        });
        (moved.map(|(_, wall)| wall.name.clone()), simulation.has_other_grains())
    })?;
    if let Some(wall) = moved.filter(|_| walls) {
        return refuse(format!(
            "wall '{wall}' was moved by the caller, and frames take walls where the scene has them; {purpose}"
        ));
    }
    // After insertion or removal, frames contain the identities of their grains.
    if !others {
        check_frames(py, &shared.scene, frames)?;
    }
    Ok(plan)
}

/// Returns rows of three numbers as an array.
pub fn vectors<'py>(py: Python<'py>, rows: impl ExactSizeIterator<Item = [f64; 3]>) -> Bound<'py, PyArray2<f64>> {
    let count = rows.len();
    let numbers: Vec<f64> = rows.flatten().collect();
    Array2::from_shape_vec((count, 3), numbers).expect("three numbers a row").into_pyarray(py)
}

fn column<'py, T: numpy::Element>(py: Python<'py>, rows: impl Iterator<Item = T>) -> Bound<'py, PyArray1<T>> {
    Array1::from_iter(rows).into_pyarray(py)
}

/// Returns the contacts of a frame as columns.
pub fn contact_columns<'py>(py: Python<'py>, contacts: &[Contact]) -> PyResult<Bound<'py, PyDict>> {
    let table = PyDict::new(py);
    let each = || contacts.iter();
    let grain = |contact: &Contact| match contact.second {
        Partner::Grain(id) => i64::from(id),
        Partner::Wall(_) => -1,
    };
    let wall = |contact: &Contact| match contact.second {
        Partner::Grain(_) => -1,
        Partner::Wall(number) => i64::from(number),
    };
    table.set_item("first", column(py, each().map(|contact| i64::from(contact.first))))?;
    table.set_item("second", column(py, each().map(grain)))?;
    table.set_item("wall", column(py, each().map(wall)))?;
    table.set_item("point", vectors(py, each().map(|contact| contact.point)))?;
    table.set_item("normal", vectors(py, each().map(|contact| contact.normal)))?;
    table.set_item("normal_force", column(py, each().map(|contact| contact.normal_force)))?;
    table.set_item("tangential_force", vectors(py, each().map(|contact| contact.tangential_force)))?;
    Ok(table)
}

#[pymethods]
impl Frame {
    /// Simulated time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    /// Number of grains.
    fn __len__(&self) -> usize {
        self.0.particles.len()
    }

    /// Centres, m: (n, 3), wrapped along periodic axes.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, self.0.particles.iter().map(|grain| grain.position))
    }

    /// Velocities, m/s: (n, 3).
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, self.0.particles.iter().map(|grain| grain.velocity))
    }

    /// Angular velocities, rad/s: (n, 3).
    #[getter]
    fn spins<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, self.0.particles.iter().map(|grain| grain.spin))
    }

    /// Radii, m: (n,).
    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, self.0.particles.iter().map(|grain| grain.radius))
    }

    /// Mean number of contacts with a force per grain: each contact of two grains counts for both.
    #[getter]
    fn coordination_number(&self) -> f64 {
        let ends = |contact: &Contact| if contact.second.is_grain() { 2 } else { 1 };
        self.0.contacts.iter().map(ends).sum::<usize>() as f64 / self.0.particles.len().max(1) as f64
    }

    /// Contacts of the last step with a force, a dict of columns: `first`, the id of a grain; `second`, the id of its partner, or
    /// -1 for a wall; `wall`, its number in the scene, or -1. In addition `point` (m) and `normal`, from the first grain to its
    /// partner, (c, 3); `normal_force` (N), positive for repulsion; `tangential_force` on the partner (N), (c, 3).
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        contact_columns(py, &self.0.contacts)
    }

    /// Restores a frame from the data of `__reduce__`.
    #[staticmethod]
    fn _of_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Frame> {
        let refuse = |problem: String| exception(py, "JudgeError", &format!("the bytes of a frame: {problem}"));
        let body = open(MARK, bytes).map_err(refuse)?;
        postcard::from_bytes(body).map(Frame::of).map_err(|error| refuse(error.to_string()))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = postcard::to_stdvec(&*slf.get().0).expect("a frame holds only numbers");
        Ok((slf.get_type().getattr("_of_bytes")?, (PyBytes::new(slf.py(), &seal(MARK, &bytes)),)))
    }

    fn __repr__(&self) -> String {
        format!(
            "<makadam.Frame: {} grains, {} contacts, {} s>",
            self.0.particles.len(),
            self.0.contacts.len(),
            self.0.time
        )
    }
}
