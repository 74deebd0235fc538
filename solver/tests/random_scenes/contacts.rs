//! The contacts of a step, worked out from the snapshots before and after it: geometry, velocities, impulses, and what the
//! contact laws ask of them.

use super::scene::{Container, Drawn};
use makadam::effects::compliance::{NormalContact, NormalScheme, damping_ratio};
use makadam::effects::impact::Impact;
use makadam::scene::Scene;
use makadam::snapshot::{Partner, Snapshot};
use makadam::wall::PlacedWalls;
use makadam::{KeptContact, Simulation, SolutionError};
use nalgebra::Vector3;
use std::collections::BTreeMap;

type Vector = Vector3<f64>;

/// Moment of inertia of a solid sphere over `m r^2`.
pub const INERTIA: f64 = 0.4;

/// Rounding of sums of up to some thousands of terms, over the terms.
pub const ROUNDING: f64 = 1e-12;

/// Rounding of an overlap at a distance from the origin, m.
fn place_rounding(farthest: f64) -> f64 {
    8.0 * f64::EPSILON * farthest
}

/// Condition of the normal law: `u_n >= bias - regularisation lambda_n`, an equality where the contact is active.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// m/s
    pub bias: f64,
    /// 1/kg
    pub regularisation: f64,
}

/// A contact of a step; of a wall contact the grain is the first.
#[derive(Clone, Debug)]
pub struct Touch {
    pub first: usize,
    /// The second grain, or none for a wall.
    pub second: Option<usize>,
    /// Unit normal from the first to the second.
    pub normal: Vector,
    /// `1/m_a + 1/m_b`, 1/kg.
    pub inverse_mass: f64,
    /// Absent for a grain that passes more than a radius in the step and meets a wall on its way.
    pub law: Option<Law>,
    /// Relative velocity before the step, without gravity, and after it, m/s.
    pub before: Vector,
    pub after: Vector,
    /// Impulses on the second, N s; zero where the contact bears nothing.
    pub along: f64,
    pub tangential: Vector,
}

/// Largest residual of the solve of a step, m/s.
#[derive(Clone, Copy, Debug)]
pub struct Inexact {
    pub normal: f64,
    pub tangential: f64,
}

impl Inexact {
    /// The largest residuals that the solver owns up to.
    pub fn of(error: &SolutionError) -> Inexact {
        let residuals = error.residuals;
        Inexact {
            normal: residuals.normal.max,
            tangential: residuals.tangential_u.max.hypot(residuals.tangential_v.max),
        }
    }

    /// Largest residual with rounding: a velocity is a sum of changes by impulses, [`ROUNDING`] in all, and the terms of the
    /// laws are as large as velocities, or as `lambda D` where contacts press against each other. An overlap is a difference of
    /// places, of which the stabilisation makes a velocity.
    pub fn rounded(self, touches: &[Touch], step: f64, farthest: f64) -> Inexact {
        let term = |touch: &Touch| {
            let operator = touch.operator(0.0) + touch.law.map_or(0.0, |law| law.regularisation);
            let bias = touch.law.map_or(0.0, |law| if touch.along > 0.0 { law.bias.abs() } else { 0.0 });
            (touch.along + touch.tangential.norm()) * operator + touch.before.norm() + touch.after.norm() + bias
        };
        let rounding = ROUNDING * touches.iter().map(term).fold(0.0, f64::max) + 4.0 / step * place_rounding(farthest);
        Inexact { normal: self.normal + rounding, tangential: self.tangential + rounding }
    }
}

impl Touch {
    /// Normal velocity after the step, m/s.
    pub fn opening(&self) -> f64 {
        self.normal.dot(&self.after)
    }

    /// Tangential velocity after the step, m/s.
    pub fn sliding(&self) -> Vector {
        self.after - self.normal * self.opening()
    }

    /// Velocity at which the law lets a bearing contact open, m/s.
    pub fn asked(&self) -> Option<f64> {
        self.law.map(|law| law.bias - law.regularisation * self.along)
    }

    fn operator(&self, regularisation: f64) -> f64 {
        // The tangential operator is the largest part: 3.5 for a solid sphere.
        (1.0 + 1.0 / INERTIA) * self.inverse_mass + regularisation
    }

