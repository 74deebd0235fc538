//! Rapier as one of the codes: a scene of spheres in fixed boxes, stepped on one thread, its frames as a recording.
//!
//! What its settings mean (`IntegrationParameters` of rapier3d): a step is divided into `substeps`; each moves the grains
//! once, after `iterations` sweeps over soft contacts and before one sweep over rigid ones. A soft contact is a spring
//! whose stiffness is that of an oscillator of the pair's mass at the natural frequency, so that it sinks in by
//! `g / (2 pi f)^2` under the weight of its own mass, whatever the size of the grains.

use makadam::effects::catalogue::{
    COMPLIANCE, Effect, FRICTION, GRAVITY, RESTITUTION, SIZE_SPREAD, SPIN, TANGENTIAL_SPRING, VISCOSITY,
};
use makadam::scene::{Grain, Motion, Shape};
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam_validation::peers::{Code, CodeError, Job, refuse_effects, starting_grains};
use makadam_validation::plan::Scene;
use makadam_validation::recording::Recording;
use makadam_validation::stepping::{frame_is_due, steps_in};
use rapier3d_f64::prelude::*;
use std::time::{Duration, Instant};

/// Name in tables.
pub const NAME: &str = "Rapier";

/// Thickness of a wall over the largest radius: no grain of a dense flow crosses that in a step.
const WALL_THICKNESS: f64 = 10.0;

/// Effects that a scene may have; a scene with any other effect is refused. Its contacts are springs of one frequency, in place of the scene's compliance, viscosity and tangential
/// spring.
const HAS: [&Effect; 8] =
    [&GRAVITY, &SIZE_SPREAD, &COMPLIANCE, &VISCOSITY, &RESTITUTION, &FRICTION, &TANGENTIAL_SPRING, &SPIN];

/// What is varied.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Time step, s.
    pub step: f64,
    /// Substeps of a step, which Rapier calls solver iterations.
    pub substeps: usize,
    /// Sweeps over soft contacts in a substep, which Rapier calls internal iterations.
    pub iterations: usize,
    /// Natural frequency of all contacts, Hz; `None` for the engine's own, 30 Hz and 60 Hz at walls.
    pub natural_frequency: Option<f64>,
    /// Damping ratio of all contacts.
    pub damping_ratio: f64,
    /// Size of what the engine takes for a metre, m: it scales its tolerances, among them the speed at which overlaps are
    /// pushed out.
    pub length_unit: f64,
    /// Coulomb's friction at every contact point in place of the simplified model.
    pub coulomb: bool,
    /// Whether contacts of pairs that hardly moved are kept from earlier steps.
    pub recycling: bool,
    /// Whether friction is solved in the sweeps over soft contacts too.
    pub friction_in_soft_sweeps: bool,
}

impl Settings {
    /// Settings for rigid grains of a few millimetres, from which one is varied at a time.
    pub const RIGID: Settings = Settings {
        step: 1e-3,
        substeps: 4,
        iterations: 1,
        natural_frequency: Some(3000.0),
        damping_ratio: 10.0,
        length_unit: 0.01,
        coulomb: true,
        recycling: false,
        friction_in_soft_sweeps: false,
    };

    /// Step, substeps and frequency, and what else differs from [`RIGID`](Settings::RIGID).
    pub fn words(&self) -> String {
        let frequency = self.natural_frequency.map_or("30 Hz (60 at walls)".into(), |hertz| format!("{hertz} Hz"));
        let rigid = Settings::RIGID;
        let differences = [
            (self.iterations != rigid.iterations, format!("{} iterations", self.iterations)),
            (self.damping_ratio != rigid.damping_ratio, format!("damping ratio {}", self.damping_ratio)),
            (self.length_unit != rigid.length_unit, format!("length unit {} m", self.length_unit)),
            (self.coulomb != rigid.coulomb, "simplified friction".into()),
            (self.recycling != rigid.recycling, "contacts kept".into()),
            (self.friction_in_soft_sweeps != rigid.friction_in_soft_sweeps, "friction in soft sweeps".into()),
        ];
        let words = [format!("{} × {} substeps", milliseconds(self.step), self.substeps), frequency];
        let further = differences.into_iter().filter_map(|(differs, words)| differs.then_some(words));
        words.into_iter().chain(further).collect::<Vec<_>>().join(", ")
    }

    /// Step and substeps, and the frequency where it is another than that of [`RIGID`](Settings::RIGID).
    pub fn short_words(&self) -> String {
        let frequency = match self.natural_frequency {
            hertz if hertz == Settings::RIGID.natural_frequency => String::new(),
            Some(hertz) => format!(", {hertz} Hz"),
            None => ", 30 Hz".into(),
        };
        format!("{}×{}{frequency}", milliseconds(self.step), self.substeps)
    }

