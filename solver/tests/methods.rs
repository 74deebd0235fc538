//! Every method finds the solution that a direct reference finds, with the same bits everywhere.

use crate::common::Setup;
use makadam::lanes::InstructionSet;
use makadam::scene::{Scene, SolverMethod, Stop};
use makadam::schedule::Scheduler;
use makadam::solve::StopReason;
use makadam::{Simulation, SolutionError};
use std::path::Path;

fn steps(simulation: &mut Simulation, count: usize) {
    for _ in 0..count {
        simulation.step();
    }
}

/// Grains that fall into a box, on their way to a small pile.
fn pile(seed: u64, law: &str, friction: f64) -> Simulation {
    let corners = "min = [-0.015, -0.015, 0.0], max = [0.015, 0.015, 0.2]";
    Setup {
        friction,
        wall_friction: friction,
        restitution: 0.3,
        solver: format!("step = 5e-4\nnormal_law = {law}\nstop = {{ kind = 'sweeps', sweeps = 30 }}"),
        body: format!(
            "[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = {{ kind = 'box', {corners}, open = ['+z'] }}\n\
             [[population]]\ncount = {}\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.4 }}\n\
             region = {{ kind = 'box', {corners} }}\nagitation = 0.5\n",
            2 + seed % 11
        ),
        ..Setup::default()
    }
    .start_from(seed)
}

/// Largest difference of any velocity or surface speed from the direct solution, over the largest velocity, or over what
/// gravity gives in a step where all is at rest.
fn difference(simulation: &Simulation, direct: &makadam::direct::DirectSolution) -> f64 {
    let (mut worst, mut largest) = (0.0_f64, 9.81 * simulation.time_step());
    for (id, particle) in simulation.snapshot().particles.iter().enumerate() {
        for axis in 0..3 {
            let (velocity, speed) = (direct.velocities[id][axis], direct.scaled_spins[id][axis]);
            let speed_found = particle.spin[axis] * particle.radius;
            worst = worst.max((particle.velocity[axis] - velocity).abs()).max((speed_found - speed).abs());
            largest = largest.max(velocity.abs()).max(speed.abs());
        }
    }
    worst / largest
}

/// Takes a step with a method run to a tight tolerance.
fn converged(start: &Simulation, method: SolverMethod) -> (Simulation, StopReason, SolutionError) {
    let mut simulation = start.clone();
    simulation.use_method(method).unwrap();
    simulation.use_stop(Stop::Residual { tolerance: 1e-11, max_sweeps: 400_000 });
    let report = simulation.step();
    let error = simulation.solution_error();
    (simulation, report.solve.reason, error)
}

/// Friction leaves impulses of grains with many contacts undetermined, so velocities are compared. Rigid contacts have an operator
/// without full rank: with friction their solutions are not isolated and neither sweeps nor Newton steps converge at a rate, so
/// they are taken without.
#[test]
fn methods_agree_with_the_direct_reference() {
    let (hertz, linear, rigid) = ("{ kind = 'hertz' }", "{ kind = 'linear', stiffness = 1e5 }", "{ kind = 'rigid' }");
    let (mut problems, mut arrived) = ([0; 2], [[0; 2]; SolverMethod::ALL.len()]);
    for seed in 1..=22 {
        let friction = [0.1, 0.3, 0.5, 0.8][seed as usize % 4];
        for (law, friction) in [(hertz, friction), (linear, friction), (rigid, 0.0), (hertz, 0.0)] {
            let mut simulation = pile(seed, law, friction);
            for _ in 0..3 {
                steps(&mut simulation, 300);
                let name = format!("seed {seed}, {law}, friction {friction}, step {}", simulation.steps_taken());
                let direct = simulation.direct_solution().unwrap_or_else(|error| panic!("{name}: {error}"));
                let rubs = usize::from(friction > 0.0);
                problems[rubs] += 1;
                for (index, method) in SolverMethod::ALL.into_iter().enumerate() {
                    // Directions are not conjugate while contacts start and stop to slide: it stalls on a third of these.
                    if rubs == 1 && method == SolverMethod::ProjectedConjugateGradients {
                        continue;
                    }
                    let (found, reason, error) = converged(&simulation, method);
                    if reason == StopReason::MaxSweeps {
                        continue;
                    }
                    arrived[index][rubs] += 1;
                    let difference = difference(&found, &direct);
                    assert!(difference <= 1e-8, "{name}, {}: {difference:e}, {error:?}", method.name());
                    assert!(error.cone.max <= 1e-15, "{name}, {}: {error:?}", method.name());
                }
            }
        }
    }
    assert!(problems.iter().all(|&count| count > 100), "{problems:?}");
    for (method, [smooth, rough]) in SolverMethod::ALL.into_iter().zip(arrived) {
        let name = method.name();
        assert_eq!(smooth, problems[0], "{name} converges without friction");
        match method {
            SolverMethod::ProjectedConjugateGradients => {}
            // With friction it minimises no function, and here and there it stalls.
            SolverMethod::AcceleratedProjectedGradients => assert!(rough * 20 > problems[1] * 19, "{name}: {rough}"),
            _ => assert_eq!(rough, problems[1], "{name} converges with friction"),
        }
    }
}

