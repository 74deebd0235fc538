//! The contact problem as plain data: the reference solves what the lanes sweep, sweep by sweep and at the solution.

use crate::common::{CONVERGED_RIGID, FLOOR, Setup, grain};
use makadam::Simulation;
use makadam::effects::cohesion::Cohesion;
use makadam::problem::{ContactProblem, ContactState, Reference};
use makadam::scene::{Material, Scene, Stop, TangentialLaw};
use makadam::solve::StopReason;
use nalgebra::Vector3;

/// Mindlin's spring.
const SPRING: TangentialLaw = TangentialLaw::Spring { stiffness_ratio: None };

/// Grains that fall into a box.
fn poured(wall: &str, change: impl Fn(&mut Material)) -> Simulation {
    poured_by(TangentialLaw::Rigid, wall, change)
}

/// Returns the same with a law across the normals.
fn poured_by(law: TangentialLaw, wall: &str, change: impl Fn(&mut Material)) -> Simulation {
    let corners = "min = [-0.025, -0.025, 0.0], max = [0.025, 0.025, 0.2]";
    let body = format!(
        "[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = {{ kind = 'box', {corners}, open = ['+z'] }}\n{wall}\
         [[population]]\ncount = 60\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.3 }}\n\
         region = {{ kind = 'box', {corners} }}\nagitation = 0.3\n"
    );
    let solver = "step = 5e-4\nnormal_law = { kind = 'hertz' }\nover_relaxation = 1.3\n\
                  stop = { kind = 'sweeps', sweeps = 20 }";
    let mut scene: Scene = Setup { body, solver: solver.into(), restitution: 0.3, ..Setup::default() }.scene();
    scene.material.values_mut().for_each(change);
    scene.solver.tangential_law = law;
    let mut simulation = Simulation::new(&scene, 3).unwrap();
    for _ in 0..760 {
        simulation.step();
    }
    assert!(simulation.layout().contacts > 100, "{}", simulation.layout().contacts);
    simulation
}

/// A lid that presses, and a table below that turns.
fn lid() -> &'static str {
    "[[wall]]\nname = 'lid'\nmaterial = 'wall'\nshape = { kind = 'plane', point = [0, 0, 0.21], normal = [0, 0, -1] }\n\
     motion = { kind = 'force-driven', axis = [0, 0, -1], force = 1.0, mass = 0.05 }\n\
     [[wall]]\nname = 'table'\nmaterial = 'wall'\nshape = { kind = 'plane', point = [0, 0, 0.001], normal = [0, 0, 1] }\n\
     motion = { kind = 'torque-driven', point = [0, 0, 0], axis = [0, 0, 1], torque = 1e-4, moment_of_inertia = 2e-5 }\n"
}

/// One simulation for each thing that a contact problem can hold.
fn simulations() -> Vec<(&'static str, Simulation)> {
    let resists = |material: &mut Material| (material.rolling_friction, material.twisting_friction) = (0.1, 0.05);
    let sticks = |material: &mut Material| material.cohesion = Some(Cohesion::Constant { force: 2e-3, range: 1e-4 });
    vec![
        ("friction", poured("", |_| ())),
        ("smooth", poured("", |material| material.friction = 0.0)),
        ("torques", poured("", resists)),
        ("cohesion", poured("", sticks)),
        ("driven walls", poured(lid(), |_| ())),
        ("driven walls with torques", poured(lid(), resists)),
        ("springs", poured_by(SPRING, "", |_| ())),
        ("springs with driven walls and torques", poured_by(SPRING, lid(), resists)),
    ]
}

/// Largest difference of a velocity or a surface speed of a grain, or of a rate of a driven wall, m/s.
fn difference(simulation: &Simulation, problem: &ContactProblem, state: &ContactState) -> f64 {
    let (frame, mut worst) = (simulation.snapshot(), 0.0_f64);
    for (id, particle) in frame.particles.iter().enumerate() {
        let spin = Vector3::from(particle.spin) - state.spins[id];
        worst = worst.max((Vector3::from(particle.velocity) - state.velocities[id]).amax());
        worst = worst.max(spin.amax() * particle.radius);
    }
    for (number, wall) in frame.driven_walls.iter().enumerate() {
        let body = problem.grains + number;
        let rate = (state.velocities[body] + state.spins[body]).norm();
        worst = worst.max((rate - wall.rate.abs()).abs());
    }
    worst
}

/// Sweeps with the scene's over-relaxation.
fn sweeps(most_sweeps: u32) -> Reference {
    Reference { relaxation: 1.3, tolerance: 0.0, most_sweeps }
}

#[test]
fn the_reference_sweeps_as_the_lanes_do() {
    for (name, start) in simulations() {
        let problem = start.contact_problem();
        problem.check().unwrap_or_else(|words| panic!("{name}: {words}"));
        assert!(problem.contacts.len() > 50, "{name}: {}", problem.contacts.len());
        for count in [1, 2, 7] {
            let mut simulation = start.clone();
            simulation.use_stop(Stop::Sweeps { sweeps: count });
            simulation.step();
            let mut state = problem.start();
            problem.solve(&mut state, &sweeps(count));
            // Rounding alone: the same operations in another order.
            let difference = difference(&simulation, &problem, &state);
            assert!(difference < 1e-12, "{name}, {count} sweeps: {difference:e} m/s");
        }
    }
}

