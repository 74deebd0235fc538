//! Checks that a scene is periodic along the periodic axes of its domain.

use super::document::{Checked, DocumentPath};
use super::error::short;
use super::{Axis, Motion, Scene, Shape, Wall};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// Smallest ratio of a period to the interaction range of a pair of grains: no two grains have two contacts, and boxes
/// at both ends have work of their own.
pub(crate) const REACHES: f64 = 3.0;

/// Sine of the largest angle between directions that count as parallel.
const PARALLEL: f64 = 1e-9;

/// Checks the period against the grains, and the periodicity of every wall.
pub(super) fn check(scene: &Scene) -> Checked {
    let (domain, at) = (&scene.domain, DocumentPath::default().key("domain"));
    let largest = scene.grain_kinds().map(|(_, (_, largest))| largest).fold(0.0, f64::max);
    for axis in &domain.periodic {
        let (length, number) = (domain.max[axis.number()] - domain.min[axis.number()], axis.number());
        let least = REACHES * (largest * (2.0 + scene.solver.skin) + range_of_cohesion(scene, largest));
        let problem = || {
            let (length, axis) = (short(length), axis.name());
            format!("{length} m along {axis} are too short a period for grains of this size")
        };
        at.key("max").require(
            length >= least,
            problem,
            &format!("make the domain at least {} m long there", short(least)),
        )?;
        for (index, wall) in scene.wall.iter().enumerate() {
            let why = breaks(wall, &scene.course(index), *axis, [domain.min[number], domain.max[number]]);
            let (name, axis) = (&wall.name, axis.name());
            let words = |why| format!("wall '{name}' does not repeat itself along the periodic axis {axis}: {why}");
            let at = DocumentPath::default().key("wall").index(index);
            at.refuse(why.map(words), "change the wall, or take the axis out of domain.periodic")?;
        }
    }
    Ok(())
}

/// Returns the largest gap (m) with cohesion between the materials of grains and walls.
fn range_of_cohesion(scene: &Scene, largest_radius: f64) -> f64 {
    let of_grains = scene.grain_kinds().map(|(material, _)| material);
    let names: BTreeSet<&str> = of_grains.chain(scene.wall.iter().map(|wall| wall.material.as_str())).collect();
    let used = || names.iter().filter_map(|name| scene.material.get(*name));
    let rules = scene.pair.iter().filter(|rule| rule.between.iter().all(|name| names.contains(name.as_str())));
    let softest = used().map(|material| material.youngs_modulus).fold(f64::INFINITY, f64::min);
    let ranges = used()
        .filter_map(|material| material.cohesion)
        .chain(rules.filter_map(|rule| rule.cohesion))
        .map(|cohesion| cohesion.pull(largest_radius, 0.5 * softest).range);
    ranges.fold(0.0, f64::max)
}

/// Returns the reason why a wall is not periodic along an axis with these ends; `None` if the wall is periodic.
fn breaks(wall: &Wall, course: &Motion, axis: Axis, ends: [f64; 2]) -> Option<&'static str> {
    let along = Vector3::ith(axis.number(), 1.0);
    let parallel = |direction: &[f64; 3]| Vector3::from(*direction).normalize().cross(&along).norm() < PARALLEL;
    let across = |direction: &[f64; 3]| Vector3::from(*direction).normalize().dot(&along).abs() < PARALLEL;
    let face = match &wall.shape {
        Shape::Plane { normal, .. } => (!across(normal)).then_some("the plane is not parallel to the axis"),
        Shape::Box { open, .. } => {
            let closed = |sign: &str| !open.contains(&format!("{sign}{}", axis.name()));
            (closed("-") || closed("+")).then_some("list its two faces there as open")
        }
        Shape::Cylinder { base, axis: own, length, .. } if parallel(own) => {
            let far = base[axis.number()] + length * Vector3::from(*own).normalize()[axis.number()];
            let (low, high) = (base[axis.number()].min(far), base[axis.number()].max(far));
            let slack = PARALLEL * (ends[1] - ends[0]);
            (low > ends[0] + slack || high < ends[1] - slack)
                .then_some("the cylinder does not reach both ends of the domain")
        }
        Shape::Cylinder { .. } => Some("the cylinder is not parallel to the axis"),
        Shape::Spheres { .. } => None,
        _ => Some("its shape has edges"),
    };
    face.or_else(|| course.parts().iter().find_map(|motion| turns_wrongly(motion, &wall.shape, &parallel)))
}

/// Returns the reason why a motion ends the periodicity of a shape along an axis, to which `parallel` compares directions.
fn turns_wrongly(motion: &Motion, shape: &Shape, parallel: &impl Fn(&[f64; 3]) -> bool) -> Option<&'static str> {
    if let Motion::Table { content, .. } = motion {
        return content.turns().then_some("a table turns it");
    }
    let (_, turning) = motion.axis()?;
    let is_own = match shape {
        Shape::Spheres { .. } => return Some("spheres that turn about an axis"),
        Shape::Plane { normal, .. } => Vector3::from(*normal).cross(&Vector3::from(turning)).norm() < PARALLEL,
        _ => false,
    };
    (!is_own && !parallel(&turning)).then_some("it turns about another axis")
}
