//! Codes with an interface in Python: a job file for a driver script, which runs inside the code, and the frames that the script writes.

use super::input::{MotionPhase, Plan};
use super::process::{self, Program, Run, io};
use super::{CodeError, Job};
use makadam::scene::Motion;
use makadam::snapshot::{Particle, Partner, Snapshot};
use makadam_frames::import::{contact_from_force, measurable, merge_wall_contacts};
use nalgebra::Vector3;
use serde::Deserialize;
use serde_json::{Value, json};
use std::ffi::OsString;
use std::path::Path;

/// Doubles in the rows of a frame.
const HEADER: usize = 3;
const GRAIN_ROW: usize = 9;
const CONTACT_ROW: usize = 12;

/// Statement of the driver about the run.
#[derive(Debug, Deserialize)]
pub struct RunResult {
    /// Wall time of the stepping, s.
    pub seconds: f64,
    /// Processor time of the stepping, s.
    #[serde(default)]
    pub core_seconds: Option<f64>,
    /// Steps taken.
    pub steps: u64,
}

/// Reads the driver's `result.json`; any bytes are either a result or an error.
///
/// # Errors
/// Message with the fault.
pub fn read_result(bytes: &[u8]) -> Result<RunResult, String> {
    let result: RunResult = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
    match [result.seconds].into_iter().chain(result.core_seconds).find(|time| !time.is_finite() || *time < 0.0) {
        None => Ok(result),
        Some(time) => Err(format!("{time} s is no time of a run")),
    }
}

/// One run of a driver script in the job's folder.
pub(super) struct Driver<'a> {
    /// Name of the code.
    pub code: &'static str,
    /// Program of the code.
    pub program: &'a Program,
    /// Its arguments.
    pub arguments: &'a [&'a str],
    /// Name of the file for printed output.
    pub log: &'a str,
}

impl Driver<'_> {
    /// Removes the output of an earlier run.
    pub fn clear(folder: &Path) {
        for stale in ["frames.bin", "driven.bin", "result.json", "progress.txt"] {
            let _ = std::fs::remove_file(folder.join(stale));
        }
    }

    /// Runs the script and returns its statement and its frames; `radii` are those of the grains.
    pub fn execute(&self, job: &Job<'_>, plan: &Plan, radii: &[f64]) -> Result<(RunResult, Vec<Snapshot>), CodeError> {
        let folder = job.work_folder;
        let progress_file = folder.join("progress.txt");
        let log = folder.join(self.log);
        Run {
            code: self.code,
            program: &self.program.path,
            arguments: &self.arguments.iter().map(OsString::from).collect::<Vec<_>>(),
            folder,
            own_logs: &[],
            log: log.clone(),
            limit: job.time_limit,
            watch: &|| {
                let text = std::fs::read_to_string(&progress_file).unwrap_or_default();
                if let Ok(done) = text.trim().parse::<f64>() {
                    (job.progress)(done.clamp(0.0, 1.0));
                }
            },
        }
        .execute()?;

        let result_path = folder.join("result.json");
        let problem = |path: &Path, problem: String| self.problem(path, problem);
        process::disk_has_room(folder)?;
        let text =
            std::fs::read(&result_path).map_err(|_| problem(&log, "the run ended early, without an error".into()))?;
        let result = read_result(&text).map_err(|what| problem(&result_path, what))?;
        let frames_path = folder.join("frames.bin");
        let bytes = std::fs::read(&frames_path).map_err(|source| io(&frames_path, source))?;
        let frames = read_frames(&bytes, radii, job.scene.wall.len()).map_err(|what| problem(&frames_path, what))?;
        if result.steps != plan.steps || frames.len() != plan.frames().len() {
            return Err(problem(&frames_path, format!("{} frames after {} steps", frames.len(), result.steps)));
        }
        let _ = std::fs::remove_file(&frames_path);
        Ok((result, frames))
    }

    /// Fault in a file of the run.
    pub fn problem(&self, file: &Path, problem: String) -> CodeError {
        CodeError::Output { code: self.code, file: file.to_path_buf(), line: 1, problem }
    }
}

