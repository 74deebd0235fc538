//! Which effects a scene calls for, and which of its lines says so.

use crate::plan::Scene;
use makadam::scene::{Cohesion, Material, Motion, NormalLaw, PairRule, line_of};
use serde::Serialize;

/// One effect: whether the scene calls for it, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Called {
    /// Its name.
    pub effect: &'static str,
    /// Whether it is simulated.
    pub on: bool,
    /// What the scene says, or what it does not.
    pub why: String,
    /// Line of the scene file, from 1; absent where the file leaves it to the default.
    pub line: Option<usize>,
}

/// All effects, in the order in which a step meets them. `text` is the scene file's.
pub fn called(scene: &Scene, text: &str) -> Vec<Called> {
    vec![
        gravity(scene, text),
        changing_gravity(scene, text),
        wall_motion(scene, text),
        driven_walls(scene, text),
        size_spread(scene, text),
        periodic_axes(scene, text),
        compliance(scene, text),
        viscosity(scene, text),
        of_materials(scene, text, "restitution", "restitution", |one| one.restitution, "impacts are inelastic"),
        Optional {
            effect: "falling restitution",
            key: "restitution_speed",
            of_material: |one| one.restitution_speed,
            of_rule: |rule| rule.restitution_speed,
            without: "restitution is the same at any speed",
        }
        .called(scene, text),
        of_materials(scene, text, "Coulomb friction", "friction", |one| one.friction, "grains are smooth"),
        Optional {
            effect: "kinetic friction",
            key: "kinetic_friction",
            of_material: |one| one.kinetic_friction,
            of_rule: |rule| rule.kinetic_friction,
            without: "friction is the same for what sticks and what slides",
        }
        .called(scene, text),
        spin(scene, text),
        cohesion(scene, text),
        of_materials(
            scene,
            text,
            "rolling resistance",
            "rolling_friction",
            |one| one.rolling_friction,
            "grains roll without a torque",
        ),
        of_materials(
            scene,
            text,
            "twisting resistance",
            "twisting_friction",
            |one| one.twisting_friction,
            "grains twist without a torque",
        ),
    ]
}

fn on(effect: &'static str, why: String, line: Option<usize>) -> Called {
    Called { effect, on: true, why, line }
}

fn off(effect: &'static str, why: impl Into<String>) -> Called {
    Called { effect, on: false, why: why.into(), line: None }
}

fn gravity(scene: &Scene, text: &str) -> Called {
    let [x, y, z] = scene.gravity;
    match scene.gravity == [0.0; 3] {
        true => off("gravity", "gravity = [0, 0, 0]"),
        false => on("gravity", format!("gravity = [{x}, {y}, {z}]"), line_of(text, &["gravity"])),
    }
}

fn changing_gravity(scene: &Scene, text: &str) -> Called {
    match scene.gravity_changes.as_slice() {
        [] => off("changing gravity", "gravity is constant"),
        [.., last] => {
            let [x, y, z] = last.gravity;
            let why = format!("gravity = [{x}, {y}, {z}] from {} s on", last.time);
            on("changing gravity", why, line_of(text, &["gravity_changes"]))
        }
    }
}

fn wall_motion(scene: &Scene, text: &str) -> Called {
    let moving = |motion: &Motion| match motion {
        Motion::Fixed | Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => None,
        Motion::Translating { .. } => Some("translates"),
        Motion::Rotating { .. } => Some("rotates"),
        Motion::Vibrating { .. } => Some("vibrates"),
    };
    let mut walls = scene.wall.iter().enumerate();
    match walls.find_map(|(index, wall)| Some((index, wall, moving(&wall.motion)?))) {
        Some((index, wall, moves)) => on(
            "wall motion",
            format!("wall '{}' {moves}", wall.name),
            line_of(text, &["wall", &index.to_string(), "motion"]),
        ),
        None => off("wall motion", "no wall moves as prescribed"),
    }
}

fn driven_walls(scene: &Scene, text: &str) -> Called {
    let driven = (scene.wall.iter().enumerate()).find(|(_, wall)| wall.motion.is_driven());
    match driven.map(|(index, wall)| (index, wall, matches!(wall.motion, Motion::ForceDriven { .. }))) {
        Some((index, wall, by_force)) => on(
            "driven walls",
            format!("a {} drives wall '{}'", if by_force { "force" } else { "torque" }, wall.name),
            line_of(text, &["wall", &index.to_string(), "motion"]),
        ),
        None => off("driven walls", "no force or torque drives a wall"),
    }
}

fn periodic_axes(scene: &Scene, text: &str) -> Called {
    let axes: Vec<&str> = scene.domain.periodic.iter().map(|axis| axis.name()).collect();
    match axes.is_empty() {
        true => off("periodic axes", "the domain ends on all sides"),
        false => {
            let line = line_of(text, &["domain", "periodic"]);
            on("periodic axes", format!("domain.periodic = {}", axes.join(", ")), line)
        }
    }
}

fn size_spread(scene: &Scene, text: &str) -> Called {
    let populations = scene.population.iter().map(|group| group.radius.bounds());
    let ranges: Vec<(f64, f64)> =
        populations.chain(scene.grain.iter().map(|grain| (grain.radius, grain.radius))).collect();
    let smallest = ranges.iter().fold(f64::INFINITY, |least, range| least.min(range.0));
    let largest = ranges.iter().fold(0.0, |most: f64, range| most.max(range.1));
    if smallest >= largest {
        return off("size spread", "all grains are of one size");
    }
    // The first population that has radii of its own, or other ones than those before it.
    let differs = |&index: &usize| ranges[index] != (ranges[0].0, ranges[0].0);
    let index = (0..scene.population.len()).find(differs);
    let line = index.and_then(|index| line_of(text, &["population", &index.to_string(), "radius"]));
    on("size spread", format!("radii from {smallest} to {largest} m"), line)
}

