//! YADE: a job file for `yade_driver.py`, which runs inside YADE.

use super::driver::{Driver, RunResult, motion_entry};
use super::input::{Palette, Plan, Primitive, primitives};
use super::process::{Program, installed, io};
use super::yade_rolling::{Rolling, rolling};
use super::{Code, CodeError, HERTZ_MINDLIN, Job, Purpose, supported_start};
use makadam::effects::SURFACE_VELOCITY;
use makadam::effects::catalogue::{
    COHESION, COMPLIANCE, DRIVEN_WALLS, Effect, FRICTION, GRAVITY, RESTITUTION, ROLLING, SIZE_SPREAD, SPIN,
    TANGENTIAL_SPRING, VISCOSITY, WALL_MOTION,
};
use makadam::scene::{Cohesion, Grain, Material, Motion, Wall};
use makadam::snapshot::{DrivenWall, Snapshot};
use makadam_frames::output::mesh::{COARSE, FINE, Mesh, Triangle, wall_mesh};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use nalgebra::Vector3;
use serde_json::{Value, json};

const NAME: &str = "YADE";
/// Effects that its input expresses; a scene with any other effect is refused.
pub(super) const HAS: [&Effect; 13] = [
    &GRAVITY,
    &WALL_MOTION,
    &SURFACE_VELOCITY,
    &DRIVEN_WALLS,
    &SIZE_SPREAD,
    &COMPLIANCE,
    &VISCOSITY,
    &RESTITUTION,
    &FRICTION,
    &TANGENTIAL_SPRING,
    &SPIN,
    &COHESION,
    &ROLLING,
];
const DRIVER: &str = include_str!("yade_driver.py");

/// Cutoff of YADE's candidate list over the smallest radius, which affects speed alone. With the second value packing and drum are
/// fastest.
const VERLET_DISTANCE: f64 = 0.2;
const FASTEST_VERLET_DISTANCE: f64 = 0.3;

/// Doubles of a dynamic wall in a frame.
const DRIVEN_ROW: usize = 2;

installed!(
    /// YADE, an explicit soft-sphere code.
    Yade,
    "yade"
);

impl Code for Yade {
    fn name(&self) -> &'static str {
        NAME
    }

    fn contact_law(&self) -> &'static str {
        HERTZ_MINDLIN
    }

    fn timing_input(&self) -> Option<&'static str> {
        Some(
            "fixed planes across an axis are its walls, curved walls coarse meshes; candidates reach 0.3 of the smallest radius",
        )
    }

    fn version(&self) -> Option<String> {
        self.program.version(&["--version"], version_in)
    }

    fn write_input(&self, job: &Job<'_>) -> Result<String, CodeError> {
        write_input(job).map(|_| "yade -j1 -n -x yade_driver.py job.json".into())
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        let version = self.version().ok_or(CodeError::Missing { code: NAME })?;
        let (scene, folder) = (job.scene, job.work_folder);
        Driver::clear(folder);
        let (grains, plan) = write_input(job)?;
        let radii: Vec<f64> = grains.iter().map(|grain| grain.radius).collect();
        let arguments = &["-j1", "-n", "-x", "yade_driver.py", "job.json"];
        let driver = Driver { code: NAME, program: &self.program, arguments, log: "yade.log" };
        let (result, mut frames) = driver.execute(job, &plan, &radii)?;
        let driven_path = folder.join("driven.bin");
        let bytes = std::fs::read(&driven_path).map_err(|source| io(&driven_path, source))?;
        let driven: Vec<u32> =
            (0..).zip(&scene.wall).filter(|(_, wall)| wall.motion.is_driven()).map(|(index, _)| index).collect();
        read_driven_walls(&bytes, &driven, &mut frames).map_err(|what| driver.problem(&driven_path, what))?;
        let _ = std::fs::remove_file(&driven_path);
        (job.progress)(1.0);
        let RunResult { seconds, core_seconds, .. } = result;
        Ok(Recording { core_seconds, ..plan.recording(NAME, version, job, seconds, frames) })
    }
}

