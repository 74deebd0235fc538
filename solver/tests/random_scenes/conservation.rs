//! Energy, momentum and angular momentum of scenes with all effects: the ledger accounts for each to rounding, and a scene seen from a
//! frame that moves, or in a mirror, moves as the scene.

use super::scene::{Container, Drawn, Solves, components, scenes};
use makadam::Simulation;
use makadam::scene::Scene;
use makadam::snapshot::Particle;
use nalgebra::Vector3;
use proptest::prelude::*;

type Vector = Vector3<f64>;

/// Steps of a run whose ledger is kept.
const STEPS: usize = 200;

/// Part of exchanged energies and momenta that rounding leaves open, of sums over some thousand contacts.
const OPEN: f64 = 1e-10;

/// A scene with more effects than those that all drawn scenes have.
#[derive(Clone, Debug)]
pub struct WithEffects {
    drawn: Drawn,
    /// Coefficient of kinetic friction over that of friction.
    kinetic: Option<f64>,
    rolling: f64,
    twisting: f64,
    /// Cohesive force over the weight of a grain of 5 mm, and its range, m.
    cohesion: Option<(f64, f64)>,
    spring: bool,
}

pub fn with_effects(most: usize) -> impl Strategy<Value = WithEffects> {
    let kinetic = prop_oneof![Just(None), (0.0..1.0_f64).prop_map(Some)];
    let coefficient = || prop_oneof![Just(0.0), 0.0..0.5_f64];
    let cohesion = prop_oneof![Just(None), (0.1..20.0_f64, 0.0..1e-4_f64).prop_map(Some)];
    (scenes(most), kinetic, coefficient(), coefficient(), cohesion, any::<bool>()).prop_map(
        |(drawn, kinetic, rolling, twisting, cohesion, spring)| {
            let spring = spring && drawn.youngs_modulus.is_some();
            WithEffects { drawn, kinetic, rolling, twisting, cohesion, spring }
        },
    )
}

impl WithEffects {
    fn start(&self, solves: Solves) -> Simulation {
        let mut effects = format!("rolling_friction = {:?}\ntwisting_friction = {:?}\n", self.rolling, self.twisting);
        if let Some(share) = self.kinetic {
            effects += &format!("kinetic_friction = {:?}\n", share * self.drawn.friction);
        }
        if let Some((weights, range)) = self.cohesion {
            let force = weights * 0.0128;
            effects += &format!("cohesion = {{ kind = 'constant', force = {force:?}, range = {range:?} }}\n");
        }
        let spring = if self.spring { "tangential_law = { kind = 'spring' }\n" } else { "" };
        let text = self.drawn.text(solves).replace("[solver]\n", &format!("{effects}[solver]\n{spring}"));
        let scene = Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        Simulation::new(&scene, 1).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }
}

/// Size of all momenta, kg m/s.
fn momentum(drawn: &Drawn, simulation: &Simulation) -> f64 {
    let particles = simulation.snapshot().particles;
    particles.iter().enumerate().map(|(grain, one)| drawn.mass(grain) * Vector::from(one.velocity).norm()).sum()
}

/// The ledger of each step; returns the steps, and how many of them had contacts.
pub fn check_ledger(scene: &WithEffects) -> Result<[u64; 2], TestCaseError> {
    let mut simulation = scene.start(Solves::Usual);
    simulation.open_ledger();
    let (mut size, mut bearing) = (momentum(&scene.drawn, &simulation), 0);
    for step in 1..=STEPS {
        bearing += u64::from(simulation.step().contacts > 0);
        size += momentum(&scene.drawn, &simulation);
        let balance = simulation.balance().expect("it is kept");
        let scale = balance.exchanged() + balance.start.kinetic + balance.end.kinetic + balance.start.potential.abs();
        prop_assert!(balance.closure.abs() <= OPEN * scale, "step {step}: {:e} of {scale:e} J open", balance.closure);
        let open = Vector::from(balance.momentum_closure).norm();
        prop_assert!(open <= OPEN * size, "step {step}: {open:e} of {size:e} kg m/s open");
        // No lever is longer than a metre.
        let open = Vector::from(balance.angular_momentum_closure).norm();
        prop_assert!(open <= OPEN * size, "step {step}: {open:e} of {size:e} kg m2/s open");
    }
    Ok([STEPS as u64, bearing])
}