    fn parameters(&self) -> IntegrationParameters {
        let mut parameters = IntegrationParameters {
            dt: self.step,
            num_solver_iterations: self.substeps,
            num_internal_pgs_iterations: self.iterations,
            length_unit: self.length_unit,
            friction_model: if self.coulomb { FrictionModel::Coulomb } else { FrictionModel::Simplified },
            contact_recycling: self.recycling,
            friction_in_bias_pass: self.friction_in_soft_sweeps,
            // Walls are thick enough; nothing is held back at them.
            max_ccd_substeps: 0,
            ..IntegrationParameters::default()
        };
        parameters.contact_softness.damping_ratio = self.damping_ratio;
        parameters.static_contact_softness.damping_ratio = self.damping_ratio;
        if let Some(hertz) = self.natural_frequency {
            parameters.contact_softness.natural_frequency = hertz;
            parameters.static_contact_softness.natural_frequency = hertz;
        }
        parameters
    }
}

fn milliseconds(seconds: f64) -> String {
    // To three decimals, without trailing zeros.
    format!("{} ms", (1e6 * seconds).round() / 1e3)
}

/// Rapier with some settings.
pub struct Rapier {
    /// The settings.
    pub settings: Settings,
    /// Version of the crate.
    pub version: String,
}

impl Code for Rapier {
    fn name(&self) -> &'static str {
        NAME
    }

    fn version(&self) -> Option<String> {
        Some(self.version.clone())
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        let scene = job.scene;
        let grains = starting_grains(job)?;
        let mut world = build(scene, &grains, &self.settings)?;
        let steps = steps_in(scene.duration, self.settings.step);
        let mut frames = vec![snapshot(&world, &grains, 0.0, self.settings.step)];
        let mut wall = Duration::ZERO;
        for step in 1..=steps {
            let clock = Instant::now();
            world.step();
            wall += clock.elapsed();
            if step == steps || frame_is_due(step, self.settings.step, scene.measure.interval) {
                frames.push(snapshot(&world, &grains, step as f64 * self.settings.step, self.settings.step));
            }
            (job.progress)(step as f64 / steps as f64);
        }
        Ok(Recording {
            scene: scene.name.clone(),
            code: NAME.into(),
            version: self.version.clone(),
            seed: job.seed,
            time_step: self.settings.step,
            rayleigh_fraction: None,
            stiffness_factor: job.stiffness_factor,
            threads: 1,
            wall_seconds: wall.as_secs_f64(),
            core_seconds: None,
            simulated_seconds: steps as f64 * self.settings.step,
            frames,
            lacks: Vec::new(),
            alarms: Vec::new(),
            notes: Vec::new(),
        })
    }
}

/// Who a collider is: a grain or a wall of the scene, by its place. Kept in the collider's user data.
fn tag(partner: Partner) -> u128 {
    match partner {
        Partner::Grain(id) => u128::from(id) << 1,
        Partner::Wall(place) => u128::from(place) << 1 | 1,
    }
}

fn untag(data: u128) -> Partner {
    let number = (data >> 1) as u32;
    if data & 1 == 0 { Partner::Grain(number) } else { Partner::Wall(number) }
}

fn vector([x, y, z]: [f64; 3]) -> Vector {
    Vector::new(x, y, z)
}

/// The scene in Rapier's terms.
fn build(scene: &Scene, grains: &[Grain], settings: &Settings) -> Result<PhysicsWorld, CodeError> {
    let refuse = |reason: String| Err(CodeError::Unsupported { code: NAME, reason });
    refuse_effects(NAME, &HAS, scene, grains)?;
    if !scene.pair.is_empty() {
        return refuse("it has rules for pairs of materials".into());
    }
    check_coefficients(scene, grains)?;
    let mut world = PhysicsWorld {
        gravity: vector(scene.gravity),
        integration_parameters: settings.parameters(),
        ..Default::default()
    };
    let surface = |collider: ColliderBuilder, material: &str, partner: Partner| {
        let material = &scene.material[material];
        collider
            .density(material.density)
            .friction(material.friction)
            .friction_combine_rule(CoefficientCombineRule::Min)
            .restitution(material.restitution)
            .restitution_combine_rule(CoefficientCombineRule::Min)
            .user_data(tag(partner))
    };
    let thickness = WALL_THICKNESS * grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    for (place, wall) in scene.wall.iter().enumerate() {
        let (Shape::Box { min, max, open }, Motion::Fixed) = (&wall.shape, &wall.motion) else {
            return refuse(format!("the wall {} is not a box at rest", wall.name));
        };
        for (centre, half) in slabs(*min, *max, open, thickness) {
            let body = RigidBodyBuilder::fixed().translation(vector(centre));
            let slab = ColliderBuilder::cuboid(half[0], half[1], half[2]);
            world.insert(body, surface(slab, &wall.material, Partner::Wall(place as u32)));
        }
    }
    for (id, grain) in grains.iter().enumerate() {
        let body = RigidBodyBuilder::dynamic()
            .translation(vector(grain.position))
            .linvel(vector(grain.velocity))
            .angvel(vector(grain.spin))
            .can_sleep(false);
        let ball = ColliderBuilder::ball(grain.radius);
        world.insert(body, surface(ball, &grain.material, Partner::Grain(id as u32)));
    }
    Ok(world)
}

