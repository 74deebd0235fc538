//! LAMMPS: a deck and initial grains go in; dumps and a log come back.

mod deck;
mod surfaces;

use super::deck_run::{DeckRun, HAS, contact, open, particle, particles_of, vector};
use super::palette::Palette;
use super::plan::Plan;
use super::process::Program;
use super::{Code, CodeError, HERTZ_MINDLIN, Job, Purpose, supported_start};
use crate::import::{FrameTable, measurable, merge_wall_contacts, read_dump};
use crate::plan::Scene;
use crate::recording::{Content, Recording};
use makadam::scene::Grain;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use nalgebra::Vector3;
use std::ffi::OsString;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use surfaces::{Surface, surfaces};

const NAME: &str = "LAMMPS";

/// LAMMPS with its package GRANULAR, an explicit soft-sphere code.
pub struct Lammps {
    program: Program,
}

impl Default for Lammps {
    fn default() -> Self {
        Self { program: Program::from_environment(NAME, "lmp") }
    }
}

impl Lammps {
    /// LAMMPS under another name or path.
    pub fn new(program: impl Into<OsString>) -> Self {
        Self { program: Program::new(program) }
    }
}

impl Code for Lammps {
    fn name(&self) -> &'static str {
        NAME
    }

    fn contact_law(&self) -> &'static str {
        HERTZ_MINDLIN
    }

    fn timing_input(&self) -> Option<&'static str> {
        Some("contacts with walls are neither kept nor dumped; skin of half the smallest radius")
    }

    fn version(&self) -> Option<String> {
        self.program.version(&["-help", "-log", "none"], version_in)
    }

    fn write_input(&self, job: &Job<'_>) -> Result<String, CodeError> {
        write_input(job).map(|_| "lmp -in deck.in".into())
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        let version = self.version().ok_or(CodeError::Missing { code: NAME })?;
        let Input { grains, largest_step, plan, dumps } = write_input(job)?;
        let folder = job.work_folder;
        let dumps: Vec<PathBuf> = dumps.into_iter().map(|name| folder.join(name)).collect();
        let run = DeckRun { code: NAME, program: self.program.path(), log: "lammps.log", loop_seconds, dumps: &dumps };
        let told = job.purpose == Purpose::Measuring;
        let read = || frames_in(job.scene, &grains, largest_step, folder, told, open);
        let recording = run.carry_out(job, version, &plan, read)?;
        Ok(Recording { lacks: if told { Vec::new() } else { vec![Content::WallContacts] }, ..recording })
    }
}

/// What a run is made of, beside its files.
struct Input {
    grains: Vec<Grain>,
    /// What the time step may be at most, s.
    largest_step: f64,
    plan: Plan,
    /// Names of the dumps that it leaves.
    dumps: Vec<String>,
}

/// Writes deck and grains into the job's folder.
fn write_input(job: &Job<'_>) -> Result<Input, CodeError> {
    let scene = job.scene;
    let grains = supported_start(NAME, &HAS, job)?;
    let largest_step = job.rayleigh_fraction * scene.rayleigh_step(&grains);
    let plan = Plan::new(scene, largest_step);
    let unsupported = |reason: String| CodeError::Unsupported { code: NAME, reason };
    let surfaces = surfaces(&scene.wall, &grains).map_err(unsupported)?;
    let files = deck::files(scene, &grains, &surfaces, &plan, job.purpose).map_err(unsupported)?;
    super::write_files(job.work_folder, files)?;
    let told = if job.purpose == Purpose::Measuring { &surfaces[..] } else { &[] };
    let dumps: Vec<String> = dump_names(scene, &grains, told).collect();
    if job.purpose == Purpose::Measuring {
        super::write_files(job.work_folder, vec![("frames.toml".to_string(), manifest(job.seed, &plan, &dumps))])?;
    }
    Ok(Input { grains, largest_step, plan, dumps })
}

/// Writes a manifest for `makadam measure` with the statements that the dumps of a run lack.
fn manifest(seed: u64, plan: &Plan, dumps: &[String]) -> String {
    let contacts: Vec<&String> = dumps.iter().filter(|name| *name != "grains.dump").collect();
    format!(
        "# Frames of this run: makadam measure frames.toml --scene SCENE\ngrains = [\"grains.dump\"]\ncontacts = {contacts:?}\n\
         time-step = {:e}\ncontacts-complete = true\nfirst-id = 1\nseed = {seed}\n",
        plan.time_step
    )
}

/// The version in the words "... Massively Parallel Simulator - 22 Jul 2025 - Update 4", without the dashes.
fn version_in(words: &str) -> Option<&str> {
    let after = words.split_once("Parallel Simulator - ")?.1;
    after.lines().next().map(str::trim).filter(|version| !version.is_empty())
}

/// Sum of the stepping times of a log, without the time of output, s; numbers that are not finite do not count.
pub fn loop_seconds(log: &str) -> f64 {
    let number = |word: Option<&str>| word.and_then(|word| word.trim().parse::<f64>().ok()).filter(|n| n.is_finite());
    let of = |line: &str| match line.strip_prefix("Loop time of ") {
        Some(rest) => number(rest.split(' ').next()).unwrap_or(0.0),
        // Section, least, mean and largest time of the processes, of which there is one.
        None if line.starts_with("Output ") => -number(line.split('|').nth(2)).unwrap_or(0.0),
        None => 0.0,
    };
    let sum: f64 = log.lines().map(of).sum();
    if sum.is_finite() { sum.max(0.0) } else { 0.0 }
}

