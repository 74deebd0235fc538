//! Range checks of a scene before the simulation.

use super::coefficients::coefficients;
use super::document::{Checked, Document, DocumentPath};
use super::error::{Fault, is_printable, short};
use super::settings::{Obstacle, SettingError};
use super::types::usual_spacing;
use super::{
    ContactCoefficients, Domain, GrainEntry, MOST_MEMORY, NormalLaw, Placement, Scene, Shape, SolverMethod,
    SolverSettings, Stop, TangentialLaw, flow, gauge, motion, periodic, stages,
};
use crate::surface::FACES;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Largest number of grains of a scene: grains and contacts have 32-bit indices.
pub(crate) const MOST_GRAINS: f64 = 1e8;
/// Largest number of materials: materials have 8-bit indices.
const MOST_MATERIALS: usize = 256;
/// Largest number of sweeps per step, inner sweeps included: interrupts are not polled within a step.
const MOST_SWEEPS: f64 = 1e6;
/// Largest number of inner sweeps per sweep over all boxes: more than one inner sweep does not pay (`docs/memory.md`).
const MOST_INNER_SWEEPS: f64 = 1e3;

/// Checks every value of a scene against its physical range.
pub(super) fn check(scene: &Scene) -> Checked {
    names(scene)?;
    let root = DocumentPath::default();
    root.key("duration").range(scene.duration, 0.0, 1e5, "s")?;
    gravity(scene)?;
    extent(&root.key("domain"), &scene.domain.min, &scene.domain.max)?;
    periodic::check(scene)?;
    root.key("largest_start_overlap").range(scene.largest_start_overlap, 0.0, 2.0, "smaller radii")?;
    materials(scene)?;
    walls(scene)?;
    grains(scene)?;
    flow::check(scene)?;
    gauge::check(scene)?;
    accuracy(scene)?;
    solver(scene)?;
    stages::check(scene)?;
    watch(scene)
}

pub(super) fn gravity(scene: &Scene) -> Checked {
    let root = DocumentPath::default();
    root.key("gravity").finite(&scene.gravity)?;
    let mut before = 0.0;
    for (index, change) in scene.gravity_changes.iter().enumerate() {
        let at = root.key("gravity_changes").index(index);
        at.key("gravity").finite(&change.gravity)?;
        at.key("time").range(change.time, 0.0, 1e6, "s")?;
        let problem = || format!("{} s is not after {} s, the time before it", short(change.time), short(before));
        let remedy = "list the changes in the order of their times, the first above 0";
        at.key("time").require(change.time > before, problem, remedy)?;
        before = change.time;
    }
    Ok(())
}

fn watch(scene: &Scene) -> Checked {
    let (at, watch) = (DocumentPath::default().key("watch"), &scene.watch);
    at.key("overlap").range(watch.overlap, 1e-9, 2.0, "(over the smaller radius)")?;
    at.key("energy").range(watch.energy, 1e-9, 1e6, "(no unit)")?;
    at.key("residual").range(watch.residual, 1e-12, 1e12, "(in units of g h)")
}

pub(super) fn materials(scene: &Scene) -> Checked {
    let (all, problem) = (DocumentPath::default().key("material"), || format!("{} materials", scene.material.len()));
    all.require(scene.material.len() <= MOST_MATERIALS, problem, &format!("define at most {MOST_MATERIALS}"))?;
    for (name, material) in &scene.material {
        let at = DocumentPath::default().key("material").name(name);
        at.key("density").usual(material.density, [1.0, 3e4], [1e-6, 1e9], scene.unusual_values, "kg/m3")?;
        at.key("youngs_modulus").range(material.youngs_modulus, 1e2, 1e13, "Pa")?;
        at.key("poisson_ratio").range(material.poisson_ratio, 0.0, 0.4999, "(no unit)")?;
        for one in coefficients() {
            one.check(&at, (one.of_material)(material), |ceiling| (ceiling.of_material)(material))?;
        }
    }
    for (index, rule) in scene.pair.iter().enumerate() {
        let at = DocumentPath::default().key("pair").index(index);
        for name in &rule.between {
            known_material(scene, &at.key("between"), name)?;
        }
        let [a, b] = &rule.between;
        for one in coefficients() {
            one.check(&at, (one.of_rule)(rule), |ceiling| least(scene, [a, b], ceiling.of_contact))?;
        }
    }
    Ok(())
}

