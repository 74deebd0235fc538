//! NumPy arrays over the memory of a simulation.
//!
//! The base of such an array is an object that owns the simulation, so that the memory outlives all derived arrays. Two events
//! could still invalidate the memory, and both are excluded:
//!
//! - A step reallocates the arrays of the grains to add boxes. Before the first view the simulation reserves memory, and from then
//!   on it never exceeds the reserve.
//! - Insertion and removal of grains: refused while such a view is alive ([`Shared::refuse_views`]).
//!
//! The arrays of the candidate list do change their length. Before a step changes them, their views take over the memory, and the
//! simulation continues with a copy ([`Shared::release_pairs`]): the views stay unchanged.
//!
//! A thread may read or write such an array while another one steps. Reads then return old or new numbers, and writes may be
//! lost. This is safe: any bit pattern is valid, and no number is used as an unchecked index.

use crate::errors::exception;
use crate::shared::{HeldPairs, Shared};
use numpy::ndarray::{ArrayView, Dimension, IntoDimension, ShapeBuilder};
use numpy::{Element, PyArray, PyArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Base object of views of the arrays of grains.
#[pyclass(frozen, module = "makadam._core")]
struct StateOwner {
    shared: Arc<Shared>,
    writable: bool,
}

impl StateOwner {
    fn of(shared: &Arc<Shared>, writable: bool) -> StateOwner {
        shared.state_views.fetch_add(1, Ordering::SeqCst);
        if writable {
            shared.writable_views.fetch_add(1, Ordering::SeqCst);
            shared.taken_to_write.store(true, Ordering::SeqCst);
        }
        StateOwner { shared: shared.clone(), writable }
    }
}

impl Drop for StateOwner {
    fn drop(&mut self) {
        self.shared.state_views.fetch_sub(1, Ordering::SeqCst);
        if self.writable {
            self.shared.writable_views.fetch_sub(1, Ordering::SeqCst);
        }
    }
}

/// Base object of views of the candidate list.
#[pyclass(frozen, module = "makadam._core")]
struct PairOwner {
    /// Owner of the memory after the hand-over; before, the simulation is the owner.
    _pairs: Arc<HeldPairs>,
    _shared: Arc<Shared>,
}

/// Numbers in consecutive records in memory.
struct Records<T> {
    /// Address of the first number.
    start: *const T,
    /// Number of records, numbers per record, and the stride in numbers.
    records: usize,
    width: usize,
    stride: usize,
}

/// Creates an array over memory of its owner.
///
/// # Safety
/// The memory must stay valid and in place for the lifetime of the owner.
unsafe fn over<'py, T: Element, D: Dimension>(
    records: &Records<T>,
    shape: impl IntoDimension<Dim = D>,
    strides: impl IntoDimension<Dim = D>,
    owner: Bound<'py, PyAny>,
    writable: bool,
) -> Bound<'py, PyArray<T, D>> {
    // SAFETY: guaranteed by the contract of this function.
    let array = unsafe {
        let view = ArrayView::from_shape_ptr(shape.into_dimension().strides(strides.into_dimension()), records.start);
        PyArray::borrow_from_array(&view, owner)
    };
    if !writable {
        array.readwrite().make_nonwriteable();
    }
    array
}

/// Quantity of grains in a view.
#[derive(Clone, Copy)]
pub enum State {
    /// Centres, m.
    Positions,
    /// Velocities, m/s.
    Velocities,
    /// Radius times angular velocity, m/s.
    ScaledSpins,
    /// Radii, m.
    Radii,
    /// Inverse masses, 1/kg.
    InverseMasses,
    /// Ids.
    Ids,
}