    /// Bound of `lambda_n w` with the gap velocity `w = u_n - asked`, J, for a residual `rho = |min(lambda_n D, w)|`: the product
    /// of the smaller and the larger of `lambda_n D` and w, over D.
    pub fn normal_slack(&self, inexact: Inexact) -> f64 {
        let Some(law) = self.law else { return 0.0 };
        if self.along <= 0.0 {
            return 0.0;
        }
        let operator = self.inverse_mass + law.regularisation;
        let gap = self.opening() - (law.bias - law.regularisation * self.along);
        inexact.normal * self.along.max(gap.abs() / operator)
    }

    /// Bound of `lambda_t . u_t + mu lambda_n |u_t|`, J, which is never negative in the cone and zero under Coulomb's law.
    ///
    /// One update takes `lambda_t` to the projection p of `lambda_t - u_t / D` on the disc of radius `R = mu lambda_n'`, where
    /// `lambda_n'` is updated too, and the residual is `rho = D |p - lambda_t|`. For every z in the disc
    /// `(lambda_t - u_t/D - p) . (z - p) <= 0`; with `z = -R u_t/|u_t|` and `|z - p| <= 2 R` follows
    /// `p . u_t <= -R |u_t| + 2 R rho`, and `lambda_t . u_t <= p . u_t + rho |u_t| / D`.
    pub fn friction_slack(&self, friction: f64, inexact: Inexact) -> f64 {
        if friction == 0.0 {
            return 0.0;
        }
        let normal = inexact.normal / self.inverse_mass;
        let tangential = inexact.tangential / self.operator(0.0);
        let (radius, sliding) = (friction * (self.along + normal), self.sliding().norm());
        2.0 * radius * inexact.tangential + (tangential + friction * normal) * sliding
    }
}

/// The scene's wall and how its contacts are discretised.
pub struct Laws {
    drawn: Drawn,
    scheme: NormalScheme,
    scene: Scene,
    masses: Vec<f64>,
    damping_ratio: f64,
}

impl Laws {
    /// The laws of a scene as its text says them.
    pub fn new(drawn: &Drawn, scene: &Scene) -> Laws {
        let settings = &scene.solver;
        let mean_radius = drawn.grains.iter().map(|grain| grain.radius).sum::<f64>() / drawn.grains.len() as f64;
        let scheme = NormalScheme {
            law: settings.normal_law,
            step: settings.step,
            damping_steps: settings.damping_steps,
            restitution_threshold: settings.slowest_impact(mean_radius, drawn.gravity.norm()),
            gravity: drawn.gravity.norm(),
        };
        let masses = (0..drawn.grains.len()).map(|grain| drawn.mass(grain)).collect();
        Laws {
            drawn: drawn.clone(),
            scheme,
            scene: scene.clone(),
            masses,
            damping_ratio: damping_ratio(drawn.restitution),
        }
    }

    pub fn mass(&self, grain: usize) -> f64 {
        self.masses[grain]
    }

    /// Mass of all grains, kg.
    pub fn mass_of_all(&self) -> f64 {
        self.masses.iter().sum()
    }

    /// The law of a contact that ended with a normal impulse and a normal velocity.
    ///
    /// It jumps where an overlap begins, and at the threshold of impacts: contacts that were stopped at touch lie there up to
    /// rounding. Of the laws within rounding the one is taken that fits best.
    fn fitting_law(
        &self,
        [overlap, velocity]: [f64; 2],
        rest: [f64; 2],
        kept: Option<&KeptContact>,
        farthest: f64,
        ended: [f64; 2],
    ) -> Law {
        let [along, opening] = ended;
        let gap = |law: &Law| opening - law.bias + law.regularisation * along;
        let off = |law: &Law| if along > 0.0 { gap(law).abs() } else { -gap(law) };
        let (far, fast) = (place_rounding(farthest), ROUNDING * velocity.abs());
        let near = [-1.0, 0.0, 1.0]
            .into_iter()
            .flat_map(|a| [-1.0, 0.0, 1.0].map(|b| (overlap + a * far, velocity + b * fast)));
        let laws = near.map(|(overlap, velocity)| self.law([overlap, velocity], rest, kept));
        laws.min_by(|a, b| off(a).total_cmp(&off(b))).expect("there are nine")
    }

