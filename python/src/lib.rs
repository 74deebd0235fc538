//! Makadam for Python: the module `makadam._core`, on which the package `makadam` is built.
//!
//! ```text
//! scene.rs       scenes from dicts, texts, files and names
//! settings.rs    settings in place of those of the scene and the machine
//! kept.rs        checkpoints with the scene and seed that they are of
//! pictures.rs    frames on disk, as pictures and as pages
//! simulation.rs  the simulation: views, forces, grains that come and go
//! shared.rs      who may work on a simulation, and who looks at it
//! stepping.rs    steps without the interpreter's lock, that a signal can stop
//! crowd.rs       grains that were put to one place
//! views.rs       arrays of NumPy that lie in the memory of a simulation
//! frame.rs       copies of the state by id
//! judge.rs       recordings, observables
//! comparison.rs  comparison with the reference codes
//! statistics.rs  statistics of the judge
//! errors.rs      exceptions; convert.rs  values of Python, TOML and JSON
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

/// Runs the command `makadam` on arguments, the first of which is its name; returns its exit code.
#[pyfunction]
#[pyo3(name = "_command")]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    let code = py.detach(|| makadam_validation::commands::run_program(arguments));
    // An exit code has no number but for the system.
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(1)
}

/// The parts of Makadam that are written in Rust.
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
