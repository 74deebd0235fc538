//! Forces and torques of the caller on the grains.
//!
//! ```text
//! v' = v + h F / m          w' = w + h T / I,   I = 2/5 m r^2
//! ```
//!
//! before the contact solve, like gravity. Forces do not count as approach: restitution depends on the velocities at the start of the step.
//! The work of a force is `h F . (v + v')/2`, with the velocities at the start and at the end of the step, contact impulses included.

use super::{InterventionError, Interventions};
use crate::Simulation;
use crate::lanes::{cross, dot, plus, times};
use crate::world::{Body, INVERSE_INERTIA, World};

/// Upper bound of forces in SI units.
const LARGEST: f64 = 1e30;

impl Simulation {
    /// Applies forces at the centres of the grains in the next step only: N, one per grain, in id order, in addition to gravity.
    /// They replace forces set earlier for the same step; an empty list clears these.
    ///
    /// ```
    /// # use makadam::{GrainEntry, Material, Scene, Simulation};
    /// let scene = Scene::builder().material("glass", Material::default()).gravity([0.0; 3]).domain([-1.0; 3], [1.0; 3]);
    /// # let grain = GrainEntry { material: "glass".into(), radius: 0.005, position: [0.0; 3], velocity: [0.0; 3], spin: [0.0; 3] };
    /// let scene = scene.grain(grain).build()?;
    /// let mut simulation = Simulation::builder(&scene).time_step(1e-3).build()?;
    /// for _ in 0..100 {
    ///     simulation.apply_forces(&[[1e-3, 0.0, 0.0]])?;
    ///     simulation.step();
    /// }
    /// let mass = Material::default().density * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    /// let [speed, ..] = simulation.frame().velocities()[0];
    /// assert!((speed / (1e-3 * 0.1 / mass) - 1.0).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InterventionError::Length`] if the list is neither empty nor of one entry per grain, [`InterventionError::Number`] if a
    /// force is not finite.
    pub fn apply_forces(&mut self, forces: &[[f64; 3]]) -> Result<(), InterventionError> {
        self.give_loads(APPLIED, Some(forces), None)
    }

    /// Applies torques about the centres, N m, under the same rules.
    ///
    /// # Errors
    /// As for [`apply_forces`](Simulation::apply_forces).
    pub fn apply_torques(&mut self, torques: &[[f64; 3]]) -> Result<(), InterventionError> {
        self.give_loads(APPLIED, None, Some(torques))
    }

    /// Applies both, instead of all forces and torques set earlier for the same step. If one list is refused, neither is applied.
    ///
    /// # Errors
    /// As for [`apply_forces`](Simulation::apply_forces).
    pub fn apply_loads(&mut self, forces: &[[f64; 3]], torques: &[[f64; 3]]) -> Result<(), InterventionError> {
        self.give_loads(APPLIED, Some(forces), Some(torques))
    }

    /// Adds forces and torques to the applied ones for the next step; they replace loads added earlier for the same step.
    ///
    /// # Errors
    /// As for [`apply_forces`](Simulation::apply_forces).
    pub fn add_loads(&mut self, forces: &[[f64; 3]], torques: &[[f64; 3]]) -> Result<(), InterventionError> {
        self.give_loads(ADDED, Some(forces), Some(torques))
    }

    /// Replaces the given lists, if both are valid.
    fn give_loads(
        &mut self,
        which: usize,
        forces: Option<&[[f64; 3]]>,
        torques: Option<&[[f64; 3]]>,
    ) -> Result<(), InterventionError> {
        let (grains, loads) = (self.world.grains(), &mut self.interventions.loads[which]);
        check("the list of forces", "the force", forces.unwrap_or_default(), grains)?;
        check("the list of torques", "the torque", torques.unwrap_or_default(), grains)?;
        for (list, new) in [(&mut loads.forces, forces), (&mut loads.torques, torques)] {
            if let Some(new) = new {
                list.clear();
                list.extend_from_slice(new);
            }
        }
        Ok(())
    }