/// A drum whose grains have come to lie on each other.
fn drum() -> Simulation {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/drum/scene.toml");
    let mut simulation = Simulation::new(&Scene::load(&file).unwrap(), 1).unwrap();
    steps(&mut simulation, 1000);
    assert!(simulation.layout().contacts > 2000, "{}", simulation.layout().contacts);
    simulation
}

#[test]
fn every_method_has_the_same_bits_everywhere() {
    let start = drum();
    let mut hashes = Vec::new();
    for method in SolverMethod::ALL {
        let hash = |set: InstructionSet, scheduler: Scheduler, threads: usize| {
            let mut simulation = start.clone();
            simulation.use_method(method).unwrap();
            simulation.use_instruction_set(set).unwrap();
            simulation.use_team(scheduler, threads).unwrap();
            steps(&mut simulation, 50);
            simulation.state_hash()
        };
        let expected = hash(InstructionSet::Generic, Scheduler::Serial, 1);
        // Tasks are the same on any instruction set, so not every set needs every team.
        let teams = [(Scheduler::CentralQueue, 3), (Scheduler::WorkStealing, 2)];
        let sets = InstructionSet::ALL.into_iter().filter(|set| set.is_available());
        let widest = InstructionSet::detect();
        for (set, (scheduler, threads)) in sets.zip(teams.into_iter().cycle()).chain([(widest, teams[1])]) {
            let name = method.name();
            assert_eq!(hash(set, scheduler, threads), expected, "{name}: {set:?}, {scheduler:?}, {threads} threads");
        }
        assert!(!hashes.contains(&expected), "{} does what another method does", method.name());
        hashes.push(expected);
    }
}

#[test]
fn convergence_is_that_of_the_step_and_leaves_no_trace() {
    let mut simulation = drum();
    for method in SolverMethod::ALL {
        let hash = simulation.state_hash();
        let points = simulation.convergence(method, 10).unwrap();
        assert_eq!(simulation.state_hash(), hash, "a copy took the step");
        assert!(
            points.windows(2).all(|two| two[1].seconds > two[0].seconds && two[1].iterations == two[0].iterations + 1)
        );
        simulation.use_method(method).unwrap();
        simulation.use_stop(Stop::Sweeps { sweeps: 10 });
        simulation.step();
        let error = simulation.solution_error();
        assert_eq!(error.residuals, points[10].residuals, "{}", method.name());
        assert_eq!(error.complementarity(), error.residuals.normal);
        assert!(error.unit == 9.81 * 5e-4 && error.largest_overlap > 0.0 && error.largest_overlap < 0.1, "{error:?}");
        assert!(error.cone.max < 1e-12 && error.relative() > 0.0, "{error:?}");
    }
}