fn compliance(scene: &Scene, text: &str) -> Called {
    let line = line_of(text, &["solver", "normal_law"]).filter(|_| says(text, "normal_law"));
    match scene.solver.normal_law {
        NormalLaw::Rigid => off("elastic compliance", "solver.normal_law is rigid"),
        NormalLaw::Linear { stiffness } => on("elastic compliance", format!("linear, {stiffness} N/m"), line),
        NormalLaw::Hertz => on("elastic compliance", format!("Hertz, {}", stiffest(scene)), line),
    }
}

/// Whether the file spells a key out at all: the line of the nearest table says nothing then.
fn says(text: &str, key: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with(key) || line.contains(&format!(" {key} =")))
}

fn stiffest(scene: &Scene) -> String {
    let modulus = scene.material.values().map(|one| one.youngs_modulus).fold(0.0, f64::max);
    format!("stiffest material {modulus:e} Pa")
}

fn viscosity(scene: &Scene, text: &str) -> Called {
    let name = "contact viscosity";
    if scene.solver.normal_law == NormalLaw::Rigid {
        return off(name, "rigid contacts have restitution alone");
    }
    match scene.material.iter().find(|(_, one)| one.restitution < 1.0) {
        Some((material, one)) => on(
            name,
            format!("damps impacts that the step resolves to the restitution {} of '{material}'", one.restitution),
            line_of(text, &["material", material, "restitution"]),
        ),
        None => off(name, "every restitution is 1"),
    }
}

fn cohesion(scene: &Scene, text: &str) -> Called {
    let words = |cohesion: &Cohesion| match cohesion {
        Cohesion::Constant { force, range } => format!("a pull of {force} N up to a gap of {range} m"),
        Cohesion::SurfaceEnergy { work } => format!("a work of adhesion of {work} J/m2"),
    };
    if let Some((name, cohesion)) = scene.material.iter().find_map(|(name, one)| Some((name, one.cohesion.as_ref()?))) {
        let line = line_of(text, &["material", name, "cohesion"]);
        return on("cohesion", format!("material '{name}': {}", words(cohesion)), line);
    }
    let mut rules = scene.pair.iter().enumerate();
    match rules.find_map(|(index, rule)| Some((index, rule, rule.cohesion.as_ref()?))) {
        Some((index, rule, cohesion)) => {
            let [a, b] = &rule.between;
            let line = line_of(text, &["pair", &index.to_string(), "cohesion"]);
            on("cohesion", format!("pair '{a}', '{b}': {}", words(cohesion)), line)
        }
        None => off("cohesion", "nothing pulls"),
    }
}

fn spin(scene: &Scene, text: &str) -> Called {
    match scene.material.iter().find(|(_, one)| one.friction > 0.0) {
        Some((material, _)) => {
            on("spin", "friction turns grains".into(), line_of(text, &["material", material, "friction"]))
        }
        None => off("spin", "without friction nothing turns a grain"),
    }
}

/// A value that a table may give or not.
type Value<Table> = fn(&Table) -> Option<f64>;

/// An effect that is on where some material or pair names its key, which it need not.
struct Optional {
    effect: &'static str,
    key: &'static str,
    of_material: Value<Material>,
    of_rule: Value<PairRule>,
    /// What is the case where none does.
    without: &'static str,
}

impl Optional {
    fn called(&self, scene: &Scene, text: &str) -> Called {
        let Optional { effect, key, of_material, of_rule, without } = self;
        let mut materials = scene.material.iter();
        if let Some((name, value)) = materials.find_map(|(name, one)| Some((name, of_material(one)?))) {
            let line = line_of(text, &["material", name, key]);
            return on(effect, format!("material '{name}': {key} = {value}"), line);
        }
        let mut rules = scene.pair.iter().enumerate();
        match rules.find_map(|(index, rule)| Some((index, rule, of_rule(rule)?))) {
            Some((index, rule, value)) => {
                let [a, b] = &rule.between;
                let line = line_of(text, &["pair", &index.to_string(), key]);
                on(effect, format!("pair '{a}', '{b}': {key} = {value}"), line)
            }
            None => off(effect, *without),
        }
    }
}

/// An effect that is on where the coefficient of some material that is used, or of some pair, is above zero.
fn of_materials(
    scene: &Scene,
    text: &str,
    effect: &'static str,
    key: &'static str,
    of: fn(&Material) -> f64,
    without: &str,
) -> Called {
    if let Some((name, one)) = scene.material.iter().find(|(_, one)| of(one) > 0.0) {
        let line = line_of(text, &["material", name, key]);
        return on(effect, format!("material '{name}': {key} = {}", of(one)), line);
    }
    let coefficient = |index: usize| {
        let [a, b] = &scene.pair[index].between;
        let pair = scene.contact_coefficients(a, b, true);
        match key {
            "friction" => pair.friction,
            "restitution" => pair.restitution,
            "rolling_friction" => pair.rolling_friction,
            _ => pair.twisting_friction,
        }
    };
    match (0..scene.pair.len()).find(|&index| coefficient(index) > 0.0) {
        Some(index) => {
            let [a, b] = &scene.pair[index].between;
            let line = line_of(text, &["pair", &index.to_string(), key]);
            on(effect, format!("pair '{a}', '{b}': {key} = {}", coefficient(index)), line)
        }
        None => off(effect, without),
    }
}