/// A phase of a motion: point of the axis (m), unit vector along motion or axis, and speed (m/s), angular velocity (rad/s) or largest
/// displacement (m) with the frequency of the vibration (Hz).
pub(super) fn motion_entry(motion: &Motion, phase: &MotionPhase) -> Option<Value> {
    let size = |vector: &[f64; 3]| Vector3::from(*vector).norm();
    let (kind, point, direction, rate, frequency) = match motion {
        Motion::Translating { velocity, .. } => ("translating", [0.0; 3], *velocity, size(velocity), 0.0),
        Motion::Rotating { point, axis, rate, .. } => ("rotating", *point, *axis, *rate, 0.0),
        Motion::Vibrating { amplitude, frequency, .. } => {
            ("vibrating", [0.0; 3], *amplitude, size(amplitude), *frequency)
        }
        _ => return None,
    };
    let axis: [f64; 3] = Vector3::from(direction).try_normalize(0.0)?.into();
    let (rate, [first, last]) = (phase.direction * rate, [phase.first, phase.last]);
    Some(json!({
        "kind": kind, "point": point, "axis": axis, "rate": rate, "frequency": frequency, "first": first, "last": last,
    }))
}

/// Reads the driver's frames; any bytes are either frames or an error.
///
/// # Errors
/// Message with the fault.
pub fn read_frames(bytes: &[u8], radii: &[f64], walls: usize) -> Result<Vec<Snapshot>, String> {
    let mut rest = bytes.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap_or_default()));
    if !bytes.len().is_multiple_of(8) {
        return Err("it ends in the middle of a number".into());
    }
    let mut row = |length: usize| -> Result<Vec<f64>, String> {
        let row: Vec<f64> = rest.by_ref().take(length).collect();
        match row.len() == length && row.iter().all(|value| value.is_finite()) {
            true => Ok(row),
            false if row.len() < length => Err("it ends in the middle of a frame".into()),
            false => Err("a number is not finite: the run diverged".into()),
        }
    };
    let mut frames = Vec::new();
    let mut left = bytes.len() / 8;
    while left > 0 {
        let header = row(HEADER)?;
        let (time, grains, contacts) = (header[0], header[1], header[2]);
        if grains != radii.len() as f64 || contacts < 0.0 || contacts > left as f64 {
            return Err(format!("frame {} holds {grains} grains and {contacts} contacts", frames.len()));
        }
        let mut particles = Vec::with_capacity(radii.len());
        for (id, &radius) in radii.iter().enumerate() {
            let r = row(GRAIN_ROW)?;
            particles.push(Particle {
                id: id as u32,
                position: [r[0], r[1], r[2]],
                radius,
                velocity: [r[3], r[4], r[5]],
                spin: [r[6], r[7], r[8]],
            });
        }
        let count = contacts as usize;
        let mut list = Vec::new();
        for _ in 0..count {
            let r = row(CONTACT_ROW)?;
            let bound = if r[1] == 0.0 { radii.len() } else { walls } as f64;
            if !(0.0..radii.len() as f64).contains(&r[0]) || !(0.0..bound).contains(&r[2]) {
                return Err(format!("a contact between {} and {} does not exist", r[0], r[2]));
            }
            let partner = if r[1] == 0.0 { Partner::Grain(r[2] as u32) } else { Partner::Wall(r[2] as u32) };
            let normal = Vector3::new(r[6], r[7], r[8]);
            let force = Vector3::new(r[9], r[10], r[11]);
            list.extend(contact_from_force(r[0] as u32, partner, [r[3], r[4], r[5]], normal, force));
        }
        let contacts = merge_wall_contacts(list);
        frames.push(measurable(Snapshot { time, particles, contacts, ..Snapshot::default() })?);
        left -= HEADER + GRAIN_ROW * radii.len() + CONTACT_ROW * count;
    }
    Ok(frames)
}
