//! Frames of one run of one code, with their origin.

use crate::plan::MeasuredScene;
use makadam::checkpoint::{open, seal_value, write_atomically};
use makadam::snapshot::{Particle, Partner, Snapshot};
use makadam::watch::Watchdog;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Magic bytes of a recording file; the last byte is the format version.
const MARK: [u8; 8] = *b"mkd-rec\x05";

/// One run of a scene in one code.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the scene.
    pub scene: String,
    /// Name of the code: "Makadam", "YADE", "LIGGGHTS" or "LAMMPS".
    pub code: String,
    /// Version, as reported by the code.
    pub version: String,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Time step, s; 0 if the code does not report it.
    pub time_step: f64,
    /// Time step over the Rayleigh step; absent for codes without this limit.
    pub rayleigh_fraction: Option<f64>,
    /// Factor on every Young's modulus of the scene.
    pub stiffness_factor: f64,
    /// Threads used.
    pub threads: usize,
    /// Wall time of the time stepping, s, without set-up and output if the code reports them separately.
    pub wall_seconds: f64,
    /// Processor time of the time stepping on one core, s, without set-up and output; absent if the system or the code does not report
    /// it. Files do not store it.
    #[serde(skip)]
    pub core_seconds: Option<f64>,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Frames, in the order of time, the last frame at the end of the run.
    pub frames: Vec<Snapshot>,
    /// Contents that the frames lack; observables that need them are not measured.
    pub lacks: Vec<Content>,
    /// Diagnostics of a watchdog, the first of each kind.
    pub alarms: Vec<Noticed>,
    /// Notes for the reader on imported frames. Files do not store them.
    #[serde(skip)]
    pub notes: Vec<String>,
}

/// Diagnostic of a watchdog that did not end the run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Noticed {
    /// Kind, position and time.
    pub what: String,
    /// True if it invalidates the numbers of the run.
    pub fatal: bool,
}

impl Noticed {
    /// Returns the diagnostics of a watchdog so far.
    pub fn by(watchdog: &Watchdog) -> Vec<Noticed> {
        let noticed = watchdog.noticed().iter();
        noticed.map(|alarm| Noticed { what: alarm.to_string(), fatal: alarm.trouble.is_fatal() }).collect()
    }

    /// Returns the message.
    pub fn words(&self) -> String {
        match self.fatal {
            true => format!("THESE NUMBERS ARE INVALID: {}", self.what),
            false => format!("NOT SOUND: {}", self.what),
        }
    }
}

/// Optional content of a frame, next to positions and radii.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Content {
    /// Velocities.
    Velocities,
    /// Angular velocities.
    Spins,
    /// Contacts between grains, with their forces.
    Contacts,
    /// Contacts with walls, with their forces.
    WallContacts,
    /// Displacements of dynamic walls.
    DrivenWalls,
}

impl Content {
    /// Returns the name for messages.
    pub fn words(self) -> &'static str {
        match self {
            Content::Velocities => "velocities",
            Content::Spins => "angular velocities",
            Content::Contacts => "contacts between grains",
            Content::WallContacts => "contacts with walls",
            Content::DrivenWalls => "poses of driven walls",
        }
    }
}

/// Error of a recording file.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// Error of the system.
    #[error("{0}: {1}; check that the path is right and the disk has room")]
    Io(String, std::io::Error),
    /// Bytes other than an intact recording.
    #[error("{0} {1}; delete it and run the code again")]
    Format(String, String),
}

impl Recording {
    /// Makes a recording of one run on one thread: without time step, wall time or diagnostics, with all contents.
    pub fn new(
        scene: &MeasuredScene,
        code: &str,
        version: impl Into<String>,
        seed: u64,
        frames: Vec<Snapshot>,
    ) -> Recording {
        Recording {
            scene: scene.name.clone(),
            code: code.into(),
            version: version.into(),
            seed,
            stiffness_factor: 1.0,
            threads: 1,
            simulated_seconds: frames.last().map_or(0.0, |frame| frame.time),
            frames,
            ..Recording::default()
        }
    }

    /// Encodes the recording with a checksum envelope, which detects damage.
    pub fn to_bytes(&self) -> Vec<u8> {
        seal_value(MARK, self)
    }