/// Writes job and driver into the job's folder: the grains and the steps of the run.
fn write_input(job: &Job<'_>) -> Result<(Vec<Grain>, Plan), CodeError> {
    let scene = &job.scene.with_own_motions();
    let job = &Job { scene, ..*job };
    let grains = supported_start(NAME, &HAS, job)?;
    let unsupported = |reason: String| CodeError::Unsupported { code: NAME, reason };
    if scene.wall.iter().any(|wall| matches!(wall.motion, Motion::TorqueDriven { .. })) {
        return Err(unsupported("a wall is driven by a torque".into()));
    }
    if let Some(wall) = scene.wall.iter().find(|wall| is_belt(wall) && wall.motion != Motion::Fixed) {
        return Err(unsupported(format!("wall '{}' moves and has a surface velocity", wall.name)));
    }
    if let Some(wall) = scene.wall.iter().find(|wall| !belt_runs_along(wall, scene)) {
        return Err(unsupported(format!(
            "the surface velocity of wall '{}' is not along all its triangles",
            wall.name
        )));
    }
    let plan = Plan::new(scene, job.rayleigh_fraction * scene.rayleigh_step(&grains));
    let palette = Palette::new(scene, &grains);
    let rolling = rolling(&palette, &grains).map_err(unsupported)?;
    let cohesion = surface_energy(&palette).map_err(unsupported)?;
    let text = job_file(job, &grains, &plan, &palette, (rolling, cohesion)).to_string();
    super::write_files(job.work_folder, [("job.json", text.as_str()), ("yade_driver.py", DRIVER)])?;
    Ok((grains, plan))
}

/// Largest component of a surface velocity along the normal of a triangle, over its magnitude.
const ALONG: f64 = 1e-6;

fn is_belt(wall: &Wall) -> bool {
    wall.surface_velocity != [0.0; 3]
}

/// Returns true if a surface velocity lies in the planes of all triangles of its wall. YADE takes the whole velocity, the scene its
/// component along the surface.
fn belt_runs_along(wall: &Wall, scene: &MeasuredScene) -> bool {
    let velocity = Vector3::from(wall.surface_velocity);
    let is_along = |triangle: &Triangle| {
        let [a, b, c] = triangle.map(Vector3::from);
        let normal = (b - a).cross(&(c - a));
        normal.dot(&velocity).abs() <= ALONG * normal.norm() * velocity.norm()
    };
    !is_belt(wall) || wall_mesh(&wall.shape, &scene.domain, 1.0, COARSE).triangles.iter().all(is_along)
}

/// Finds the version in "Yade version: 2023.02a".
fn version_in(words: &str) -> Option<&str> {
    words.split_once("ersion:")?.1.split_whitespace().next()
}

/// Cohesion in YADE's terms: an attraction of `4 pi gamma R*` during contact (Derjaguin, Muller & Toporov), which is the pull-off force
/// `3/2 pi w R*` for `gamma = 3 w / 8`. The value is one number for all contacts, without a range.
fn surface_energy(palette: &Palette<'_>) -> Result<Option<f64>, String> {
    let mut all = palette.pairs().map(|(_, _, pair)| pair.cohesion);
    match all.next().flatten() {
        first if !all.all(|other| other == first) => Err("it has one surface energy for all contacts".into()),
        None => Ok(None),
        Some(Cohesion::SurfaceEnergy { work, range: Some(0.0) }) => Ok(Some(0.375 * work)),
        Some(Cohesion::SurfaceEnergy { .. }) => Err("its pull ends where contact ends: give cohesion range = 0".into()),
        Some(Cohesion::Constant { .. }) => Err("its pull goes with the radius: give cohesion as surface-energy".into()),
    }
}

