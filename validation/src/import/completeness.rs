//! Evidence that a list of contacts is not complete: spheres that overlap touch.
//!
//! A file that lists contacts states that these are all, and lists that lacked some were written by people who took them to be complete. So no
//! statement of the caller replaces the check, and none overrides it: a list is refused for what overlaps and is not in it, beyond the
//! fractions below, which allow for positions a step younger than contacts and for walls made of triangles.

use crate::observables::close_pairs;
use crate::plan::Scene;
use crate::recording::Content;
use makadam::snapshot::{Particle, Snapshot};
use makadam::wall::PlacedWalls;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Overlap, over the mean one of the pairs that are told, from which on two spheres should be in a list of contacts: positions are a step
/// younger than contacts.
const DEEP: f64 = 0.25;

/// The same over the radius, where so many of the pairs that are told lie apart that few digits hide what is shallower.
const LEAST_DEPTH: f64 = 1e-4;

/// Share of the pairs that are told which overlap, from which on places are exact enough for any overlap.
const EXACT: f64 = 0.9;

/// Share of the pairs that overlap deeply of which a whole list may lack no more.
const DEEP_UNTOLD: f64 = 0.02;

/// The same of all pairs that overlap, where velocities tell those that part: these may bear nothing.
const ANY_UNTOLD: f64 = 0.05;

/// So many times its chance deviation must what is untold exceed the pairs that are told and lie apart: what moved since the contacts were
/// told makes as many of both.
const BEYOND_CHANCE: f64 = 2.0;

/// Share of the grains that lie in a wall of which a whole list may lack no more: a wall made of triangles is not quite where the scene has it.
const AT_WALL_UNTOLD: f64 = 0.2;

/// Angle between a contact and the way to the nearest point of a face within which it is one with that face, degrees.
const TOWARDS_FACE: f64 = 30.0;

/// So few grains in a wall tell nothing.
const FEW: usize = 5;

/// What overlaps, and how much of it no list tells.
#[derive(Default)]
struct Count {
    all: usize,
    untold: usize,
    example: Option<String>,
}

impl Count {
    fn add(&mut self, is_told: bool, what: impl FnOnce() -> String) {
        self.all += 1;
        if !is_told {
            self.untold += 1;
            self.example.get_or_insert_with(what);
        }
    }
}

/// What is told of the contacts of some frames, against where their grains are.
#[derive(Default)]
pub(super) struct Completeness {
    has_velocities: bool,
    /// Pairs of grains that overlap deeply.
    deep: Count,
    /// All that overlap.
    any: Count,
    /// Pairs that are told, and those of them that lie apart.
    told: usize,
    apart: usize,
    /// Of each wall, and of each of its faces: one face may be what is missing.
    walls: BTreeMap<(usize, Option<usize>), Count>,
}

/// Contacts that a frame's lists name, whatever their forces.
#[derive(Default)]
pub(super) struct Named {
    /// Two grains, the smaller number first.
    pub pairs: BTreeSet<(u32, u32)>,
    /// Ways from a grain to a wall.
    pub walls: BTreeMap<(u32, u32), Vec<Vector3<f64>>>,
}

impl Named {
    /// Takes note that two grains touch.
    ///
    /// # Errors
    /// What is wrong with it, in words that follow their names.
    pub fn meet(&mut self, one: u32, other: u32) -> Result<(), &'static str> {
        if one == other {
            return Err("of a contact are one");
        }
        match self.pairs.insert((one.min(other), one.max(other))) {
            true => Ok(()),
            false => Err("touch twice in this frame; list each contact once"),
        }
    }
}

impl Completeness {
    /// Of frames with velocities, or without.
    pub fn new(has_velocities: bool) -> Completeness {
        Completeness { has_velocities, ..Completeness::default() }
    }

    /// Looks at a frame; at its walls only where its lists tell of some.
    pub fn look(&mut self, scene: &Scene, frame: &Snapshot, named: &Named, of_walls: bool) {
        let deep = self.look_at_pairs(scene, frame, named);
        if of_walls {
            self.look_at_walls(scene, frame, named, deep);
        }
    }