/// Names of the dumps: of grains, of pairs, and one for each surface and kind of grain.
fn dump_names(scene: &Scene, grains: &[Grain], surfaces: &[Surface]) -> impl Iterator<Item = String> {
    let meetings = deck::meetings(surfaces, deck::kinds(&Palette::new(scene, grains))).len();
    let walls = (0..meetings).map(|number| format!("wall{number}.dump"));
    ["grains.dump", "pairs.dump"].map(String::from).into_iter().chain(walls)
}

/// The frames that a run of the scene leaves in the dumps of a folder: `grains.dump`, `pairs.dump`, and `wall0.dump` and so on, one for
/// each smooth surface and each material of grains. `time_step` (s) is the largest one that the run may have had; `open` gives a dump.
/// Any bytes are either frames or an error.
///
/// # Errors
/// [`CodeError::Output`] with file and line, [`CodeError::Unsupported`] for a scene that LAMMPS cannot have run, or what `open` says.
pub fn read_frames<R: BufRead>(
    scene: &Scene,
    grains: &[Grain],
    time_step: f64,
    folder: &Path,
    open: impl Fn(&Path) -> Result<R, CodeError>,
) -> Result<Vec<Snapshot>, CodeError> {
    frames_in(scene, grains, time_step, folder, true, open)
}

/// The same; `told` says whether there are dumps of contacts with surfaces.
fn frames_in<R: BufRead>(
    scene: &Scene,
    grains: &[Grain],
    time_step: f64,
    folder: &Path,
    told: bool,
    open: impl Fn(&Path) -> Result<R, CodeError>,
) -> Result<Vec<Snapshot>, CodeError> {
    let plan = Plan::new(scene, time_step);
    let asked = plan.frames();
    let surfaces = if told { surfaces(&scene.wall, grains) } else { Ok(Vec::new()) };
    let surfaces = surfaces.map_err(|reason| CodeError::Unsupported { code: NAME, reason })?;
    let meetings = deck::meetings(&surfaces, deck::kinds(&Palette::new(scene, grains)));
    let fault = |file: &Path, line: usize, problem: String| CodeError::Output {
        code: NAME,
        file: file.to_path_buf(),
        line,
        problem,
    };
    let read = |file: &Path, columns: usize| -> Result<Vec<FrameTable>, CodeError> {
        let mut frames = read_dump(open(file)?, columns).map_err(|found| fault(file, found.line, found.problem))?;
        // Both ends of the run are dumped by two dumps.
        frames.dedup_by_key(|frame| frame.step);
        match frames.iter().filter_map(|frame| frame.step).eq(asked.iter().copied()) {
            true => Ok(frames),
            false => {
                let problem = format!("not the {} frames that were asked for, but {}", asked.len(), frames.len());
                Err(fault(file, 1, problem))
            }
        }
    };
    let dumps: Vec<PathBuf> = dump_names(scene, grains, &surfaces).map(|name| folder.join(name)).collect();
    let states = read(&dumps[0], deck::GRAIN_COLUMNS)?;
    let pairs = read(&dumps[1], deck::PAIR_COLUMNS)?;
    let walls = dumps[2..].iter().map(|dump| read(dump, deck::WALL_COLUMNS)).collect::<Result<Vec<_>, _>>()?;
    let mut frames = Vec::with_capacity(states.len());
    for ((index, state), step) in states.iter().enumerate().zip(&asked) {
        let time = *step as f64 * plan.time_step;
        let particles = particles_of(state, grains).map_err(|(row, what)| fault(&dumps[0], state.line + row, what))?;
        let mut contacts = Vec::new();
        for (row, r) in pairs[index].rows().enumerate() {
            let ids = (particle(&particles, r[0]), particle(&particles, r[1]));
            let (Some(a), Some(b)) = ids else {
                return Err(fault(&dumps[1], pairs[index].line + row, format!("no grains {} and {}", r[0], r[1])));
            };
            contacts.extend(between(a, b, vector(&r[2..]) + vector(&r[5..])));
        }
        for ((meeting, dump), file) in meetings.iter().zip(&walls).zip(&dumps[2..]) {
            let wall = surfaces[meeting.surface].wall as u32;
            for (row, r) in dump[index].rows().enumerate() {
                let Some(a) = particle(&particles, r[0]) else {
                    return Err(fault(file, dump[index].line + row, format!("no grain {}", r[0])));
                };
                let point = vector(&r[4..]);
                let normal = point - Vector3::from(a.position);
                contacts.extend(contact(a, Partner::Wall(wall), point.into(), normal, &r[1..]));
            }
        }
        let contacts = merge_wall_contacts(contacts);
        let frame = Snapshot { time, particles, contacts, ..Snapshot::default() };
        frames.push(measurable(frame).map_err(|problem| fault(&dumps[1], pairs[index].line, problem))?);
    }
    Ok(frames)
}

/// The contact of two grains, from the force on the first; it acts in the middle of the overlap.
fn between(a: &Particle, b: &Particle, force: Vector3<f64>) -> Option<Contact> {
    let (from, to) = (Vector3::from(a.position), Vector3::from(b.position));
    let apart = to - from;
    let overlap = a.radius + b.radius - apart.norm();
    let point = from + apart.try_normalize(0.0)? * (a.radius - 0.5 * overlap);
    contact(a, Partner::Grain(b.id), point.into(), apart, force.as_slice())
}
