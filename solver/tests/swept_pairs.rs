//! Grains never pass through each other, however fast they are for the step.
//!
//! `MAKADAM_PAIRS=100000 cargo test --release -p makadam swept_pairs` tries as many.

use crate::common::{CONVERGED_RIGID, DENSITY, Setup, grain, parse};
use crate::containment::draw::Drawn;
use makadam::scene::Scene;
use makadam::schedule::Scheduler;
use makadam::snapshot::Particle;
use makadam::watch::{Trouble, Watchdog};
use makadam::{Partner, Simulation};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};

type Vector = Vector3<f64>;

/// Pairs of a usual run.
const FEW: u64 = 2000;

/// Time step, s.
const STEP: f64 = 1e-4;

struct Dice(ChaCha8Rng);

impl Dice {
    fn number(number: u64) -> Dice {
        Dice(ChaCha8Rng::seed_from_u64(number))
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn direction(&mut self) -> Vector {
        loop {
            let vector = Vector::from_fn(|_, _| self.between(-1.0, 1.0));
            if (0.1..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }
}

/// Two smooth grains in space that fly at each other.
struct Pair {
    radii: [f64; 2],
    /// Unit vector of the motion of the first as seen from the second.
    along: Vector,
    /// Distance at which they would pass each other, over the sum of their radii, and its direction.
    offset: f64,
    across: Vector,
    /// Relative speed, m/s, and steps until they meet.
    speed: f64,
    steps: f64,
    restitution: f64,
    rigid: bool,
    /// Velocity of the second, m/s.
    drift: Vector,
}

impl Pair {
    fn number(number: u64) -> Pair {
        let mut dice = Dice::number(number);
        let radii = [dice.between(0.002, 0.01), dice.between(0.002, 0.01)];
        let along = dice.direction();
        let across = along.cross(&dice.direction()).normalize();
        // From a tenth of the smaller grain's diameter a step up to ten.
        let diameters = 0.1 * 100.0_f64.powf(dice.between(0.0, 1.0));
        let speed = diameters * 2.0 * radii[0].min(radii[1]) / STEP;
        Pair {
            radii,
            along,
            across,
            offset: if number.is_multiple_of(2) { 0.0 } else { dice.between(0.0, 0.8) },
            speed,
            steps: dice.between(0.5, 4.0),
            restitution: [0.0, 0.5, 1.0][number as usize / 2 % 3],
            rigid: (number / 6).is_multiple_of(2),
            drift: dice.direction() * (speed * dice.between(0.0, 1.0)),
        }
    }

    /// Sum of the radii, m.
    fn reach(&self) -> f64 {
        self.radii.iter().sum()
    }

    /// Relative path in a step, m.
    fn path(&self) -> f64 {
        self.speed * STEP
    }

    fn start(&self) -> Simulation {
        let far = (1.0 - self.offset * self.offset).sqrt() * self.reach() + self.path() * self.steps;
        let place = self.across * (self.offset * self.reach()) - self.along * far;
        let body = grain(self.radii[0], place.into(), (self.drift + self.along * self.speed).into())
            + &grain(self.radii[1], [0.0; 3], self.drift.into());
        let law = if self.rigid { "rigid" } else { "hertz" };
        let solver = CONVERGED_RIGID.replace("rigid", law);
        let setup = Setup {
            gravity: [0.0; 3],
            friction: 0.0,
            restitution: self.restitution,
            youngs_modulus: 1e9,
            solver,
            body,
            ..Setup::default()
        };
        setup.start()
    }
}

fn relative(simulation: &Simulation) -> [Vector; 2] {
    let particles = simulation.snapshot().particles;
    let [place, velocity]: [fn(&Particle) -> [f64; 3]; 2] = [|one| one.position, |one| one.velocity];
    [place, velocity].map(|of| Vector::from(of(&particles[0])) - Vector::from(of(&particles[1])))
}

#[test]
fn pairs_never_pass_from_a_tenth_of_a_diameter_a_step_to_ten() {
    let asked = std::env::var("MAKADAM_PAIRS").ok().map(|count| count.parse().expect("a whole number"));
    let (mut swept, mut slow) = (0, 0);
    for number in 0..asked.unwrap_or(FEW) {
        let pair = Pair::number(number);
        let mut simulation = pair.start();
        let [_, before] = relative(&simulation);
        let momentum = Vector::from(simulation.momentum());
        let energy = simulation.energy().kinetic;
        for _ in 0..12 {
            simulation.step();
        }
        assert_eq!(simulation.passage(), None, "pair {number}");
        let [place, velocity] = relative(&simulation);
        let lost = (Vector::from(simulation.momentum()) - momentum).norm();
        assert!(lost <= 1e-12 * momentum.norm().max(energy / pair.speed), "pair {number}: momentum {lost:e}");
        if pair.path() > pair.radii[0].min(pair.radii[1]) {
            // Newton's law along the normal at which smooth hard spheres meet, to rounding.
            swept += 1;
            let depth = (1.0 - pair.offset * pair.offset).sqrt();
            let normal = pair.along * depth - pair.across * pair.offset;
            let closing = normal.dot(&before);
            let sliding = velocity - normal * normal.dot(&velocity);
            assert!((sliding - (before - normal * closing)).norm() < 1e-6 * pair.speed, "pair {number}");
            let parting = -normal.dot(&velocity);
            let expected = pair.restitution * closing;
            assert!((parting - expected).abs() < 1e-6 * pair.speed, "pair {number}: {parting} for {expected} m/s");
        } else {
            slow += 1;
            let turned = (velocity - before).norm();
            assert!(turned > 0.1 * pair.speed, "pair {number} at {} R a step passed", pair.path() / pair.reach());
        }
        // The first is still on the side that it came from.
        let normal = pair.along * (1.0 - pair.offset * pair.offset).sqrt() - pair.across * pair.offset;
        assert!(pair.offset > 0.0 || normal.dot(&place) < 0.0, "pair {number} is on the other side");
    }
    println!("{swept} pairs swept, {slow} met at the start of a step");
    assert!(swept > 100 && slow > 100);
}

/// Shortest distance of two centres on their straight paths of a step over the one that they may not go below, of those whose path relative
/// to each other is longer than the smaller of their radii.
fn closest(before: &[Particle], after: &[Particle]) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..before.len() {
        for j in 0..i {
            let arm = |of: &[Particle]| Vector::from(of[j].position) - Vector::from(of[i].position);
            let (start, end, radii) = (arm(before), arm(after), [before[i].radius, before[j].radius]);
            let (path, larger, sum) = (end - start, radii[0].max(radii[1]), radii[0] + radii[1]);
            if path.norm() > (sum - larger) * (1.0 + 1e-6) {
                let share = (-start.dot(&path) / path.norm_squared()).clamp(0.0, 1.0);
                let bound = match start.norm() {
                    apart if apart > sum * (1.0 - 2e-9) => sum,
                    deep if deep <= larger => 0.9 * deep,
                    overlapping => larger + 0.9 * (overlapping - larger),
                };
                least = least.min((start + path * share).norm() / bound);
            }
        }
    }
    least
}

#[test]
fn no_path_of_a_step_leads_through_another_grain() {
    let (mut steps, mut struck, mut told) = (0, 0, 0);
    for number in 0..120 {
        let drawn = Drawn::number(number);
        if !drawn.container.repeats() {
            let mut simulation = Simulation::new(&drawn.scene(), 1).unwrap();
            let mut before = simulation.snapshot().particles;
            for step in 0..20 {
                simulation.step();
                if simulation.passage().is_some() || simulation.crossing().is_some() {
                    told += 1;
                    break;
                }
                let frame = simulation.snapshot();
                let least = closest(&before, &frame.particles);
                assert!(least > 1.0 - 1e-6, "container {number} ({}), step {step}: {least}", drawn.summary());
                steps += 1;
                struck += frame.contacts.iter().filter(|contact| contact.second.is_grain()).count();
                before = frame.particles;
            }
        }
    }
    println!("{steps} steps, {struck} contacts of grains; {told} runs given up");
    assert!(steps > 1000 && struck > 1000 && told < 40);
}

#[test]
fn the_scene_of_two_grains_that_passed_has_an_impact() {
    let text = "name = 'two'\ndescription = ''\nduration = 0.02\ngravity = [0.0, 0.0, 0.0]\n\
                domain = { min = [-10, -10, -10], max = [10, 10, 10] }\n\
                [material.a]\ndensity = 2500.0\nyoungs_modulus = 1e9\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
                [[grain]]\nmaterial = 'a'\nradius = 0.005\nposition = [-0.05, 0, 0]\nvelocity = [37.0, 0, 0]\n\
                [[grain]]\nmaterial = 'a'\nradius = 0.005\nposition = [0.05, 0.0, 0]\nvelocity = [-37.0, 0, 0]\n\
                [solver]\nstep = 5e-4\n";
    let mut simulation = Simulation::new(&parse(text).unwrap(), 1).unwrap();
    simulation.open_ledger();
    let mut impulse = 0.0;
    for _ in 0..40 {
        simulation.step();
        let contacts = simulation.snapshot().contacts;
        impulse += contacts.iter().map(|contact| contact.normal_force * 5e-4).sum::<f64>();
        assert!(contacts.iter().all(|contact| (contact.first, contact.second) == (0, Partner::Grain(1))));
    }
    let speeds = simulation.snapshot().particles.iter().map(|one| one.velocity[0]).collect::<Vec<_>>();
    assert!((speeds[0] + 18.5).abs() < 1e-9 && (speeds[1] - 18.5).abs() < 1e-9, "{speeds:?}");
    let mass = DENSITY * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    assert!((impulse / (mass * 55.5) - 1.0).abs() < 1e-9, "frames have the impulse of the impact: {impulse}");
    let balance = simulation.balance().unwrap();
    assert!((balance.restitution / (0.75 * balance.start.kinetic) - 1.0).abs() < 1e-9, "{balance:#?}");
    assert!(balance.closure.abs() < 1e-12 * balance.start.kinetic, "{balance:#?}");
    assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-15), "{balance:#?}");
}

