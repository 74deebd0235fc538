//! MigFlow: a job file for `migflow_driver.py`, which runs inside a Python with the package.
//!
//! MigFlow solves the contacts of rigid spheres with Coulomb friction and without restitution, by a nonlinear Gauss-Seidel method with a
//! queue of contacts. A velocity may close a gap within a step, not more. So an impact ends where the surfaces meet, and an overlap stays.
//!
//! Walls are triangles, which have no edges of their own in MigFlow. Edges of a wall that grains could meet become segments, and their ends
//! spheres without radius: those of one triangle alone, and in a mesh those between triangles with different normals.

use super::driver::{Driver, RunResult, motion_entry};
use super::input::{Palette, Plan};
use super::process::{Program, ending, installed};
use super::{Code, CodeError, Job, supported_start};
use makadam::effects::catalogue::{Effect, FRICTION, GRAVITY, SIZE_SPREAD, SPIN, WALL_MOTION};
use makadam::scene::{Grain, Motion, Shape, Wall};
use makadam_frames::output::mesh::{FINE, Mesh, Triangle, wall_mesh};
use makadam_frames::recording::Recording;
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::collections::BTreeMap;

const NAME: &str = "MigFlow";
/// Effects that its input expresses; a scene with any other effect is refused.
pub(super) const HAS: [&Effect; 5] = [&GRAVITY, &WALL_MOTION, &SIZE_SPREAD, &FRICTION, &SPIN];
const DRIVER: &str = include_str!("migflow_driver.py");

/// Penetration by which the velocities of a step may err, over the smallest radius. With 1e-3 a column of ten grains sinks by 4% of a radius
/// in 2 s, with 1e-4 by 0.4%.
const TOLERANCE: f64 = 1e-4;

/// Range of candidates beyond the paths of a step, over the smallest radius; affects speed alone. The default of MigFlow is the largest radius.
const SLACK: f64 = 0.1;

installed!(
    /// MigFlow, a non-smooth code with rigid spheres.
    Migflow,
    "migflow"
);

impl Code for Migflow {
    fn name(&self) -> &'static str {
        NAME
    }

    fn contact_law(&self) -> &'static str {
        "rigid, Coulomb"
    }

    fn version(&self) -> Option<String> {
        let print = "import importlib.metadata as found; print(found.version('migflow'))";
        self.program.version(&["-c", print], |words| Some(words.trim()).filter(|version| !version.is_empty()))
    }

    fn write_input(&self, job: &Job<'_>) -> Result<String, CodeError> {
        write_input(job).map(|_| "migflow migflow_driver.py job.json".into())
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        let version = self.version().ok_or(CodeError::Missing { code: NAME })?;
        Driver::clear(job.work_folder);
        let (grains, plan) = write_input(job)?;
        let radii: Vec<f64> = grains.iter().map(|grain| grain.radius).collect();
        let arguments = &["migflow_driver.py", "job.json"];
        let driver = Driver { code: NAME, program: &self.program, arguments, log: "migflow.log" };
        let (RunResult { seconds, core_seconds, .. }, frames) = driver.execute(job, &plan, &radii)?;
        (job.progress)(1.0);
        let mut recording = plan.recording(NAME, version, job, seconds, frames);
        recording.notes.extend(unfinished(&ending(&job.work_folder.join(driver.log)), plan.steps));
        Ok(Recording { core_seconds, rayleigh_fraction: None, ..recording })
    }
}

/// Returns a note on the solves that ended above the tolerance, by the last line of the driver; none if there are none.
fn unfinished(log: &str, steps: u64) -> Option<String> {
    let line = log.lines().rev().find(|line| line.ends_with("steps not converged"))?;
    let count = line.split(' ').rev().nth(3).filter(|count| *count != "0")?;
    Some(format!("{count} of {steps} solves ended above the tolerance of penetration"))
}

