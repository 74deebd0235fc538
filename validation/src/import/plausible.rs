//! What the frames of a scene cannot have: grains outside of it, contacts of grains that are apart.

use crate::plan::{Scene, setup_hash};
use crate::recording::{grains_belong_to, outside_domain};
use crate::run_frames::RunFrames;
use makadam::effects::period::Period;
use makadam::scene::{Domain, Reaction, Shape, Wall};
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam::wall::{PlacedFace, PlacedWalls};
use nalgebra::Vector3;

/// Gap over the smaller radius beyond which no law of contacts acts. Contacts are told of positions up to a step ago.
const APART: f64 = 1.0;

/// Tangential over normal force below which there is none: digits of forces and places leave some.
const FRICTIONLESS: f64 = 1e-6;

/// So few contacts of a frame may all be without a tangential force.
const FEW_CONTACTS: usize = 20;

/// What is wrong with a contact of grains, or of a grain and a wall, that are apart, in words that follow their names.
pub(super) fn apart(first: &Particle, second: Option<&Particle>, towards: &Vector3<f64>) -> Option<String> {
    let (reach, smaller) = match second {
        Some(second) => (first.radius + second.radius, first.radius.min(second.radius)),
        None => (first.radius, first.radius),
    };
    let gap = towards.norm() - reach;
    (gap > APART * smaller).then(|| {
        format!("are {gap:.3e} m apart, and do not touch; see to it that contacts count grains as the frames do, and are of their time")
    })
}

/// By how much the point of two grains (m) lies outside of the first or the second, m, where it lies farther than contacts can.
pub(super) fn beside(first: &Particle, second: &Particle, point: &Vector3<f64>, period: Period) -> Option<f64> {
    let outside = |grain: &Particle| period.arm(&grain.position.into(), point).norm() - grain.radius;
    let off = outside(first).max(outside(second));
    (off > APART * first.radius.min(second.radius)).then_some(off)
}

/// That a run is of another scene than it is measured by, in a sentence, if it is.
pub(super) fn of_other_scene(run: &RunFrames, scene: &Scene) -> Option<String> {
    let (folder, name) = (run.folder(), run.scene());
    let is_other = match run.setup_hash() {
        Some(hash) => hash != setup_hash(scene),
        None => name != scene.name,
    };
    is_other.then(|| match name == scene.name {
        true => format!(
            "{} is a run of {name} with other walls, materials, grains or effects than those given here; give the scene that was run, with the \
             same changes (--set)",
            folder.display()
        ),
        false => format!("{} is a run of {name}, and is measured by {}", folder.display(), scene.name),
    })
}

/// Angle between a contact's normal and the way to its partner from which on they contradict each other, degrees: contacts are told of
/// positions up to a step ago, and fast grains turn about each other in a long one.
const ASKEW: f64 = 60.0;

/// By how much a given normal is off the way to the partner (m), degrees, where it contradicts it; the way tells nothing where it is short
/// against the radius (m).
pub(super) fn askew(normal: &Vector3<f64>, towards: &Vector3<f64>, radius: f64) -> Option<f64> {
    let angle = normal.angle(towards).to_degrees();
    (towards.norm() > 0.1 * radius && angle > ASKEW).then_some(angle)
}

/// The image of a place that lies in the domain, as far as it is periodic; the place itself where it lies inside.
pub(super) fn image(domain: &Domain, place: Vector3<f64>) -> Vector3<f64> {
    let low = Vector3::from(domain.min);
    let wrapped = domain.period().wrapped(&place, &low);
    let is_inside = |axis: usize| (domain.min[axis]..domain.max[axis]).contains(&place[axis]);
    Vector3::from_fn(|axis, _| if is_inside(axis) { place[axis] } else { wrapped[axis] })
}

