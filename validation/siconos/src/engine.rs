//! Siconos as one of the codes: a scene of spheres in boxes at rest, stepped by a script in Debian's Python, its frames as a
//! recording.
//!
//! Siconos steps with Moreau and Jean's scheme, as Makadam does, and solves the contact problem of each step by projected
//! Gauss-Seidel (NSGS) until the error of its own measure, relative to the free velocities, is below a tolerance. Its grains
//! are rigid, its restitution is Newton's, its contacts are found by Bullet.

use makadam::effects::catalogue::{
    COMPLIANCE, Effect, FRICTION, GRAVITY, RESTITUTION, SIZE_SPREAD, SPIN, TANGENTIAL_SPRING, VISCOSITY,
};
use makadam::scene::{Grain, Motion, Shape, populate};
use makadam_validation::peers::yade::{read_frames, read_result};
use makadam_validation::peers::{Code, CodeError, Job, refuse_effects};
use makadam_validation::plan::Scene;
use makadam_validation::recording::Recording;
use makadam_validation::scenes::in_file;
use makadam_validation::stepping::{frame_is_due, steps_in};
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Name in tables.
pub const NAME: &str = "Siconos";

const DRIVER: &str = include_str!("driver.py");
const ASSERTIONS_OFF: &str = include_str!("assertions_off.c");

/// Iterations at which a solve is given up.
const MOST_ITERATIONS: u32 = 10_000;

/// Effects that a scene may have; a scene with any other effect is refused. Its contacts are rigid, in place of the scene's compliance, viscosity and tangential spring.
const HAS: [&Effect; 8] =
    [&GRAVITY, &SIZE_SPREAD, &COMPLIANCE, &VISCOSITY, &RESTITUTION, &FRICTION, &TANGENTIAL_SPRING, &SPIN];

/// What is varied.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Time step, s.
    pub step: f64,
    /// Relative error at which a solve stops.
    pub tolerance: f64,
    /// Whether Siconos runs as Debian packages it, with assertions that walk its graphs.
    pub assertions: bool,
}

impl Settings {
    /// Step and tolerance, and whether assertions are on.
    pub fn words(&self) -> String {
        let assertions = if self.assertions { ", with assertions" } else { "" };
        format!("{} ms, tolerance {:e}{assertions}", milliseconds(self.step), self.tolerance)
    }

    /// The same where there is little room.
    pub fn short_words(&self) -> String {
        let assertions = if self.assertions { ", assertions" } else { "" };
        format!("{} ms, {:e}{assertions}", milliseconds(self.step), self.tolerance)
    }
}

/// To three decimals, without trailing zeros.
fn milliseconds(seconds: f64) -> f64 {
    (1e6 * seconds).round() / 1e3
}

/// Siconos with some settings.
pub struct Siconos {
    /// The settings.
    pub settings: Settings,
    /// Version of the package.
    pub version: String,
}

/// The Python that has Siconos: Debian's, unless the environment says otherwise.
fn python() -> OsString {
    std::env::var_os("MAKADAM_SICONOS_PYTHON").unwrap_or_else(|| "/usr/bin/python3".into())
}

