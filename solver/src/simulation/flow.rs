//! Grains that come and go by the scene: sources and sinks.
//!
//! Grains come and go at the start of a step that rebuilds the candidate list. If grains are due and the list is still valid, it
//! is rebuilt once a grain could have fallen by its mean diameter since ([`Flow::every`]), or at once if a grain could leave a sink
//! within the step or has crossed it in the last one. A grain is due for a sink if its straight path in the last step meets it. A source places each grain at a random free place of its region, without overlap; after some tries the grain
//! waits for the next rebuild. The radius of a grain is a function of seed, source and its number among the grains of the
//! source. The place is one of seed, source and try. So bits do not depend on threads, and a checkpoint holds the counts alone.

use crate::Simulation;
use crate::lanes::{cross, plus, times};
use crate::scene::{Insertion, Neighbours, Region, Removal, Scene, sphere_volume};
use crate::schedule::{Phase, Team};
use crate::simulation::energy::Stored;
use crate::simulation::intervention::Booked;
use crate::world::{Body, INERTIA, NewGrain, Sphere, World, chunk, chunks};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of tries to place a grain at a rebuild, after which it waits.
const TRIES: u64 = 100;

/// Fewest steps between two rebuilds for grains that are due: a rebuild costs about as much as one to two steps.
const FEWEST_STEPS: f64 = 16.0;

/// Largest time between two rebuilds for grains that are due, over the duration of the scene: without gravity, grains do not fall.
const LATEST: f64 = 0.01;

/// Words of the generator for one radius or one place.
const WORDS: u128 = 1 << 12;

/// Grains that have come from a source, or gone into a sink.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Passed {
    /// Number of grains.
    pub grains: u64,
    /// Mass, kg.
    pub mass: f64,
}

impl Passed {
    fn add(&mut self, mass: f64) {
        self.grains += 1;
        self.mass += mass;
    }
}

/// State of the sources and sinks of a scene: [`Simulation::flow`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlowReport {
    /// Grains from each source, in the order of the scene.
    pub inserted: Vec<Passed>,
    /// Time by which each source is late with its next grain, s; 0 if none is due.
    pub lags: Vec<f64>,
    /// Grains into each sink, in the order of the scene.
    pub removed: Vec<Passed>,
    /// Largest lag of a source that finds free places, s: grains come only when the candidate list is rebuilt.
    pub usual_lag: f64,
}

/// Counts of sources and sinks, which with the scene determine all later grains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Counts {
    pub seed: u64,
    pub inserted: Vec<Passed>,
    /// Tries of each source to place a grain.
    pub tries: Vec<u64>,
    pub removed: Vec<Passed>,
}

impl Counts {
    /// Returns true if the counts are possible.
    pub fn are_sound(&self) -> bool {
        let mut passed = self.inserted.iter().chain(&self.removed);
        passed.all(|passed| (0.0..1e30).contains(&passed.mass) && passed.grains < 1 << 53)
            && self.tries.iter().all(|&tries| tries < 1 << 53)
    }
}

/// Sources and sinks of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Flow {
    scene: Arc<Scene>,
    /// Number of the material and density (kg/m3) of the grains of each source.
    materials: Vec<(u8, f64)>,
    /// Number of steps after which the list is rebuilt for grains that are due.
    every: f64,
    pub counts: Counts,
    /// Energy that came minus energy that went since the simulation was built, without elastic energy, J.
    pub supplied: f64,
}

impl Flow {
    /// Returns the sources and sinks of a scene; `None` without any.
    pub fn of(scene: &Scene, seed: u64, world: &World) -> Option<Flow> {
        if !scene.flows() {
            return None;
        }
        let material = |source: &Insertion| {
            let number = world.table.find(&source.material).unwrap_or_default();
            (number, scene.material[&source.material].density)
        };
        let (gravity, mean) = (scene.largest_gravity(), 2.0 * scene.mean_radius());
        // Time in which a grain falls by a mean diameter, from rest or with the velocity of a source.
        let time = |speed: f64| 2.0 * mean / (speed + (speed * speed + 2.0 * gravity * mean).sqrt());
        let speeds = scene.insert.iter().map(|source| Vector3::from(source.velocity).norm());
        let time = speeds.map(time).fold(time(0.0), f64::min).min(LATEST * scene.duration);
        let counts = Counts {
            seed,
            inserted: vec![Passed::default(); scene.insert.len()],
            tries: vec![0; scene.insert.len()],
            removed: vec![Passed::default(); scene.remove.len()],
        };
        Some(Flow {
            materials: scene.insert.iter().map(material).collect(),
            every: (time / scene.solver.step).floor().clamp(FEWEST_STEPS, 1e4),
            scene: Arc::new(scene.clone()),
            counts,
            supplied: 0.0,
        })
    }

