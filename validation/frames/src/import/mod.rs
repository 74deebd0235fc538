//! Frames of any code, read from files and a manifest.
//!
//! ```text
//! file ─> dump, text, VTK ─> FrameTable: columns with a meaning ─> assemble, with scene and manifest ─> Recording, as of a run
//! ```
//!
//! Columns are identified by their names in the file or the manifest, never by their index. Nothing is guessed. Missing statements are
//! refused with the manifest line to add, or the [`Recording`] lists missing contents, and observables that need them are not measured.

mod columns;
mod contacts;
mod dump;
mod format;
mod frames;
mod identity;
mod legacy_vtk;
mod manifest;
mod table;
mod text;
mod vtkhdf;
mod xml;

pub use columns::{Column, StatedColumns, column_of};
pub use contacts::merge_wall_contacts;
pub use contacts::{contact_from_force, measurable};
pub use format::parse;
pub use manifest::{FilePattern, Manifest};
pub use table::{FrameTable, ImportError, Periods};

use crate::plan::MeasuredScene;
use crate::recording::{Content, Recording, outside_domain};
use contacts::{Columns, ContactList, vector};
use frames::{Assembly, Frame};
use identity::{Identity, Numbers};
use makadam::scene::{Domain, Reaction};
use makadam::snapshot::{Contact, Particle, Snapshot};
use manifest::Missing;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Grains and contacts as tables, in the layout of the files.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// Frames of grains.
    pub grains: Vec<FrameTable>,
    /// Frames of contacts.
    pub contacts: Vec<FrameTable>,
    /// Files of grains and of contacts, by their canonical names.
    pub files: [BTreeSet<PathBuf>; 2],
}

impl Tables {
    /// Reads all files of a manifest.
    ///
    /// # Errors
    /// [`ImportError`] with file and line.
    pub fn read(manifest: &Manifest) -> Result<Tables, ImportError> {
        let mut tables = Tables::default();
        for (is_contacts, patterns) in [&manifest.grains, &manifest.contacts].into_iter().enumerate() {
            for pattern in patterns {
                for file in manifest.files(pattern)? {
                    tables.add(is_contacts == 1, &file, pattern, manifest)?;
                }
            }
        }
        Ok(tables)
    }

    /// Iterates over the frames with grains: a frame without any has no columns in some formats.
    fn with_grains(&self) -> impl Iterator<Item = &FrameTable> {
        self.grains.iter().filter(|table| !table.values.is_empty())
    }

    /// Adds the frames of a file of grains or of contacts. The file name gives the time or step of a single frame that states neither.
    ///
    /// # Errors
    /// [`ImportError`] with file and line, also for a file read before, under this name or another one: its frames would count twice.
    pub fn add(
        &mut self,
        is_contacts: bool,
        file: &Path,
        pattern: &FilePattern,
        manifest: &Manifest,
    ) -> Result<(), ImportError> {
        let own_name = file.canonicalize().unwrap_or_else(|_| file.to_path_buf());
        if !self.files[usize::from(is_contacts)].insert(own_name) {
            let problem = "the file is given twice, by this name or another one; name each file once";
            return Err(ImportError::new(file, 1, problem));
        }
        let (tables, columns) = match is_contacts {
            true => (&mut self.contacts, &manifest.contact_columns),
            false => (&mut self.grains, &manifest.columns),
        };
        let bytes = std::fs::read(file).map_err(|error| ImportError::new(file, 1, error.to_string()))?;
        let mut frames = parse(file, bytes, columns)?;
        if let ([frame], Some(stamp)) = (&mut frames[..], pattern.stamp(file))
            && frame.time.is_none()
            && frame.step.is_none()
        {
            (frame.time, frame.step) = (stamp.time, stamp.step);
        }
        tables.extend(frames);
        Ok(())
    }
}