    fn law(&self, state: [f64; 2], [effective_radius, inverse_mass]: [f64; 2], kept: Option<&KeptContact>) -> Law {
        let [overlap, velocity] = state;
        // Both sides of a contact are of one material, with Poisson's ratio 0.3.
        let effective_modulus = self.drawn.youngs_modulus.unwrap_or(1e7) / (2.0 * (1.0 - 0.3 * 0.3));
        let (restitution, damping_ratio) = (self.drawn.restitution, self.damping_ratio);
        let contact =
            NormalContact { overlap, velocity, effective_modulus, effective_radius, inverse_mass, damping_ratio };
        let known = kept.map_or([0.0; 2], |one| [one.impact.speed, one.impact.velocity].map(f64::from));
        let impact = Impact::of(state, known, kept.map_or(0.0, |one| one.impulse[0]) * inverse_mass);
        let constraint = contact.constraint(&self.scheme, impact.speed);
        let constraint = impact.decide(constraint, &self.scheme, state, inverse_mass, restitution).constraint;
        Law { bias: constraint.bias, regularisation: constraint.regularisation }
    }

    /// All contacts of a step that bear, and those of grains that overlap before it and bear nothing, given what contacts kept from
    /// the step before.
    pub fn touches(
        &self,
        before: &Snapshot,
        after: &Snapshot,
        [kept_pairs, kept_walls]: &[Vec<KeptContact>; 2],
    ) -> Vec<Touch> {
        let h = self.scheme.step;
        // Impulses by pair of grains, on the second; and by grain and normal at walls.
        let (mut pairs, mut walls) = (BTreeMap::new(), Vec::new());
        for contact in &after.contacts {
            let (along, tangential) = (contact.normal_force * h, Vector::from(contact.tangential_force) * h);
            match contact.second {
                Partner::Grain(second) if contact.first < second => {
                    pairs.insert((contact.first as usize, second as usize), (along, tangential));
                }
                Partner::Grain(second) => {
                    pairs.insert((second as usize, contact.first as usize), (along, -tangential));
                }
                Partner::Wall(_) => {
                    walls.push((contact.first as usize, Vector::from(contact.normal), along, tangential))
                }
            }
        }
        let mut touches = Vec::new();
        let velocity = |snapshot: &Snapshot, grain: usize| Vector::from(snapshot.particles[grain].velocity);
        // The surface moves with r omega x n on the first side.
        let surface = |snapshot: &Snapshot, grain: usize, normal: &Vector| {
            (Vector::from(snapshot.particles[grain].spin) * snapshot.particles[grain].radius).cross(normal)
        };
        let grains = &before.particles;
        let farthest = farthest(before);
        for first in 0..grains.len() {
            for second in first + 1..grains.len() {
                let (a, b) = (&grains[first], &grains[second]);
                let arm = Vector::from(b.position) - Vector::from(a.position);
                let overlap = a.radius + b.radius - arm.norm();
                let borne = pairs.get(&(first, second));
                if borne.is_none() && overlap < 0.0 {
                    continue;
                }
                let normal = arm.normalize();
                let relative = |snapshot: &Snapshot| {
                    let turning = surface(snapshot, first, &normal) + surface(snapshot, second, &normal);
                    velocity(snapshot, second) - velocity(snapshot, first) - turning
                };
                let inverse_mass = 1.0 / self.masses[first] + 1.0 / self.masses[second];
                let (along, tangential) = borne.copied().unwrap_or((0.0, Vector::zeros()));
                let own = relative(before);
                let effective_radius = a.radius * b.radius / (a.radius + b.radius);
                let after = relative(after);
                let (state, rest) = ([overlap, normal.dot(&own)], [effective_radius, inverse_mass]);
                let ids = [first as u32, second as u32];
                let is_it = |one: &&KeptContact| [one.first, one.second] == ids || [one.second, one.first] == ids;
                let own_kept = kept_pairs.iter().find(is_it);
                let law = Some(self.fitting_law(state, rest, own_kept, farthest, [along, normal.dot(&after)]));
                let second = Some(second);
                touches.push(Touch { first, second, normal, inverse_mass, law, before: own, after, along, tangential });
            }
        }
        let walls_placed =
            PlacedWalls::at(&self.scene.wall, &self.scene.domain, before.time, &before.driven_walls, &[]);
        // The first face of a cylinder is its shell; no grain gets to its rims. In a step that turns it moves along the chord.
        let (shells, turn) = match self.drawn.container {
            Container::Cylinder { rate, .. } => (1, rate * h),
            _ => (usize::MAX, 0.0),
        };
        let chord = if turn == 0.0 { 1.0 } else { turn.sin() / turn };
        let faces: Vec<_> = walls_placed.faces().map(|(_, face)| face).take(shells).collect();
        for (first, grain) in grains.iter().enumerate() {
            let centre = Vector::from(grain.position);
            for (number, face) in faces.iter().enumerate() {
                let travel = || velocity(before, first) + self.drawn.gravity * h - face.velocity_at(&centre);
                let (gap, own_normal) = face.nearest(&centre, travel);
                let overlap = grain.radius - gap;
                // The faces of a box lie across each other; of other walls there is one.
                let parallel = |normal: &Vector| normal.dot(&own_normal) > 0.9 || faces.len() == 1;
                let borne = walls.iter().find(|(of, normal, ..)| *of == first && parallel(normal));
                if borne.is_none() && overlap < 0.0 {
                    continue;
                }
                let fast = velocity(before, first).norm() * h > grain.radius;
                let (normal, along, tangential) =
                    borne.map_or((own_normal, 0.0, Vector::zeros()), |&(_, normal, along, by)| (normal, along, by));
                let wall = face.velocity_at(&(centre + normal * gap)) * chord;
                let relative =
                    |snapshot: &Snapshot| wall - velocity(snapshot, first) - surface(snapshot, first, &normal);
                let (own, inverse_mass) = (relative(before), 1.0 / self.masses[first]);
                let after = relative(after);
                let (state, rest) = ([overlap, normal.dot(&own)], [grain.radius, inverse_mass]);
                let of_face = |one: &&KeptContact| one.first == first as u32 && one.second == number as u32;
                let own_kept = kept_walls.iter().find(of_face);
                let law = self.fitting_law(state, rest, own_kept, farthest, [along, normal.dot(&after)]);
                let law = (!fast).then_some(law);
                touches.push(Touch {
                    first,
                    second: None,
                    normal,
                    inverse_mass,
                    law,
                    before: own,
                    after,
                    along,
                    tangential,
                });
            }
        }
        touches
    }
}

