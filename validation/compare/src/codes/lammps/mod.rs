//! LAMMPS with its package GRANULAR, an explicit soft-sphere code: the deck `deck.in`, the law of its contacts, its walls, its log.
//!
//! Walls are regions, each with one smooth surface, whose motion is given by variables:
//!
//! ```text
//! plane      plane, endless                                       one side
//! box        a plane a closed face, endless                       one side
//! cylinder   cylinder, both ends open: a thin shell with rims     two sides
//! disc       cylinder from outside, too short for a contact       two sides
//! ```
//!
//! `fix wall/gran/region` reports one contact per grain, so that a box is not a `block`: its six surfaces would share that one. Cylinders
//! and discs lie along x, y or z; others are refused.

use super::deck::{DeckRun, HAS, data, manifest, render, values};
use super::input::{AXES, Face, MotionPhase, Palette, Plan, along, closed_faces};
use super::process::{Program, installed};
use super::{Code, CodeError, HERTZ_MINDLIN, Job, Purpose, supported_start};
use makadam::scene::{ContactCoefficients, Grain, Material, Motion, Shape, Wall};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use minijinja::{Value, context};
use nalgebra::Vector3;
use std::fmt::Write;

const NAME: &str = "LAMMPS";

installed!(
    /// LAMMPS with its package GRANULAR.
    Lammps,
    "lmp"
);

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
        let plan = write_input(job)?;
        DeckRun { code: NAME, program: &self.program, log: "lammps.log", loop_seconds }.execute(job, version, &plan)
    }
}

/// Writes deck, grains and manifest into the job's folder.
fn write_input(job: &Job<'_>) -> Result<Plan, CodeError> {
    let scene = &job.scene.with_own_motions();
    let job = &Job { scene, ..*job };
    let grains = supported_start(NAME, &HAS, job)?;
    let plan = Plan::new(scene, job.rayleigh_fraction * scene.rayleigh_step(&grains));
    let unsupported = |reason: String| CodeError::Unsupported { code: NAME, reason };
    let palette = Palette::new(scene, &grains);
    let kinds = (0..palette.len()).filter(|&entry| !palette.is_wall(entry)).count();
    let surfaces = surfaces(&scene.wall, &grains).map_err(unsupported)?;
    let (deck, dumps) = deck(job, &grains, &surfaces, &plan, &palette, kinds).map_err(unsupported)?;
    let files = [("deck.in".into(), deck), ("grains.data".into(), data(scene, &grains, &palette, kinds))];
    super::write_files(job.work_folder, files.into_iter().chain([manifest(job.seed, &plan, &dumps[1..], "")]))?;
    Ok(plan)
}

/// Overlap, over the radius, at which the spring against rolling is as stiff as the tangential spring times the effective radius squared:
/// here the stiffness is a constant. Mean overlaps are 0.0025 in `heap-rolling` and 0.0055 in `drum-rolling`.
const ROLLING_OVERLAP: f64 = 0.004;

/// Columns of contacts in the dumps.
const PAIR_NAMES: [&str; 8] = ["id1", "id2", "fnx", "fny", "fnz", "ftx", "fty", "ftz"];
const WALL_NAMES: [&str; 8] = ["id1", "fx", "fy", "fz", "px", "py", "pz", "wall"];