/// Two grains that meet across the end of a periodic axis, so many periods a step.
#[test]
fn pairs_meet_across_a_periodic_end() {
    for (speed, place) in [(30.0, 0.045), (300.0, 0.0), (3000.0, 0.02), (5000.0, 0.0)] {
        let text = format!(
            "name = 'ring'\ndescription = ''\nduration = 1.0\ngravity = [0.0, 0.0, 0.0]\n\
             domain = {{ min = [-0.05, -1, -1], max = [0.05, 1, 1], periodic = ['x'] }}\n\
             [material.a]\ndensity = 2500.0\nyoungs_modulus = 1e9\npoisson_ratio = 0.3\nfriction = 0.0\nrestitution = 1.0\n\
             [[grain]]\nmaterial = 'a'\nradius = 0.005\nposition = [{place:?}, 0, 0]\nvelocity = [{speed:?}, 0, 0]\n\
             [[grain]]\nmaterial = 'a'\nradius = 0.005\nposition = [-0.03, 0.0, 0]\nvelocity = [0.0, 0, 0]\n\
             [solver]\nstep = 5e-4\n"
        );
        let mut simulation = Simulation::new(&parse(&text).unwrap(), 1).unwrap();
        for _ in 0..4 {
            simulation.step();
            let moving: Vec<f64> = simulation.snapshot().particles.iter().map(|one| one.velocity[0]).collect();
            // One of the two has it all, in turn.
            assert!(
                moving.iter().any(|one| one.abs() < 1e-9 * speed)
                    && moving.iter().any(|one| (one - speed).abs() < 1e-9 * speed),
                "{moving:?}"
            );
        }
        let hits = simulation.snapshot().particles[1].velocity[0];
        assert!(hits != 0.0 || speed > 30.0, "{speed} m/s: nobody was hit");
    }
}