    /// Writes the recording as one file, through a temporary file so that no reader finds a half-written file.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), RecordingError> {
        write_atomically(path, &self.to_bytes()).map_err(|e| RecordingError::Io(path.display().to_string(), e))
    }

    /// Checks that the recording matches a scene, by the scene's name and the content of the frames.
    ///
    /// # Errors
    /// Message about the mismatch.
    pub fn belongs_to(&self, scene: &MeasuredScene) -> Result<(), String> {
        if self.scene != scene.name {
            return Err(format!("the recording is of the scene '{}', not of '{}'", self.scene, scene.name));
        }
        self.frames.iter().try_for_each(|frame| frame_belongs_to(frame, scene))
    }

    /// Reads a recording.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be read or is not a recording.
    pub fn load(path: &Path) -> Result<Recording, RecordingError> {
        let bytes = std::fs::read(path).map_err(|e| RecordingError::Io(path.display().to_string(), e))?;
        Recording::parse(&bytes).map_err(|problem| RecordingError::Format(path.display().to_string(), problem))
    }

    /// Decodes the bytes of a recording; all bytes are either a measurable recording or an error.
    ///
    /// # Errors
    /// Message, to follow the file name.
    pub fn parse(bytes: &[u8]) -> Result<Recording, String> {
        let body = open(MARK, bytes)?;
        Recording::of_body(body).map_err(|problem| format!("is not a recording that can be measured: {problem}"))
    }

    fn of_body(body: &[u8]) -> Result<Recording, String> {
        let (recording, rest) = postcard::take_from_bytes::<Recording>(body).map_err(|error| error.to_string())?;
        if !rest.is_empty() {
            return Err(format!("{} bytes too many", rest.len()));
        }
        let fraction = recording.rayleigh_fraction.unwrap_or(1.0);
        let numbers = [fraction, recording.stiffness_factor, recording.simulated_seconds];
        let is_step = (0.0..f64::INFINITY).contains(&recording.time_step);
        if !is_step
            || !numbers.iter().all(|number| number.is_finite() && *number > 0.0)
            || !recording.wall_seconds.is_finite()
        {
            return Err("a time or factor is not a positive number".into());
        }
        for (number, frame) in recording.frames.iter().enumerate() {
            check_frame(frame).map_err(|problem| format!("frame {number}: {problem}"))?;
        }
        Ok(recording)
    }
}

/// Checks that a frame matches a scene: number of grains, radii, walls in contact.
///
/// # Errors
/// Message about the mismatch.
pub fn frame_belongs_to(frame: &Snapshot, scene: &MeasuredScene) -> Result<(), String> {
    let (here, there) = (frame.particles.len(), scene.grain_count());
    let of =
        |what: String| Err(format!("the frame at {} s is of another scene than '{}': {what}", frame.time, scene.name));
    if here != there && !scene.flows() {
        return of(format!("it has {here} grains, and the scene has {there}"));
    }
    let sizes = scene.grain_kinds().map(|(_, radii)| radii);
    let (low, high) =
        sizes.fold((f64::INFINITY, 0.0_f64), |(low, high), (least, most)| (low.min(least), high.max(most)));
    let fits = |radius: f64| (low * (1.0 - SAME_SIZE)..=high * (1.0 + SAME_SIZE)).contains(&radius);
    if let Some(Particle { id, radius, .. }) = frame.particles.iter().find(|grain| !fits(grain.radius)) {
        return of(format!(
            "grain {id} has a radius of {radius} m, and those of the scene are from {low} m to {high} m"
        ));
    }
    let wall = frame.contacts.iter().find_map(|contact| match contact.second {
        Partner::Wall(number) if number as usize >= scene.wall.len() => Some(number),
        _ => None,
    });
    wall.map_or(Ok(()), |number| of(format!("a grain touches wall {number}, and the scene has {}", scene.wall.len())))
}

/// Returns a message on grains outside a domain that no grain may leave; `None` if all grains are inside.
pub fn outside_domain(frame: &Snapshot, scene: &MeasuredScene) -> Option<String> {
    let period = scene.domain.period();
    let is_out = |axis: usize, place: f64| {
        !period.is_periodic(axis) && !(scene.domain.min[axis]..=scene.domain.max[axis]).contains(&place)
    };
    let outside = |grain: &&Particle| (0..3).any(|axis| is_out(axis, grain.position[axis]));
    let first = frame.particles.iter().find(outside)?;
    let count = frame.particles.iter().filter(outside).count();
    Some(format!(
        "in the frame at {} s {count} of {} grains lie outside the domain of '{}', the first of them grain {} at {:?} m",
        frame.time,
        frame.particles.len(),
        scene.name,
        first.id,
        first.position
    ))
}

/// Relative tolerance of radii: codes write radii with few digits.
pub const SAME_SIZE: f64 = 1e-3;

/// Upper limit of positions, speeds, sizes and forces, in SI units.
pub const LARGEST: f64 = 1e12;

/// Checks that grain numbers are contiguous, contacts are between existing grains, and all numbers are finite.
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
    if !frame.origins.is_empty() && frame.origins.len() != frame.particles.len() {
        return Err(format!("{} grains with {} identities", frame.particles.len(), frame.origins.len()));
    }
    if frame.passed.iter().any(|passed| !(0.0..LARGEST).contains(&passed.mass)) {
        return Err("the mass that came or went is not a number".into());
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

#[cfg(test)]
#[path = "../tests/unit/recording.rs"]
mod tests;
