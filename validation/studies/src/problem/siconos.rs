//! Siconos' projected Gauss-Seidel (NSGS) on the local problem, by a script in Debian's Python, and its recorded answers.

use super::check::Settings;
use super::{ProblemFile, compressed_columns, parse, solution};
use makadam::problem::LocalProblem;
use makadam::scene::SceneError;
use makadam_frames::plan::MeasuredScene;
use nalgebra::Vector3;
use serde::Deserialize;
use serde_json::json;
use std::ffi::OsString;
use std::io::Write;
use std::process::{Command, Stdio};

const SCRIPT: &str = include_str!("siconos.py");

/// Error of Siconos.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SiconosError {
    /// Siconos is not installed.
    #[error(
        "python3-siconos is missing: {0}; install that package of Debian, or name a Python that has Siconos in \
         MAKADAM_SICONOS_PYTHON"
    )]
    Missing(String),
    /// Siconos failed.
    #[error("Siconos failed: {0}")]
    Failed(String),
}

/// Answer of Siconos, as the script prints it.
#[derive(Deserialize)]
pub(super) struct Found {
    impulses: Vec<f64>,
    pub iterations: u32,
    pub converged: bool,
    pub seconds: f64,
}

impl Found {
    pub fn impulses(&self) -> Vec<Vector3<f64>> {
        self.impulses.chunks_exact(3).map(Vector3::from_column_slice).collect()
    }
}

/// Returns the Python that has Siconos: Debian's, unless the environment names another.
fn python() -> OsString {
    std::env::var_os("MAKADAM_SICONOS_PYTHON").unwrap_or_else(|| "/usr/bin/python3".into())
}

/// Version of the package.
///
/// # Errors
/// [`SiconosError::Missing`].
pub fn version() -> Result<String, SiconosError> {
    let asked = "import siconos.numerics; from siconos import version; print(version)";
    let python = python();
    let output = Command::new(&python).args(["-c", asked]).stdin(Stdio::null()).output();
    let output = output.map_err(|error| SiconosError::Missing(format!("{}: {error}", python.display())))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        let last = errors.lines().last().unwrap_or_default();
        return Err(SiconosError::Missing(format!("{}: {last}", python.display())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().into())
}

/// Solves a local problem from zero impulses.
pub(super) fn solve(local: &LocalProblem, settings: &Settings) -> Result<Found, SiconosError> {
    let failed = |words: String| SiconosError::Failed(words);
    let (starts, rows, values) = compressed_columns(local);
    let job = json!({
        "rows": 3 * local.offset.len(),
        "p": starts,
        "i": rows,
        "x": values,
        "q": local.offset.iter().flatten().collect::<Vec<_>>(),
        "mu": local.friction,
        "tolerance": settings.tolerance,
        "most_iterations": settings.most_sweeps,
    });
    let mut process = Command::new(python())
        .args(["-c", SCRIPT])
        .env("OMP_NUM_THREADS", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| SiconosError::Missing(error.to_string()))?;
    if let Some(mut input) = process.stdin.take() {
        // A process that ends early reports the cause itself.
        let _ = input.write_all(job.to_string().as_bytes());
    }
    let output = process.wait_with_output().map_err(|error| failed(error.to_string()))?;
    let (text, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    if !output.status.success() {
        return Err(failed(errors.lines().last().unwrap_or("it said nothing").into()));
    }
    let line = text.lines().rfind(|line| line.starts_with('{')).unwrap_or_default();
    let found: Found = serde_json::from_str(line).map_err(|error| failed(error.to_string()))?;
    match found.impulses.len() == 3 * local.offset.len() {
        true => Ok(found),
        false => Err(failed(format!("{} numbers for {} contacts", found.impulses.len(), local.offset.len()))),
    }
}

/// Recorded problem.
pub struct Recorded {
    /// Name.
    pub name: &'static str,
    /// Time of the step, s.
    pub time: f64,
    scene: &'static str,
    file: &'static [u8],
}

/// Version of Siconos of the recorded answers.
pub const SICONOS: &str = "4.4.0";

macro_rules! recorded {
    ($name:literal, $time:literal, $scene:literal) => {
        Recorded {
            name: $name,
            time: $time,
            scene: include_str!($scene),
            file: include_bytes!(concat!("recorded/", $name, ".hdf5")),
        }
    };
}

/// Recorded problems.
pub const RECORDED: [Recorded; 4] = [
    recorded!("packing", 0.45, "recorded/packing.toml"),
    recorded!("drum", 1.5, "recorded/drum.toml"),
    recorded!("oedometer", 0.7, "recorded/oedometer.toml"),
    recorded!("packing-100", 0.5, "recorded/packing-100.toml"),
];

impl Recorded {
    /// Returns the scene of the step.
    pub fn scene(&self) -> Result<MeasuredScene, SceneError> {
        MeasuredScene::parse(self.scene)
    }

    /// Returns the problem.
    pub fn problem(&self) -> Result<ProblemFile, String> {
        parse(self.file.to_vec())
    }

    /// Returns the impulses of Siconos' answer, in the frames of the contacts, N s.
    pub fn siconos(&self) -> Result<Vec<Vector3<f64>>, String> {
        solution(self.file.to_vec())
    }
}
