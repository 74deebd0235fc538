//! Codes with a deck and dumps, LIGGGHTS and LAMMPS: grains and values of the decks, a run, and the frames in its dumps.

use super::input::{Palette, Plan};
use super::process::{Program, Run, disk_has_room, ending, io};
use super::{CodeError, Job, Purpose};
use makadam::effects::catalogue::{
    COMPLIANCE, Effect, FRICTION, GRAVITY, RESTITUTION, ROLLING, SIZE_SPREAD, SPIN, TANGENTIAL_SPRING, VISCOSITY,
    WALL_MOTION,
};
use makadam::scene::{Grain, Reaction};
use makadam::snapshot::Snapshot;
use makadam_frames::import::{ImportError, Manifest, Tables, assemble};
use makadam_frames::output::mesh::reach;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::{Content, Recording};
use minijinja::{Environment, UndefinedBehavior, Value, context};
use nalgebra::Vector3;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::Path;

/// Effects that the decks of both codes express; a scene with any other effect is refused. Three effects of LIGGGHTS differ from the scene's:
/// its servo wall has a controller instead of a mass; the attraction of its cohesion scales with the area of the overlap; its twisting
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

/// Skin of the neighbour list over the smallest radius, which affects speed alone. With the second value packing, drum and heap are fastest,
/// within 3%.
const SKIN: f64 = 0.25;
const FASTEST_SKIN: f64 = 0.5;

/// Most bins per grain. Both codes clear all bins at each rebuild: a single grain in 2 m of air took LIGGGHTS 300 times as long with bins of
/// its own size.
const MOST_BINS: f64 = 100.0;

/// Number of progress lines in the log.
const REPORTS: u64 = 100;

/// File that states the data that the dumps of a run lack.
const MANIFEST: &str = "frames.toml";

/// Renders a deck. Filters print numbers: `e` with the fewest digits, `full` and `row` with 17, `row` a list of them.
pub(super) fn render(template: &str, values: Value) -> String {
    let mut engine = Environment::new();
    engine.set_trim_blocks(true);
    engine.set_lstrip_blocks(true);
    engine.set_keep_trailing_newline(true);
    engine.set_undefined_behavior(UndefinedBehavior::Strict);
    engine.add_filter("e", |number: f64| format!("{number:e}"));
    engine.add_filter("full", |number: f64| format!("{number:.17e}"));
    engine.add_filter("row", |row: Vec<f64>| row.iter().map(|number| format!(" {number:.17e}")).collect::<String>());
    engine.render_str(template, values).expect("a deck has all values that its template names")
}

/// Values of both decks.
pub(super) fn values(scene: &MeasuredScene, grains: &[Grain], plan: &Plan, purpose: Purpose) -> Value {
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let skin = smallest
        * match purpose {
            Purpose::Measuring => SKIN,
            Purpose::Timing => FASTEST_SKIN,
        };
    let gravity = Vector3::from(scene.gravity);
    context! {
        // The box is fixed, and a grain that leaves ends the run; where the scene lets grains escape, the box grows with them.
        boundary => match scene.watch.on_escape {
            Reaction::Stop => "f f f",
            Reaction::Warn | Reaction::Ignore => "m m m",
        },
        skin,
        bin_size => wide_bins(scene, grains, skin),
        time_step => plan.time_step,
        gravity => gravity.norm(),
        down => gravity.try_normalize(0.0).map(<[f64; 3]>::from),
        reports => (plan.steps / REPORTS).max(1),
    }
}

/// Size of bins where the codes' own size, half the cutoff of their lists, would give too many, m.
fn wide_bins(scene: &MeasuredScene, grains: &[Grain], skin: f64) -> Option<f64> {
    let limits = reach(&scene.domain);
    let volume: f64 = (0..3).map(|axis| limits.max[axis] - limits.min[axis]).product();
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    let usual = largest + 0.5 * skin;
    let sparing = (volume / (MOST_BINS * grains.len() as f64)).cbrt();
    (sparing > usual).then_some(sparing)
}

/// Grains as atoms of `kinds` types. The simulation box contains all walls.
pub(super) fn data(scene: &MeasuredScene, grains: &[Grain], palette: &Palette<'_>, kinds: usize) -> String {
    let limits = reach(&scene.domain);
    let mut text = format!("Initial grains\n\n{} atoms\n{kinds} atom types\n", grains.len());
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let (low, high) = (limits.min[axis], limits.max[axis]);
        let margin = 0.05 * (high - low);
        let _ = writeln!(text, "{:e} {:e} {name}lo {name}hi", low - margin, high + margin);
    }
    text += "\nAtoms\n\n";
    for (index, grain) in grains.iter().enumerate() {
        let [x, y, z] = grain.position;
        let kind = palette.index(&grain.material, false) + 1;
        let (diameter, density) = (2.0 * grain.radius, scene.material[&grain.material].density);
        let _ = writeln!(text, "{} {kind} {diameter:e} {density:e} {x:e} {y:e} {z:e}", index + 1);
    }
    text += "\nVelocities\n\n";
    for (index, grain) in grains.iter().enumerate() {
        let ([u, v, w], [p, q, r]) = (grain.velocity, grain.spin);
        let _ = writeln!(text, "{} {u:e} {v:e} {w:e} {p:e} {q:e} {r:e}", index + 1);
    }
    text
}

