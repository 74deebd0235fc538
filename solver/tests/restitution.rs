//! Restitution that comes out of impacts, whatever the step, the speed, the stiffness, the law and the phase of the step.
//! `MAKADAM_IMPACTS` sets the number of impacts that are drawn.

use crate::common::{FLOOR, Setup, grain, run_until};
use makadam::Simulation;
use makadam::scene::Scene;

/// Largest shortfall and excess of the restitution by law. A linear spring's damping starts with a jump at first touch.
const LINEAR: [f64; 2] = [0.025, 0.025];
const HERTZ: [f64; 2] = [0.012, 0.02];
/// Recovery of the overlap in an inelastic impact.
const RIGID: [f64; 2] = [1e-6, 0.0026];

/// Numbers from a seed, uniform between 0 and 1 (SplitMix64).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the logarithm.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.uniform())
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[(self.uniform() * list.len() as f64) as usize]
    }
}

#[derive(Clone, Copy, Debug)]
enum Law {
    Rigid,
    Linear,
    Hertz,
}

/// An impact without gravity.
#[derive(Clone, Copy, Debug)]
struct Impact {
    law: Law,
    /// s
    step: f64,
    /// m/s
    speed: f64,
    /// Pa
    modulus: f64,
    restitution: f64,
    /// Overlap at first touch over the path of a step.
    phase: f64,
    /// m
    radius: f64,
}

impl Impact {
    /// Impact whose overlap stays below half a radius: a deeper one is none of spheres.
    fn draw(random: &mut Random) -> Impact {
        loop {
            let impact = Self::draw_any(random);
            if impact.depth() < 0.5 * impact.radius {
                return impact;
            }
        }
    }

    fn draw_any(random: &mut Random) -> Impact {
        let (step, speed) = (random.between(1e-6, 2e-3), random.between(0.01, 5.0));
        let drawn = random.uniform();
        Impact {
            law: random.of(&[Law::Rigid, Law::Linear, Law::Hertz, Law::Hertz]),
            step,
            speed,
            modulus: random.between(1e5, 7e10),
            restitution: random.of(&[0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0, drawn]),
            phase: random.uniform(),
            // A grain that passes half its radius in a step meets walls on its way: see `impact.rs`.
            radius: (4.0 * speed * step).max(0.005),
        }
    }

    fn solver(&self) -> String {
        let law = match self.law {
            Law::Rigid => "{ kind = 'rigid' }".into(),
            Law::Linear => format!("{{ kind = 'linear', stiffness = {:e} }}", self.modulus * self.radius),
            Law::Hertz => "{ kind = 'hertz' }".into(),
        };
        format!(
            "step = {:e}\nnormal_law = {law}\nstop = {{ kind = 'sweeps', sweeps = 3 }}\nover_relaxation = 1.0",
            self.step
        )
    }

    fn start(&self, body: String) -> Simulation {
        let setup = Setup {
            gravity: [0.0; 3],
            youngs_modulus: self.modulus,
            restitution: self.restitution,
            friction: 0.0,
            wall_friction: 0.0,
            solver: self.solver(),
            body,
        };
        let mut scene = setup.scene();
        scene.watch.every = 0;
        Simulation::new(&scene, 1).unwrap_or_else(|error| panic!("{self:?}: {error}"))
    }

    /// Gap (m) from which the first overlap has the phase.
    fn gap(&self) -> f64 {
        (2.0 - self.phase) * self.speed * self.step
    }

    /// Largest overlap (m) of an elastic impact, by the stiffness or Hertz's law; masses and moduli of a pair differ by less than a
    /// factor of two.
    fn depth(&self) -> f64 {
        let mass = 2500.0 * 4.2 * self.radius.powi(3);
        match self.law {
            Law::Rigid => 0.0,
            Law::Linear => self.speed * (mass / (self.modulus * self.radius)).sqrt(),
            Law::Hertz => {
                (15.0 * mass * self.speed.powi(2) / (16.0 * 0.55 * self.modulus * self.radius.sqrt())).powf(0.4)
            }
        }
    }

    /// Steps that the impact takes at most, recovery of an inelastic one left out.
    fn steps(&self) -> usize {
        30 + (20.0 * self.depth() / self.speed / self.step) as usize
    }

