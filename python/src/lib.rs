//! Python bindings of Makadam: the module `makadam._core`, the basis of the package `makadam`.
//!
//! ```text
//! scene.rs       scenes from dicts, texts, files and names
//! settings.rs    settings that replace those of the scene and the machine
//! kept.rs        checkpoints with their scene and seed
//! pictures.rs    frames on disk, as pictures and as pages
//! simulation.rs  the simulation: views, forces, insertion and removal of grains
//! shared.rs      locking and view bookkeeping
//! stepping.rs    steps without the interpreter's lock, interruptible by a signal
//! crowd.rs       coincident grains
//! views.rs       NumPy arrays over the memory of a simulation
//! frame.rs       copies of the state by id
//! judge.rs       recordings, observables
//! comparison.rs  comparison with the reference codes
//! statistics.rs  validation statistics
//! errors.rs      exceptions; convert.rs  Python, TOML and JSON values
//! ```

mod comparison;
mod convert;
mod crowd;
mod errors;
mod frame;
mod judge;
mod kept;
mod pictures;
mod scene;
mod settings;
mod shared;
mod simulation;
mod statistics;
mod stepping;
mod views;

use pyo3::prelude::*;
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs the command `makadam` on arguments, starting with its name; returns its exit code.
#[pyfunction]
#[pyo3(name = "_command")]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    let code = py.detach(|| makadam_validation::commands::run_program(arguments));
    // An exit code has no public numeric value.
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(1)
}

/// Rust part of the package.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    makadam_validation::state_commit();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("BUILD", makadam::BUILD)?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<frame::Frame>()?;
    module.add_class::<judge::Recording>()?;
    module.add_function(wrap_pyfunction!(command, module)?)?;
    module.add_function(wrap_pyfunction!(scene::known, module)?)?;
    module.add_function(wrap_pyfunction!(judge::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(judge::measure_of_frames, module)?)?;
    module.add_function(wrap_pyfunction!(judge::observables, module)?)?;
    module.add_function(wrap_pyfunction!(comparison::reference, module)?)?;
    module.add_function(wrap_pyfunction!(comparison::compare, module)?)?;
    module.add_function(wrap_pyfunction!(comparison::compare_runs, module)?)?;
    module.add_function(wrap_pyfunction!(statistics::block_average, module)?)?;
    module.add_function(wrap_pyfunction!(statistics::ensemble, module)?)?;
    module.add_function(wrap_pyfunction!(statistics::equivalence, module)?)?;
    Ok(())
}
