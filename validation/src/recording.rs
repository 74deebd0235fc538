//! What one run of one code leaves behind: its frames and where they came from.

use makadam::checkpoint::write_atomically;
use makadam::snapshot::{Partner, Snapshot};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One run of a scene in one code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the scene.
    pub scene: String,
    /// Name of the code: "Makadam", "YADE" or "LIGGGHTS".
    pub code: String,
    /// Version that the code reports of itself.
    pub version: String,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Time step, s.
    pub time_step: f64,
    /// Time step over the Rayleigh step; absent for codes that are not bound by it.
    pub rayleigh_fraction: Option<f64>,
    /// Factor on every Young's modulus of the scene.
    pub stiffness_factor: f64,
    /// Threads used.
    pub threads: usize,
    /// Wall time of the time stepping, s, set-up and output left out as far as the code tells them apart.
    pub wall_seconds: f64,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Frames, in the order of time, the last one at the end of the run.
    pub frames: Vec<Snapshot>,
}

/// Why a recording file could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The system refused.
    #[error("{0}: {1}; check that the path is right and the disk has room")]
    Io(String, std::io::Error),
    /// The bytes are not a recording.
    #[error("{0}: not a recording: {1}; delete it and run the code again")]
    Format(String, String),
}

impl Recording {
    /// Writes the recording as one file, through a temporary name so that a half-written file is never read.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), RecordingError> {
        let bytes =
            postcard::to_stdvec(self).map_err(|e| RecordingError::Format(path.display().to_string(), e.to_string()))?;
        write_atomically(path, &bytes).map_err(|e| RecordingError::Io(path.display().to_string(), e))
    }

    /// Reads a recording.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be read or is not a recording.
    pub fn load(path: &Path) -> Result<Recording, RecordingError> {
        let bytes = std::fs::read(path).map_err(|e| RecordingError::Io(path.display().to_string(), e))?;
        Recording::parse(&bytes).map_err(|problem| RecordingError::Format(path.display().to_string(), problem))
    }

    /// Reads the bytes of a recording; any bytes are either one that can be measured or an error.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn parse(bytes: &[u8]) -> Result<Recording, String> {
        let (recording, rest) = postcard::take_from_bytes::<Recording>(bytes).map_err(|error| error.to_string())?;
        if !rest.is_empty() {
            return Err(format!("{} bytes too many", rest.len()));
        }
        let fraction = recording.rayleigh_fraction.unwrap_or(1.0);
        let numbers = [recording.time_step, fraction, recording.stiffness_factor, recording.simulated_seconds];
        if !numbers.iter().all(|number| number.is_finite() && *number > 0.0) || !recording.wall_seconds.is_finite() {
            return Err("a time or factor is not a positive number".into());
        }
        for (number, frame) in recording.frames.iter().enumerate() {
            check_frame(frame).map_err(|problem| format!("frame {number}: {problem}"))?;
        }
        Ok(recording)
    }
}

/// No place, speed, size or force comes near it, in SI units.
const LARGEST: f64 = 1e12;

/// Grains are numbered without holes, contacts are between them, and every number is one.
fn check_frame(frame: &Snapshot) -> Result<(), String> {
    let finite = |vector: &[f64; 3]| vector.iter().all(|component| component.abs() < LARGEST);
    if !frame.time.is_finite() {
        return Err("its time is not a number".into());
    }
    for (place, grain) in frame.particles.iter().enumerate() {
        if grain.id as usize != place {
            return Err(format!("grain {} stands in place {place}", grain.id));
        }
        let whole = [grain.position, grain.velocity, grain.spin].iter().all(finite);
        if !whole || !(1.0 / LARGEST..LARGEST).contains(&grain.radius) {
            return Err(format!("grain {place} has a value that is not a number, or no radius"));
        }
    }
    for wall in &frame.driven_walls {
        if !finite(&[wall.displacement, wall.rate, 0.0]) {
            return Err(format!("driven wall {} has a value that is not a number", wall.wall));
        }
    }
    for contact in &frame.contacts {
        let grains = [Some(contact.first), if let Partner::Grain(id) = contact.second { Some(id) } else { None }];
        if let Some(id) = grains.into_iter().flatten().find(|&id| id as usize >= frame.particles.len()) {
            return Err(format!("a contact of grain {id}, which is not there"));
        }
        let whole = [contact.point, contact.normal, contact.tangential_force].iter().all(finite);
        if !whole || !finite(&[contact.normal_force; 3]) {
            return Err(format!("a contact of grain {} has a value that is not a number", contact.first));
        }
    }
    Ok(())
}