    /// Goes on with the sources and sinks of another stage.
    pub fn enter(&mut self, scene: &Scene, world: &World) {
        if let Some(next) = Flow::of(scene, self.counts.seed, world) {
            let before = std::mem::replace(self, next);
            (self.counts, self.supplied) = (before.counts, before.supplied);
        }
    }

    /// Returns true if a source has a further grain, now or later.
    pub fn has_grains_to_come(&self) -> bool {
        (0..self.counts.inserted.len()).any(|source| self.due_at(source).is_finite())
    }

    /// Takes over the counts of a checkpoint.
    ///
    /// # Errors
    /// Message if they belong to other sources or sinks.
    pub fn continue_from(&mut self, counts: &Counts) -> Result<(), String> {
        let lengths = |counts: &Counts| [counts.inserted.len(), counts.tries.len(), counts.removed.len()];
        if lengths(counts) != lengths(&self.counts) {
            return Err("has other sources and sinks than the scene".into());
        }
        self.counts = counts.clone();
        Ok(())
    }

    /// Returns the generator of a source at a number of its grains or of its tries.
    fn random(&self, source: usize, of_places: bool, number: u64) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.counts.seed);
        random.set_stream(2 * source as u64 + 1 + u64::from(of_places));
        random.set_word_pos(u128::from(number) * WORDS);
        random
    }

    /// Returns the radius (m) and the mass (kg) of the next grain of a source.
    fn next(&self, source: usize) -> (f64, f64) {
        let mut random = self.random(source, false, self.counts.inserted[source].grains);
        let radius = self.scene.insert[source].radius.draw(&mut random);
        (radius, self.materials[source].1 * sphere_volume(radius))
    }

    /// Returns the time (s) at which the next grain of a source is due; infinite if no more come.
    fn due_at(&self, source: usize) -> f64 {
        let (settings, Passed { grains, mass }) = (&self.scene.insert[source], self.counts.inserted[source]);
        let is_last = settings.total.is_some_and(|total| grains >= total);
        let after = match (settings.rate, settings.mass_rate) {
            (Some(rate), _) => (grains + 1) as f64 / rate,
            (_, Some(rate)) => (mass + self.next(source).1) / rate,
            _ => 0.0,
        };
        let time = settings.from + after;
        if is_last || settings.until.is_some_and(|until| time > until) { f64::INFINITY } else { time }
    }

    /// Returns the sinks that act at a time (s), with their numbers.
    fn sinks(&self, time: f64) -> impl Iterator<Item = (usize, &Region)> {
        let acts = move |sink: &Removal| time >= sink.from && sink.until.is_none_or(|until| time <= until);
        let sinks = self.scene.remove.iter().enumerate().filter(move |(_, sink)| acts(sink));
        sinks.map(|(index, sink)| (index, &sink.region))
    }
}

impl Simulation {
    /// Returns the grains that have come and gone by the sources and sinks of the scene; `None` for a scene without any.
    pub fn flow(&self) -> Option<FlowReport> {
        let flow = self.flow.as_ref()?;
        let lag = |source: usize| (self.world.time - flow.due_at(source)).max(0.0);
        Some(FlowReport {
            inserted: flow.counts.inserted.clone(),
            lags: (0..flow.counts.inserted.len()).map(lag).collect(),
            removed: flow.counts.removed.clone(),
            usual_lag: flow.every * self.settings.step,
        })
    }

    /// Returns the grains that have come from all sources and gone into all sinks.
    pub fn passed(&self) -> [Passed; 2] {
        let counts = self.flow.as_ref().map(|flow| &flow.counts);
        let sum = |sum: Passed, one: &Passed| Passed { grains: sum.grains + one.grains, mass: sum.mass + one.mass };
        let lists = counts.map_or([&[][..]; 2], |counts| [&counts.inserted, &counts.removed]);
        lists.map(|all| all.iter().fold(Passed::default(), sum))
    }

    /// Returns the energy that came minus the energy that went with grains, without elastic energy, since the simulation was
    /// built, J.
    pub(crate) fn supplied_by_flow(&self) -> f64 {
        self.flow.as_ref().map_or(0.0, |flow| flow.supplied)
    }