/// A step and what it left: snapshots before and after, its contacts, and how exact its solve was.
pub struct Stepped {
    pub before: Snapshot,
    pub after: Snapshot,
    pub touches: Vec<Touch>,
    pub inexact: Inexact,
    /// Impacts on the paths of grains after the solve. They change velocities once more, so that these are not those of the solve, and the
    /// places at which the paths end.
    pub struck: usize,
    /// Memory of contacts from the step before.
    pub kept: [Vec<KeptContact>; 2],
}

/// Takes a step.
pub fn step(simulation: &mut Simulation, laws: &Laws) -> Stepped {
    let (before, kept) = (simulation.snapshot(), simulation.kept_contacts());
    simulation.step();
    let error = simulation.solution_error();
    let after = simulation.snapshot();
    let touches = laws.touches(&before, &after, &kept);
    let inexact = Inexact::of(&error).rounded(&touches, laws.scheme.step, farthest(&before));
    Stepped { before, after, touches, inexact, struck: simulation.impacts_on_paths(), kept }
}

/// Largest distance of a grain's surface from the origin, m.
pub fn farthest(snapshot: &Snapshot) -> f64 {
    snapshot.particles.iter().map(|grain| Vector::from(grain.position).norm() + grain.radius).fold(0.0, f64::max)
}

impl Container {
    /// Returns true if its walls move.
    pub fn moves(&self) -> bool {
        matches!(self, Container::Cylinder { rate, .. } if *rate != 0.0)
    }
}
