//! LIGGGHTS, an explicit soft-sphere code: the deck `deck.in`, its walls, its log.
//!
//! ```text
//! walls        measuring                    timing
//! curved       fine mesh                    primitive where it is one, else coarse mesh
//! flat         mesh                         primitive where it is one, else mesh
//! contacts     dumped                       missing: a primitive has none that can be dumped together with those of meshes
//! ```
//!
//! For timing, a drum about y lies along z: the primitive cylinders turn about x and z alone.

use super::deck::{DeckRun, HAS, data, manifest, render, values};
use super::input::{AXES, Palette, Plan, Primitive, primitives, stl};
use super::process::{Program, installed};
use super::{Code, CodeError, HERTZ_MINDLIN, Job, Purpose, supported_start};
use makadam::effects::SURFACE_VELOCITY;
use makadam::scene::{Domain, Grain, Motion, Shape, TriangleMesh, Wall};
use makadam::snapshot::Snapshot;
use makadam_frames::output::mesh::{COARSE, FINE, Mesh, wall_mesh};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::{Content, Recording};
use minijinja::{Value, context};
use nalgebra::Vector3;

const NAME: &str = "LIGGGHTS";

installed!(
    /// LIGGGHTS, an explicit soft-sphere code.
    Liggghts,
    "liggghts"
);

impl Code for Liggghts {
    fn name(&self) -> &'static str {
        NAME
    }

    fn contact_law(&self) -> &'static str {
        HERTZ_MINDLIN
    }

    fn version(&self) -> Option<String> {
        // Without a log: LIGGGHTS would write one into the current folder.
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
        if walls_move(job.scene, &plan) && !recording.lacks.contains(&Content::WallContacts) {
            recording.lacks.push(Content::WallContacts);
        }
        Ok(recording)
    }
}

/// Returns true if a wall moves in a measured frame. `compute wall/gran/local` then lists wrong forces: in `drum-lifters` they carry 0.62 of
/// the weight, those that act on the grains (`fix mesh/surface/stress`) all of it.
fn walls_move(scene: &MeasuredScene, plan: &Plan) -> bool {
    let is_belt = |wall: &Wall| wall.surface_velocity != [0.0; 3];
    let in_motion = |wall: &Wall| plan.phases(&wall.motion).iter().any(|phase| phase.last >= plan.fine_from);
    scene.wall.iter().any(|wall| is_belt(wall) || in_motion(wall))
}