/// What a reader must know of measured frames that are unlike the scene, in sentences.
pub(crate) fn unlike<'f>(scene: &Scene, frames: impl Iterator<Item = &'f Snapshot> + Clone) -> Vec<String> {
    let filled = || frames.clone().filter(|frame| !frame.particles.is_empty());
    let mut notes: Vec<String> = filled().find_map(|frame| grains_belong_to(frame, scene).err()).into_iter().collect();
    let is_meant = scene.watch.on_escape == Reaction::Ignore;
    notes.extend(filled().find_map(|frame| outside_domain(frame, scene)).filter(|_| !is_meant));
    notes.extend(filled().find_map(|frame| behind_walls(frame, scene)));
    let contacts = || filled().flat_map(|frame| &frame.contacts);
    if contacts().next().is_some() && !contacts().any(|contact| contact.normal_force > 0.0) {
        notes.push(
            "no contact pushes its grains apart: forces are to be those on the first grain, and normals lead away from it".into(),
        );
    }
    let has_friction = scene.material.values().any(|material| material.friction > 0.0);
    let drags = |contact: &Contact| {
        let tangential = Vector3::from(contact.tangential_force).norm();
        tangential > FRICTIONLESS * contact.normal_force.abs()
    };
    let has_many = filled().any(|frame| frame.contacts.len() > FEW_CONTACTS);
    if has_friction && has_many && !contacts().any(drags) {
        notes.push(
            "no contact has a tangential force, and the scene has friction: forces are to be whole ones, not their normal parts".into(),
        );
    }
    notes
}

/// That grains of a frame lie behind planes and faces of boxes by more than their radius, in a sentence, if some do. Walls that a force
/// or a torque drives count where the frame tells where they are, boxes where no grain is meant to leave the scene.
fn behind_walls(frame: &Snapshot, scene: &Scene) -> Option<String> {
    let placed = PlacedWalls::at(&scene.wall, &scene.domain, frame.time, &frame.driven_walls);
    let is_told = |wall: usize| frame.driven_walls.iter().any(|driven| driven.wall as usize == wall);
    let counts = |wall: usize| match &scene.wall[wall] {
        Wall { motion, .. } if motion.is_driven() && !is_told(wall) => false,
        Wall { shape: Shape::Box { .. }, .. } => scene.watch.on_escape != Reaction::Ignore,
        Wall { shape, .. } => matches!(shape, Shape::Plane { .. }),
    };
    let faces: Vec<(usize, PlacedFace<'_>)> = placed.faces().filter(|(wall, _)| counts(*wall)).collect();
    let deepest = |grain: &Particle| {
        let depths = faces.iter().map(|(wall, face)| (-face.distance(&grain.position.into()), *wall));
        depths.max_by(|one, other| one.0.total_cmp(&other.0)).filter(|(depth, _)| *depth > grain.radius)
    };
    let (grain, (depth, wall)) = frame.particles.iter().find_map(|grain| Some((grain.id, deepest(grain)?)))?;
    let count = frame.particles.iter().filter(|grain| deepest(grain).is_some()).count();
    Some(format!(
        "in the frame at {} s {count} of {} grains lie behind walls of '{}' by more than their radius, the first of them grain {grain}, \
         {depth:.3e} m behind '{}': axes, units and origin have to be those of the scene",
        frame.time,
        frame.particles.len(),
        scene.name,
        scene.wall[wall].name
    ))
}

/// That measured frames are the same as the one before, to the last bit, if some are.
pub(super) fn standing<'f>(frames: impl Iterator<Item = &'f Snapshot>) -> Option<String> {
    let frames: Vec<&Snapshot> = frames.filter(|frame| !frame.particles.is_empty()).collect();
    let same = frames.windows(2).filter(|pair| pair[0].particles == pair[1].particles).count();
    (same > 0).then(|| {
        format!(
            "{same} of {} measured frames are the same as the one before, to the last bit: their grains stand still, or the frame was written \
             again",
            frames.len()
        )
    })
}

/// Whether two contacts with a wall are one that is told twice: at one point, with one force.
pub(super) fn is_same(one: &Contact, other: &Contact) -> bool {
    matches!(one.second, Partner::Wall(_))
        && (one.first, one.second, one.point, one.normal_force, one.tangential_force)
            == (other.first, other.second, other.point, other.normal_force, other.tangential_force)
}