/// Largest difference of a velocity from its image: in residuals at which solves end ([`Solves::Converged`], 1e-13 of g h or of 1 m/s), and
/// in speeds of the fastest grain.
///
/// The image has its grains in another order of cells, so that sweeps take its contacts in another order: the two solutions agree as far as
/// solves go, times the condition of the contact problem, and as far as rounding of velocities goes. The largest difference in 600 scenes
/// was below ten residuals; a hundred times that is allowed.
const OFF: [f64; 2] = [1e3, 1e-9];

/// Frame from which a scene is seen.
#[derive(Clone, Copy, Debug)]
pub enum Seen {
    /// One that moves with a velocity against the scene's, m/s.
    Moving(Vector),
    /// A mirror across x.
    Mirrored,
}

impl Seen {
    fn of(self, drawn: &Drawn) -> Drawn {
        match self {
            Seen::Moving(boost) => {
                let mut moved = drawn.clone();
                moved.grains.iter_mut().for_each(|grain| grain.velocity += boost);
                moved
            }
            Seen::Mirrored => drawn.mapped(|v| self.velocity(v), |v| self.spin(v)),
        }
    }

    fn velocity(self, of: Vector) -> Vector {
        match self {
            Seen::Moving(boost) => of + boost,
            Seen::Mirrored => Vector::new(-of.x, of.y, of.z),
        }
    }

    /// A spin, as an axial vector.
    fn spin(self, of: Vector) -> Vector {
        match self {
            Seen::Moving(_) => of,
            Seen::Mirrored => Vector::new(of.x, -of.y, -of.z),
        }
    }
}

/// A scene whose contacts are solved to the end, seen from another frame: every step leads to the image of its state. Seen from a
/// frame that moves, grains are among themselves: walls would move there.
///
/// A step of compliant contacts with moderate friction has one solution, and so have the velocities of smooth rigid grains. Rigid grains
/// with friction may have several: of three that touch each other, which do not roll without one contact that slides, the scene and its
/// mirror image slid at another one, with all laws obeyed to 1e-16 m/s. Rigid grains are compared without friction.
pub fn check_seen(scene: &WithEffects, seen: Seen) -> Result<[u64; 2], TestCaseError> {
    let container = match seen {
        Seen::Moving(_) => Container::None,
        Seen::Mirrored => scene.drawn.container,
    };
    let rough = f64::from(u8::from(scene.drawn.youngs_modulus.is_some()));
    let friction = 0.5 * rough * scene.drawn.friction.min(1.0);
    let own = WithEffects {
        drawn: Drawn { container, friction, ..scene.drawn.clone() },
        rolling: rough * scene.rolling,
        twisting: rough * scene.twisting,
        ..scene.clone()
    };
    let gravity = own.drawn.gravity.norm();
    let unit = if gravity > 0.0 { gravity * own.drawn.step } else { 1.0 };
    let mut run = own.start(Solves::Usual);
    let mut counts = [0; 2];
    for step in 0..STEPS {
        let state = run.snapshot();
        run.step();
        if step % 8 != 0 || run.snapshot().contacts.is_empty() {
            continue;
        }
        let Some(here) = own.drawn.starting_at(&state) else { break };
        let image = seen.of(&here);
        let [one, other] = [here, image].map(|drawn| {
            let mut simulation = WithEffects { drawn, ..own.clone() }.start(Solves::Converged);
            let report = simulation.step();
            (simulation.snapshot(), report.solve.is_converged())
        });
        counts[0] += 1;
        if !(one.1 && other.1) {
            continue;
        }
        counts[1] += 1;
        let speed =
            |grain: &Particle| Vector::from(grain.velocity).norm().max(Vector::from(grain.spin).norm() * grain.radius);
        let fastest = one.0.particles.iter().chain(&other.0.particles).map(speed).fold(0.0, f64::max);
        for (a, b) in one.0.particles.iter().zip(&other.0.particles) {
            let apart = (seen.velocity(a.velocity.into()) - Vector::from(b.velocity)).norm();
            let turned = (seen.spin(a.spin.into()) - Vector::from(b.spin)).norm() * a.radius;
            let off = apart.max(turned);
            let bound = OFF[0] * 1e-13 * unit + OFF[1] * fastest;
            prop_assert!(off <= bound, "step {step}: {off:e} m/s apart, {bound:e} at most, fastest {fastest:e}");
        }
    }
    Ok(counts)
}

/// A frame's velocity, m/s.
pub fn boosts() -> impl Strategy<Value = Vector> {
    components().prop_map(|share| share * 2.0)
}
