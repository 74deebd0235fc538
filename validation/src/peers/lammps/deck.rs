//! The input of LAMMPS: deck and initial grains.

use super::surfaces::{Surface, region, variables};
use crate::peers::Purpose;
use crate::peers::data_file::{boundary, data, neighbours};
use crate::peers::palette::Palette;
use crate::peers::plan::Plan;
use crate::plan::Scene;
use makadam::scene::{ContactCoefficients, Grain, Material};
use nalgebra::Vector3;
use std::fmt::Write;

/// Columns of the dump of grains: id, position, velocity, spin.
pub(super) const GRAIN_COLUMNS: usize = 10;

/// Columns of the dump of contacts between grains: two ids, normal and tangential force on the first grain.
pub(super) const PAIR_COLUMNS: usize = PAIR_NAMES.len();

/// Columns of the dump of contacts with a surface: id, force on the grain, point on the surface, number of the wall.
pub(super) const WALL_COLUMNS: usize = WALL_NAMES.len();

/// What the columns of contacts are called in the dumps, in the words that `makadam measure` knows.
const PAIR_NAMES: [&str; 8] = ["id1", "id2", "fnx", "fny", "fnz", "ftx", "fty", "ftz"];
const WALL_NAMES: [&str; 8] = ["id1", "fx", "fy", "fz", "px", "py", "pz", "wall"];

/// What the tangential spring remembers: a force, as in YADE. With a displacement, which LIGGGHTS keeps, a contact that slides keeps what
/// damping leaves of the cap, and falls short of the cap while it unloads: in `packing` friction mobilisation is then 0.368 ± 0.002 where
/// it is 0.397 ± 0.003 with a force and 0.401 ± 0.003 in LIGGGHTS.
const TANGENTIAL: &str = "mindlin/force";

/// Overlap, over the radius, at which the spring against rolling is as stiff as the tangential spring times the effective radius squared:
/// here the stiffness is a constant. Mean overlaps are 0.0025 in `heap-rolling` and 0.0055 in `drum-rolling`.
const ROLLING_OVERLAP: f64 = 0.004;

/// Lines of progress in the log.
const REPORTS: u64 = 100;

/// What grains of one kind have to do with one surface: a fix and a dump of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    /// Place of the surface.
    pub surface: usize,
    /// Material of the grains, as the palette numbers it.
    kind: usize,
}

/// Every kind of grain with every surface.
pub(super) fn meetings(surfaces: &[Surface], kinds: usize) -> Vec<Meeting> {
    let of = |surface| (0..kinds).map(move |kind| Meeting { surface, kind });
    (0..surfaces.len()).flat_map(of).collect()
}

/// Number of materials that grains have; the palette has these first.
pub(super) fn kinds(palette: &Palette<'_>) -> usize {
    (0..palette.len()).filter(|&entry| !palette.is_wall(entry)).count()
}

