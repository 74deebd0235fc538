//! LIGGGHTS: a deck, wall meshes and initial grains go in; dumps and a log come back.

mod deck;
mod turn;
mod walls;

use super::deck_run::{DeckRun, HAS, contact, open, particle, particles_of, vector};
use super::plan::Plan;
use super::process::Program;
use super::{Code, CodeError, HERTZ_MINDLIN, Job, Purpose, supported_start};
use crate::import::{FrameTable, measurable, merge_wall_contacts, read_dump};
use crate::plan::Scene;
use crate::recording::{Content, Recording};
use makadam::scene::Grain;
use makadam::snapshot::{Partner, Snapshot};
use nalgebra::Vector3;
use std::ffi::OsString;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use turn::Turn;
use walls::Walls;

const NAME: &str = "LIGGGHTS";

/// LIGGGHTS, an explicit soft-sphere code.
pub struct Liggghts {
    program: Program,
}

impl Default for Liggghts {
    fn default() -> Self {
        Self { program: Program::from_environment(NAME, "liggghts") }
    }
}

impl Liggghts {
    /// LIGGGHTS under another name or path.
    pub fn new(program: impl Into<OsString>) -> Self {
        Self { program: Program::new(program) }
    }
}

impl Code for Liggghts {
    fn name(&self) -> &'static str {
        NAME
    }

    fn contact_law(&self) -> &'static str {
        HERTZ_MINDLIN
    }

    fn version(&self) -> Option<String> {
        // Without a log, since it would leave one behind wherever it is asked.
        self.program.version(&["-help", "-log", "none"], version_in)
    }

    fn write_input(&self, job: &Job<'_>) -> Result<String, CodeError> {
        write_input(job).map(|_| "liggghts -in deck.in".into())
    }

    fn timing_input(&self) -> Option<&'static str> {
        Some(
            "walls are its primitives where they can be, else coarse meshes, whose contacts are not dumped; skin of half the smallest radius",
        )
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        let version = self.version().ok_or(CodeError::Missing { code: NAME })?;
        let Input { grains, plan, walls, turn } = write_input(job)?;
        let dumps = ["grains", "pairs", "walls"].map(|name| job.work_folder.join(format!("{name}.dump")));
        let run =
            DeckRun { code: NAME, program: self.program.path(), log: "liggghts.log", loop_seconds, dumps: &dumps };
        let told: Vec<usize> = match walls.are_told() {
            true => walls.meshes.iter().map(|(wall, _)| *wall).collect(),
            false => Vec::new(),
        };
        let read = || {
            let frames = frames_in(&grains, &plan, &told, &dumps, open)?;
            Ok(frames.into_iter().map(|frame| turn.frame_back(frame)).collect())
        };
        let recording = run.carry_out(job, version, &plan, read)?;
        let lacks = match job.purpose {
            Purpose::Measuring => Vec::new(),
            Purpose::Timing => vec![Content::WallContacts],
        };
        Ok(Recording { lacks, ..recording })
    }
}

/// What a run is made of, beside its files.
struct Input {
    grains: Vec<Grain>,
    plan: Plan,
    walls: Walls,
    /// The coordinates of the deck and of its dumps.
    turn: Turn,
}

/// Writes deck, grains and meshes into the job's folder.
fn write_input(job: &Job<'_>) -> Result<Input, CodeError> {
    let grains = supported_start(NAME, &HAS, job)?;
    let plan = Plan::new(job.scene, job.rayleigh_fraction * job.scene.rayleigh_step(&grains));
    let (turn, scene, grains) = match job.purpose {
        Purpose::Measuring => (Turn::default(), job.scene.clone(), grains),
        Purpose::Timing => {
            let turn = Turn::of(job.scene);
            (turn, turn.scene(job.scene), turn.grains(&grains))
        }
    };
    let walls = match job.purpose {
        Purpose::Measuring => Walls::measured(&scene, &grains),
        Purpose::Timing => Walls::timed(&scene, &grains),
    };
    let files =
        deck::files(&scene, &grains, &walls, &plan).map_err(|reason| CodeError::Unsupported { code: NAME, reason })?;
    super::write_files(job.work_folder, files)?;
    if job.purpose == Purpose::Measuring {
        super::write_files(job.work_folder, vec![("frames.toml".to_string(), manifest(job.seed, &plan, &walls))])?;
    }
    Ok(Input { grains, plan, walls, turn })
}

/// Writes a manifest for `makadam measure` with the statements that the dumps of a run lack: its local computes have no names of columns.
fn manifest(seed: u64, plan: &Plan, walls: &Walls) -> String {
    let dumps = if walls.are_told() { "\"pairs.dump\", \"walls.dump\"" } else { "\"pairs.dump\"" };
    let meshes: Vec<usize> = walls.meshes.iter().map(|(wall, _)| *wall).collect();
    let list = |names: &str| names.split(',').map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    format!(
        "# Frames of this run: makadam measure frames.toml --scene SCENE\ngrains = [\"grains.dump\"]\ncontacts = [{dumps}]\n\
         time-step = {:e}\ncontacts-complete = true\nfirst-id = 1\nseed = {seed}\nwalls = {meshes:?}\n\n[contact-columns]\nc_pairs = [{}]\nc_walls = [{}]\n",
        plan.time_step,
        list("first,second,_,fx,fy,fz,px,py,pz"),
        list("px,py,pz,_,_,_,wall,_,first,fx,fy,fz")
    )
}