/// Returns the deck and the names of its dumps, the grains first. Each kind of grain and surface has a fix and a dump of its own.
///
/// # Errors
/// Limit of LAMMPS.
fn deck(
    job: &Job<'_>,
    grains: &[Grain],
    surfaces: &[Surface],
    plan: &Plan,
    palette: &Palette<'_>,
    kinds: usize,
) -> Result<(String, Vec<String>), String> {
    let scene = job.scene;
    let laws = Laws::new(palette, grains)?;
    let of_grains = palette.pairs().filter(|(_, second, _)| !palette.is_wall(*second));
    let pairs = of_grains.map(|(a, b, pair)| context! { first => a + 1, second => b + 1, law => laws.of(a, b, &pair) });
    let of_walls = surfaces.iter().enumerate().flat_map(|surface| (0..kinds).map(move |kind| (surface, kind)));
    let meetings = of_walls.filter_map(|((number, Surface { wall, .. }), kind)| {
        let entry = palette.index(&scene.wall[*wall].material, true);
        let law = laws.of(kind, entry, &palette.coefficients(kind, entry)?);
        Some(context! { wall, surface => number, kind => kind + 1, law })
    });
    let meetings: Vec<Value> = meetings.collect();
    let measures = job.purpose == Purpose::Measuring;
    let listed = |name: &str, count: usize| (1..=count).map(|at| format!("{name}[{at}]")).collect::<Vec<_>>();
    let mut dumps = vec![
        context! { name => "grains", style => "custom", thresh => "", names => Vec::<&str>::new(),
        columns => "id x y z vx vy vz omegax omegay omegaz".split(' ').collect::<Vec<_>>() },
        context! { name => "pairs", style => "local", thresh => "", names => PAIR_NAMES,
        columns => [listed("c_ids", 2), listed("c_pairs", 6)].concat() },
    ];
    dumps.extend((0..meetings.len()).filter(|_| measures).map(|number| {
        // The first column is the contact flag.
        let felt = listed(&format!("f_wall{number}"), 7);
        let columns = [&["id".into()], &felt[1..], &[format!("v_met{number}")]].concat();
        let thresh = format!(" thresh {} > 0.5", felt[0]);
        context! { name => format!("wall{number}"), style => "custom", thresh, names => WALL_NAMES, columns }
    }));
    let names = dumps.iter().map(|dump| format!("{}.dump", dump.get_attr("name").unwrap_or_default())).collect();
    let Plan { steps, fine, coarse, fine_from, .. } = plan;
    let own = context! {
        pairs => pairs.collect::<Vec<_>>(), walls => lines(scene, surfaces, plan),
        kinds, meetings, measures, dumps, steps, fine, coarse, fine_from
    };
    let deck = render(include_str!("deck.in"), context! { ..own, ..values(scene, grains, plan, job.purpose) });
    Ok((deck, names))
}

/// Law of every contact.
struct Laws<'a> {
    palette: &'a Palette<'a>,
    materials: Vec<&'a Material>,
    /// Mean radius of the grains, m.
    radius: f64,
    /// True if a contact resists rolling: all contacts have the same terms.
    rolls: bool,
}

impl<'a> Laws<'a> {
    fn new(palette: &'a Palette<'a>, grains: &[Grain]) -> Result<Laws<'a>, String> {
        if palette.pairs().any(|(_, _, pair)| pair.restitution <= 0.0) {
            return Err("its damping takes restitution above 0 only".into());
        }
        let radius = grains.iter().map(|grain| grain.radius).sum::<f64>() / grains.len() as f64;
        let rolls = palette.pairs().any(|(_, _, pair)| pair.rolling_friction > 0.0);
        Ok(Laws { palette, materials: palette.materials().collect(), radius, rolls })
    }

    /// Returns the law of two entries of the palette: Hertz and Mindlin with the moduli of both. The style that takes Young's modulus and
    /// Poisson's ratio takes one of each for a pair. Damping is that of LIGGGHTS, whose force may attract at the end of an impact: a limited
    /// force changes restitution.
    ///
    /// The tangential spring stores a force, as in YADE. With a displacement, which LIGGGHTS stores, a sliding contact retains a damped
    /// fraction of the cap, and falls short of the cap during unloading. In `packing` friction mobilisation is then 0.368 ± 0.002 instead
    /// of 0.397 ± 0.003 with a force and 0.401 ± 0.003 in LIGGGHTS.
    fn of(&self, a: usize, b: usize, pair: &ContactCoefficients) -> String {
        let (normal, shear) = (self.effective(a, b, softness), self.effective(a, b, shear_softness));
        let (stiffness, tangential) = (4.0 / 3.0 * normal, 8.0 * shear);
        // As in the other codes, the damping is that of the normal spring at the tangential stiffness. Over the coefficient of the normal spring
        // 2 E* a, it is the root of the ratio of both springs.
        let damping = (4.0 * shear / normal).sqrt();
        let ContactCoefficients { friction, restitution, rolling_friction, .. } = pair;
        let mut law = format!(
            "hertz {stiffness:.17e} {restitution:.17e} damping coeff_restitution \
             tangential mindlin/force {tangential:.17e} {damping:.17e} {friction:.17e}"
        );
        if self.rolls {
            let effective = if self.palette.is_wall(b) { self.radius } else { 0.5 * self.radius };
            let stiffness = tangential * (effective * ROLLING_OVERLAP * self.radius).sqrt();
            let _ = write!(law, " rolling sds {stiffness:.17e} 0 {rolling_friction:.17e}");
        }
        law
    }

    fn effective(&self, a: usize, b: usize, softness: impl Fn(&Material) -> f64) -> f64 {
        1.0 / (softness(self.materials[a]) + softness(self.materials[b]))
    }
}