/// Names and texts of the input files; an error says what LAMMPS cannot do.
pub(super) fn files(
    scene: &Scene,
    grains: &[Grain],
    surfaces: &[Surface],
    plan: &Plan,
    purpose: Purpose,
) -> Result<[(&'static str, String); 2], String> {
    let palette = Palette::new(scene, grains);
    let deck = deck(scene, grains, surfaces, plan, &palette, purpose)?;
    Ok([("deck.in", deck), ("grains.data", data(scene, grains, &palette, kinds(&palette)))])
}

fn deck(
    scene: &Scene,
    grains: &[Grain],
    surfaces: &[Surface],
    plan: &Plan,
    palette: &Palette<'_>,
    purpose: Purpose,
) -> Result<String, String> {
    let mut text = String::from("units si\natom_style sphere\n");
    let _ = writeln!(text, "boundary {}\nnewton off\ncomm_modify vel yes", boundary(scene));
    text += "processors 1 1 1\nread_data grains.data\n";
    text += &neighbours(scene, grains, purpose);
    let laws = Laws::new(palette, grains)?;
    text += "pair_style granular\n";
    let kinds = kinds(palette);
    for (a, b, pair) in palette.pairs().filter(|(_, b, _)| !palette.is_wall(*b)) {
        let _ = writeln!(text, "pair_coeff {} {} {}", a + 1, b + 1, laws.of(a, b, &pair, false));
    }
    let _ = writeln!(text, "timestep {:.17e}", plan.time_step);
    let gravity = Vector3::from(scene.gravity);
    if let Some(direction) = gravity.try_normalize(0.0) {
        let [x, y, z]: [f64; 3] = direction.into();
        let _ = writeln!(text, "fix gravity all gravity {:.17e} vector {x:.17e} {y:.17e} {z:.17e}", gravity.norm());
    }

    for (index, wall) in scene.wall.iter().enumerate() {
        variables(&mut text, index, &wall.motion, plan);
    }
    for (number, surface) in surfaces.iter().enumerate() {
        region(&mut text, number, surface, &scene.wall[surface.wall].motion, plan);
    }
    for kind in 1..=kinds {
        let _ = writeln!(text, "group kind{kind} type {kind}");
    }
    let meetings = meetings(surfaces, kinds);
    for (number, Meeting { surface, kind }) in meetings.iter().enumerate() {
        let entry = palette.index(&scene.wall[surfaces[*surface].wall].material, true);
        let Some(pair) = palette.coefficients(*kind, entry) else { continue };
        let law = laws.of(*kind, entry, &pair, true);
        let (kind, words) = (kind + 1, "wall/gran/region granular");
        let told = if purpose == Purpose::Measuring { " contacts" } else { "" };
        let _ = writeln!(text, "fix wall{number} kind{kind} {words} {law} region surface{surface}{told}");
    }
    text += "fix integrate all nve/sphere\n";
    text += "compute ids all property/local patom1 patom2 cutoff radius\n";
    text += "compute pairs all pair/local fx fy fz p1 p2 p3 cutoff radius\n";
    let _ = writeln!(text, "thermo_style custom step atoms ke\nthermo {}", (plan.steps / REPORTS).max(1));
    text += "thermo_modify flush yes lost error norm no\n";
    let walls: Vec<usize> = meetings.iter().map(|meeting| surfaces[meeting.surface].wall).collect();
    dumps(&mut text, plan, if purpose == Purpose::Measuring { &walls } else { &[] });
    // One run: where one ends and another begins, walls would have no velocity for a step.
    let _ = writeln!(text, "run {}", plan.steps);
    Ok(text)
}

/// The law of every contact.
struct Laws<'a> {
    materials: Vec<&'a Material>,
    /// Mean radius of the grains, m.
    radius: f64,
    /// Whether anything resists rolling: all contacts have the same parts.
    rolls: bool,
}