/// Manifest of the dumps of a run, with its name; `contacts` are dumps, `further` are keys of one code.
pub(super) fn manifest(seed: u64, plan: &Plan, contacts: &[String], further: &str) -> (String, String) {
    let text = format!(
        "# Frames of this run: makadam measure {MANIFEST} --scene SCENE\ngrains = [\"grains.dump\"]\ncontacts = {contacts:?}\n\
         time-step = {:e}\ncontacts-complete = true\nfirst-id = 1\nseed = {seed}\n{further}",
        plan.time_step
    );
    (MANIFEST.into(), text)
}

/// Run of a code, with its program and its log.
pub(super) struct DeckRun<'a> {
    pub code: &'static str,
    pub program: &'a Program,
    /// Name of the file for printed output.
    pub log: &'static str,
    /// Reads the wall time of the stepping from the code's own log, without output, s.
    pub loop_seconds: fn(&str) -> f64,
}

impl DeckRun<'_> {
    /// Runs `deck.in` in the job's folder, reads its dumps and removes them.
    ///
    /// # Errors
    /// [`CodeError`]; files of the code stay in the job's folder.
    pub fn execute(&self, job: &Job<'_>, version: String, plan: &Plan) -> Result<Recording, CodeError> {
        let folder = job.work_folder;
        let refused = |ImportError { file, line, problem }| CodeError::Output { code: self.code, file, line, problem };
        let manifest = Manifest::load(&folder.join(MANIFEST)).map_err(refused)?;
        let dumps = manifest.grains.iter().chain(&manifest.contacts);
        let remove = || dumps.clone().for_each(|dump| _ = std::fs::remove_file(folder.join(dump.text())));
        remove();
        let engine_log = folder.join("engine.log");
        let core_share = Run {
            code: self.code,
            program: &self.program.path,
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
        let frames = frames(job.scene, &manifest).map_err(refused)?;
        let wrong = |problem: String| {
            let file = folder.join("grains.dump");
            CodeError::Output { code: self.code, file, line: 1, problem }
        };
        let times = plan.frames().into_iter().map(|step| step as f64 * plan.time_step);
        if !times.clone().eq(frames.iter().map(|frame| frame.time)) {
            let problem = format!("not the {} frames that were asked for, but {}", times.count(), frames.len());
            return Err(wrong(problem));
        }
        let count = job.scene.grain_count();
        if let Some(frame) = frames.iter().find(|frame| frame.particles.len() != count) {
            let left = frame.particles.len();
            return Err(wrong(format!(
                "{left} of {count} grains at {} s: the others have left the domain",
                frame.time
            )));
        }
        let text = std::fs::read(&engine_log).map_err(|source| io(&engine_log, source))?;
        remove();
        (job.progress)(1.0);
        let wall_seconds = (self.loop_seconds)(&String::from_utf8_lossy(&text));
        let core_seconds = core_share.map(|share| share * wall_seconds);
        let lacks = match job.purpose {
            Purpose::Measuring => Vec::new(),
            Purpose::Timing => vec![Content::WallContacts],
        };
        Ok(Recording { core_seconds, lacks, ..plan.recording(self.code, version, job, wall_seconds, frames) })
    }
}

/// Reads the frames that a manifest names.
fn frames(scene: &MeasuredScene, manifest: &Manifest) -> Result<Vec<Snapshot>, ImportError> {
    let mut tables = Tables::read(manifest)?;
    // These lists are complete, as those of Makadam are, and list a grain on the edge of two triangles once per triangle.
    tables.grains.iter_mut().chain(&mut tables.contacts).for_each(|table| table.first_id = manifest.first_id);
    Ok(assemble(scene, manifest, &tables)?.frames)
}

/// Reads the last step in a log.
fn last_step(log: &Path) -> Option<u64> {
    let text = ending(log);
    text.lines().rev().find_map(|line| {
        let mut words = line.split_whitespace().map(str::parse::<f64>);
        match (words.next(), words.next(), words.next(), words.next()) {
            (Some(Ok(step)), Some(Ok(_)), Some(Ok(_)), None) => Some(step as u64),
            _ => None,
        }
    })
}

#[cfg(test)]
#[path = "../../tests/unit/codes_deck.rs"]
mod tests;