#[test]
fn a_row_of_grains_passes_a_fast_impact_on() {
    let row = (0..6).map(|number| {
        let (place, velocity) = if number == 0 { (-0.02, 300.0) } else { (0.0, 0.0) };
        grain(0.005, [0.01 * f64::from(number) + place, 0.0, 0.0], [velocity, 0.0, 0.0])
    });
    let setup = Setup { gravity: [0.0; 3], restitution: 1.0, friction: 0.0, body: row.collect(), ..Setup::default() };
    let mut simulation = setup.start();
    for _ in 0..10 {
        simulation.step();
    }
    let speeds: Vec<f64> = simulation.snapshot().particles.iter().map(|one| one.velocity[0]).collect();
    assert!((speeds[5] - 300.0).abs() < 1e-6 && speeds[..5].iter().all(|one| one.abs() < 1e-6), "{speeds:?}");
}

#[test]
fn grains_that_fly_together_do_not_meet() {
    let mut body = String::new();
    for number in 0..200 {
        let at = [number % 6, number / 6 % 6, number / 36].map(|place| 0.0101 * f64::from(place));
        body += &grain(0.005, at, [700.0, -300.0, 100.0]);
    }
    let mut simulation = Setup { gravity: [0.0; 3], body, ..Setup::default() }.start();
    let momentum = simulation.momentum();
    for _ in 0..50 {
        simulation.step();
        assert!(simulation.snapshot().contacts.is_empty());
    }
    assert_eq!(simulation.momentum(), momentum);
}