    /// Fails where a speed of separation is not what it should be.
    fn judge(&self, separation: f64) {
        let found = separation / self.speed;
        let [below, above] = match self.law {
            Law::Rigid => RIGID,
            Law::Linear => LINEAR,
            Law::Hertz => HERTZ,
        };
        let excess = found - self.restitution;
        assert!(excess <= above && excess >= -below, "{self:?}: {found}");
    }
}

fn count() -> u64 {
    std::env::var("MAKADAM_IMPACTS").ok().map_or(300, |count| count.parse().expect("a whole number"))
}

#[test]
fn grains_leave_walls_at_their_restitution() {
    for seed in 0..count() {
        let impact = Impact::draw(&mut Random(seed));
        let Impact { radius, speed, .. } = impact;
        let body = format!("{FLOOR}{}", grain(radius, [0.0, 0.0, radius + impact.gap()], [0.0, 0.0, -speed]));
        let mut simulation = impact.start(body);
        let mut state = simulation.snapshot().particles[0];
        for _ in 0..impact.steps() {
            simulation.step();
            state = simulation.snapshot().particles[0];
            if state.velocity[2] > 0.0 && state.position[2] > radius {
                break;
            }
        }
        impact.judge(state.velocity[2]);
    }
}

#[test]
fn pairs_part_at_their_restitution_and_keep_momentum() {
    for seed in 0..count() {
        let random = &mut Random(seed + 1_000_000);
        let impact = Impact { law: random.of(&[Law::Rigid, Law::Linear, Law::Hertz]), ..Impact::draw(random) };
        let radii = [impact.radius, impact.radius * (1.0 + random.uniform())];
        // Along any direction, in any frame of reference.
        let direction: [f64; 3] = std::array::from_fn(|_| 2.0 * random.uniform() - 1.0);
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let normal = direction.map(|x| x / length);
        let drift: [f64; 3] = std::array::from_fn(|_| impact.speed * (2.0 * random.uniform() - 1.0));
        let apart = radii[0] + radii[1] + impact.gap();
        let at = |distance: f64| normal.map(|x| x * distance);
        let velocity: [f64; 3] = std::array::from_fn(|axis| drift[axis] - impact.speed * normal[axis]);
        let body = grain(radii[0], [0.0; 3], drift) + &grain(radii[1], at(apart), velocity);
        let mut simulation = impact.start(body);
        let start = simulation.momentum();
        let separation = |simulation: &Simulation| {
            let [a, b] = <[_; 2]>::try_from(simulation.snapshot().particles).expect("two grains");
            let arm: [f64; 3] = std::array::from_fn(|axis| b.position[axis] - a.position[axis]);
            let distance = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
            let closing = (0..3).map(|axis| (b.velocity[axis] - a.velocity[axis]) * arm[axis] / distance).sum::<f64>();
            (distance > a.radius + b.radius, closing)
        };
        let energy = simulation.energy().kinetic;
        let mut parted = (false, 0.0);
        for _ in 0..impact.steps() {
            simulation.step();
            parted = separation(&simulation);
            if parted.0 && parted.1 > 0.0 {
                break;
            }
        }
        impact.judge(parted.1);
        // Where the step resolves it, an impact without loss keeps its energy up to the order of the step.
        assert!(simulation.energy().kinetic <= energy * (1.0 + 1e-3), "{impact:?}: energy is created");
        let size = start.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (now, then) in simulation.momentum().iter().zip(start) {
            assert!((now - then).abs() <= 1e-11 * size, "{impact:?}: {now} of {then} kg m/s");
        }
    }
}

/// A gas of smooth grains in a periodic box: the share of its energy that it has after half a second.
fn energy_kept(step: f64, restitution: f64) -> f64 {
    let text = format!(
        "name = 'gas'\ndescription = ''\nduration = 1.0\ngravity = [0, 0, 0]\n\
         domain = {{ min = [0, 0, 0], max = [0.08, 0.08, 0.08], periodic = ['x', 'y', 'z'] }}\n\
         [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0\n\
         restitution = {restitution}\n[solver]\nstep = {step:e}\n[watch]\nevery = 0\n\
         [[population]]\ncount = 125\nmaterial = 'grain'\nradius = {{ kind = 'fixed', value = 0.004 }}\n\
         region = {{ kind = 'box', min = [0, 0, 0], max = [0.08, 0.08, 0.08] }}\nspacing = 1.9\nagitation = 0.5\n"
    );
    let mut simulation = Simulation::new(&Scene::parse(&text).unwrap(), 1).unwrap();
    let start = simulation.energy().kinetic;
    run_until(&mut simulation, 0.5);
    let end = simulation.energy();
    (end.kinetic + end.elastic) / start
}