    /// Applies the forces and torques of the step, after the velocities at its start were stored.
    pub(crate) fn act_from_outside(&mut self) {
        let Interventions { loads, spins_before, .. } = &mut self.interventions;
        spins_before.clear();
        if loads.iter().any(|loads| !loads.torques.is_empty()) {
            spins_before.extend(self.world.bodies.iter().map(|body| body.scaled_spin));
        }
        let World { bodies, ids, .. } = &mut self.world;
        for loads in loads.iter().filter(|loads| !loads.are_none()) {
            for (body, &id) in bodies.iter_mut().zip(&*ids) {
                loads.push(body, id, self.settings.step);
            }
        }
    }

    /// Books the work and impulses of the forces and torques of a step, once its velocities are known and before bodies move;
    /// then clears the loads.
    pub(crate) fn account_for_forces(&mut self) {
        self.interventions.work = 0.0;
        let Simulation { world, interventions, settings, ledger, .. } = self;
        let h = settings.step;
        for loads in interventions.loads.iter_mut().filter(|loads| !loads.are_none()) {
            let (mut work, mut impulse, mut angular_impulse) = (0.0, [0.0; 3], [0.0; 3]);
            for (place, &id) in world.ids.iter().enumerate() {
                let body = &world.bodies[place];
                if let Some(force) = loads.forces.get(id as usize) {
                    let [x, y, z, _] = world.before[place].0;
                    work += h * dot(*force, times(plus([x, y, z], body.velocity), 0.5));
                    impulse = plus(impulse, times(*force, h));
                    let centre = world.spheres[place].centre.into();
                    angular_impulse = plus(angular_impulse, times(cross(centre, *force), h));
                }
                if let Some(torque) = loads.torques.get(id as usize) {
                    let mean = times(plus(interventions.spins_before[place], body.scaled_spin), 0.5);
                    work += h * dot(*torque, times(mean, body.inverse_radius));
                    angular_impulse = plus(angular_impulse, times(*torque, h));
                }
            }
            interventions.work += work;
            if ledger.is_some() {
                let booked = &mut interventions.booked;
                booked.energy += work;
                booked.impulse = plus(booked.impulse, impulse);
                booked.angular_impulse = plus(booked.angular_impulse, angular_impulse);
            }
            loads.forces.clear();
            loads.torques.clear();
        }
        interventions.spins_before.clear();
    }
}

/// Forces (N) and torques (N m) of a step, by id; empty without loads.
#[derive(Clone, Debug, Default)]
pub(super) struct Loads {
    pub forces: Vec<[f64; 3]>,
    pub torques: Vec<[f64; 3]>,
}

/// Indices of the applied loads, the added loads, and their sum.
const APPLIED: usize = 0;
const ADDED: usize = 1;
pub(super) const LOADS: usize = 2;

impl Loads {
    pub fn are_none(&self) -> bool {
        self.forces.is_empty() && self.torques.is_empty()
    }

    /// Applies the force and torque of a grain for a step of length `h`, s.
    fn push(&self, body: &mut Body, id: u32, h: f64) {
        if let Some(force) = self.forces.get(id as usize) {
            body.velocity = plus(body.velocity, times(*force, h * body.inverse_mass));
        }
        if let Some(torque) = self.torques.get(id as usize) {
            let turned = INVERSE_INERTIA * body.inverse_mass * body.inverse_radius * h;
            body.scaled_spin = plus(body.scaled_spin, times(*torque, turned));
        }
    }
}

fn check(list: &'static str, what: &'static str, given: &[[f64; 3]], grains: usize) -> Result<(), InterventionError> {
    if !given.is_empty() && given.len() != grains {
        return Err(InterventionError::Length { what: list, given: given.len(), grains });
    }
    let wrong = given.iter().position(|vector| !vector.iter().all(|component| component.abs() < LARGEST));
    wrong.map_or(Ok(()), |grain| Err(InterventionError::Number { what, grain, value: given[grain] }))
}
