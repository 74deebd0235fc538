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
/// A step of compliant contacts with moderate friction has one solution; elsewhere Coulomb's law may have several.
pub fn check_seen(scene: &WithEffects, seen: Seen) -> Result<[u64; 2], TestCaseError> {
    let container = match seen {
        Seen::Moving(_) => Container::None,
        Seen::Mirrored => scene.drawn.container,
    };
    let friction = 0.5 * scene.drawn.friction.min(1.0);
    let own = WithEffects { drawn: Drawn { container, friction, ..scene.drawn.clone() }, ..scene.clone() };
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

#[test]
fn debug_mirror() {
    use super::scene::Grain;
    let drawn = Drawn { grains: vec![Grain { radius: 0.004432877489267082, position: Vector::new(0.0, 0.0, -0.0), velocity: Vector::new(0.0, 0.0, 0.09040725303825899), spin: Vector::new(0.0, 0.0, -28.173374366022784) }, Grain { radius: 0.004016380534603593, position: Vector::new(-0.005947381902650141, 0.0, -0.006025317839121262), velocity: Vector::new(0.06351010143183992, -0.1574292303945068, 0.0643423532211963), spin: Vector::new(0.0, 0.0, 7.274479968379007) }, Grain { radius: 0.004758367467036494, position: Vector::new(-0.01169370375079889, 0.0033504920865295826, -0.011774968548743265), velocity: Vector::new(0.16172483190858664, -0.01789203936231364, 0.0628797786483772), spin: Vector::new(0.0, 0.0, 0.0) }, Grain { radius: 0.0024857489632540667, position: Vector::new(0.0025646441067513114, 0.004578359108975935, 0.004529931732599761), velocity: Vector::new(-0.033445891470107764, -0.03903441692730898, -0.05907548914747735), spin: Vector::new(0.0, 0.0, 0.0) }, Grain { radius: 0.0026424427558620935, position: Vector::new(-0.008813216793459522, 0.0, 0.0), velocity: Vector::new(0.26298580711953334, 0.04471936718530969, 0.11100985006526998), spin: Vector::new(-63.72464409064931, 41.699295989288885, 62.606391871432805) }, Grain { radius: 0.006441712671835007, position: Vector::new(0.00767916592648438, -0.0012214517265420703, 0.009026880604550445), velocity: Vector::new(-0.21624475883130162, -0.010110160965313605, -0.06849821096429008), spin: Vector::new(-16.21067771374877, -25.47754955409218, 18.01352764210747) }, Grain { radius: 0.002481188938094658, position: Vector::new(0.0, -0.006927894560216463, 0.0), velocity: Vector::new(-0.12190487084104955, 0.09040725303825899, 0.1349973464484324), spin: Vector::new(0.0, 10.69041280615317, 26.41821271291152) }], container: Container::None, gravity: Vector::new(-9.81, 0.0, 0.0), youngs_modulus: None, friction: 2.0, restitution: 0.0, step: 0.0003909640585904859 };
    let scene = WithEffects { drawn, kinetic: None, rolling: 0.3951211361008578, twisting: 0.0, cohesion: Some((5.486367303876896, 9.901872200763919e-5)), spring: false };
    let own = WithEffects { drawn: Drawn { friction: 0.5, ..scene.drawn.clone() }, ..scene.clone() };
    let mut run = own.start(Solves::Usual);
    for step in 0..80 {
        let state = run.snapshot();
        run.step();
        if step != 72 { continue; }
        let here = own.drawn.starting_at(&state).unwrap();
        let image = Seen::Mirrored.of(&here);
        for drawn in [here, image] {
            let mut simulation = WithEffects { drawn, ..own.clone() }.start(Solves::Converged);
            let before = simulation.snapshot();
            let report = simulation.step();
            println!("{:?}", report.solve);
            let after = simulation.snapshot();
            for c in &after.contacts {
                let makadam::snapshot::Partner::Grain(s) = c.second else { continue };
                let (a, b) = (&before.particles[c.first as usize], &before.particles[s as usize]);
                let n = Vector::from(c.normal);
                let gap = (Vector::from(a.position) - Vector::from(b.position)).norm() - a.radius - b.radius;
                let un = (Vector::from(b.velocity) - Vector::from(a.velocity)).dot(&n);
                let (x, y) = (&after.particles[c.first as usize], &after.particles[s as usize]);
                let un1 = (Vector::from(y.velocity) - Vector::from(x.velocity)).dot(&n);
                let ft = Vector::from(c.tangential_force).norm();
                println!("{}-{} gap {:e} un {:e} after {:e} fn {:e} ft/fn {:.9} torque?", c.first, s, gap, un, un1, c.normal_force, ft / c.normal_force);
            }
            for p in &after.particles { println!("  v {:?} w {:?}", p.velocity, p.spin); }
        }
    }
}