/// Returns a view of the grains of a simulation, rows in memory order.
pub fn state<'py>(py: Python<'py>, shared: &Arc<Shared>, what: State) -> PyResult<Bound<'py, PyAny>> {
    if shared.scene.plan.flows() || !shared.scene.plan.stage.is_empty() {
        let message = "grains come and go in the steps of this scene, or it has stages, so that no array of them can stay; take copies: frame()";
        return Err(exception(py, "ViewError", message));
    }
    let writable = matches!(what, State::Positions | State::Velocities | State::ScaledSpins);
    // From here on, insertion and removal of grains are refused.
    let owner = Bound::new(py, StateOwner::of(shared, writable))?.into_any();
    let placed = shared.with(py, |simulation| {
        simulation.keep_arrays_in_place().map(|()| {
            let (spheres, bodies, ids) = simulation.arrays();
            (spheres.as_ptr().cast(), bodies.as_ptr().cast(), ids.as_ptr(), ids.len())
        })
    })?;
    let (sphere, body, ids, count): (*const f64, *const f64, *const u32, usize) =
        placed.map_err(|error| pyo3::exceptions::PyMemoryError::new_err(error.to_string()))?;
    let of = |start: *const f64, offset: usize, width: usize, stride: usize| Records {
        // The offset is below the length of a record; without records nothing is read.
        start: start.wrapping_add(offset),
        records: count,
        width,
        stride,
    };
    // Layout of the records: centre and radius; velocity, inverse mass, scaled spin, inverse radius.
    let numbers = match what {
        State::Positions => of(sphere, 0, 3, 4),
        State::Velocities => of(body, 0, 3, 8),
        State::ScaledSpins => of(body, 4, 3, 8),
        State::Radii => of(sphere, 3, 1, 4),
        State::InverseMasses => of(body, 3, 1, 8),
        State::Ids => {
            let ids = Records { start: ids, records: count, width: 1, stride: 1 };
            // SAFETY: the ids stay in place like all arrays of the grains, and the owner holds the simulation.
            return Ok(unsafe { over(&ids, [count], [1], owner, false) }.into_any());
        }
    };
    // SAFETY: same as for the ids; sphere records are four numbers and body records eight, without gaps.
    Ok(unsafe {
        match numbers.width {
            1 => over(&numbers, [numbers.records], [numbers.stride], owner, writable).into_any(),
            width => over(&numbers, [numbers.records, width], [numbers.stride, 1], owner, writable).into_any(),
        }
    })
}

/// Quantity of the candidate list in a view.
#[derive(Clone, Copy)]
pub enum Pairs {
    /// Rows of two grains.
    Grains,
    /// Normal impulse and tangential impulse on the second grain, N s.
    GrainImpulses,
    /// Row of a grain and number of a face.
    Walls,
    /// Normal impulse and tangential impulse on the wall, N s.
    WallImpulses,
}

/// Returns a view of the present candidate list of a simulation.
pub fn pairs<'py>(py: Python<'py>, shared: &Arc<Shared>, what: Pairs) -> PyResult<Bound<'py, PyAny>> {
    let taken = shared.with(py, |simulation| {
        // While no thread steps: from here on, arrays in views are handed over before a step changes them.
        let mut last = shared.pairs.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let held = last.upgrade().unwrap_or_else(|| {
            let held = Arc::new(HeldPairs::default());
            *last = Arc::downgrade(&held);
            held
        });
        let (pairs, pair_impulses, walls, wall_impulses) = simulation.pairs_in_list();
        let counts = [pairs.len(), walls.len()];
        (held, counts, (pairs.as_ptr(), pair_impulses.as_ptr()), (walls.as_ptr(), wall_impulses.as_ptr()))
    })?;
    let (held, [of_grains, of_walls], (pairs, pair_impulses), (walls, wall_impulses)) = taken;
    let owner = Bound::new(py, PairOwner { _pairs: held, _shared: shared.clone() })?.into_any();
    let names = |start: *const u32, records: usize| Records { start, records, width: 2, stride: 2 };
    let numbers = |start: *const f64, records: usize| Records { start, records, width: 4, stride: 4 };
    // SAFETY: until the arrays change, the simulation owns them, and the owner holds the simulation; then the owner receives them
    // at the same address. Records are two numbers, and four, without gaps.
    Ok(unsafe {
        match what {
            Pairs::Grains => matrix(&names(pairs.cast(), of_grains), owner),
            Pairs::Walls => matrix(&names(walls.cast(), of_walls), owner),
            Pairs::GrainImpulses => matrix(&numbers(pair_impulses.cast(), of_grains), owner),
            Pairs::WallImpulses => matrix(&numbers(wall_impulses.cast(), of_walls), owner),
        }
    })
}

/// Creates a read-only array of rows.
///
/// # Safety
/// Same as for [`over`].
unsafe fn matrix<'py, T: Element>(records: &Records<T>, owner: Bound<'py, PyAny>) -> Bound<'py, PyAny> {
    // SAFETY: guaranteed by the contract of this function.
    unsafe { over(records, [records.records, records.width], [records.stride, 1], owner, false) }.into_any()
}