/// Returns a coefficient of contacts of two materials: the smaller value if both are materials of walls.
fn least(scene: &Scene, [first, second]: [&str; 2], of: fn(&ContactCoefficients) -> f64) -> f64 {
    let of_walls = |name: &str| scene.wall.iter().any(|wall| wall.material == name);
    let value = |a: &str, b: &str, wall: bool| of(&scene.contact_coefficients(a, b, wall));
    match (of_walls(first), of_walls(second)) {
        (true, true) => value(second, first, true).min(value(first, second, true)),
        (true, false) => value(second, first, true),
        (false, wall) => value(first, second, wall),
    }
}

pub(super) fn walls(scene: &Scene) -> Checked {
    for (index, wall) in scene.wall.iter().enumerate() {
        let at = DocumentPath::default().key("wall").index(index);
        known_material(scene, &at.key("material"), &wall.material)?;
        shape(&at.key("shape"), &wall.shape)?;
        at.key("surface_velocity").finite(&wall.surface_velocity)?;
        let problem = || "given for a wall that a force or a torque moves, whose surface moves with it".into();
        let (fits, remedy) = (!wall.motion.is_driven(), "leave it out, or prescribe the motion of the wall");
        at.key("surface_velocity").require(fits || wall.surface_velocity == [0.0; 3], problem, remedy)?;
        wall.motion.check(&at.key("motion"))?;
    }
    motion::check_parents(scene)
}

/// Checks the values of a shape.
pub(super) fn shape(at: &DocumentPath, shape: &Shape) -> Checked {
    match shape {
        Shape::Plane { point, normal } => {
            at.key("point").finite(point)?;
            at.key("normal").direction(normal)
        }
        Shape::Box { min, max, open } => {
            extent(at, min, max)?;
            open.iter().try_for_each(|face| {
                let (known, remedy) = (FACES.contains(&face.as_str()), "use -x, +x, -y, +y, -z or +z");
                at.key("open").require(known, || format!("'{face}' is not a face"), remedy)
            })
        }
        Shape::Cylinder { base, axis, radius, length } => tube(at, (base, axis), (&[*radius], "radius"), *length),
        Shape::Frustum { base, axis, radii, length } => tube(at, (base, axis), (radii, "radii"), *length),
        Shape::Rectangle { corner, edges } => {
            at.key("corner").finite(corner)?;
            edges.iter().try_for_each(|edge| at.key("edges").finite(edge))?;
            let [one, other] = edges.map(Vector3::from);
            let (least, most) = (one.norm().min(other.norm()), one.norm().max(other.norm()));
            let spans = least >= 1e-9 && one.cross(&other).norm() >= 1e-6 * least * most;
            let remedy = "give two sides of at least 1e-9 m in different directions";
            at.key("edges").require(spans, || format!("{edges:?} span no area"), remedy)
        }
        Shape::Spheres { centres, radius } => {
            let mut all = centres.iter().enumerate();
            all.try_for_each(|(number, centre)| at.key("centres").index(number).finite(centre))?;
            at.key("radius").range(*radius, 1e-9, 1e4, "m")
        }
        Shape::Mesh { file, scale, rotate, translate, content } => {
            at.key("scale").range(*scale, 1e-9, 1e9, "m")?;
            at.key("translate").finite(translate)?;
            if let Some(rotate) = rotate {
                at.key("rotate").key("axis").direction(&rotate.axis)?;
                at.key("rotate").key("angle").range(rotate.angle, -360.0, 360.0, "degrees")?;
            }
            let remedy = "parse the scene with its folder, or create the shape by Shape::mesh";
            at.key("file").require(!content.is_empty(), || format!("'{file}' has not been read"), remedy)?;
            let near = shape.bounds().iter().flat_map(|(low, high)| low.iter().chain(high)).all(|x| x.abs() < 1e6);
            let remedy = "give the metres per unit of the file, such as 0.001 for millimetres";
            at.key("scale").require(near, || format!("'{file}' has corners beyond 1e6 m"), remedy)
        }
        Shape::Disc { centre, normal, radius, hole } => {
            at.key("centre").finite(centre)?;
            at.key("normal").direction(normal)?;
            at.key("radius").range(*radius, 1e-9, 1e4, "m")?;
            at.key("hole").range(*hole, 0.0, *radius, "m, the radius of the disc")
        }
    }
}

