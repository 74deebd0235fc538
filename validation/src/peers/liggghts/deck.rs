//! The input of LIGGGHTS: deck, initial grains, one mesh file a wall.

use super::walls::Walls;
use crate::peers::data_file::{boundary, data, neighbours};
use crate::peers::palette::Palette;
use crate::peers::plan::Plan;
use crate::peers::stl::stl;
use crate::plan::Scene;
use makadam::scene::{Grain, Motion};
use nalgebra::Vector3;
use std::fmt::Write;

/// Columns of the dump of grains: id, position, velocity, spin.
pub(super) const GRAIN_COLUMNS: usize = 10;

/// Columns of the dump of contacts between grains: three ids, force on the first grain, contact point.
pub(super) const PAIR_COLUMNS: usize = 9;

/// Columns of the dump of contacts with walls: point on the wall, centre of the grain, three ids, force on the grain.
/// The keyword `contactPoint` gives zeros there.
pub(super) const WALL_COLUMNS: usize = 12;

/// Lines of progress in the log.
const REPORTS: u64 = 100;

/// Names and texts of the input files; an error says what LIGGGHTS cannot do.
pub(super) fn files(
    scene: &Scene,
    grains: &[Grain],
    walls: &Walls,
    plan: &Plan,
) -> Result<Vec<(String, String)>, String> {
    let palette = Palette::new(scene, grains);
    let mut files = vec![
        ("deck.in".to_string(), deck(scene, grains, walls, plan, &palette)?),
        ("grains.data".to_string(), data(scene, grains, &palette, palette.len())),
    ];
    for (wall, mesh) in &walls.meshes {
        files.push((format!("wall{wall}.stl"), stl(mesh)));
    }
    Ok(files)
}

fn deck(scene: &Scene, grains: &[Grain], walls: &Walls, plan: &Plan, palette: &Palette<'_>) -> Result<String, String> {
    let mut text = String::from("atom_style granular\natom_modify map array\n");
    let _ = writeln!(text, "boundary {}\nnewton off", boundary(scene));
    text += "communicate single vel yes\nunits si\nprocessors 1 1 1\n";
    let moduli = || palette.materials().map(|material| material.youngs_modulus);
    // LIGGGHTS takes moduli outside its usual range for a slip unless told otherwise.
    if moduli().any(|modulus| modulus > 1e9) {
        text += "hard_particles yes\n";
    }
    if moduli().any(|modulus| modulus < 5e6) {
        text += "soft_particles yes\n";
    }
    text += "read_data grains.data\n";
    text += &neighbours(scene, grains, walls.purpose);

    properties(&mut text, palette)?;
    // Off: a limited force changes restitution (0.3 becomes 0.4). Everything else as the code has it, tangential damping too.
    // Of its rolling models epsd2 alone has a static branch without a viscous part; its cap is mu_r R* F_n, as ours.
    let model = match palette.pairs().any(|(_, _, pair)| pair.rolling_friction > 0.0) {
        true => "model hertz tangential history rolling_friction epsd2",
        false => "model hertz tangential history",
    };
    let settings = "limitForce off";
    let _ = writeln!(text, "pair_style gran {model} {settings}\npair_coeff * *\ntimestep {:.17e}", plan.time_step);
    let gravity = Vector3::from(scene.gravity);
    if let Some(direction) = gravity.try_normalize(0.0) {
        let [x, y, z]: [f64; 3] = direction.into();
        let _ = writeln!(text, "fix gravity all gravity {:.17e} vector {x:.17e} {y:.17e} {z:.17e}", gravity.norm());
    }
    for (wall, mesh) in &walls.meshes {
        let kind = palette.index(&scene.wall[*wall].material, true) + 1;
        let _ = write!(text, "fix wall{wall} all mesh/surface file wall{wall}.stl type {kind}");
        // Contacts keep their history from one triangle of a curved surface to the next.
        match mesh.bend > 0.0 {
            true => _ = writeln!(text, " curvature {:.6} curvature_tolerant yes", 1.2 * mesh.bend),
            false => text.push('\n'),
        }
    }
    if !walls.meshes.is_empty() {
        let names: Vec<String> = walls.meshes.iter().map(|(wall, _)| format!("wall{wall}")).collect();
        let (count, names) = (names.len(), names.join(" "));
        let _ = writeln!(text, "fix walls all wall/gran {model} mesh n_meshes {count} meshes {names} {settings}");
    }
    for (number, (wall, words)) in walls.primitives.iter().enumerate() {
        let kind = palette.index(&scene.wall[*wall].material, true) + 1;
        let _ = writeln!(text, "fix primitive{number} all wall/gran {model} primitive type {kind} {words} {settings}");
    }
    text += "fix integrate all nve/sphere\n";
    // These must stand before the first run.
    text += "compute pairs all pair/gran/local id force contactPoint\n";
    if walls.are_told() {
        text += "compute walls all wall/gran/local pos id force\n";
    }
    let _ = writeln!(text, "thermo_style custom step atoms ke\nthermo {}", (plan.steps / REPORTS).max(1));
    text += "thermo_modify flush yes lost error norm no\n";
    pieces(&mut text, scene, walls, plan);
    Ok(text)
}

