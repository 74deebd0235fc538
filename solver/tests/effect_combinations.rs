//! Whatever effects a scene combines, all that can be asked of a simulation answers: what lays contacts out and what works on them
//! must agree on what a contact holds.

use crate::common::Setup;
use makadam::Simulation;
use makadam::scene::{Scene, SolverMethod};

/// A pile on a floor with some of the effects; friction in all pairs, resistances and cohesion between the grains and at the floor.
fn pile([friction, rolling, twisting, kinetic, cohesive, springy]: [bool; 6]) -> Scene {
    let value = |on: bool, line: &str| if on { format!("{line}\n") } else { String::new() };
    let lines = [
        value(rolling, "rolling_friction = 0.1"),
        value(twisting, "twisting_friction = 0.1"),
        value(kinetic, "kinetic_friction = 0.0"),
        value(cohesive, "cohesion = { kind = 'surface-energy', work = 0.05 }"),
    ];
    let corners = "min = [-0.015, -0.015, 0.0], max = [0.015, 0.015, 0.2]";
    let scene = Setup {
        friction: if friction { 0.5 } else { 0.0 },
        wall_friction: if friction { 0.5 } else { 0.0 },
        solver: format!(
            "step = 5e-4\nnormal_law = {{ kind = 'hertz' }}\nstop = {{ kind = 'sweeps', sweeps = 8 }}\n{}",
            value(springy, "tangential_law = { kind = 'spring' }")
        ),
        body: format!(
            "[[wall]]\nname = 'box'\nmaterial = 'grain'\nshape = {{ kind = 'box', {corners}, open = ['+z'] }}\n\
             [[population]]\ncount = 20\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.2 }}\n\
             region = {{ kind = 'box', {corners} }}\nagitation = 0.5\n"
        ),
        ..Setup::default()
    };
    scene.scene_with(&lines.concat())
}

/// Takes steps, traced ones among them.
fn advance(simulation: &mut Simulation, steps: usize) -> usize {
    let mut contacts = 0;
    for number in 0..steps {
        contacts = if number % 50 == 7 { simulation.trace_step().0.contacts } else { simulation.step().contacts };
    }
    contacts
}

#[test]
fn every_combination_of_effects_answers_to_all_that_is_asked() {
    for choice in 0_u32..64 {
        let effects = [0, 1, 2, 3, 4, 5].map(|effect| choice >> effect & 1 == 1);
        let [friction, rolling, twisting, kinetic, cohesive, springy] = effects;
        let scene = pile(effects);
        let mut simulation = Simulation::new(&scene, 1).unwrap_or_else(|error| panic!("{effects:?}: {error}"));
        let set = simulation.effects();
        let found =
            [set.friction(), set.rolling(), set.twisting(), set.kinetic_friction(), set.cohesion(), set.spring()];
        let asked = [friction, rolling, twisting, friction && kinetic, cohesive, friction && springy];
        assert_eq!(found, asked, "what was asked for");
        assert!(advance(&mut simulation, 300) > 20, "{effects:?}: a pile has contacts");
        let error = simulation.solution_error();
        assert!(error.relative().is_finite() && error.relative() > 0.0, "{effects:?}: {error:?}");
        assert!(error.cone.max < 1e-12, "{effects:?}: {error:?}");
        let points = simulation.convergence(SolverMethod::GaussSeidel, 40).unwrap();
        let rms = |place: usize| points[place].residuals.rms();
        assert!(rms(40) < 0.5 * rms(0), "{effects:?}: {} after {}", rms(40), rms(0));
        assert_eq!(simulation.snapshot().particles.len(), 20);
        let mut resumed = Simulation::resume(&scene, &simulation.checkpoint()).unwrap();
        advance(&mut simulation, 60);
        advance(&mut resumed, 60);
        assert_eq!(resumed.state_hash(), simulation.state_hash(), "{effects:?}");
    }
}
