//! Fronts, orders of convergence and plans, against what can be worked out by hand.

use approx::assert_relative_eq;
use makadam::scene::{Scene, SolverSettings, Stop};
use makadam_validation::tradeoff::{Convergence, Knobs, Plan, pareto_front};
use std::path::Path;

/// Values of three seeds about a middle: the same for all grids, so that their differences have no noise.
fn seeds(middle: f64) -> [f64; 3] {
    [middle - 0.3, middle, middle + 0.3]
}

#[test]
fn the_limit_of_a_first_order_method_is_found() {
    // f(h) = 2 + 3 h at h = 0.4, 0.2 and 0.1.
    let found = Convergence::of([&seeds(3.2), &seeds(2.6), &seeds(2.3)]).unwrap();
    assert_relative_eq!(found.observed_order.unwrap(), 1.0, epsilon = 1e-12);
    assert_relative_eq!(found.richardson.unwrap(), 2.0, epsilon = 1e-12);
    assert_eq!(found.safety_factor, 1.25);
    assert_relative_eq!(found.grid_convergence_index, 1.25 * 0.3, epsilon = 1e-12);
}

#[test]
fn the_limit_of_a_second_order_method_is_found() {
    // f(h) = 5 - h^2 at h = 4, 2 and 1.
    let found = Convergence::of([&seeds(-11.0), &seeds(1.0), &seeds(4.0)]).unwrap();
    assert_relative_eq!(found.observed_order.unwrap(), 2.0, epsilon = 1e-12);
    assert_relative_eq!(found.richardson.unwrap(), 5.0, epsilon = 1e-12);
    assert_relative_eq!(found.grid_convergence_index, 1.25 * 1.0, epsilon = 1e-12);
}

#[test]
fn an_order_that_is_off_gives_no_estimate_and_a_wide_band() {
    // Differences of 8 and 1: order three. Differences of opposite signs: no order at all.
    for (grids, order) in [([10.0, 2.0, 1.0], Some(3.0)), ([1.5, 2.0, 1.0], None)] {
        let found = Convergence::of(grids.map(seeds).each_ref().map(|grid| &grid[..])).unwrap();
        assert_eq!(found.observed_order.map(|order| order.round()), order);
        assert_eq!((found.richardson, found.safety_factor), (None, 3.0));
        assert_relative_eq!(found.grid_convergence_index, 3.0 * 1.0, epsilon = 1e-12);
    }
}

#[test]
fn differences_that_drown_in_the_spread_over_seeds_have_no_order() {
    let found = Convergence::of([&[3.2, 3.2, 3.2], &[2.0, 2.6, 3.2], &[3.3, 2.3, 1.3]]).unwrap();
    assert_eq!((found.observed_order, found.safety_factor), (None, 3.0));
    assert!(Convergence::of([&[1.0], &[1.0, 2.0], &[1.0, 2.0]]).is_none(), "seeds are compared one by one");
    assert!(Convergence::of([&[], &[], &[]]).is_none());
}

#[test]
fn a_front_holds_what_nothing_beats() {
    let points = [[1.0, 0.5], [2.0, 0.6], [3.0, 0.2], [4.0, 0.3], [5.0, 0.1], [0.5, 0.9], [6.0, f64::NAN]];
    assert_eq!(pareto_front(&points, 0.0), [5, 0, 2, 4]);
    // Errors below the floor are equal: the cheapest of them ends the front.
    assert_eq!(pareto_front(&points, 0.25), [5, 0, 2]);
    assert_eq!(pareto_front(&points, 1.0), [5]);
    assert!(pareto_front(&[], 0.0).is_empty());
}

#[test]
fn a_plan_holds_each_configuration_once_and_three_grids_a_stiffness() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let scene = Scene::load(&file).unwrap();
    for quick in [true, false] {
        let plan = Plan::new(&scene, quick, &["Makadam", "YADE"], &[0.5, 10.0]);
        for (place, configuration) in plan.configurations.iter().enumerate() {
            assert!(!plan.configurations[..place].contains(configuration), "{} twice", configuration.setting());
        }
        let factors: Vec<f64> = plan.refinements.iter().map(|refinement| refinement.stiffness_factor).collect();
        assert_eq!(factors, [0.5, 1.0, 10.0]);
        for refinement in &plan.refinements {
            let grids = refinement.grids.map(|place| &plan.configurations[place]);
            let [coarse, middle, fine] = grids.map(|grid| grid.step().unwrap());
            assert_eq!((coarse, middle), (2.0 * middle, 2.0 * fine));
            assert!(grids.iter().all(|grid| grid.sweeps() == grids[2].sweeps()));
            // Nothing of Makadam's is finer or takes more sweeps than the reference.
            let own = plan.configurations.iter().filter(|c| c.stiffness_factor == refinement.stiffness_factor);
            for configuration in own.filter(|configuration| configuration.code == "Makadam") {
                assert!(configuration.step() >= grids[2].step() && configuration.sweeps() <= grids[2].sweeps());
            }
        }
        let fractions: Vec<f64> = plan.configurations.iter().filter_map(|c| c.rayleigh_fraction()).collect();
        assert!(fractions.iter().all(|fraction| (0.01..=0.8).contains(fraction)));
    }
}

#[test]
fn one_setting_is_varied_at_a_time() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let scene = Scene::load(&file).unwrap();
    let plan = Plan::new(&scene, false, &["Makadam"], &[]);
    let mut varied = 0;
    for configuration in &plan.configurations {
        let Knobs::Solver { settings, variation } = &configuration.knobs else { panic!("only Makadam was asked for") };
        let Some(variation) = variation else {
            assert!(matches!(settings.stop, Stop::Sweeps { .. }));
            continue;
        };
        varied += 1;
        assert_ne!(*settings, scene.solver);
        assert_eq!(settings.step, scene.solver.step);
        if variation.starts_with("residual") {
            assert!(matches!(settings.stop, Stop::Residual { .. }));
            assert_eq!(SolverSettings { stop: scene.solver.stop, ..settings.clone() }, scene.solver);
        } else {
            assert_eq!(settings.stop, scene.solver.stop);
        }
    }
    assert!(varied >= 10, "warm start, over-relaxation, inner sweeps, residuals, precision, methods: {varied}");
}
