//! A run of a code that takes a deck and leaves dumps and a log, as LIGGGHTS and LAMMPS do, and the rows of its dumps.

use super::plan::Plan;
use super::process::{Run, disk_has_room, io};
use super::{CodeError, Job};
use crate::import::{FrameTable, contact_from_force};
use crate::recording::Recording;
use makadam::effects::catalogue::{
    COMPLIANCE, Effect, FRICTION, GRAVITY, RESTITUTION, ROLLING, SIZE_SPREAD, SPIN, TANGENTIAL_SPRING, VISCOSITY,
    WALL_MOTION,
};
use makadam::scene::Grain;
use makadam::snapshot::{Particle, Partner, Snapshot};
use nalgebra::Vector3;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Effects that the decks of both codes express; a scene with any other effect is refused. Three that LIGGGHTS has differ from the scene's:
/// its servo wall has a controller in place of a mass, the pull of its cohesion goes with the area of the overlap, and its twisting
/// resistance is tied to the rolling one.
pub(super) const HAS: [&Effect; 10] = [
    &GRAVITY,
    &WALL_MOTION,
    &SIZE_SPREAD,
    &COMPLIANCE,
    &VISCOSITY,
    &RESTITUTION,
    &FRICTION,
    &TANGENTIAL_SPRING,
    &SPIN,
    &ROLLING,
];

/// A run of `deck.in`, which stands in the job's folder.
pub(super) struct DeckRun<'a> {
    /// Name of the code.
    pub code: &'static str,
    /// The program.
    pub program: &'a OsStr,
    /// Name of the file for what it prints.
    pub log: &'static str,
    /// Wall time of the stepping in its own log, without output, s.
    pub loop_seconds: fn(&str) -> f64,
    /// The dumps that it leaves.
    pub dumps: &'a [PathBuf],
}

impl DeckRun<'_> {
    /// Runs the deck; `read_frames` reads the dumps afterwards, which are removed then.
    ///
    /// # Errors
    /// [`CodeError`]; what the code wrote stays in the job's folder.
    pub fn carry_out(
        &self,
        job: &Job<'_>,
        version: String,
        plan: &Plan,
        read_frames: impl FnOnce() -> Result<Vec<Snapshot>, CodeError>,
    ) -> Result<Recording, CodeError> {
        let folder = job.work_folder;
        let remove = || self.dumps.iter().for_each(|dump| _ = std::fs::remove_file(dump));
        remove();
        let engine_log = folder.join("engine.log");
        let core_share = Run {
            code: self.code,
            program: self.program,
            arguments: &["-in", "deck.in", "-log", "engine.log", "-nocite"].map(OsString::from),
            folder,
            log: folder.join(self.log),
            own_logs: std::slice::from_ref(&engine_log),
            limit: job.time_limit,
            watch: &|| {
                if let Some(step) = last_step(&engine_log) {
                    (job.progress)((step as f64 / plan.steps as f64).clamp(0.0, 1.0));
                }
            },
        }
        .execute()?;
        disk_has_room(folder)?;
        let frames = read_frames()?;
        let text = std::fs::read(&engine_log).map_err(|source| io(&engine_log, source))?;
        remove();
        (job.progress)(1.0);
        let wall_seconds = (self.loop_seconds)(&String::from_utf8_lossy(&text));
        let core_seconds = core_share.map(|share| share * wall_seconds);
        Ok(Recording { core_seconds, ..plan.recording(self.code, version, job, wall_seconds, frames) })
    }
}

/// Opens a dump.
pub(super) fn open(file: &Path) -> Result<BufReader<File>, CodeError> {
    File::open(file).map(BufReader::new).map_err(|source| io(file, source))
}

/// The last step of which the log tells.
fn last_step(log: &Path) -> Option<u64> {
    let mut file = File::open(log).ok()?;
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(400))).ok()?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes);
    text.lines().rev().find_map(|line| {
        let mut words = line.split_whitespace().map(str::parse::<f64>);
        match (words.next(), words.next(), words.next(), words.next()) {
            (Some(Ok(step)), Some(Ok(_)), Some(Ok(_)), None) => Some(step as u64),
            _ => None,
        }
    })
}

pub(super) fn vector(row: &[f64]) -> Vector3<f64> {
    Vector3::new(row[0], row[1], row[2])
}

pub(super) fn contact(
    first: &Particle,
    second: Partner,
    point: [f64; 3],
    towards: Vector3<f64>,
    force: &[f64],
) -> Option<makadam::snapshot::Contact> {
    contact_from_force(first.id, second, point, towards.try_normalize(0.0)?, vector(force))
}

/// The grain of an id as these codes count, from 1.
pub(super) fn particle(particles: &[Particle], id: f64) -> Option<&Particle> {
    if id >= 1.0 { particles.get(id as usize - 1) } else { None }
}

/// The grains of a frame of `id x y z vx vy vz omegax omegay omegaz`; else the row that is wrong, and what is.
pub(super) fn particles_of(state: &FrameTable, grains: &[Grain]) -> Result<Vec<Particle>, (usize, String)> {
    let mut found: Vec<Option<Particle>> = vec![None; grains.len()];
    for (row, r) in state.rows().enumerate() {
        let index = r[0] - 1.0;
        if !(0.0..grains.len() as f64).contains(&index) {
            return Err((row, format!("no grain {}", r[0])));
        }
        let id = index as usize;
        found[id] = Some(Particle {
            id: id as u32,
            position: [r[1], r[2], r[3]],
            radius: grains[id].radius,
            velocity: [r[4], r[5], r[6]],
            spin: [r[7], r[8], r[9]],
        });
    }
    let count = found.len();
    let particles: Vec<Particle> = found.into_iter().flatten().collect();
    match particles.len() == count {
        true => Ok(particles),
        false => Err((0, format!("{} of {count} grains: the others have left the domain", particles.len()))),
    }
}