/// Version of the package, or why it cannot be used.
///
/// # Errors
/// What is wrong, in words.
pub fn installed() -> Result<String, String> {
    let asked =
        "import siconos.kernel, siconos.mechanics.collision.bullet; from siconos import version; print(version)";
    let python = python();
    let output = Command::new(&python).args(["-c", asked]).stdin(Stdio::null()).output();
    let output = output.map_err(|error| format!("{}: {error}", python.display()))?;
    let (text, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    match output.status.success() {
        true => Ok(text.trim().into()),
        false => Err(format!(
            "{} has no Siconos with Bullet: {}; install Debian's python3-siconos, or name another Python in \
             MAKADAM_SICONOS_PYTHON",
            python.display(),
            errors.lines().last().unwrap_or_default()
        )),
    }
}

#[derive(Serialize)]
struct JobFile {
    time_step: f64,
    steps: u64,
    frames: Vec<u64>,
    gravity: [f64; 3],
    friction: f64,
    restitution: f64,
    tolerance: f64,
    most_iterations: u32,
    grains: Vec<GrainEntry>,
    planes: Vec<PlaneEntry>,
}

#[derive(Serialize)]
struct GrainEntry {
    radius: f64,
    mass: f64,
    position: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
}

/// A face of a box, seen from inside.
#[derive(Serialize)]
struct PlaneEntry {
    /// Place of the wall in the scene.
    wall: usize,
    point: [f64; 3],
    /// Unit vector into the box.
    normal: [f64; 3],
}

impl Code for Siconos {
    fn name(&self) -> &'static str {
        NAME
    }

    fn version(&self) -> Option<String> {
        Some(self.version.clone())
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        let scene = job.scene;
        let grains = populate(scene, job.seed).map_err(in_file(job.scene_file))?;
        let step = self.settings.step;
        let steps = steps_in(scene.duration, step);
        let (friction, restitution) = coefficients(scene, &grains)?;
        let due = |number: &u64| *number == steps || frame_is_due(*number, step, scene.measure.interval);
        let file = JobFile {
            time_step: step,
            steps,
            frames: std::iter::once(0).chain((1..=steps).filter(due)).collect(),
            gravity: scene.gravity,
            friction,
            restitution,
            tolerance: self.settings.tolerance,
            most_iterations: MOST_ITERATIONS,
            planes: planes(scene)?,
            grains: grains.iter().map(|grain| entry(scene, grain)).collect(),
        };
        let folder = job.work_folder;
        let io = |path: &Path, source| CodeError::Io { path: path.display().to_string(), source };
        std::fs::create_dir_all(folder).map_err(|source| io(folder, source))?;
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.join(name);
            std::fs::write(&path, bytes).map_err(|source| io(&path, source))
        };
        let text = serde_json::to_vec(&file).map_err(|error| io(&folder.join("job.json"), error.into()))?;
        write("job.json", &text)?;
        write("driver.py", DRIVER.as_bytes())?;
        let mut command = Command::new(python());
        if !self.settings.assertions {
            write("assertions_off.c", ASSERTIONS_OFF.as_bytes())?;
            command.env("LD_PRELOAD", library(folder)?);
        }
        let output = command
            .args(["driver.py", "job.json"])
            .current_dir(folder)
            .env("OMP_NUM_THREADS", "1")
            .env("OPENBLAS_NUM_THREADS", "1")
            .stdin(Stdio::null())
            .output()
            .map_err(|source| io(Path::new(&python()), source))?;
        let log = folder.join("siconos.log");
        write("siconos.log", &[output.stdout, output.stderr].concat())?;
        if !output.status.success() {
            let text = std::fs::read_to_string(&log).unwrap_or_default();
            let tail = text.lines().rev().take(5).collect::<Vec<_>>().into_iter().rev().collect::<Vec<_>>().join(" / ");
            return Err(CodeError::Crashed { code: NAME, status: output.status.to_string(), log, tail });
        }
        let read = |name: &str| {
            let path = folder.join(name);
            std::fs::read(&path).map_err(|source| io(&path, source))
        };
        let wrong =
            |name: &str, problem: String| CodeError::Output { code: NAME, file: folder.join(name), line: 1, problem };
        let result = read_result(&read("result.json")?).map_err(|problem| wrong("result.json", problem))?;
        let radii: Vec<f64> = grains.iter().map(|grain| grain.radius).collect();
        let frames = read_frames(&read("frames.bin")?, &radii, scene.wall.len())
            .map_err(|problem| wrong("frames.bin", problem))?;
        if result.steps != steps || frames.len() != file.frames.len() {
            return Err(wrong("frames.bin", format!("{} frames after {} steps", frames.len(), result.steps)));
        }
        (job.progress)(1.0);
        Ok(Recording {
            scene: scene.name.clone(),
            code: NAME.into(),
            version: self.version.clone(),
            seed: job.seed,
            time_step: step,
            rayleigh_fraction: None,
            stiffness_factor: job.stiffness_factor,
            threads: 1,
            wall_seconds: result.seconds,
            core_seconds: None,
            simulated_seconds: steps as f64 * step,
            frames,
            lacks: Vec::new(),
            alarms: Vec::new(),
            notes: Vec::new(),
        })
    }
}