    /// Lets grains come and go that are due, if the candidate list is rebuilt in this step in any case (`stale`) or for them.
    /// Returns true if the list has to be rebuilt.
    pub(super) fn let_flow(&mut self, stale: bool, team: &Team) -> bool {
        let Some(flow) = self.flow.take() else { return stale };
        let (time, [due, at_once]) = (self.world.time, self.are_due(&flow, team));
        let age =
            self.candidates.built_from().map_or(f64::INFINITY, |(_, built_at)| (time - built_at) / self.settings.step);
        let now = due && (stale || at_once || age.round() >= flow.every);
        let flow = if now { self.exchange(flow) } else { flow };
        self.flow = Some(flow);
        stale || now
    }

    /// Returns the number of the sink that a grain is in (true), or has crossed in the last step (false).
    fn sink(&self, flow: &Flow, sphere: &Sphere, body: &Body) -> Option<(usize, bool)> {
        let (world, centre) = (&self.world, self.world.wrapped(&sphere.centre));
        let path = Vector3::from(body.velocity) * if self.steps > 0 { self.settings.step } else { 0.0 };
        let starts = [centre - path, world.wrapped(&(centre - path))];
        let met = |region: &Region| {
            starts[..1 + usize::from(world.period.any())].iter().any(|start| region.meets(start, &path))
        };
        flow.sinks(world.time)
            .find_map(|(index, region)| (region.holds(&centre) || met(region)).then(|| (index, region.holds(&centre))))
    }

    /// Returns true if a grain is due, and true if one may leave a sink within the step. Allocates nothing.
    fn are_due(&self, flow: &Flow, team: &Team) -> [bool; 2] {
        let (world, h) = (&self.world, self.settings.step);
        let (leaves, at_once) = (AtomicBool::new(false), AtomicBool::new(false));
        if flow.sinks(world.time).next().is_some() {
            let grains = world.grains();
            team.each(Phase::Detect, chunks(grains), |number| {
                let places = chunk(number, grains);
                for (sphere, body) in world.spheres[places.clone()].iter().zip(&world.bodies[places]) {
                    if let Some((index, is_inside)) = self.sink(flow, sphere, body) {
                        leaves.store(true, Ordering::Relaxed);
                        let velocity = Vector3::from(body.velocity) + world.gravity * h;
                        let next = world.wrapped(&(world.wrapped(&sphere.centre) + velocity * h));
                        let stays = is_inside && flow.scene.remove[index].region.holds(&next);
                        at_once.fetch_or(!stays, Ordering::Relaxed);
                    }
                }
            });
        }
        let mut sources = 0..flow.counts.inserted.len();
        let mut comes = || sources.any(|source| flow.due_at(source) <= world.time * (1.0 + 1e-12));
        [leaves.into_inner() || comes(), at_once.into_inner()]
    }

    /// Removes and inserts the grains that are due, and prepares the candidate list for its rebuild.
    fn exchange(&mut self, mut flow: Flow) -> Flow {
        let gone = self.leaving(&mut flow);
        let went = self.booked_with(&gone);
        let come = self.coming(&mut flow, &gone);
        if gone.is_empty() && come.is_empty() {
            return flow;
        }
        let came =
            come.iter().fold(Booked::default(), |sum, grain| sum.with(&self.booked_of(&grain.sphere, &grain.body)));
        flow.supplied += came.energy - (went.0.energy + went.1.cohesive);
        if let Some(ledger) = &mut self.ledger {
            ledger.exchange([&came, &went.0], went.1);
        }
        let moves = self.world.change(&gone, &come);
        self.candidates.change(&moves, &self.world);
        self.interventions.renumber_loads(&moves.ids, self.world.grains());
        self.swept.forget_pace();
        flow
    }

    /// Returns the places of the grains in sinks, ascending, and counts them.
    fn leaving(&self, flow: &mut Flow) -> Vec<u32> {
        let world = &self.world;
        let mut gone = Vec::new();
        for (place, (sphere, body)) in world.spheres[..world.grains()].iter().zip(&world.bodies).enumerate() {
            if let Some((sink, _)) = self.sink(flow, sphere, body) {
                gone.push(place as u32);
                flow.counts.removed[sink].add(1.0 / body.inverse_mass);
            }
        }
        gone
    }