    /// Looks at the pairs of a frame; gives the overlap from which on grains touch, m.
    fn look_at_pairs(&mut self, scene: &Scene, frame: &Snapshot, named: &Named) -> f64 {
        let grains = &frame.particles;
        let gravity = Vector3::from(scene.gravity).norm();
        // Grains that part faster than by a fall through their overlap need not bear anything.
        let overlaps: Vec<(f64, (u32, u32), bool)> = close_pairs(grains, 0.0)
            .into_iter()
            .map(|pair| {
                let (one, other, overlap) = (&grains[pair.first], &grains[pair.second], -pair.gap);
                let ids = (one.id.min(other.id), one.id.max(other.id));
                (overlap, ids, self.has_velocities && parting_speed(one, other) > (2.0 * gravity * overlap).sqrt())
            })
            .collect();
        let (told, touching) = (named.pairs.len(), overlaps.iter().filter(|(_, ids, _)| named.pairs.contains(ids)));
        let (touching, sum) = touching.fold((0, 0.0), |(count, sum), (overlap, ..)| (count + 1, sum + overlap));
        self.told += told;
        self.apart += told - touching;
        let radius = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
        let least = if touching as f64 >= EXACT * told as f64 { 0.0 } else { LEAST_DEPTH * radius };
        let deep = (DEEP * sum / touching.max(1) as f64).max(least);
        for (overlap, ids, parts) in overlaps.iter().filter(|(overlap, ..)| *overlap > least) {
            let is_told = named.pairs.contains(ids);
            if *parts && !is_told {
                continue;
            }
            let what = || format!("grains {} and {} by {overlap:.3e} m at {} s", ids.0, ids.1, frame.time);
            self.any.add(is_told, what);
            if *overlap > deep {
                self.deep.add(is_told, what);
            }
        }
        deep
    }

    fn look_at_walls(&mut self, scene: &Scene, frame: &Snapshot, named: &Named, deep: f64) {
        // Where a driven wall is, files do not tell.
        let is_known = |wall: usize| !scene.wall[wall].motion.is_driven();
        let placed = PlacedWalls::at(&scene.wall, &scene.domain, frame.time, &[]);
        for (number, (wall, face)) in placed.faces().enumerate().filter(|(_, (wall, _))| is_known(*wall)) {
            for Particle { id, radius, position, .. } in &frame.particles {
                let (distance, normal) = face.nearest(&Vector3::from(*position), Vector3::zeros);
                // A wall that has swallowed half a grain is not where the scene has it.
                let overlap = radius - distance;
                if overlap > deep && overlap < 0.5 * radius {
                    let named = named.walls.get(&(*id, wall as u32)).into_iter().flatten();
                    let is_named = named.into_iter().any(|towards| towards.angle(&normal).to_degrees() < TOWARDS_FACE);
                    let what = || format!("grain {id} by {overlap:.3e} m at {} s", frame.time);
                    for part in [None, Some(number)] {
                        self.walls.entry((wall, part)).or_default().add(is_named, what);
                    }
                }
            }
        }
    }

    /// What the lists lack, in sentences.
    pub fn lacking(&self, scene: &Scene) -> Vec<(Content, String)> {
        let mut lacking = Vec::new();
        let share = |count: &Count| count.untold as f64 / count.all.max(1) as f64;
        let is_short = |count: &Count, most: f64| {
            let (untold, apart) = (count.untold as f64, self.apart as f64);
            untold - apart > (most * count.all as f64).max(BEYOND_CHANCE * (untold + apart).sqrt())
        };
        let rules = [Some((&self.deep, DEEP_UNTOLD)), self.has_velocities.then_some((&self.any, ANY_UNTOLD))];
        if let Some((count, _)) = rules.into_iter().flatten().find(|(count, most)| is_short(count, *most)) {
            let Count { all, untold, example } = count;
            let example = example.as_deref().unwrap_or_default();
            lacking.push((
                Content::Contacts,
                format!(
                    "of {all} pairs of grains that overlap in the measured frames {untold} are in no list of contacts, such as {example}: \
                     nothing is measured of contacts between grains; leave all of them"
                ),
            ));
        }
        let walls = self.walls.iter().filter(|(_, count)| count.all >= FEW && share(count) > AT_WALL_UNTOLD);
        let mut told: BTreeSet<usize> = BTreeSet::new();
        for ((wall, part), count) in walls.filter(|((wall, _), _)| told.insert(*wall)) {
            let Count { all, untold, example } = count;
            let (name, example) = (&scene.wall[*wall].name, example.as_deref().unwrap_or_default());
            let with = if part.is_some() { "one face of the wall" } else { "the wall" };
            lacking.push((
                Content::WallContacts,
                format!(
                    "of {all} overlaps of grains with {with} {wall} ({name}) in the measured frames {untold} are in no list of contacts, \
                     such as {example}: nothing is measured of contacts with walls; leave all of them"
                ),
            ));
        }
        lacking
    }

    /// What cannot be told of the lists, in a sentence.
    pub fn unseen(&self) -> Option<String> {
        let (told, apart) = (self.told, self.apart);
        (told > 0 && self.any.all == 0).then(|| {
            format!(
                "whether the lists have all contacts cannot be seen: {apart} of the {told} pairs of grains in them lie apart, and none overlap \
                 by more than {LEAST_DEPTH:.0e} radii; write places with more digits, and contacts of the same time"
            )
        })
    }
}

/// The speed at which two grains part along the line of their centres, m/s; negative where they approach.
fn parting_speed(one: &Particle, other: &Particle) -> f64 {
    let [towards, relative] = [(other.position, one.position), (other.velocity, one.velocity)]
        .map(|(of_other, of_one)| Vector3::from(of_other) - Vector3::from(of_one));
    towards.try_normalize(0.0).map_or(0.0, |towards| relative.dot(&towards))
}