fn properties(text: &mut String, palette: &Palette<'_>) -> Result<(), String> {
    let list = |values: Vec<f64>| values.iter().map(|value| format!(" {value:.17e}")).collect::<String>();
    let young = list(palette.materials().map(|material| material.youngs_modulus).collect());
    let poisson = list(palette.materials().map(|material| material.poisson_ratio).collect());
    let _ = writeln!(text, "fix young all property/global youngsModulus peratomtype{young}");
    let _ = writeln!(text, "fix poisson all property/global poissonsRatio peratomtype{poisson}");
    let (mut friction, mut rolling, mut restitution) = (Vec::new(), Vec::new(), Vec::new());
    for a in 0..palette.len() {
        for b in 0..palette.len() {
            // Walls never touch each other; the numbers of such a pair mean nothing.
            let pair = palette.coefficients(a, b);
            let e = pair.map_or(0.5, |pair| pair.restitution);
            if e <= 0.05 {
                return Err(format!("it takes restitution above 0.05 only, not {e}"));
            }
            friction.push(pair.map_or(0.0, |pair| pair.friction));
            rolling.push(pair.map_or(0.0, |pair| pair.rolling_friction));
            restitution.push(e);
        }
    }
    let count = palette.len();
    let resists = rolling.iter().any(|&coefficient| coefficient > 0.0);
    let (friction, rolling, restitution) = (list(friction), list(rolling), list(restitution));
    let _ = writeln!(text, "fix friction all property/global coefficientFriction peratomtypepair {count}{friction}");
    let _ = writeln!(
        text,
        "fix restitution all property/global coefficientRestitution peratomtypepair {count}{restitution}"
    );
    if resists {
        let _ = writeln!(
            text,
            "fix rolling all property/global coefficientRollingFriction peratomtypepair {count}{rolling}"
        );
    }
    Ok(())
}

/// The runs between the times at which walls start or stop or frames become denser.
fn pieces(text: &mut String, scene: &Scene, walls: &Walls, plan: &Plan) {
    let boundaries = plan.boundaries(scene);
    let mut dumping = 0;
    let ends = plan.fine_from == plan.steps;
    for (index, &at) in boundaries.iter().enumerate() {
        for (wall, _) in &walls.meshes {
            let motion = &scene.wall[*wall].motion;
            let phases = plan.phases(motion);
            if phases.iter().any(|phase| phase.last == at && at < plan.steps) {
                let _ = writeln!(text, "unfix move{wall}");
            }
            if let Some(phase) = phases.iter().find(|phase| phase.first == at) {
                start_motion(text, *wall, motion, phase.direction);
            }
        }
        let Some(next) = boundaries.get(index + 1) else { break };
        let every = if at >= plan.fine_from && !ends { plan.fine } else { plan.coarse };
        if every != dumping {
            dumps(text, "", every, dumping != 0, walls.are_told());
            dumping = every;
        }
        // A dump whose interval is the whole run adds the last frame where the interval misses it.
        if *next == plan.steps && !plan.steps.is_multiple_of(every) {
            dumps(text, "last", plan.steps, false, walls.are_told());
        }
        let _ = writeln!(text, "run {}", next - at);
    }
}

fn start_motion(text: &mut String, wall: usize, motion: &Motion, direction: f64) {
    let _ = match motion {
        Motion::Fixed | Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => Ok(()),
        Motion::Translating { velocity: [x, y, z], .. } => {
            writeln!(text, "fix move{wall} all move/mesh mesh wall{wall} linear {x:.17e} {y:.17e} {z:.17e}")
        }
        Motion::Rotating { point: [x, y, z], axis, rate, .. } => {
            let rate = direction * rate;
            // The period has no sign: a wall that turns backwards has its axis turned about.
            let [a, b, c]: [f64; 3] = (Vector3::from(*axis).normalize() * rate.signum()).into();
            let period = std::f64::consts::TAU / rate.abs().max(1e-12);
            writeln!(
                text,
                "fix move{wall} all move/mesh mesh wall{wall} rotate origin {x:.17e} {y:.17e} {z:.17e} \
                 axis {a:.17e} {b:.17e} {c:.17e} period {period:.17e}"
            )
        }
        Motion::Vibrating { amplitude: [x, y, z], frequency, .. } => {
            let period = 1.0 / frequency.max(1e-12);
            writeln!(
                text,
                "fix move{wall} all move/mesh mesh wall{wall} wiggle amplitude {x:.17e} {y:.17e} {z:.17e} \
                 period {period:.17e}"
            )
        }
    };
}

fn dumps(text: &mut String, tag: &str, every: u64, replace: bool, walls: bool) {
    let local = |name: &str, count: usize| (1..=count).map(|at| format!(" c_{name}[{at}]")).collect::<String>();
    let state = " id x y z vx vy vz omegax omegay omegaz".to_string();
    let numbers = |count: usize| vec!["%.12g"; count].join(" ");
    let tables = [
        ("grains", "custom", state, format!("%d {}", numbers(GRAIN_COLUMNS - 1))),
        ("pairs", "local", local("pairs", PAIR_COLUMNS), numbers(PAIR_COLUMNS)),
        ("walls", "local", local("walls", WALL_COLUMNS), numbers(WALL_COLUMNS)),
    ];
    for (name, style, columns, format) in tables.into_iter().take(if walls { 3 } else { 2 }) {
        if replace {
            let _ = writeln!(text, "undump {name}{tag}");
        }
        let _ = writeln!(text, "dump {name}{tag} all {style} {every} {name}.dump{columns}");
        let _ = writeln!(text, "dump_modify {name}{tag} append yes format \"{format}\"");
    }
}