/// Checks a cylinder or a frustum, of which one radius may be zero.
pub(super) fn tube(
    at: &DocumentPath,
    (base, axis): (&[f64; 3], &[f64; 3]),
    (radii, key): (&[f64], &'static str),
    length: f64,
) -> Checked {
    at.key("base").finite(base)?;
    at.key("axis").direction(axis)?;
    at.key(key).range(radii[0].max(radii[radii.len() - 1]), 1e-9, 1e4, "m")?;
    radii.iter().try_for_each(|radius| at.key(key).range(*radius, 0.0, 1e4, "m"))?;
    at.key("length").range(length, 1e-9, 1e4, "m")
}

fn grains(scene: &Scene) -> Checked {
    let mut count = scene.listed().count() as f64;
    for (index, population) in scene.population.iter().enumerate() {
        let at = DocumentPath::default().key("population").index(index);
        known_material(scene, &at.key("material"), &population.material)?;
        count += population.count as f64;
        at.key("count").range(count, 0.0, MOST_GRAINS, "grains, with those before it")?;
        at.key("spacing").range(population.spacing, 1.0, 100.0, "largest diameters")?;
        at.key("agitation").range(population.agitation, 0.0, 1e3, "m/s")?;
        population.radius.check(&at.key("radius"))?;
        let (fits, remedy) = (population.spacing == usual_spacing(), "leave it out, or let placement = 'lattice'");
        let problem = || "given with random places, which have no lattice".into();
        at.key("spacing").require(fits || population.placement != Placement::Random, problem, remedy)?;
        population.region.check(&at.key("region"))?;
    }
    for (index, grain) in scene.grain.iter().enumerate() {
        listed(scene, &DocumentPath::default().key("grain").index(index), grain)?;
    }
    let Some(start) = &scene.start else { return Ok(()) };
    if start.grains().is_empty() && scene.insert.is_empty() {
        let remedy = "give a line for each grain; a start without grains needs an [[insert]]";
        return Err(start.at_line(1, "names of columns, and no grains", remedy));
    }
    let mut grains = start.grains().iter().enumerate();
    grains.try_for_each(|(index, grain)| {
        listed(scene, &DocumentPath::default(), grain).map_err(|fault| start.of_grain(index, &fault))
    })
}

/// Checks the values of a grain with a given position.
fn listed(scene: &Scene, at: &DocumentPath, grain: &GrainEntry) -> Checked {
    known_material(scene, &at.key("material"), &grain.material)?;
    at.key("radius").range(grain.radius, 1e-9, 100.0, "m")?;
    at.key("position").finite(&grain.position)?;
    at.key("velocity").finite(&grain.velocity)?;
    at.key("spin").finite(&grain.spin)
}

/// Refuses a step or a stop in addition to an accuracy, which chooses both.
pub(super) fn chosen_twice(document: &Document<'_>) -> Checked {
    for key in ["step", "stop"] {
        let at = DocumentPath::default().key("solver").key(key);
        let problem = || "given beside accuracy, which chooses it".into();
        at.require(!document.has("solver", key), problem, "leave this key or accuracy out")?;
    }
    Ok(())
}

fn accuracy(scene: &Scene) -> Checked {
    let Some(accuracy) = &scene.accuracy else { return Ok(()) };
    let at = DocumentPath::default().key("accuracy");
    let asks = "give one of angle, packing_fraction, friction_mobilisation, overlap, relative";
    at.require(!accuracy.is_empty(), || "asks for nothing".into(), asks)?;
    let problem = || "the scene has no gravity, and accuracies are known of grains that settle under gravity".into();
    at.require(scene.largest_gravity() > 0.0, problem, "leave it out, and give solver.step and solver.stop")?;
    let asked = [
        ("angle", accuracy.angle, "degrees"),
        ("packing_fraction", accuracy.packing_fraction, "(no unit)"),
        ("friction_mobilisation", accuracy.friction_mobilisation, "(no unit)"),
        ("overlap", accuracy.overlap, "mean radii"),
        ("relative", accuracy.relative, "(no unit)"),
    ];
    for (key, value, unit) in asked {
        if let Some(value) = value {
            at.key(key).range(value, 1e-6, 10.0, unit)?;
        }
    }
    Ok(())
}

pub(super) fn solver(scene: &Scene) -> Checked {
    let at = DocumentPath::default().key("solver");
    let settings = &scene.solver;
    at.key("step").usual(settings.step, [1e-9, 0.1], [1e-15, 0.1], scene.unusual_values, "s")?;
    at.key("over_relaxation").range(settings.over_relaxation, 0.1, 1.9, "(no unit)")?;
    at.key("damping_steps").range(settings.damping_steps, 0.0, 1e3, "time steps")?;
    at.key("restitution_threshold").range(settings.restitution_threshold.unwrap_or(0.0), 0.0, 1e3, "m/s")?;
    at.key("skin").range(settings.skin, 1e-3, 10.0, "mean radii")?;
    at.key("warm_start").range(settings.warm_start, 0.0, 1.0, "(no unit)")?;
    if let NormalLaw::Linear { stiffness } = settings.normal_law {
        at.key("normal_law").key("stiffness").range(stiffness, 1e-6, 1e15, "N/m")?;
    }
    tangential_law(settings, &at.key("tangential_law"))?;
    let method = at.key("method");
    match settings.method {
        SolverMethod::Anderson { memory } => {
            method.key("memory").range(f64::from(memory), 1.0, MOST_MEMORY as f64, "iterations")?;
        }
        SolverMethod::Jacobi { damping } => method.key("damping").range(damping, 1e-3, 1.0, "(no unit)")?,
        _ => {}
    }
    if let Err(error) = scene.goes_with(settings.method, settings.precision) {
        return Err(unsuitable(scene, &error));
    }
    let stop = at.key("stop");
    let most = match settings.stop {
        Stop::Sweeps { .. } => stop.key("sweeps"),
        Stop::Residual { tolerance, .. } => {
            stop.key("tolerance").range(tolerance, 1e-16, 1e6, "g h")?;
            stop.key("max_sweeps")
        }
        Stop::TimeBudget { seconds, .. } => {
            stop.key("seconds").range(seconds, 1e-9, 1e3, "s")?;
            stop.key("max_sweeps")
        }
    };
    let (sweeps, inner) = (f64::from(settings.stop.max_sweeps()), f64::from(settings.inner_sweeps));
    most.range(sweeps, 1.0, MOST_SWEEPS, "sweeps")?;
    at.key("inner_sweeps").range(inner, 1.0, MOST_INNER_SWEEPS, "sweeps over a box for each over all")?;
    let problem = || format!("{inner} for each of {sweeps} sweeps are {} sweeps a step", short(sweeps * inner));
    let remedy = format!("lower it or solver.stop, to at most {} sweeps a step", short(MOST_SWEEPS));
    at.key("inner_sweeps").require(sweeps * inner <= MOST_SWEEPS, problem, &remedy)
}

fn tangential_law(settings: &SolverSettings, at: &DocumentPath) -> Checked {
    let TangentialLaw::Spring { stiffness_ratio } = settings.tangential_law else { return Ok(()) };
    if let Some(ratio) = stiffness_ratio {
        at.key("stiffness_ratio").range(ratio, 1e-3, 1e3, "of the normal stiffness")?;
    }
    let problem = || "a spring, beside a rigid normal law that has no stiffness to go by".into();
    let remedy = "give normal_law a stiffness, or leave tangential_law out";
    at.require(settings.normal_law != NormalLaw::Rigid, problem, remedy)
}

/// Refuses a method or a precision that lacks equations for the scene.
fn unsuitable(scene: &Scene, error: &SettingError) -> Fault {
    let at = DocumentPath::default().key("solver");
    let (key, asked, obstacle) = match error {
        SettingError::SinglePrecision(obstacle) => ("precision", "single", obstacle),
        SettingError::Method { method, obstacle } => ("method", method.name(), obstacle),
        other => return at.fault(other.to_string(), "leave it out"),
    };
    let (beside, goes) = match obstacle {
        Obstacle::Torques => {
            let rolling = scene.possible_contacts().any(|contact| contact.rolling_friction > 0.0);
            let key = if rolling { "rolling_friction" } else { "twisting_friction" };
            (format!("where a material has {key}"), "torques go")
        }
        Obstacle::DrivenWalls => {
            let driven = scene.wall.iter().find(|wall| wall.motion.is_driven());
            (format!("where wall '{}' is driven", driven.map_or("", |wall| &wall.name)), "driven walls go")
        }
        Obstacle::TangentialSpring => ("where tangential_law is a spring".into(), "tangential springs go"),
        Obstacle::Method | Obstacle::SinglePrecision => {
            let problem = format!("{asked}, with method {}", scene.solver.method.name());
            return at.key(key).fault(problem, "single precision goes with gauss-seidel alone; leave one out");
        }
    };
    let remedy = format!("{goes} with gauss-seidel in double precision alone; leave one out");
    at.key(key).fault(format!("{asked}, {beside}"), &remedy)
}

pub(super) fn interval(at: &DocumentPath, start: f64, stop: Option<f64>) -> Checked {
    at.key("start").range(start, 0.0, 1e6, "s")?;
    at.key("stop").range(stop.unwrap_or(start), start, 1e6, "s")
}

pub(super) fn extent(at: &DocumentPath, min: &[f64; 3], max: &[f64; 3]) -> Checked {
    at.key("min").finite(min)?;
    at.key("max").finite(max)?;
    let problem = || format!("max {max:?} is not above min {min:?} along every axis");
    let remedy = "give the lower corner as min and the upper corner as max";
    at.key("max").require((0..3).all(|i| min[i] < max[i]), problem, remedy)
}

pub(super) fn known_material(scene: &Scene, at: &DocumentPath, name: &str) -> Checked {
    if scene.material.contains_key(name) {
        return Ok(());
    }
    let known = scene.material.keys().cloned().collect::<Vec<_>>().join(", ");
    let remedy = format!("add [material.{name}] or name one of: {known}");
    Err(at.fault(format!("there is no material '{name}'"), &remedy))
}

/// Longest name, bytes: file names are limited to 255 bytes, and results add a suffix to the name of the scene.
const LONGEST: usize = 100;

/// Reserved name: columns of a dynamic wall in the table of observables begin with the wall's name, and an observable has this prefix.
const TAKEN: &str = "driven_wall";

/// Checks the names of the scene and rejects duplicates.
fn names(scene: &Scene) -> Checked {
    let root = DocumentPath::default();
    let at = root.key("name");
    fit(&at, "the scene's name", &scene.name)?;
    let is_path = scene.name.contains(['/', '\\']) || scene.name == "." || scene.name == "..";
    let problem = is_path.then(|| format!("'{}' does not name a folder of results", scene.name));
    at.refuse(problem, "give a name without '/' and '\\', other than '.' and '..'")?;
    let odd = scene.description.chars().find(|&c| !is_printable(c) && !matches!(c, '\n' | '\r' | '\t'));
    let problem = odd.map(|odd| format!("has the character {}, which does not show", odd.escape_unicode()));
    root.key("description").refuse(problem, "leave it out")?;
    for name in scene.material.keys() {
        fit(&root.key("material"), "a material's name", name)?;
    }
    for (index, wall) in scene.wall.iter().enumerate() {
        let problem = || format!("the columns of a driven wall '{TAKEN}' would be those of the observable driven-wall");
        let free = wall.name != TAKEN || !wall.motion.is_driven();
        root.key("wall").index(index).key("name").require(free, problem, "give the wall another name")?;
    }
    own_names(&root.key("wall"), "wall", scene.wall.iter().map(|wall| &*wall.name))?;
    let mut pairs = HashMap::new();
    for (index, rule) in scene.pair.iter().enumerate() {
        let [a, b] = &rule.between;
        let before = pairs.insert((a.min(b), a.max(b)), index);
        let problem = before.map(|before| format!("pair[{before}] is a rule of '{a}' and '{b}' already"));
        let at = root.key("pair").index(index).key("between");
        at.refuse(problem, "say in one rule all that holds for the two, in any order")?;
    }
    Ok(())
}

/// Checks the names of the entries of a list, each valid and unlike those before it; `what` is such an entry.
pub(super) fn own_names<'n>(list: &DocumentPath, what: &str, names: impl Iterator<Item = &'n str>) -> Checked {
    let mut known = HashMap::new();
    for (index, name) in names.enumerate() {
        let at = list.index(index).key("name");
        fit(&at, &format!("a {what}'s name"), name)?;
        let problem = known.insert(name, index).map(|before| format!("'{name}' is the name of {what}[{before}] too"));
        at.refuse(problem, &format!("give each {what} a name of its own: tables tell them apart by it"))?;
    }
    Ok(())
}