/// Returns the job file of the driver.
fn job_file(
    job: &Job<'_>,
    grains: &[Grain],
    plan: &Plan,
    palette: &Palette<'_>,
    (rolling, cohesion): (Option<Rolling>, Option<f64>),
) -> Value {
    let scene = job.scene;
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let reach = match job.purpose {
        Purpose::Measuring => VERLET_DISTANCE,
        Purpose::Timing => FASTEST_VERLET_DISTANCE,
    };
    let material =
        |of: &Material| json!({ "young": of.youngs_modulus, "poisson": of.poisson_ratio, "density": of.density });
    let grain = |grain: &Grain| {
        json!({
            "material": palette.index(&grain.material, false),
            "radius": grain.radius,
            "position": grain.position,
            "velocity": grain.velocity,
            "spin": grain.spin,
        })
    };
    let wall = |(wall, (mesh, planes)): (&Wall, Surfaces)| {
        let phases = plan.phases(&wall.motion);
        json!({
            "material": palette.index(&wall.material, true),
            // Triangles that approximate a curved surface.
            "curved": mesh.bend > 0.0,
            "triangles": mesh.triangles,
            "planes": planes,
            "belt": is_belt(wall).then_some(wall.surface_velocity),
            "motions": phases.iter().filter_map(|phase| motion_entry(&wall.motion, phase)).collect::<Vec<_>>(),
            "drive": drive_entry(&wall.motion, plan),
        })
    };
    let walls = scene.wall.iter().zip(surfaces(job, grains, rolling.is_some())).map(wall);
    // Two materials, friction angle (radians), restitution.
    let pairs = palette.pairs().map(|(a, b, pair)| (a, b, pair.friction.atan(), pair.restitution));
    json!({
        "time_step": plan.time_step,
        "steps": plan.steps,
        "frames": plan.frames(),
        "gravity": scene.gravity,
        "verlet_distance": smallest * reach,
        "materials": palette.materials().map(material).collect::<Vec<_>>(),
        "pairs": pairs.collect::<Vec<_>>(),
        "rolling": rolling,
        // Surface energy of all contacts, J/m2.
        "cohesion": cohesion,
        "grains": grains.iter().map(grain).collect::<Vec<_>>(),
        "walls": walls.collect::<Vec<_>>(),
    })
}

/// Triangles of a wall, and its endless planes across an axis: the axis, 0 to 2, and their position on it, m.
type Surfaces = (Mesh, Vec<(usize, f64)>);

/// Surfaces of each wall: triangles; for timing, planes instead where a wall consists of planes. Planes resist rolling otherwise than
/// facets do; the coefficient accounts for the difference.
fn surfaces(job: &Job<'_>, grains: &[Grain], rolls: bool) -> Vec<Surfaces> {
    let Job { scene, purpose, .. } = job;
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let (fineness, found) = match purpose {
        Purpose::Measuring => (FINE, vec![Vec::new(); scene.wall.len()]),
        Purpose::Timing => (COARSE, primitives(scene, grains)),
    };
    let plane = |primitive: &Primitive| match *primitive {
        Primitive::Plane { axis, at } if !rolls => Some((axis, at)),
        Primitive::Plane { .. } | Primitive::Cylinder { .. } => None,
    };
    let of = |(wall, found): (&Wall, &Vec<Primitive>)| {
        let planes: Vec<_> = found.iter().filter_map(plane).collect();
        let mesh = planes.is_empty().then(|| wall_mesh(&wall.shape, &scene.domain, smallest, fineness));
        (mesh.unwrap_or_default(), planes)
    };
    scene.wall.iter().zip(&found).map(of).collect()
}

/// Unit vector of the axis, force along it (N), mass (kg) and first step of a dynamic wall.
fn drive_entry(motion: &Motion, plan: &Plan) -> Option<Value> {
    let Motion::ForceDriven { axis, force, mass, start, .. } = *motion else { return None };
    let axis: [f64; 3] = Vector3::from(axis).normalize().into();
    Some(json!({ "axis": axis, "force": force, "mass": mass, "first": plan.step_at(start) }))
}

/// Reads displacement (m or rad) and rate of each dynamic wall, frame after frame.
///
/// # Errors
/// Message: a wrong number of bytes, or a number that is not finite.
pub fn read_driven_walls(bytes: &[u8], walls: &[u32], frames: &mut [Snapshot]) -> Result<(), String> {
    let row = 8 * DRIVEN_ROW * walls.len();
    if bytes.len() != row * frames.len() {
        return Err(format!("it holds {} bytes for {} frames of {} walls", bytes.len(), frames.len(), walls.len()));
    }
    let mut numbers = bytes.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap_or_default()));
    for frame in frames {
        for &wall in walls {
            let mut number = || numbers.next().unwrap_or(f64::NAN);
            let (displacement, rate) = (number(), number());
            if !displacement.is_finite() || !rate.is_finite() {
                return Err("a number is not finite: the run diverged".into());
            }
            frame.driven_walls.push(DrivenWall { wall, displacement, rate });
        }
    }
    Ok(())
}
