//! Insertion and removal of grains between steps.
//!
//! After insertion or removal, the simulation restarts at its present time with the present grains, in id order, and the impulses
//! of their contacts. The result equals reading a checkpoint of them, bit for bit. Boxes are chosen for the new number of grains,
//! and the next step rebuilds the candidate list.

use super::{Booked, InterventionError};
use crate::Simulation;
use crate::scene::{GrainEntry, MOST_GRAINS, Neighbours, Scene, SolverSettings};
use crate::simulation::checkpoint::state::State;
use crate::wall::WallsAt;
use crate::world::World;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::ops::Range;

/// Least and largest radius, m, as in scenes.
const RADII: Range<f64> = 1e-9..100.0;

/// Largest component of a position, velocity or spin, in SI units, as in scenes.
const LARGEST: f64 = 1e6;

impl Simulation {
    /// Returns the present grains as scene entries, in id order: `scene` provides the names of their materials.
    pub fn grain_entries(&self, scene: &Scene) -> Vec<GrainEntry> {
        let names: Vec<&String> = scene.material.keys().collect();
        let entry = |place: u32| {
            let place = place as usize;
            let (sphere, body) = (&self.world.spheres[place], &self.world.bodies[place]);
            let material = names.get(usize::from(self.world.materials[place]));
            GrainEntry {
                material: material.map(|name| name.to_string()).unwrap_or_default(),
                radius: sphere.radius,
                position: self.world.wrapped(&sphere.centre).into(),
                velocity: body.velocity,
                spin: body.scaled_spin.map(|component| component / sphere.radius),
            }
        };
        self.places_by_id().into_iter().map(entry).collect()
    }

    /// Number of grains.
    pub fn grains(&self) -> usize {
        self.world.grains()
    }

    /// Returns true if grains were inserted or removed, so that the grains may differ from the grains of the scene.
    pub fn has_other_grains(&self) -> bool {
        self.world.roll.changed
    }

    /// Inserts grains with materials of this simulation's scene, and returns their ids, which follow the present ids.
    ///
    /// Contacts of the last step are unknown until the next step: their impulses are preserved, but [`frame`](Simulation::frame)
    /// lists no contacts.
    ///
    /// # Errors
    /// [`InterventionError::Insertion`] if a grain has an unknown material or an invalid radius or state, lies outside the domain, or
    /// overlaps a wall or a grain by more than the scene's `largest_start_overlap` of the smaller radius. [`InterventionError::Rule`] if a
    /// scene with all of the grains fails [`Scene::check`], for instance because of a short period. [`InterventionError::TooMany`].
    pub fn insert(&mut self, scene: &Scene, grains: &[GrainEntry]) -> Result<Range<u32>, InterventionError> {
        let before = self.world.grains();
        let all = before + grains.len();
        if all as f64 > MOST_GRAINS {
            return Err(InterventionError::TooMany { grains: all, most: MOST_GRAINS as usize });
        }
        let poses: Vec<_> = self.world.walls.poses(self.world.time).collect();
        let walls = self.world.walls.placed(&poses);
        for (index, grain) in grains.iter().enumerate() {
            let refuse = |(problem, remedy)| InterventionError::Insertion { index, problem, remedy };
            self.check_grain(scene, &walls, grain).map_err(refuse)?;
        }
        self.check_rules(scene, grains)?;
        self.check_overlaps(scene, grains)?;
        if !grains.is_empty() {
            let mut state = State::of(self);
            for (id, grain) in (before as u32..).zip(grains) {
                let number = self.world.table.find(&grain.material).unwrap_or_default();
                state.add(id, grain, number, scene.material[&grain.material].density);
            }
            let old: Vec<Option<u32>> = (0..before as u32).map(Some).collect();
            self.begin_anew(self.world.without_grains(), &self.settings.clone(), &state, &old, all);
        }
        Ok(before as u32..all as u32)
    }

    /// Removes grains by their ids; duplicates are allowed. The others keep their order and are renumbered contiguously: returns
    /// the new id of each old id, `None` for removed grains.
    ///
    /// Contacts of the last step are unknown until the next step, as after [`insert`](Simulation::insert).
    ///
    /// # Errors
    /// [`InterventionError::NoGrain`].
    pub fn remove(&mut self, ids: &[u32]) -> Result<Vec<Option<u32>>, InterventionError> {
        let grains = self.world.grains();
        let mut stays = vec![true; grains];
        for &id in ids {
            *stays.get_mut(id as usize).ok_or(InterventionError::NoGrain { id, grains })? = false;
        }
        let mut next = 0;
        let new_ids: Vec<Option<u32>> = stays
            .iter()
            .map(|&stays| {
                next += u32::from(stays);
                stays.then(|| next - 1)
            })
            .collect();
        if (next as usize) < grains {
            let mut state = State::of(self);
            state.renumber(&new_ids);
            self.begin_anew(self.world.without_grains(), &self.settings.clone(), &state, &new_ids, next as usize);
        }
        Ok(new_ids)
    }