#[test]
fn reference_lanes_and_direct_solution_agree() {
    for (name, start) in simulations() {
        // A table that turns, on which grains resist rolling: 100,000 sweeps leave 1e-8 m/s.
        if name.contains("driven walls") && name.contains("torques") {
            continue;
        }
        let problem = start.contact_problem();
        let mut simulation = start.clone();
        let stop = Stop::Residual { tolerance: 1e-11, max_sweeps: 1_000_000 };
        simulation.use_stop(stop);
        simulation.step();
        let (lanes, report) = start.solution_in_lanes(stop);
        assert_eq!(report.reason, StopReason::Residual, "{name}: {report:?}");
        let found = difference(&simulation, &problem, &lanes);
        assert!(found < 1e-15, "{name}, a copy: {found:e} m/s");
        assert!(problem.residuals(&lanes).max() < 1e-12, "{name}: {:?}", problem.residuals(&lanes));
        let mut state = problem.start();
        let ending =
            problem.solve(&mut state, &Reference { relaxation: 1.3, tolerance: 1e-14, most_sweeps: 1_000_000 });
        let residuals = problem.residuals(&state);
        assert!(residuals.max() < 1e-12 && residuals.cone.max < 1e-15, "{name}: {ending:?}, {residuals:?}");
        // Residuals of 1e-11 g h are 5e-14 m/s; the operator's condition, some 1e4, stands between them and velocities.
        let found = difference(&simulation, &problem, &state);
        assert!(found < 1e-9, "{name}, lanes: {found:e} m/s");
        if problem.resists_turning() {
            let refused = start.direct_solution().unwrap_err().to_string();
            assert!(refused.contains("rolling"), "{refused}");
            continue;
        }
        let (local, direct) = (problem.local(), problem.local().direct_solution().unwrap());
        let impulses = problem.impulses_of(&local, &direct.impulses);
        let solution = problem.state_of(&impulses);
        let found = difference(&simulation, &problem, &solution);
        assert!(found < 1e-9, "{name}, direct: {found:e} m/s");
        assert!(problem.residuals(&solution).max() < 1e-12, "{name}: {:?}", problem.residuals(&solution));
    }
}

#[test]
fn the_reduced_problem_has_the_velocities_of_the_bodies() {
    for (name, start) in simulations() {
        let problem = start.contact_problem();
        let local = problem.local();
        let state = problem.state_of(&problem.impulses_of(&local, &local.impulses));
        for (&number, reduced) in local.contacts.iter().zip(local.velocities(&local.impulses)) {
            let contact = &problem.contacts[number];
            let mut expected = contact.frame().transpose() * problem.relative_velocity(contact, &state);
            expected.x += contact.compliance * contact.impulse.normal - contact.bias;
            let difference = (expected - reduced).amax();
            assert!(difference < 1e-12, "{name}, contact {number}: {difference:e} m/s");
        }
    }
}

#[test]
fn posing_a_problem_leaves_no_trace() {
    for (name, start) in simulations() {
        let (mut asked, mut other) = (start.clone(), start);
        for _ in 0..5 {
            asked.contact_problem();
            asked.step();
            other.step();
        }
        assert_eq!(asked.state_hash(), other.state_hash(), "{name}");
    }
}

#[test]
fn a_grain_at_rest_has_the_closed_form() {
    let body = FLOOR.to_string() + &grain(0.005, [0.0, 0.0, 0.005], [0.0; 3]);
    let simulation = Setup { body, solver: CONVERGED_RIGID.into(), ..Setup::default() }.start();
    let problem = simulation.contact_problem();
    assert_eq!((problem.grains, problem.bodies.len(), problem.contacts.len()), (1, 1, 1));
    let (grain, contact) = (&problem.bodies[0], &problem.contacts[0]);
    assert_eq!((contact.first, contact.second), (0, None));
    assert!((contact.normal + Vector3::z()).norm() < 1e-15 && (contact.arms[0] + Vector3::z() * 0.005).norm() < 1e-15);
    assert!((grain.velocity.z + 9.81e-4).abs() < 1e-15, "{}", grain.velocity.z);
    let mut state = problem.start();
    problem.solve(&mut state, &Reference { relaxation: 1.0, tolerance: 0.0, most_sweeps: 3 });
    // One normal update is the solution: lambda_n (S_n + Sigma') = q - n.u.
    let operator = grain.inverse_mass[(0, 0)] + contact.compliance;
    // The floor rests, so u is less the grain's velocity.
    let impulse = (contact.bias + contact.normal.dot(&grain.velocity)) / operator;
    let found = state.impulses[0].normal;
    assert!((found - impulse).abs() <= 1e-14 * impulse && impulse > 0.0, "{found:e}, {impulse:e}");
    assert_eq!(problem.residuals(&state).cone.max, 0.0);
}

#[test]
fn what_is_wrong_with_a_problem_is_told() {
    let sound = poured("", |_| ()).contact_problem();
    type Damage = fn(&mut ContactProblem);
    let damages: [(&str, Damage); 7] = [
        ("names body", |problem| problem.contacts[0].first = 1_000),
        ("of a body with itself", |problem| problem.contacts[0].second = Some(problem.contacts[0].first)),
        ("not finite", |problem| problem.contacts[0].bias = f64::NAN),
        ("not finite", |problem| problem.bodies[0].velocity.x = f64::INFINITY),
        ("not orthonormal", |problem| problem.contacts[0].normal *= 1.1),
        ("below zero", |problem| problem.contacts[0].friction = -0.5),
        ("not symmetric", |problem| problem.bodies[0].inverse_mass[(0, 1)] = 1e3),
    ];
    for (words, damage) in damages {
        let mut problem = sound.clone();
        damage(&mut problem);
        let told = problem.check().unwrap_err();
        assert!(told.contains(words), "no '{words}' in: {told}");
    }
}
