//! LIGGGHTS, an explicit soft-sphere code: the deck `deck.in`, mesh files of walls, its log.

mod turn;
mod walls;

use super::deck::{DeckRun, HAS, data, manifest, render, values};
use super::palette::Palette;
use super::plan::Plan;
use super::process::Program;
use super::stl::stl;
use super::{Code, CodeError, HERTZ_MINDLIN, Job, Purpose, supported_start};
use makadam::scene::{Grain, Motion};
use makadam_frames::plan::Scene;
use makadam_frames::recording::Recording;
use minijinja::{Value, context};
use nalgebra::Vector3;
use std::ffi::OsString;
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
        let (plan, turn) = write_input(job)?;
        let run = DeckRun { code: NAME, program: &self.program, log: "liggghts.log", loop_seconds };
        let mut recording = run.execute(job, version, &plan)?;
        recording.frames.iter_mut().for_each(|frame| turn.frame_back(frame));
        Ok(recording)
    }
}

/// Writes deck, grains, meshes and manifest into the job's folder; returns the coordinates of deck and dumps.
fn write_input(job: &Job<'_>) -> Result<(Plan, Turn), CodeError> {
    let grains = supported_start(NAME, &HAS, job)?;
    let plan = Plan::new(job.scene, job.rayleigh_fraction * job.scene.rayleigh_step(&grains));
    let (turn, scene, grains) = match job.purpose {
        Purpose::Measuring => (Turn::default(), job.scene.clone(), grains),
        Purpose::Timing => {
            let turn = Turn::of(job.scene);
            (turn, turn.scene(job.scene), turn.grains(&grains))
        }
    };
    let walls = Walls::new(&scene, &grains, job.purpose);
    let palette = Palette::new(&scene, &grains);
    let deck = deck(&scene, &grains, &walls, &plan, &palette);
    let deck = deck.map_err(|reason| CodeError::Unsupported { code: NAME, reason })?;
    let mut contacts = vec!["pairs.dump".to_string()];
    contacts.extend(walls.are_told().then(|| "walls.dump".into()));
    // Its local computes have no names of columns.
    let numbers: Vec<usize> = walls.meshes.iter().map(|(wall, _)| *wall).collect();
    let list = |names: &str| names.split(',').map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let columns = format!(
        "walls = {numbers:?}\n\n[contact-columns]\nc_pairs = [{}]\nc_walls = [{}]\n",
        list("first,second,_,fx,fy,fz,px,py,pz"),
        list("px,py,pz,_,_,_,wall,_,first,fx,fy,fz")
    );
    let mut files = vec![
        ("deck.in".into(), deck),
        ("grains.data".into(), data(&scene, &grains, &palette, palette.len())),
        manifest(job.seed, &plan, &contacts, &columns),
    ];
    files.extend(walls.meshes.iter().map(|(wall, mesh)| (format!("wall{wall}.stl"), stl(mesh))));
    super::write_files(job.work_folder, files)?;
    Ok((plan, turn))
}

/// Returns the deck.
///
/// # Errors
/// Limit of LIGGGHTS.
fn deck(scene: &Scene, grains: &[Grain], walls: &Walls, plan: &Plan, palette: &Palette<'_>) -> Result<String, String> {
    let entries = || (0..palette.len()).flat_map(|a| (0..palette.len()).map(move |b| (a, b)));
    // Walls never touch each other; the numbers of such a pair have no effect.
    let pairs: Vec<_> = entries().map(|(a, b)| palette.coefficients(a, b)).collect();
    let restitution: Vec<f64> = pairs.iter().map(|pair| pair.map_or(0.5, |pair| pair.restitution)).collect();
    if let Some(low) = restitution.iter().find(|restitution| **restitution <= 0.05) {
        return Err(format!("it takes restitution above 0.05 only, not {low}"));
    }
    let kind = |wall: usize| palette.index(&scene.wall[wall].material, true) + 1;
    let meshes = walls.meshes.iter().map(|(wall, mesh)| {
        // Contacts keep their history from one triangle of a curved surface to the next.
        let curved = || format!(" curvature {:.6} curvature_tolerant yes", 1.2 * mesh.bend);
        let curvature = if mesh.bend > 0.0 { curved() } else { String::new() };
        context! { wall, kind => kind(*wall), curvature }
    });
    let primitives = walls.primitives.iter().map(|(wall, words)| context! { kind => kind(*wall), words });
    let own = context! {
        young => palette.materials().map(|material| material.youngs_modulus).collect::<Vec<_>>(),
        poisson => palette.materials().map(|material| material.poisson_ratio).collect::<Vec<_>>(),
        friction => pairs.iter().map(|pair| pair.map_or(0.0, |pair| pair.friction)).collect::<Vec<_>>(),
        restitution,
        rolling => pairs.iter().map(|pair| pair.map_or(0.0, |pair| pair.rolling_friction)).collect::<Vec<_>>(),
        meshes => meshes.collect::<Vec<_>>(),
        primitives => primitives.collect::<Vec<_>>(),
        tables => tables(walls.are_told()),
        pieces => pieces(scene, walls, plan),
    };
    Ok(render(include_str!("deck.in"), context! { ..own, ..values(scene, grains, plan, walls.purpose) }))
}