/// Assembles the frames of files; notes for the reader are among the notes of the recording.
///
/// # Errors
/// [`ImportError`] with file and line: missing statements, or statements inconsistent with the scene or with each other.
pub fn assemble(scene: &MeasuredScene, manifest: &Manifest, tables: &Tables) -> Result<Recording, ImportError> {
    if tables.grains.is_empty() {
        return Err(ImportError::new(Path::new("-"), 1, "no file has a frame; give files of grains"));
    }
    tables.grains.iter().try_for_each(|table| position(table).map(|_| ()))?;
    tables.grains.iter().chain(&tables.contacts).try_for_each(|table| same_box(table, &scene.domain))?;

    let mut assembly = Assembly { scene, manifest, tables, missing: Missing::default(), notes: Vec::new() };
    tables.contacts.iter().for_each(|table| _ = Columns::of(table, &mut assembly.missing));
    let foreign = tables.contacts.iter().find(|table| table.first_id.is_none());
    if let Some(table) = foreign.filter(|_| !manifest.contacts_complete) {
        let meaning = "the files list all contacts of each of their frames; else leave the files of contacts out";
        assembly.missing.add(table, 0, "contacts-complete = true", meaning);
    }
    let frames = assembly.frames()?;
    let identity = Identity::new(scene, manifest, &frames);
    let numbers = identity.numbers(&frames, &mut assembly.missing)?;
    let radii = match tables.with_grains().find(|table| table.radius().is_none()) {
        Some(table) => identity.radii(table, &mut assembly)?,
        None => Vec::new(),
    };
    assembly.missing.refuse()?;

    let mut snapshots = Vec::with_capacity(frames.len());
    let step = longest_step(manifest, &frames);
    for frame in &frames {
        let particles = particles(frame.grains, &identity, &numbers, &radii, &scene.domain)?;
        let mut list = ContactList::new(scene, manifest, &numbers, &particles);
        for table in &frame.contacts {
            let columns = Columns::of(table, &mut assembly.missing);
            columns.map_or(Ok(()), |columns| list.add(table, &columns))?;
        }
        if let Some(step) = step.filter(|_| frame.is_measured) {
            list.check_complete(&frame.contacts, step)?;
        }
        let contacts = merge_wall_contacts(list.contacts);
        let driven_walls = frame.grains.driven_walls.clone();
        let snapshot = Snapshot { time: frame.time, particles, contacts, driven_walls, ..Snapshot::default() };
        snapshots.push(measurable(snapshot).map_err(|problem| frame.grains.fault(0, problem))?);
    }
    let code = manifest.name.as_deref().unwrap_or("frames");
    let version = manifest.version.as_deref().unwrap_or("unknown");
    // Frames do not state the code's time step, which can differ from the step in their numbers.
    let recording = Recording::new(scene, code, version, manifest.seed.unwrap_or(scene.seed), snapshots);
    Ok(Recording { lacks: lacks(scene, tables), notes: assembly.notes, ..recording })
}

/// Returns the contents that some frames lack.
fn lacks(scene: &MeasuredScene, tables: &Tables) -> Vec<Content> {
    let driven: Vec<u32> =
        (0..).zip(&scene.wall).filter(|(_, wall)| wall.motion.is_driven()).map(|(wall, _)| wall).collect();
    let states_poses =
        |table: &FrameTable| driven.iter().all(|wall| table.driven_walls.iter().any(|stated| stated.wall == *wall));
    let all_have = |of: fn(usize) -> Column| tables.with_grains().all(|table| table.vector(of).is_some());
    let some_has = |column: Column| tables.contacts.iter().any(|table| table.find(column).is_some());
    let has = [
        (Content::DrivenWalls, !driven.is_empty() && tables.grains.iter().all(states_poses)),
        (Content::Velocities, all_have(Column::Velocity)),
        (Content::Spins, all_have(Column::Spin)),
        (Content::Contacts, some_has(Column::Second)),
        (Content::WallContacts, some_has(Column::Wall)),
    ];
    has.into_iter().filter(|(_, has)| !has).map(|(content, _)| content).collect()
}