    /// Returns the grains that come, source after source, and counts them.
    fn coming(&self, flow: &mut Flow, gone: &[u32]) -> Vec<NewGrain> {
        let (world, time) = (&self.world, self.world.time * (1.0 + 1e-12));
        let mut come = Vec::new();
        let sources = 0..flow.counts.inserted.len();
        if sources.clone().all(|source| flow.due_at(source) > time) {
            return come;
        }
        let scene = flow.scene.clone();
        let mut neighbours = Neighbours::new(&scene.domain, world.largest_and_mean_radius().0);
        let mut left = gone.iter().peekable();
        for (place, sphere) in (0..).zip(&world.spheres[..world.grains()]) {
            if left.next_if(|&&one| one == place).is_none() && self.is_near_a_source(&scene, sphere) {
                neighbours.add(&world.wrapped(&sphere.centre).into(), sphere.radius);
            }
        }
        let poses: Vec<_> = world.walls.poses(world.time).collect();
        let walls = world.walls.placed(&poses);
        let is_clear_of_walls = |centre: &Vector3<f64>, radius: f64| {
            let mut is_clear = true;
            walls.for_each_near(centre, |_| radius, |_, face| is_clear &= face.distance(centre) >= radius);
            is_clear
        };
        for source in sources {
            while flow.due_at(source) <= time {
                let (radius, mass) = flow.next(source);
                let free = (0..TRIES).find_map(|_| {
                    flow.counts.tries[source] += 1;
                    let mut random = flow.random(source, true, flow.counts.tries[source]);
                    let centre = scene.insert[source].region.draw(radius, &mut random);
                    let is_free = is_clear_of_walls(&centre, radius)
                        && neighbours.find(&centre.into(), radius, |overlap, _| overlap > 0.0).is_none();
                    is_free.then_some(centre)
                });
                let Some(centre) = free else { break };
                neighbours.add(&centre.into(), radius);
                flow.counts.inserted[source].add(mass);
                let (velocity, inverse_mass, inverse_radius) =
                    (scene.insert[source].velocity, 1.0 / mass, 1.0 / radius);
                come.push(NewGrain {
                    body: Body { velocity, inverse_mass, scaled_spin: [0.0; 3], inverse_radius },
                    sphere: Sphere { centre, radius },
                    material: flow.materials[source].0,
                    source: source as u16 + 1,
                });
            }
        }
        come
    }

    /// Returns true if a grain may touch a new grain of a source.
    fn is_near_a_source(&self, scene: &Scene, sphere: &Sphere) -> bool {
        let world = &self.world;
        let centre = world.wrapped(&sphere.centre);
        scene.insert.iter().any(|source| {
            let ((low, high), reach) = (source.region.bounds(), sphere.radius);
            (0..3).all(|axis| {
                let apart = (low[axis] - centre[axis]).max(centre[axis] - high[axis]);
                let length = world.period.length(axis);
                let around =
                    if world.period.is_periodic(axis) { length - (high[axis] - low[axis]) - apart } else { apart };
                apart.min(around) <= reach
            })
        })
    }

    /// Energy half a step earlier, momentum and angular momentum of a grain, without its contacts.
    fn booked_of(&self, sphere: &Sphere, body: &Body) -> Booked {
        let (mass, h, gravity) = (1.0 / body.inverse_mass, self.settings.step, self.world.gravity);
        let (velocity, spin) = (Vector3::from(body.velocity), Vector3::from(body.scaled_spin));
        let kinetic = 0.5 * mass * (velocity.norm_squared() + INERTIA * spin.norm_squared());
        let potential = -mass * gravity.dot(&(sphere.centre - velocity * (0.5 * h)));
        let own = times(body.scaled_spin, INERTIA * sphere.radius);
        Booked {
            energy: kinetic + potential,
            impulse: times(body.velocity, mass),
            angular_impulse: times(plus(cross(sphere.centre.into(), body.velocity), own), mass),
        }
    }

    /// Sums energy, momentum and angular momentum of grains, and the energy stored in their contacts.
    fn booked_with(&self, places: &[u32]) -> (Booked, Stored) {
        let mut sum = Booked::default();
        if places.is_empty() {
            return (sum, Stored::default());
        }
        let mut is_listed = vec![false; self.world.bodies.len()];
        for &place in places {
            is_listed[place as usize] = true;
            sum = sum.with(&self.booked_of(&self.world.spheres[place as usize], &self.world.bodies[place as usize]));
        }
        let counts = |places: [u32; 2]| places.iter().any(|&place| is_listed[place as usize]);
        (sum, self.contact_energy_of(counts).stored)
    }
}