/// Returns the dumps: grains; contacts between grains, with three ids, force on the first grain and contact point; contacts with walls, with
/// point on the wall, centre of the grain, three ids and force on the grain (the keyword `contactPoint` gives zeros there).
fn tables(walls: bool) -> Vec<Value> {
    let local = |name: &str, count: usize| {
        let columns = (1..=count).map(|at| format!(" c_{name}[{at}]")).collect::<String>();
        context! { name, style => "local", columns, formats => vec!["%.12g"; count].join(" ") }
    };
    let columns = " id x y z vx vy vz omegax omegay omegaz";
    let formats = format!("%d{}", " %.12g".repeat(9));
    let mut tables = vec![context! { name => "grains", style => "custom", columns, formats }, local("pairs", 9)];
    tables.extend(walls.then(|| local("walls", 12)));
    tables
}

/// Returns the runs between the times at which walls start or stop or frames become denser.
fn pieces(scene: &Scene, walls: &Walls, plan: &Plan) -> Vec<Value> {
    let mut dumping = 0;
    let ends = plan.fine_from == plan.steps;
    let boundaries = plan.boundaries(scene);
    let piece = |[at, next]: &[u64; 2]| {
        let moves = walls.meshes.iter().map(|(wall, _)| {
            let motion = &scene.wall[*wall].motion;
            let phases = plan.phases(motion);
            let first = phases.iter().find(|phase| phase.first == *at);
            let starts = first.and_then(|phase| motion_words(motion, phase.direction));
            context! { wall, stops => phases.iter().any(|phase| phase.last == *at), starts }
        });
        let moves: Vec<Value> = moves.collect();
        let every = if *at >= plan.fine_from && !ends { plan.fine } else { plan.coarse };
        let mut dumps = Vec::new();
        if every != dumping {
            dumps.push(context! { tag => "", every, replaces => dumping != 0 });
            dumping = every;
        }
        // A dump whose interval is the whole run adds the last frame where the interval misses it.
        if *next == plan.steps && !plan.steps.is_multiple_of(every) {
            dumps.push(context! { tag => "last", every => plan.steps, replaces => false });
        }
        context! { moves, dumps, steps => next - at }
    };
    boundaries.array_windows().map(piece).collect()
}

/// Returns a motion as `fix move/mesh` takes it; none for a wall at rest.
fn motion_words(motion: &Motion, direction: f64) -> Option<String> {
    Some(match motion {
        Motion::Fixed | Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => return None,
        Motion::Translating { velocity: [x, y, z], .. } => format!("linear {x:.17e} {y:.17e} {z:.17e}"),
        Motion::Rotating { point: [x, y, z], axis, rate, .. } => {
            let rate = direction * rate;
            // The period has no sign: the axis of a wall that turns backwards is reversed.
            let [a, b, c]: [f64; 3] = (Vector3::from(*axis).normalize() * rate.signum()).into();
            let period = std::f64::consts::TAU / rate.abs().max(1e-12);
            format!("rotate origin {x:.17e} {y:.17e} {z:.17e} axis {a:.17e} {b:.17e} {c:.17e} period {period:.17e}")
        }
        Motion::Vibrating { amplitude: [x, y, z], frequency, .. } => {
            let period = 1.0 / frequency.max(1e-12);
            format!("wiggle amplitude {x:.17e} {y:.17e} {z:.17e} period {period:.17e}")
        }
    })
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