/// Compiles what turns the assertions of the graphs off.
fn library(folder: &Path) -> Result<PathBuf, CodeError> {
    let library = folder.join("assertions_off.so");
    let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
    let output = Command::new(&compiler)
        .args(["-O2", "-shared", "-fPIC", "-o", "assertions_off.so", "assertions_off.c"])
        .current_dir(folder)
        .output()
        .map_err(|source| CodeError::Io { path: compiler.display().to_string(), source })?;
    match output.status.success() {
        // The path must hold wherever the program is started.
        true => library.canonicalize().map_err(|source| CodeError::Io { path: library.display().to_string(), source }),
        false => Err(CodeError::Crashed {
            code: NAME,
            status: output.status.to_string(),
            log: folder.join("assertions_off.c"),
            tail: String::from_utf8_lossy(&output.stderr).into_owned(),
        }),
    }
}

fn entry(scene: &Scene, grain: &Grain) -> GrainEntry {
    let volume = 4.0 / 3.0 * std::f64::consts::PI * grain.radius.powi(3);
    GrainEntry {
        radius: grain.radius,
        mass: scene.material[&grain.material].density * volume,
        position: grain.position,
        velocity: grain.velocity,
        spin: grain.spin,
    }
}

fn refuse<T>(reason: String) -> Result<T, CodeError> {
    Err(CodeError::Unsupported { code: NAME, reason })
}

/// Friction and restitution, which are the same at all contacts: one law is given to Siconos.
fn coefficients(scene: &Scene, grains: &[Grain]) -> Result<(f64, f64), CodeError> {
    refuse_effects(NAME, &HAS, scene, grains)?;
    if scene.prepare.is_some() {
        return refuse("it starts from a prepared state".into());
    }
    let mut pairs = Vec::new();
    for grain in grains {
        let others = grains.iter().map(|other| (other.material.as_str(), false));
        let walls = scene.wall.iter().map(|wall| (wall.material.as_str(), true));
        // Materials of grains repeat; the first grain of each is enough.
        if pairs.iter().any(|(name, _)| *name == grain.material) {
            continue;
        }
        let all: Vec<(f64, f64)> = (others.take(grains.len()).chain(walls))
            .map(|(other, wall)| {
                let pair = scene.contact_coefficients(&grain.material, other, wall);
                (pair.friction, pair.restitution)
            })
            .collect();
        pairs.push((grain.material.clone(), all));
    }
    let mut all = pairs.into_iter().flat_map(|(_, all)| all);
    match all.next() {
        None => refuse("it has no grains".into()),
        Some(first) if all.all(|other| other == first) => Ok(first),
        Some(_) => refuse("friction or restitution differ from contact to contact".into()),
    }
}

/// The closed faces of all boxes.
fn planes(scene: &Scene) -> Result<Vec<PlaneEntry>, CodeError> {
    let mut planes = Vec::new();
    for (place, wall) in scene.wall.iter().enumerate() {
        let (Shape::Box { min, max, open }, Motion::Fixed) = (&wall.shape, &wall.motion) else {
            return refuse(format!("the wall {} is not a box at rest", wall.name));
        };
        for axis in 0..3 {
            for (inward, face) in [(1.0, min), (-1.0, max)] {
                let name = format!("{}{}", if inward > 0.0 { '-' } else { '+' }, ["x", "y", "z"][axis]);
                if open.contains(&name) {
                    continue;
                }
                let mut normal = [0.0; 3];
                normal[axis] = inward;
                planes.push(PlaneEntry { wall: place, point: *face, normal });
            }
        }
    }
    Ok(planes)
}