#[test]
fn an_elastic_gas_keeps_its_energy_at_any_step() {
    for step in [2.5e-5, 5e-5, 1e-4, 2e-4, 5e-4] {
        let kept = energy_kept(step, 1.0);
        println!("{step} s: {kept}");
        assert!((0.98..1.003).contains(&kept), "{kept} of the energy is left at a step of {step} s");
    }
}

/// Greatest height (m) of the lowest point of a grain after its first impact on the floor, dropped from a height (m).
fn height_of_bounce(radius: f64, drop: f64, restitution: f64, solver: &str) -> f64 {
    let body = format!("{FLOOR}{}", grain(radius, [0.0, 0.0, radius + drop], [0.0; 3]));
    let mut simulation = Setup { restitution, solver: solver.into(), body, ..Setup::default() }.start();
    let mut state = || {
        simulation.step();
        simulation.snapshot().particles[0]
    };
    while state().velocity[2] <= 0.0 {}
    let mut highest = 0.0_f64;
    loop {
        let now = state();
        highest = highest.max(now.position[2] - radius);
        if now.velocity[2] < 0.0 {
            return highest;
        }
    }
}

#[test]
fn fine_powder_rebounds_to_its_height() {
    for law in ["hertz", "rigid"] {
        let solver = format!("step = 1e-5\nnormal_law = {{ kind = '{law}' }}");
        let height = height_of_bounce(25e-6, 100e-6, 0.9, &solver);
        assert!((height - 81e-6).abs() < 1e-6, "{law}: {height} m");
        // What is slower than a threshold that a scene gives is at rest, as it says.
        let height = height_of_bounce(25e-6, 100e-6, 0.9, &format!("{solver}\nrestitution_threshold = 0.05"));
        assert!(height < 40e-6, "{law}: {height} m");
    }
}

#[test]
fn the_threshold_follows_the_scales_of_the_scene() {
    let threshold = |gravity: f64, radius: f64, solver: &str| {
        let body = format!("{FLOOR}{}", grain(radius, [0.0, 0.0, 2.0 * radius], [0.0; 3]));
        Setup { gravity: [0.0, 0.0, -gravity], solver: solver.into(), body, ..Setup::default() }
            .scene()
            .slowest_impact()
    };
    assert!((threshold(9.81, 0.005, "step = 5e-4") - 0.16 * (9.81 * 0.01_f64).sqrt()).abs() < 1e-12);
    assert!((threshold(9.81, 25e-6, "step = 5e-4") - 5.0 * 9.81 * 5e-4).abs() < 1e-12);
    assert_eq!(threshold(0.0, 0.005, "step = 5e-4"), 0.0);
    assert_eq!(threshold(9.81, 0.005, "step = 5e-4\nrestitution_threshold = 0.02"), 0.02);
}

#[test]
fn impacts_all_below_the_threshold_are_reported() {
    let slow = |gravity: f64, speed: f64, solver: &str| {
        let body = format!("{FLOOR}{}", grain(0.005, [0.0, 0.0, 0.0051], [0.0, 0.0, -speed]));
        let setup = Setup { gravity: [0.0, 0.0, -gravity], solver: solver.into(), body, ..Setup::default() };
        let findings = setup.scene().findings(None);
        findings.iter().any(|finding| finding.problem.contains("restitution_threshold"))
    };
    assert!(slow(0.0, 0.04, "restitution_threshold = 0.05"));
    assert!(!slow(0.0, 0.04, ""), "without gravity nothing is at rest");
    assert!(!slow(0.0, 0.06, "restitution_threshold = 0.05"));
    // Under gravity a grain may fall through the whole domain.
    let end = (2.0 * 9.81 * 1.0051 + 0.04_f64 * 0.04).sqrt();
    assert!(slow(9.81, 0.04, &format!("restitution_threshold = {}", 1.01 * end)));
    assert!(!slow(9.81, 0.04, &format!("restitution_threshold = {}", 0.99 * end)));
}