/// The version in the words "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled ...".
fn version_in(words: &str) -> Option<&str> {
    let after = words.split_once("LIGGGHTS-PUBLIC ")?.1;
    after.split([',', ' ', ')']).next().filter(|version| !version.is_empty())
}

/// Sum of the stepping times of a log, without the time of output, s; numbers that are not finite do not count.
pub fn loop_seconds(log: &str) -> f64 {
    let first = |line: &str| line.split_whitespace().find_map(|word| word.parse::<f64>().ok());
    let number = |line: &str| first(line).filter(|number| number.is_finite()).unwrap_or(0.0);
    let sum: f64 = log
        .lines()
        .map(|line| match line.split_once('=') {
            _ if line.starts_with("Loop time of ") => number(line),
            Some((name, value)) if name.starts_with("Outpt time") => -number(value),
            _ => 0.0,
        })
        .sum();
    if sum.is_finite() { sum.max(0.0) } else { 0.0 }
}

/// The frames that a run of the scene leaves in its three dumps: of grains, of pairs of grains, and of grains and walls.
/// `time_step` (s) is the largest one that the run may have had; `open` gives a dump, and is named `path` in errors. Any
/// bytes are either frames or an error.
///
/// # Errors
/// [`CodeError::Output`] with file and line, or what `open` says.
pub fn read_frames<R: BufRead>(
    scene: &Scene,
    grains: &[Grain],
    time_step: f64,
    dumps: &[PathBuf; 3],
    open: impl Fn(&Path) -> Result<R, CodeError>,
) -> Result<Vec<Snapshot>, CodeError> {
    let meshes: Vec<usize> = Walls::measured(scene, grains).meshes.iter().map(|(wall, _)| *wall).collect();
    frames_in(grains, &Plan::new(scene, time_step), &meshes, dumps, open)
}

/// The frames of a plan in the dumps; `meshes` are the walls of the dump of grains and walls, which is not read where there are none.
fn frames_in<R: BufRead>(
    grains: &[Grain],
    plan: &Plan,
    meshes: &[usize],
    dumps: &[PathBuf; 3],
    open: impl Fn(&Path) -> Result<R, CodeError>,
) -> Result<Vec<Snapshot>, CodeError> {
    let asked = plan.frames();
    let fault = |file: &Path, line: usize, problem: String| CodeError::Output {
        code: NAME,
        file: file.to_path_buf(),
        line,
        problem,
    };
    let read = |file: &PathBuf, columns: usize| -> Result<Vec<FrameTable>, CodeError> {
        let mut frames = read_dump(open(file)?, columns).map_err(|found| fault(file, found.line, found.problem))?;
        // Where frames become denser, the step between is dumped by both dumps.
        frames.dedup_by_key(|frame| frame.step);
        match frames.iter().filter_map(|frame| frame.step).eq(asked.iter().copied()) {
            true => Ok(frames),
            false => {
                let problem = format!("not the {} frames that were asked for, but {}", asked.len(), frames.len());
                Err(fault(file, 1, problem))
            }
        }
    };
    let states = read(&dumps[0], deck::GRAIN_COLUMNS)?;
    let pairs = read(&dumps[1], deck::PAIR_COLUMNS)?;
    let walls = match meshes.is_empty() {
        true => Vec::new(),
        false => read(&dumps[2], deck::WALL_COLUMNS)?,
    };
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
            let normal = Vector3::from(b.position) - Vector3::from(a.position);
            contacts.extend(contact(a, Partner::Grain(b.id), vector(&r[6..]).into(), normal, &r[3..]));
        }
        for (row, r) in walls.get(index).into_iter().flat_map(FrameTable::rows).enumerate() {
            let mesh = if r[6] >= 0.0 { meshes.get(r[6] as usize) } else { None };
            let (Some(&wall), Some(a)) = (mesh, particle(&particles, r[8])) else {
                return Err(fault(&dumps[2], walls[index].line + row, format!("no mesh {} or grain {}", r[6], r[8])));
            };
            let point = vector(r);
            let normal = point - Vector3::from(a.position);
            contacts.extend(contact(a, Partner::Wall(wall as u32), point.into(), normal, &r[9..]));
        }
        let contacts = merge_wall_contacts(contacts);
        let frame = Snapshot { time, particles, contacts, ..Snapshot::default() };
        frames.push(measurable(frame).map_err(|problem| fault(&dumps[1], pairs[index].line, problem))?);
    }
    Ok(frames)
}
