//! A candidate that touches becomes constraint data: gap and normal, bias, regularisation, starting impulse.

use crate::detect::{Candidates, Impulse};
use crate::effects::compliance::{NormalConstraint, NormalContact};
use crate::effects::restitution::with_restitution;
use crate::partition::{Constraint, Layout, Packer, PairEntry, Task, WallEntry};
use crate::scene::{NormalLaw, SolverSettings};
use crate::world::{ContactMaterial, Pose, World};
use nalgebra::Vector3;

/// Turns candidates into lane groups; keeps its buffers from step to step.
#[derive(Clone, Debug, Default)]
pub struct Constrainer {
    packer: Packer,
    poses: Vec<Pose>,
    pair_entries: Vec<PairEntry>,
    wall_entries: Vec<WallEntry>,
}

/// What all contacts of a step share.
struct StepConstants {
    law: NormalLaw,
    h: f64,
    damping_steps: f64,
    threshold: f64,
    warm_start: f64,
    /// Gap up to which a contact may still matter in this step, m; zero but for rigid contacts.
    reach: f64,
}

impl Constrainer {
    /// Lays out the contacts of a step of length `h` (s) from the state at its start, before forces act.
    pub fn constrain(
        &mut self,
        world: &World,
        candidates: &mut Candidates,
        settings: &SolverSettings,
        layout: &mut Layout,
    ) {
        let h = settings.step;
        let constants = StepConstants {
            law: settings.normal_law,
            h,
            damping_steps: settings.damping_steps,
            threshold: settings.restitution_threshold,
            warm_start: settings.warm_start,
            reach: match settings.normal_law {
                NormalLaw::Rigid => (settings.restitution_threshold + world.gravity.norm() * h) * h,
                _ => 0.0,
            },
        };
        layout.clear();
        self.packer.resize(world.grains());
        self.poses.clear();
        self.poses.extend(world.surfaces.iter().map(|surface| surface.at(world.time)));
        let boxes = (candidates.pair_tasks.len() - 1) / crate::partition::STAGES;
        for task in 0..candidates.pair_tasks.len() - 1 {
            let (pairs_before, walls_before) = (layout.pairs.len(), layout.walls.len());
            self.gather_pairs(world, candidates, task, &constants);
            self.packer.pack_pairs(&self.pair_entries, world.grains() as u32, layout);
            self.gather_walls(world, candidates, task, &constants);
            self.packer.pack_walls(&self.wall_entries, world.grains() as u32, layout);
            let (pairs, walls) = (pairs_before..layout.pairs.len(), walls_before..layout.walls.len());
            if !pairs.is_empty() || !walls.is_empty() {
                layout.tasks.push(Task { stage: (task / boxes) as u8, pairs, walls });
            }
        }
    }

    fn gather_pairs(&mut self, world: &World, candidates: &mut Candidates, task: usize, constants: &StepConstants) {
        self.pair_entries.clear();
        for source in candidates.pair_tasks[task]..candidates.pair_tasks[task + 1] {
            let pair = candidates.pairs[source as usize];
            let (i, j) = (pair.first as usize, pair.second as usize);
            let (a, b) = (&world.bodies[i], &world.bodies[j]);
            let arm = world.positions[j] - world.positions[i];
            let square = arm.norm_squared();
            let touch = a.radius + b.radius + constants.reach;
            let remembered = std::mem::take(&mut candidates.pair_impulses[source as usize]);
            if square >= touch * touch {
                continue;
            }
            let distance = square.sqrt();
            // Two grains with one centre have no normal; any direction parts them.
            let normal = if distance > 0.0 { arm / distance } else { Vector3::z() };
            let velocity = normal.dot(&(Vector3::from(b.velocity) - Vector3::from(a.velocity)));
            let material = world.table.between_grains(world.materials[i], world.materials[j]);
            let contact = NormalContact {
                overlap: a.radius + b.radius - distance,
                velocity,
                effective_modulus: material.effective_modulus,
                effective_radius: a.radius * b.radius / (a.radius + b.radius),
                inverse_mass: a.inverse_mass + b.inverse_mass,
                damping_ratio: material.damping_ratio,
            };
            if let Some(constraint) = normal_constraint(&contact, material, constants) {
                let constraint = assemble(constraint, normal, material, remembered, constants.warm_start, source);
                self.pair_entries.push(PairEntry { first: pair.first, second: pair.second, constraint });
            }
        }
    }

    fn gather_walls(&mut self, world: &World, candidates: &mut Candidates, task: usize, constants: &StepConstants) {
        self.wall_entries.clear();
        for source in candidates.wall_tasks[task]..candidates.wall_tasks[task + 1] {
            let wall = candidates.walls[source as usize];
            let grain = wall.body as usize;
            let (body, centre) = (&world.bodies[grain], &world.positions[grain]);
            let surface = &world.surfaces[wall.surface as usize];
            let pose = &self.poses[wall.surface as usize];
            let (distance, normal) = pose.nearest(centre);
            let remembered = std::mem::take(&mut candidates.wall_impulses[source as usize]);
            if distance >= body.radius + constants.reach {
                continue;
            }
            let wall_velocity = pose.velocity_at(&(centre + normal * distance));
            let velocity = normal.dot(&(wall_velocity - Vector3::from(body.velocity)));
            let material = world.table.with_wall(world.materials[grain], surface.material);
            let contact = NormalContact {
                overlap: body.radius - distance,
                velocity,
                effective_modulus: material.effective_modulus,
                effective_radius: body.radius,
                inverse_mass: body.inverse_mass,
                damping_ratio: material.damping_ratio,
            };
            if let Some(constraint) = normal_constraint(&contact, material, constants) {
                let constraint = assemble(constraint, normal, material, remembered, constants.warm_start, source);
                self.wall_entries.push(WallEntry { body: wall.body, wall_velocity: wall_velocity.into(), constraint });
            }
        }
    }
}

#[inline]
fn normal_constraint(
    contact: &NormalContact,
    material: &ContactMaterial,
    constants: &StepConstants,
) -> Option<NormalConstraint> {
    let constraint = contact.constraint(constants.law, constants.h, constants.damping_steps);
    let (overlap, velocity) = (contact.overlap, contact.velocity);
    let (restitution, threshold) = (material.restitution, constants.threshold);
    with_restitution(constraint, constants.law, overlap, velocity, restitution, threshold, constants.h)
}

/// Puts a constraint together; the remembered tangential impulse is projected onto the new tangent plane.
#[inline]
fn assemble(
    constraint: NormalConstraint,
    normal: Vector3<f64>,
    material: &ContactMaterial,
    remembered: Impulse,
    warm_start: f64,
    source: u32,
) -> Constraint {
    let tangential = Vector3::from(remembered.tangential);
    let tangential = (tangential - normal * normal.dot(&tangential)) * warm_start;
    Constraint {
        normal: normal.into(),
        bias: constraint.bias,
        regularisation: constraint.regularisation,
        friction: material.friction,
        impulse: Impulse { normal: remembered.normal * warm_start, tangential: tangential.into() },
        source,
    }
}