/// Returns the longest possible time step of the code, s; `None` if velocities or times do not determine it.
fn longest_step(manifest: &Manifest, frames: &[Frame<'_>]) -> Option<f64> {
    let has_velocities = frames.iter().all(|frame| frame.grains.vector(Column::Velocity).is_some());
    let between = frames.array_windows().map(|[one, other]| other.time - one.time);
    let step = between.chain(manifest.time_step).fold(f64::INFINITY, f64::min);
    (has_velocities && step.is_finite()).then_some(step)
}

/// Refuses a file with another periodic box than the scene: contacts and overlaps across its ends would differ.
fn same_box(table: &FrameTable, domain: &Domain) -> Result<(), ImportError> {
    let Some(Periods { lengths, rounding }) = table.periods else { return Ok(()) };
    let period = domain.period();
    let name = |axis: usize| ["x", "y", "z"][axis];
    for (axis, length) in lengths.into_iter().enumerate() {
        let own = if period.is_periodic(axis) { domain.max[axis] - domain.min[axis] } else { 0.0 };
        if (length - own).abs() <= rounding && (length > 0.0) == (own > 0.0) {
            continue;
        }
        let words = |length: f64| match length > 0.0 {
            true => format!("periodic along {}, with a length of {length} m", name(axis)),
            false => format!("not periodic along {}", name(axis)),
        };
        let problem =
            format!("its box is {}, and the scene is {}; give the scene that was run", words(length), words(own));
        return Err(table.fault(0, problem));
    }
    Ok(())
}

/// Returns the columns of the coordinates.
fn position(table: &FrameTable) -> Result<[usize; 3], ImportError> {
    let is_scaled = table.unread.iter().any(|name| ["xs", "xsu"].contains(&name.as_str()));
    table.vector(Column::Position).ok_or_else(|| {
        let remedy = match is_scaled {
            true => "coordinates are scaled to the box: dump x y z instead",
            false => {
                "name the columns of the file in their order: columns = [\"id\", \"x\", \"y\", \"z\", \"radius\", ...]"
            }
        };
        table.fault(0, format!("no columns x, y, z among {}; {remedy}", table.names()))
    })
}

/// Returns the grains of a frame in the order of their numbers, at their images in the domain along periodic axes.
fn particles(
    table: &FrameTable,
    identity: &Identity<'_>,
    numbers: &Numbers,
    radii: &[f64],
    domain: &Domain,
) -> Result<Vec<Particle>, ImportError> {
    let position = position(table)?;
    let (id, size) = (table.find(Column::Id), table.radius());
    let (velocity, spin) = (table.vector(Column::Velocity), table.vector(Column::Spin));
    let particle = |(row, cells): (usize, &[f64])| {
        let id = numbers.get(&(identity.own_number(id, row, cells) as i64)).copied().unwrap_or_default();
        let radius = match size {
            Some((column, factor)) => factor * cells[column],
            None => radii.get(id as usize).copied().unwrap_or_default(),
        };
        let of = |columns: Option<[usize; 3]>| columns.map_or([0.0; 3], |columns| columns.map(|column| cells[column]));
        let position = image(domain, vector(cells, position)).into();
        Particle { id, position, radius, velocity: of(velocity), spin: of(spin) }
    };
    let mut particles: Vec<Particle> = table.rows().enumerate().map(particle).collect();
    particles.sort_by_key(|particle| particle.id);
    match particles.array_windows().any(|[one, other]| one.id == other.id) {
        false => Ok(particles),
        true => Err(table.fault(0, "two grains of a frame have one number")),
    }
}

/// Returns the image of a point in the domain along periodic axes; a point inside is unchanged to the bit.
fn image(domain: &Domain, point: Vector3<f64>) -> Vector3<f64> {
    let wrapped = domain.period().wrapped(&point, &domain.min.into());
    let is_inside = |axis: usize| (domain.min[axis]..domain.max[axis]).contains(&point[axis]);
    Vector3::from_fn(|axis, _| if is_inside(axis) { point[axis] } else { wrapped[axis] })
}

/// Largest tangential over normal force of a central force that a file states with six digits.
const CENTRAL: f64 = 1e-3;
/// Smallest number of contacts of a bed, which under friction is not free of tangential forces.
const FEWEST_CONTACTS: usize = 10;

/// Returns notes on measured frames: grains outside the domain, forces without any repulsive one, and without any tangential one.
pub fn unlike<'f>(scene: &MeasuredScene, frames: impl Iterator<Item = &'f Snapshot> + Clone) -> Vec<String> {
    let may_leave = scene.watch.on_escape == Reaction::Ignore;
    let outside = frames.clone().find_map(|frame| outside_domain(frame, scene)).filter(|_| !may_leave);
    let has_friction = scene.material.values().any(|material| material.friction > 0.0);
    let mut between = frames.clone().flat_map(|frame| &frame.contacts).filter(|contact| contact.normal_force > 0.0);
    let central =
        |contact: &Contact| contact.tangential_force.iter().all(|part| part.abs() < CENTRAL * contact.normal_force);
    let slides = has_friction && between.clone().count() >= FEWEST_CONTACTS && between.all(central);
    let slides = slides.then(|| {
        "no contact has a tangential force: the column may hold the central part of the forces alone (fx of LAMMPS's compute pair/local)"
            .to_string()
    });
    let mut contacts = frames.flat_map(|frame| &frame.contacts).peekable();
    let pulls = contacts.peek().is_some() && !contacts.any(|contact| contact.normal_force > 0.0);
    let pulls = pulls.then(|| {
        "no contact pushes its grains apart: forces are those on the first grain, and normals lead away from it"
            .to_string()
    });
    outside.into_iter().chain(pulls).chain(slides).collect()
}