#[test]
fn many_contacts_are_no_case_for_dense_matrices() {
    let message = drum().direct_solution().unwrap_err().to_string();
    assert!(message.contains("at most 500"), "{message}");
}

/// The drum with grains that resist rolling, after they have come to lie on each other.
fn rolling_drum() -> Simulation {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/drum-rolling/scene.toml");
    let mut simulation = Simulation::new(&Scene::load(&file).unwrap(), 1).unwrap();
    steps(&mut simulation, 1000);
    simulation
}

#[test]
fn torques_are_measured_and_converge_with_the_rest() {
    let mut simulation = rolling_drum();
    let points = simulation.convergence(SolverMethod::GaussSeidel, 400).unwrap();
    let turning = |place: usize| points[place].residuals.turning;
    assert!(turning(0).rms > 0.0 && turning(0).max >= turning(0).rms, "{:?}", turning(0));
    assert!(turning(400).rms < 0.05 * turning(1).rms, "{:e} to {:e}", turning(1).rms, turning(400).rms);
    assert!(points[400].residuals.rms() >= turning(400).rms, "it is a part of the whole");
    // One thread or three, lanes of any width: the same bits.
    let few = simulation.convergence(SolverMethod::GaussSeidel, 3).unwrap();
    for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
        simulation.use_instruction_set(set).unwrap();
        simulation.use_team(Scheduler::WorkStealing, 3).unwrap();
        let other = simulation.convergence(SolverMethod::GaussSeidel, 3).unwrap();
        let residuals = |points: &[makadam::ConvergencePoint]| points.iter().map(|p| p.residuals).collect::<Vec<_>>();
        assert_eq!(residuals(&other), residuals(&few), "{set:?}");
    }
    // A step's own error has them too.
    simulation.step();
    assert!(simulation.solution_error().residuals.turning.rms > 0.0);
    assert_eq!(drum().convergence(SolverMethod::GaussSeidel, 1).unwrap()[1].residuals.turning.rms, 0.0);
}

#[test]
fn methods_that_leave_torques_out_are_refused_where_there_are_any() {
    let simulation = rolling_drum();
    for method in SolverMethod::ALL.into_iter().filter(|&method| method != SolverMethod::GaussSeidel) {
        let error = simulation.convergence(method, 1).unwrap_err();
        assert!(error.to_string().contains("torques") && error.to_string().contains(method.name()), "{error}");
    }
}

/// Exactness on a linear problem. Where contacts neither open nor slide, changes of sweeps span few directions: combined by the weights that leave the
/// least change, as many sweeps as directions are exact.
#[test]
fn anderson_is_exact_where_changes_span_few_directions() {
    let body = [1.0, 2.99, 4.98].map(|height| crate::common::grain(0.005, [0.0, 0.0, 0.005 * height], [0.0; 3]));
    let solver = "step = 5e-4\nnormal_law = { kind = 'linear', stiffness = 1e4 }\nover_relaxation = 1.0".into();
    let setup = Setup {
        friction: 0.0,
        wall_friction: 0.0,
        solver,
        body: format!("{}{}", crate::common::FLOOR, body.concat()),
        ..Setup::default()
    };
    let simulation = setup.start();
    let residual = |method: SolverMethod, iterations: usize| {
        simulation.convergence(method, iterations as u32).unwrap()[iterations].residuals.rms()
    };
    let method = SolverMethod::Anderson { memory: 5 };
    let scale = residual(SolverMethod::GaussSeidel, 1);
    let (plain, combined) = (residual(SolverMethod::GaussSeidel, 6) / scale, residual(method, 6) / scale);
    println!("{plain:e} {combined:e}");
    assert!(combined < 1e-6 && combined < 1e-3 * plain, "{combined:e}, {plain:e} by sweeps alone");
    // Nothing changes any more.
    assert!(residual(method, 100) < 1e-9 * scale);
}