/// Contribution of a material to the inverse of the effective modulus of Hertz, 1/Pa.
fn softness(material: &Material) -> f64 {
    (1.0 - material.poisson_ratio.powi(2)) / material.youngs_modulus
}

/// Contribution of a material to the inverse of the effective shear modulus of Mindlin, 1/Pa.
fn shear_softness(material: &Material) -> f64 {
    2.0 * (2.0 - material.poisson_ratio) * (1.0 + material.poisson_ratio) / material.youngs_modulus
}

/// Finds the version in "... Massively Parallel Simulator - 22 Jul 2025 - Update 4", without the dashes.
fn version_in(words: &str) -> Option<&str> {
    let after = words.split_once("Parallel Simulator - ")?.1;
    after.lines().next().map(str::trim).filter(|version| !version.is_empty())
}

/// Sum of the stepping times of a log, without the time of output, s; numbers that are not finite do not count.
pub fn loop_seconds(log: &str) -> f64 {
    let number = |word: Option<&str>| word.and_then(|word| word.trim().parse::<f64>().ok()).filter(|n| n.is_finite());
    let of = |line: &str| match line.strip_prefix("Loop time of ") {
        Some(rest) => number(rest.split(' ').next()).unwrap_or(0.0),
        // Section, then minimum, mean and maximum time over the processes; there is one process.
        None if line.starts_with("Output ") => -number(line.split('|').nth(2)).unwrap_or(0.0),
        None => 0.0,
    };
    let sum: f64 = log.lines().map(of).sum();
    if sum.is_finite() { sum.max(0.0) } else { 0.0 }
}

/// Thickness of a disc over the smallest radius: a grain whose centre lies within the disc would have no contact with it.
const THICKNESS: f64 = 1e-7;

/// One smooth surface of a wall.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    /// Index of its wall in the scene.
    pub wall: usize,
    /// Style of the region, and its numbers.
    region: String,
}

/// Returns the surfaces of all walls, in their order; an error states the limit of LAMMPS.
pub(super) fn surfaces(walls: &[Wall], grains: &[Grain]) -> Result<Vec<Surface>, String> {
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let mut all = Vec::new();
    for (index, wall) in walls.iter().enumerate() {
        let regions = regions(&wall.shape, THICKNESS * smallest);
        let regions = regions.map_err(|problem| format!("{problem}: wall '{}'", wall.name))?;
        all.extend(regions.into_iter().map(|region| Surface { wall: index, region }));
    }
    Ok(all)
}

fn regions(shape: &Shape, thickness: f64) -> Result<Vec<String>, String> {
    Ok(match shape {
        Shape::Plane { point, normal } => vec![plane(*point, *normal)],
        Shape::Box { min, max, open } => {
            let face = |Face { axis, inwards, .. }: Face| {
                let mut normal = [0.0; 3];
                normal[axis] = inwards;
                plane(if inwards > 0.0 { *min } else { *max }, normal)
            };
            closed_faces(min, max, open).into_iter().map(face).collect()
        }
        Shape::Cylinder { base, axis, radius, length } => {
            vec![format!("{} open 1 open 2", cylinder(base, axis, *radius, [0.0, *length])?)]
        }
        Shape::Disc { hole, .. } if *hole > 0.0 => return Err("it has no region like a disc with a hole".into()),
        Shape::Disc { centre, normal, radius, .. } => {
            vec![format!("{} side out", cylinder(centre, normal, *radius, [-thickness, 0.0])?)]
        }
        Shape::Spheres { .. } => return Err("a wall is made of spheres".into()),
        Shape::Mesh { .. } => return Err("it has no region like a mesh of triangles".into()),
        other => return Err(format!("no region is written for a {}", other.kind())),
    })
}