/// Writes deck, grains, meshes and manifest into the job's folder; returns the coordinates of deck and dumps.
fn write_input(job: &Job<'_>) -> Result<(Plan, Turn), CodeError> {
    let job = &Job { scene: &job.scene.with_own_motions(), ..*job };
    let grains = supported_start(NAME, &[&HAS[..], &[&SURFACE_VELOCITY]].concat(), job)?;
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
    contacts.extend(walls.are_dumped().then(|| "walls.dump".into()));
    // The local computes have no column names.
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
fn deck(
    scene: &MeasuredScene,
    grains: &[Grain],
    walls: &Walls,
    plan: &Plan,
    palette: &Palette<'_>,
) -> Result<String, String> {
    let entries = || (0..palette.len()).flat_map(|a| (0..palette.len()).map(move |b| (a, b)));
    // Walls have no contacts with each other; the numbers of such a pair have no effect.
    let pairs: Vec<_> = entries().map(|(a, b)| palette.coefficients(a, b)).collect();
    let restitution: Vec<f64> = pairs.iter().map(|pair| pair.map_or(0.5, |pair| pair.restitution)).collect();
    if let Some(low) = restitution.iter().find(|restitution| **restitution <= 0.05) {
        return Err(format!("it takes restitution above 0.05 only, not {low}"));
    }
    let kind = |wall: usize| palette.index(&scene.wall[wall].material, true) + 1;
    let meshes = walls.meshes.iter().map(|(wall, mesh)| {
        // Contacts retain their history from one triangle of a curved surface to the next.
        let curved = || format!(" curvature {:.6} curvature_tolerant yes", 1.2 * mesh.bend);
        let curvature = if mesh.bend > 0.0 { curved() } else { String::new() };
        let belt = match scene.wall[*wall].surface_velocity {
            [0.0, 0.0, 0.0] => String::new(),
            [x, y, z] => format!(" surface_vel {x:.17e} {y:.17e} {z:.17e}"),
        };
        context! { wall, kind => kind(*wall), curvature, belt }
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
        tables => tables(walls.are_dumped()),
        pieces => pieces(scene, walls, plan),
    };
    Ok(render(include_str!("deck.in"), context! { ..own, ..values(scene, grains, plan, walls.purpose) }))
}

/// Returns the dumps: grains; contacts between grains, with three ids, force on the first grain and contact point; contacts with walls. The
/// latter have point on the wall, centre of the grain, three ids and force on the grain (the keyword `contactPoint` gives zeros there).
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
fn pieces(scene: &MeasuredScene, walls: &Walls, plan: &Plan) -> Vec<Value> {
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

/// Returns a motion as arguments of `fix move/mesh`; none for a wall at rest.
fn motion_words(motion: &Motion, direction: f64) -> Option<String> {
    Some(match motion {
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
        _ => return None,
    })
}

/// Finds the version in "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled ...".
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

/// True if the coordinates are permuted: z, x, y instead of x, y, z. The permutation is a rotation, so that spins follow positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Turn(bool);

impl Turn {
    /// Returns the turn with which most of the turning cylinders of a scene are primitives.
    pub fn of(scene: &MeasuredScene) -> Turn {
        let about = |wanted: usize| {
            let turning = scene.wall.iter().filter(|wall| matches!(wall.shape, Shape::Cylinder { .. }));
            let axes = turning.filter_map(|wall| match &wall.motion {
                Motion::Rotating { axis, .. } => Some(axis),
                _ => None,
            });
            axes.filter(|axis| (0..3).all(|at| (axis[at] == 0.0) == (at != wanted))).count()
        };
        // An axis along y then lies along z; an axis along x would lie along y.
        Turn(about(1) > about(0))
    }

    fn forth(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        if self.0 { [z, x, y] } else { [x, y, z] }
    }

    fn back(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        if self.0 { [y, z, x] } else { [x, y, z] }
    }

    /// Returns the scene in these coordinates. Its populations are unchanged, since the grains are given.
    pub fn scene(self, scene: &MeasuredScene) -> MeasuredScene {
        let mut turned = scene.clone();
        turned.gravity = self.forth(scene.gravity);
        let Domain { min, max, .. } = &scene.domain;
        (turned.domain.min, turned.domain.max) = (self.forth(*min), self.forth(*max));
        for wall in &mut turned.wall {
            self.shape(&mut wall.shape);
            self.motion(&mut wall.motion);
            wall.surface_velocity = self.forth(wall.surface_velocity);
        }
        turned
    }

    fn shape(self, shape: &mut Shape) {
        let turn = |vector: &mut [f64; 3]| *vector = self.forth(*vector);
        match shape {
            Shape::Mesh { file, .. } => {
                let file = file.clone();
                let mut triangles = shape.triangles().unwrap_or_default();
                triangles.as_flattened_mut().iter_mut().for_each(turn);
                *shape = Shape::mesh(file, TriangleMesh::new(&triangles).expect("a turned mesh is a mesh"));
            }
            Shape::Box { min, max, open } => {
                [min, max].into_iter().for_each(turn);
                open.iter_mut().for_each(|face| *face = self.face(face));
            }
            Shape::Plane { point: one, normal: other }
            | Shape::Cylinder { base: one, axis: other, .. }
            | Shape::Frustum { base: one, axis: other, .. }
            | Shape::Disc { centre: one, normal: other, .. } => [one, other].into_iter().for_each(turn),
            Shape::Rectangle { corner, edges: [one, other] } => [corner, one, other].into_iter().for_each(turn),
            Shape::Spheres { centres, .. } => centres.iter_mut().for_each(turn),
        }
    }

    /// Returns the name of a face after the turn: x before is y after.
    fn face(self, name: &str) -> String {
        let turn = |letter: char| match letter {
            'x' if self.0 => 'y',
            'y' if self.0 => 'z',
            'z' if self.0 => 'x',
            other => other,
        };
        name.chars().map(turn).collect()
    }

    fn motion(self, motion: &mut Motion) {
        let turn = |vector: &mut [f64; 3]| *vector = self.forth(*vector);
        match motion {
            Motion::Translating { velocity, .. } => turn(velocity),
            Motion::Rotating { point, axis, .. } | Motion::TorqueDriven { point, axis, .. } => {
                [point, axis].into_iter().for_each(turn)
            }
            Motion::Vibrating { amplitude, .. } => turn(amplitude),
            Motion::ForceDriven { axis, .. } => turn(axis),
            // Composed motions are refused.
            Motion::Fixed | Motion::Table { .. } | Motion::List(_) => {}
        }
    }

    /// Returns grains in these coordinates.
    pub fn grains(self, grains: &[Grain]) -> Vec<Grain> {
        let turn = |grain: &Grain| Grain {
            position: self.forth(grain.position),
            velocity: self.forth(grain.velocity),
            spin: self.forth(grain.spin),
            ..grain.clone()
        };
        grains.iter().map(turn).collect()
    }

    /// Turns a frame back to the scene's own coordinates.
    pub fn frame_back(self, frame: &mut Snapshot) {
        let turn = |vector: &mut [f64; 3]| *vector = self.back(*vector);
        for grain in &mut frame.particles {
            [&mut grain.position, &mut grain.velocity, &mut grain.spin].into_iter().for_each(turn);
        }
        for contact in &mut frame.contacts {
            [&mut contact.point, &mut contact.normal, &mut contact.tangential_force].into_iter().for_each(turn);
        }
    }
}

/// Largest relative error of the velocity of a turning wall that is a primitive.
const VELOCITY_ERROR: f64 = 0.01;

/// Walls of a deck.
pub(super) struct Walls {
    pub purpose: Purpose,
    /// Walls that are meshes, by their index in the scene: LIGGGHTS numbers its meshes itself, and a wall without triangles has none.
    pub meshes: Vec<(usize, Mesh)>,
    /// Primitives of the other walls, as arguments of `fix wall/gran`.
    pub primitives: Vec<(usize, String)>,
}

impl Walls {
    /// Chooses meshes alone for measuring; for timing, the fastest surfaces with the same physics.
    pub fn new(scene: &MeasuredScene, grains: &[Grain], purpose: Purpose) -> Walls {
        let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
        let (fineness, found) = match purpose {
            Purpose::Measuring => (FINE, vec![Vec::new(); scene.wall.len()]),
            Purpose::Timing => (COARSE, primitives(scene, grains)),
        };
        let mut walls = Walls { purpose, meshes: Vec::new(), primitives: Vec::new() };
        for (place, (wall, found)) in scene.wall.iter().zip(&found).enumerate() {
            let words: Option<Vec<String>> = found.iter().map(|primitive| words(primitive, grains)).collect();
            // Only meshes have a surface velocity.
            match words.filter(|words| !words.is_empty() && wall.surface_velocity == [0.0; 3]) {
                Some(words) => walls.primitives.extend(words.into_iter().map(|words| (place, words))),
                None => {
                    let mesh = wall_mesh(&wall.shape, &scene.domain, smallest, fineness);
                    walls.meshes.extend((!mesh.triangles.is_empty()).then_some((place, mesh)));
                }
            }
        }
        walls
    }

    /// Returns true if the contacts of the walls are dumped.
    pub fn are_dumped(&self) -> bool {
        self.purpose == Purpose::Measuring && !self.meshes.is_empty()
    }
}

/// Returns a primitive as arguments of `fix wall/gran`; none where LIGGGHTS lacks the primitive.
///
/// A cylinder turns by `shear`: the name of a direction across its axis, and the angular velocity. LIGGGHTS takes the velocity at the
/// centre of the grain instead of the surface. So the angular velocity is raised by the ratio of both distances from the axis: exact for the
/// mean grain. About y the velocity is wrong: the two coordinates of the distance are interchanged, and grains are not dragged along ([`Turn`]).
fn words(primitive: &Primitive, grains: &[Grain]) -> Option<String> {
    match *primitive {
        Primitive::Plane { axis, at } => Some(format!("{}plane {at:.17e}", AXES[axis])),
        Primitive::Cylinder { axis, centre, radius, rate } => {
            // The two coordinates of the centre follow in the order x, y, z, x.
            let [first, second] = [1, 2].map(|step| centre[(axis + step) % 3]);
            let name = format!("{}cylinder {radius:.17e} {first:.17e} {second:.17e}", AXES[axis]);
            if rate == 0.0 {
                return Some(name);
            }
            let radii = || grains.iter().map(|grain| grain.radius);
            let mean = radii().sum::<f64>() / grains.len() as f64;
            let error = radii().map(|own| ((radius - own) / (radius - mean) - 1.0).abs()).fold(0.0, f64::max);
            let shear = rate * radius / (radius - mean);
            let across = AXES[(axis + 1) % 3];
            (axis != 1 && error <= VELOCITY_ERROR).then(|| format!("{name} shear {across} {shear:.17e}"))
        }
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/codes_liggghts_turn.rs"]
mod tests;