/// Writes job and driver into the job's folder. The time step is that of the scene.
fn write_input(job: &Job<'_>) -> Result<(Vec<Grain>, Plan), CodeError> {
    let scene = &job.scene.with_own_motions();
    let job = &Job { scene, ..*job };
    let grains = supported_start(NAME, &HAS, job)?;
    let plan = Plan::new(scene, scene.solver.step);
    let text = job_file(job, &grains, &plan).to_string();
    super::write_files(job.work_folder, [("job.json", text.as_str()), ("migflow_driver.py", DRIVER)])?;
    Ok((grains, plan))
}

/// Returns the job file of the driver.
fn job_file(job: &Job<'_>, grains: &[Grain], plan: &Plan) -> Value {
    let scene = job.scene;
    let palette = Palette::new(scene, grains);
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let grain = |grain: &Grain| {
        json!({
            "material": palette.index(&grain.material, false),
            "radius": grain.radius,
            "density": scene.material[&grain.material].density,
            "position": grain.position,
            "velocity": grain.velocity,
            "spin": grain.spin,
        })
    };
    let wall = |wall: &Wall| {
        let mesh = wall_mesh(&wall.shape, &scene.domain, smallest, FINE);
        let edges = edges(&mesh, matches!(wall.shape, Shape::Mesh { .. }));
        let mut corners = edges.as_flattened().to_vec();
        corners.sort_by(|one, other| one.partial_cmp(other).expect("corners are numbers"));
        corners.dedup();
        let phases = plan.phases(&wall.motion);
        json!({
            "material": palette.index(&wall.material, true),
            "point": if let Motion::Rotating { point, .. } = wall.motion { point } else { [0.0; 3] },
            "triangles": mesh.triangles,
            "edges": edges,
            "corners": corners,
            "motions": phases.iter().filter_map(|phase| motion_entry(&wall.motion, phase)).collect::<Vec<_>>(),
        })
    };
    // Two materials and their friction.
    let pairs = palette.pairs().map(|(a, b, pair)| (a, b, pair.friction));
    json!({
        "time_step": plan.time_step,
        "steps": plan.steps,
        "frames": plan.frames(),
        "gravity": scene.gravity,
        "tolerance": TOLERANCE * smallest,
        "slack": SLACK * smallest,
        "materials": palette.len(),
        "pairs": pairs.collect::<Vec<_>>(),
        "grains": grains.iter().map(grain).collect::<Vec<_>>(),
        "walls": scene.wall.iter().map(wall).collect::<Vec<_>>(),
    })
}

/// Cosine of the largest angle between the normals of triangles of one face.
const FLAT: f64 = 1.0 - 1e-9;

/// Returns the edges of a mesh that belong to one triangle, with `creases` also those between two faces.
fn edges(mesh: &Mesh, creases: bool) -> Vec<[[f64; 3]; 2]> {
    let normal = |triangle: &Triangle| {
        let [a, b, c] = triangle.map(Vector3::from);
        (b - a).cross(&(c - a)).normalize()
    };
    let mut found = BTreeMap::<[[u64; 3]; 2], Vec<usize>>::new();
    for (place, triangle) in mesh.triangles.iter().enumerate() {
        for side in 0..3 {
            let mut ends = [triangle[side], triangle[(side + 1) % 3]].map(|corner| corner.map(f64::to_bits));
            ends.sort_unstable();
            found.entry(ends).or_default().push(place);
        }
    }
    let is_met = |places: &[usize]| match places {
        [first, second] => {
            creases && normal(&mesh.triangles[*first]).dot(&normal(&mesh.triangles[*second])).abs() < FLAT
        }
        _ => true,
    };
    let met = found.iter().filter(|(_, places)| is_met(places));
    met.map(|(ends, _)| ends.map(|corner| corner.map(f64::from_bits))).collect()
}

#[cfg(test)]
#[path = "../../tests/unit/codes_migflow.rs"]
mod tests;