impl<'a> Laws<'a> {
    fn new(palette: &Palette<'a>, grains: &[Grain]) -> Result<Laws<'a>, String> {
        if palette.pairs().any(|(_, _, pair)| pair.restitution <= 0.0) {
            return Err("its damping takes restitution above 0 only".into());
        }
        let radius = grains.iter().map(|grain| grain.radius).sum::<f64>() / grains.len() as f64;
        let rolls = palette.pairs().any(|(_, _, pair)| pair.rolling_friction > 0.0);
        Ok(Laws { materials: palette.materials().collect(), radius, rolls })
    }

    /// What two entries of the palette exert on each other. Hertz and Mindlin with the moduli of both: the style that takes Young's
    /// modulus and Poisson's ratio takes one of each for a pair. Damping as in LIGGGHTS, whose force may attract at the end of an impact:
    /// one that is limited changes restitution.
    fn of(&self, a: usize, b: usize, pair: &ContactCoefficients, at_wall: bool) -> String {
        let (normal, shear) = (self.effective(a, b, softness), self.effective(a, b, shear_softness));
        let (stiffness, tangential) = (4.0 / 3.0 * normal, 8.0 * shear);
        // As the other codes have it, that of the normal spring at the tangential stiffness: over the coefficient of the normal spring
        // 2 E* a, the root of the ratio of both springs.
        let damping = (4.0 * shear / normal).sqrt();
        let ContactCoefficients { friction, restitution, rolling_friction, .. } = pair;
        let mut law = format!(
            "hertz {stiffness:.17e} {restitution:.17e} damping coeff_restitution \
             tangential {TANGENTIAL} {tangential:.17e} {damping:.17e} {friction:.17e}"
        );
        if self.rolls {
            let effective = if at_wall { self.radius } else { 0.5 * self.radius };
            let stiffness = tangential * (effective * ROLLING_OVERLAP * self.radius).sqrt();
            let _ = write!(law, " rolling sds {stiffness:.17e} 0 {rolling_friction:.17e}");
        }
        law
    }

    fn effective(&self, a: usize, b: usize, softness: impl Fn(&Material) -> f64) -> f64 {
        1.0 / (softness(self.materials[a]) + softness(self.materials[b]))
    }
}

/// Share of a material in the inverse of the effective modulus of Hertz, 1/Pa.
fn softness(material: &Material) -> f64 {
    (1.0 - material.poisson_ratio.powi(2)) / material.youngs_modulus
}

/// Share of a material in the inverse of the effective shear modulus of Mindlin, 1/Pa.
fn shear_softness(material: &Material) -> f64 {
    2.0 * (2.0 - material.poisson_ratio) * (1.0 + material.poisson_ratio) / material.youngs_modulus
}

/// The dumps, at the plan's frames: with a variable that gives the step of the next one, and once more at the end.
/// `walls` are the numbers of the walls whose surfaces grains meet, one for each meeting.
fn dumps(text: &mut String, plan: &Plan, walls: &[usize]) {
    let Plan { steps, fine, coarse, fine_from, .. } = plan;
    let _ = match fine_from < steps {
        true => writeln!(text, "variable next equal stride2(0,{steps},{coarse},{fine_from},{steps},{fine})"),
        false => writeln!(text, "variable next equal stride(0,{steps},{coarse})"),
    };
    let listed = |name: &str, count: usize| (1..=count).map(|at| format!("{name}[{at}]")).collect::<Vec<_>>();
    let grains = "id x y z vx vy vz omegax omegay omegaz".split(' ').map(String::from).collect();
    let pairs = [listed("c_ids", 2), listed("c_pairs", 6)].concat();
    let mut dumps = vec![
        Dump { name: "grains".into(), style: "custom", columns: grains, names: &[], touches: None },
        Dump { name: "pairs".into(), style: "local", columns: pairs, names: &PAIR_NAMES, touches: None },
    ];
    for (number, wall) in walls.iter().enumerate() {
        let _ = writeln!(text, "variable met{number} atom {wall}");
        // First stands whether the grain touches.
        let felt = listed(&format!("f_wall{number}"), 7);
        let columns = [&["id".into()], &felt[1..], &[format!("v_met{number}")]].concat();
        let (name, touches) = (format!("wall{number}"), Some(felt[0].clone()));
        dumps.push(Dump { name, style: "custom", columns, names: &WALL_NAMES, touches });
    }
    for dump in &dumps {
        dump.write(text, *steps);
    }
}

/// A file: two dumps write it, one at the plan's frames and one at the end.
struct Dump {
    name: String,
    style: &'static str,
    columns: Vec<String>,
    /// Names of the columns in the file, where they are not LAMMPS's own.
    names: &'static [&'static str],
    /// What is 1 of a grain that touches, else 0, where those that touch alone are listed.
    touches: Option<String>,
}

impl Dump {
    fn write(&self, text: &mut String, steps: u64) {
        let Dump { name, style, columns, names, touches } = self;
        let mut how = String::from("format float %.12g");
        for (column, name) in columns.iter().zip(*names) {
            let _ = write!(how, " colname {column} {name}");
        }
        if let Some(touches) = touches {
            let _ = write!(how, " thresh {touches} > 0.5");
        }
        let columns = columns.join(" ");
        for (dump, often) in [(name.clone(), " every v_next first yes"), (format!("{name}last"), "")] {
            let _ = writeln!(text, "dump {dump} all {style} {steps} {name}.dump {columns}");
            let _ = writeln!(text, "dump_modify {dump} append yes{often} {how}");
        }
    }
}