/// Checks that a box between two corners (m) meets the domain, or lies `entirely` inside it.
pub(super) fn in_domain(
    scene: &Scene,
    at: &DocumentPath,
    (low, high): ([f64; 3], [f64; 3]),
    entirely: bool,
) -> Checked {
    let Domain { min, max, .. } = scene.domain;
    let [below, above] = if entirely { [low, high] } else { [high, low] };
    let fits = (0..3).all(|axis| below[axis] >= min[axis] && above[axis] <= max[axis]);
    let place = if entirely { "not inside the domain" } else { "outside the domain: no grain can reach it" };
    at.require(fits, || format!("from {low:?} to {high:?} m, {place}"), "move it into [domain], or enlarge [domain]")
}

/// Checks that a name is printable and valid in a table and as a file name.
pub(super) fn fit(at: &DocumentPath, whose: &str, name: &str) -> Checked {
    at.require(!name.trim().is_empty(), || format!("{whose} is empty"), "give a name")?;
    let start: String = name.chars().take(20).collect();
    let problem = || format!("{whose} '{start}...' is {} bytes long", name.len());
    at.require(name.len() <= LONGEST, problem, &format!("give a name of at most {LONGEST} bytes"))?;
    let odd = name.chars().find(|&c| !is_printable(c)).map(char::escape_unicode);
    at.refuse(odd.map(|odd| format!("{whose} has the character {odd}, which does not show")), "leave it out")?;
    let problem = || format!("{whose} '{name}' begins as a formula does");
    let remedy = "begin with another character: programs for tables would compute it";
    at.require(!name.starts_with(['=', '+', '-', '@']), problem, remedy)
}