    /// Restarts in a world without grains, with settings, and with the grains and impulses of a state; `new_ids` maps old ids to new ids.
    pub(in crate::simulation) fn begin_anew(
        &mut self,
        world: World,
        settings: &SolverSettings,
        state: &State,
        new_ids: &[Option<u32>],
        grains: usize,
    ) {
        let before = Booked::of(self);
        let world = state.populate(world).expect("all numbers were checked");
        let mut next = Simulation::of_world(settings, world, grains);
        let scale = settings.step / self.settings.step;
        state.give_impulses(&mut next, scale).expect("contacts are those of grains that are there");
        next.go_on_as(self);
        next.interventions = self.interventions.after(new_ids, grains);
        let stay = new_ids.iter().flatten().count();
        if (stay, stay) != (new_ids.len(), grains) {
            next.world.roll.change(new_ids, std::iter::repeat_n(0, grains - stay));
        }
        *self = next;
        if self.ledger.is_some() {
            self.book_disturbance(&before);
        }
        self.note_known_energy();
    }

    /// Checks that a grain can be inserted, apart from its neighbours.
    fn check_grain(
        &self,
        scene: &Scene,
        walls: &WallsAt<'_>,
        grain: &GrainEntry,
    ) -> Result<(), (String, &'static str)> {
        let known = self.world.table.find(&grain.material).is_some() && scene.material.contains_key(&grain.material);
        if !known {
            let names: Vec<&str> = scene.material.keys().map(String::as_str).collect();
            return Err((
                format!("is of material '{}', and the scene has {}", grain.material, names.join(", ")),
                "name one of the scene's materials",
            ));
        }
        if !RADII.contains(&grain.radius) {
            return Err((format!("has a radius of {} m", grain.radius), "give one from 1e-9 to 100 m"));
        }
        let outside = self.world.limits.as_ref().zip(self.world.table.find(&grain.material));
        if let Some(problem) = outside.and_then(|(limits, material)| limits.refuse(grain.radius, material)) {
            return Err((
                problem,
                "give it a radius and a material of the grains or sources of the scene, in which grains come and go",
            ));
        }
        let numbers = grain.position.iter().chain(&grain.velocity).chain(&grain.spin);
        if let Some(wrong) = numbers.into_iter().find(|number| number.is_nan() || number.abs() >= LARGEST) {
            return Err((format!("has {wrong} in its position, velocity or spin"), "give finite SI numbers below 1e6"));
        }
        let (low, high) = self.world.domain;
        if (0..3).any(|axis| grain.position[axis] < low[axis] || grain.position[axis] > high[axis]) {
            return Err((format!("lies at {:?}, outside the domain", grain.position), "move it inside"));
        }
        let centre = Vector3::from(grain.position);
        let mut deepest: Option<(f64, u32)> = None;
        for face in 0..self.world.walls.faces() as u32 {
            let overlap = grain.radius - walls.distance(face, &centre);
            if overlap > scene.largest_start_overlap * grain.radius && deepest.is_none_or(|(most, _)| overlap > most) {
                deepest = Some((overlap, self.world.walls.wall_of(face)));
            }
        }
        match deepest {
            Some((overlap, wall)) => {
                let name = scene.wall.get(wall as usize).map(|wall| wall.name.as_str()).unwrap_or_default();
                let problem = format!("lies {overlap:.3e} m inside or behind wall '{name}' (number {wall})");
                Err((problem, "move it away from the wall, into the container"))
            }
            None => Ok(()),
        }
    }

    /// Checks the scene rules for the new grains together with the present grains; the largest grain of each material represents all of them.
    fn check_rules(&self, scene: &Scene, grains: &[GrainEntry]) -> Result<(), InterventionError> {
        let mut largest: BTreeMap<u8, f64> = BTreeMap::new();
        for (material, sphere) in self.world.materials[..self.world.grains()].iter().zip(&self.world.spheres) {
            let known = largest.entry(*material).or_default();
            *known = known.max(sphere.radius);
        }
        let names: Vec<&String> = scene.material.keys().collect();
        let there = largest.into_iter().filter_map(|(material, radius)| {
            let [position, velocity, spin] = [[0.0; 3]; 3];
            let material = names.get(usize::from(material))?.to_string();
            Some(GrainEntry { material, radius, position, velocity, spin })
        });
        let grain = there.chain(grains.iter().cloned()).collect();
        let all = Scene { grain, start: None, population: Vec::new(), ..scene.clone() };
        all.check().map_err(|error| InterventionError::Rule(error.to_string()))
    }

    /// Checks the overlaps of new grains with present grains and with each other.
    fn check_overlaps(&self, scene: &Scene, new: &[GrainEntry]) -> Result<(), InterventionError> {
        let (world, widest) = (&self.world, |most: f64, one: &GrainEntry| most.max(one.radius));
        let mut neighbours = Neighbours::new(&scene.domain, new.iter().fold(world.largest_and_mean_radius().0, widest));
        // Present grains by their ids, then new grains.
        let places = self.places_by_id();
        let old = places.len();
        for sphere in places.into_iter().map(|place| &world.spheres[place as usize]) {
            neighbours.add(&world.wrapped(&sphere.centre).into(), sphere.radius);
        }
        for (index, grain) in new.iter().enumerate() {
            let is_deep = |overlap: f64, radius: f64| overlap > scene.largest_start_overlap * grain.radius.min(radius);
            if let Some((number, overlap)) = neighbours.find(&grain.position, grain.radius, is_deep) {
                let (index, whom) = match number.checked_sub(old) {
                    Some(other) => (other, format!("grain {index} of those to insert")),
                    None => (index, format!("grain {number}")),
                };
                let problem = format!("overlaps {whom} by {overlap:.3e} m");
                let remedy = "move it away: the scene's largest_start_overlap says how much is accepted";
                return Err(InterventionError::Insertion { index, problem, remedy });
            }
            neighbours.add(&grain.position, grain.radius);
        }
        Ok(())
    }
}