/// Rapier combines the coefficients of two colliders by a rule, here the smaller one; a scene that says otherwise is
/// refused.
fn check_coefficients(scene: &Scene, grains: &[Grain]) -> Result<(), CodeError> {
    let mut names: Vec<&str> = grains.iter().map(|grain| grain.material.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let walls = scene.wall.iter().map(|wall| (wall.material.as_str(), true));
    let partners: Vec<(&str, bool)> = names.iter().map(|name| (*name, false)).chain(walls).collect();
    for first in &names {
        for (second, wall) in &partners {
            let (a, b) = (&scene.material[*first], &scene.material[*second]);
            let smaller = (a.friction.min(b.friction), a.restitution.min(b.restitution));
            let pair = scene.contact_coefficients(first, second, *wall);
            if (pair.friction, pair.restitution) != smaller {
                let reason =
                    format!("friction or restitution of {first} on {second} is not the smaller one of the two");
                return Err(CodeError::Unsupported { code: NAME, reason });
            }
        }
    }
    Ok(())
}

/// Centres and half sides of the slabs behind the closed faces of a box. They overlap beyond its edges, and those at the
/// sides of an open face reach beyond it, so that no grain meets an edge.
fn slabs(min: [f64; 3], max: [f64; 3], open: &[String], thickness: f64) -> Vec<([f64; 3], [f64; 3])> {
    let mut slabs = Vec::new();
    for axis in 0..3 {
        for (sign, face) in [(-1.0, min[axis]), (1.0, max[axis])] {
            let name = format!("{}{}", if sign < 0.0 { '-' } else { '+' }, ["x", "y", "z"][axis]);
            if open.contains(&name) {
                continue;
            }
            let mut centre: [f64; 3] = std::array::from_fn(|k| 0.5 * (min[k] + max[k]));
            let mut half: [f64; 3] = std::array::from_fn(|k| 0.5 * (max[k] - min[k]) + 2.0 * thickness);
            centre[axis] = face + 0.5 * sign * thickness;
            half[axis] = 0.5 * thickness;
            slabs.push((centre, half));
        }
    }
    slabs
}

/// Grains and contacts as they are now; forces are the impulses of the last substep over its length.
fn snapshot(world: &PhysicsWorld, grains: &[Grain], time: f64, step: f64) -> Snapshot {
    let mut particles: Vec<Particle> = Vec::with_capacity(grains.len());
    for (_, body) in world.bodies.iter().filter(|(_, body)| body.is_dynamic()) {
        let id = particles.len() as u32;
        particles.push(Particle {
            id,
            position: body.translation().to_array(),
            radius: grains[id as usize].radius,
            velocity: body.linvel().to_array(),
            spin: body.angvel().to_array(),
        });
    }
    let substep = step / world.integration_parameters.num_solver_iterations as f64;
    let who = |handle: ColliderHandle| world.colliders.get(handle).map(|collider| untag(collider.user_data));
    let mut contacts = Vec::new();
    for pair in world.contact_pairs() {
        let (Some(one), Some(other)) = (who(pair.collider1), who(pair.collider2)) else { continue };
        // The first of a contact is a grain; Rapier's normal points from its first collider to its second.
        let (first, second, sign) = match (one, other) {
            (Partner::Grain(first), second) => (first, second, 1.0),
            (wall, Partner::Grain(first)) => (first, wall, -1.0),
            (Partner::Wall(_), Partner::Wall(_)) => continue,
        };
        let grain = &particles[first as usize];
        for manifold in pair.solver_manifolds() {
            let normal = manifold.data.normal * sign;
            for point in manifold.points.iter().filter(|point| point.data.warmstart_impulse > 0.0) {
                contacts.push(Contact {
                    first,
                    second,
                    point: (vector(grain.position) + normal * grain.radius).to_array(),
                    normal: normal.to_array(),
                    normal_force: point.data.warmstart_impulse / substep,
                    // Rapier's impulse acts on its first collider.
                    tangential_force: (point.data.warmstart_tangent_world * (-sign / substep)).to_array(),
                });
            }
        }
    }
    Snapshot { time, particles, contacts, ..Snapshot::default() }
}