fn plane([x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> String {
    format!("plane {x:.17e} {y:.17e} {z:.17e} {u:.17e} {v:.17e} {w:.17e}")
}

/// Returns a cylinder between two positions along its axis, measured from its base.
fn cylinder(base: &[f64; 3], axis: &[f64; 3], radius: f64, ends: [f64; 2]) -> Result<String, String> {
    let (along, sign) = along(axis).ok_or("its cylinders and discs lie along x, y or z")?;
    let [low, high] = if sign > 0.0 { ends } else { [-ends[1], -ends[0]] }.map(|end| base[along] + end);
    // The centre's two coordinates are given in the order of x, y, z.
    let [first, second] = [[1, 2], [0, 2], [0, 1]][along].map(|other| base[other]);
    let name = AXES[along];
    Ok(format!("cylinder {name} {first:.17e} {second:.17e} {radius:.17e} {low:.17e} {high:.17e}"))
}

/// Lines of a deck: the variables that state the poses of the walls, and the regions of the surfaces.
pub(super) fn lines(scene: &MeasuredScene, surfaces: &[Surface], plan: &Plan) -> Vec<String> {
    let walls = scene.wall.iter().enumerate();
    let mut lines: Vec<String> = walls.flat_map(|(number, wall)| variables(number, &wall.motion, plan)).collect();
    for (number, surface) in surfaces.iter().enumerate() {
        lines.push(region(number, surface, &scene.wall[surface.wall].motion, plan));
    }
    lines
}

/// Returns the variables that state the pose of a wall; none where the wall is at rest.
fn variables(wall: usize, motion: &Motion, plan: &Plan) -> Vec<String> {
    let phases = plan.phases(motion);
    if phases.is_empty() {
        return Vec::new();
    }
    let time = format!("{:.17e}*({})", plan.time_step, steps_in(&phases));
    let shift = |size: &[f64; 3], of_time: &str| {
        let axes = AXES.iter().zip(size);
        axes.map(|(axis, size)| format!("variable {axis}{wall} equal ({size:.17e})*{of_time}")).collect()
    };
    match motion {
        Motion::Translating { velocity, .. } => shift(velocity, &time),
        Motion::Rotating { rate, .. } => vec![format!("variable turn{wall} equal ({rate:.17e})*{time}")],
        Motion::Vibrating { amplitude, frequency, .. } => {
            let rate = std::f64::consts::TAU * frequency;
            shift(amplitude, &format!("sin({rate:.17e}*{time})"))
        }
        _ => Vec::new(),
    }
}

/// Returns the number of steps of a wall's motion, forward minus backward, as a formula of LAMMPS.
fn steps_in(phases: &[MotionPhase]) -> String {
    let of = |MotionPhase { first, last, direction }: &MotionPhase| {
        let whole = last - first;
        format!("({direction})*((step>{first})*(step<={last})*(step-{first})+(step>{last})*{whole})")
    };
    phases.iter().map(of).collect::<Vec<_>>().join("+")
}

fn region(number: usize, surface: &Surface, motion: &Motion, plan: &Plan) -> String {
    let Surface { wall, region } = surface;
    let moves = !plan.phases(motion).is_empty();
    let shifts = matches!(motion, Motion::Translating { .. } | Motion::Vibrating { .. }) && moves;
    let shift = if shifts { format!(" move v_x{wall} v_y{wall} v_z{wall}") } else { String::new() };
    let turn = match motion {
        Motion::Rotating { point: [x, y, z], axis, .. } if moves => {
            let [a, b, c]: [f64; 3] = Vector3::from(*axis).normalize().into();
            format!(" rotate v_turn{wall} {x:.17e} {y:.17e} {z:.17e} {a:.17e} {b:.17e} {c:.17e}")
        }
        _ => String::new(),
    };
    format!("region surface{number} {region} units box{shift}{turn}")
}