/// Grains that close in on each other from all sides.
fn implosion(diameters: f64) -> Scene {
    let mut body = String::new();
    for number in 0..300 {
        let direction = Dice::number(number).direction();
        let place = direction * (0.05 + 0.0005 * number as f64);
        body += &grain(0.004, place.into(), (direction * (-diameters * 0.008 / 1e-4)).into());
    }
    let scene = Setup { gravity: [0.0; 3], body, ..Setup::default() }.scene();
    Scene { largest_start_overlap: 2.0, ..scene }
}

#[test]
fn fast_grains_have_the_same_bits_on_any_number_of_threads_with_a_ledger_that_closes() {
    for diameters in [0.3, 1.0, 3.0] {
        let scene = implosion(diameters);
        let mut alone = Simulation::new(&scene, 1).unwrap();
        let mut kept = alone.clone();
        kept.open_ledger();
        let mut teams = [2, 3].map(|threads| {
            let mut simulation = alone.clone();
            simulation.use_team(Scheduler::WorkStealing, threads).unwrap();
            simulation
        });
        for _ in 0..25 {
            alone.step();
            kept.step();
            for team in &mut teams {
                team.step();
            }
        }
        assert_eq!(kept.state_hash(), alone.state_hash(), "a ledger changes no bit");
        assert!(teams.iter().all(|team| team.state_hash() == alone.state_hash()), "{diameters} diameters a step");
        let balance = kept.balance().unwrap();
        assert!(balance.restitution > 0.1 * balance.start.kinetic, "{balance:#?}");
        assert!(balance.closure.abs() < 1e-9 * balance.start.kinetic, "{balance:#?}");
        assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-12), "{balance:#?}");
        assert!(balance.angular_momentum_closure.iter().all(|open| open.abs() < 1e-12), "{balance:#?}");
    }
}

#[test]
fn a_grain_that_rattles_between_two_within_a_step_ends_the_run() {
    let body = grain(0.5, [-0.51, 0.0, 0.0], [0.0; 3])
        + &grain(0.5, [0.51, 0.0, 0.0], [0.0; 3])
        + &grain(0.005, [0.001, 0.0, 0.0], [1e4, 0.0, 0.0]);
    let scene = Setup { gravity: [0.0; 3], restitution: 1.0, friction: 0.0, body, ..Setup::default() }.scene();
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    let mut watchdog = Watchdog::new(&scene.watch, &simulation);
    let report = simulation.step();
    let alarm = watchdog.check(&simulation, &report, false).unwrap_err();
    let Trouble::Passage { grains: [first, 2] } = alarm.trouble else { panic!("{alarm}") };
    assert!(first < 2 && alarm.trouble.is_fatal() && alarm.to_string().contains("lower solver.step"), "{alarm}");
    // Where impacts take energy it comes to rest, and all is well.
    let mut calmer = scene.clone();
    calmer.material.values_mut().for_each(|one| one.restitution = 0.5);
    let mut simulation = Simulation::new(&calmer, 1).unwrap();
    for _ in 0..10 {
        simulation.step();
        let place = simulation.snapshot().particles[2].position[0];
        assert!(place.abs() < 0.015 && simulation.passage().is_none(), "{place}");
    }
}

#[test]
fn only_paths_that_close_in_on_a_grain_meet_it() {
    // The first goes four radii along x in the step, the second rests at the origin.
    for (place, meets, what) in [
        ([-3.5, 0.0], true, "head on"),
        ([-3.5, 1.9], true, "at the rim"),
        ([-3.5, 2.1], false, "it passes on the side"),
        ([2.5, 0.0], false, "it leads away"),
        ([-6.5, 0.0], false, "it ends before"),
    ] {
        let [x, y] = place.map(|part| 0.005 * part);
        let body = grain(0.005, [x, y, 0.0], [4.0 * 0.005 / STEP, 0.0, 0.0]) + &grain(0.005, [0.0; 3], [0.0; 3]);
        let mut simulation = Setup { gravity: [0.0; 3], body, ..Setup::default() }.start();
        simulation.step();
        let resting = simulation.snapshot().particles[1].velocity == [0.0; 3];
        assert_eq!(resting, !meets, "{what}");
    }
}
