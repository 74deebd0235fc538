//! Fronts, orders of convergence and plans, against what can be worked out by hand.

use approx::assert_relative_eq;
use makadam::scene::{Precision, SolverMethod, SolverSettings, Stop};
use makadam_compare::compare::MeasuredRun;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::Measurement;
use makadam_studies::tradeoff::{Bound, Configuration, Convergence, Knobs, Outcome, Plan, Study, Terms, pareto_front};
use std::collections::{BTreeMap, BTreeSet};
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
    let scene = MeasuredScene::load(&file).unwrap();
    let plan = Plan::new(&scene, &["Makadam", "YADE"], &[0.5, 10.0]);
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
        // Nothing of Makadam's is finer than the reference or does more sweeps in a second.
        let a_second = |configuration: &Configuration| Some(f64::from(configuration.sweeps()?) / configuration.step()?);
        let own = plan.configurations.iter().filter(|c| c.stiffness_factor == refinement.stiffness_factor);
        for configuration in own.filter(|configuration| configuration.code == "Makadam") {
            assert!(configuration.step() >= grids[2].step() && a_second(configuration) <= a_second(grids[2]));
        }
    }
    let fractions: Vec<f64> = plan.configurations.iter().filter_map(|c| c.rayleigh_fraction()).collect();
    assert!(fractions.iter().all(|fraction| (0.2..=0.5).contains(fraction)));
}

fn smoke() -> MeasuredScene {
    MeasuredScene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml")).unwrap()
}

/// Settings and names of what a plan varies beside step and sweeps.
fn varied(scene: &MeasuredScene) -> Vec<(SolverSettings, String)> {
    let plan = Plan::new(scene, &["Makadam"], &[]);
    let solver = |knobs: &Knobs| match knobs {
        Knobs::Solver { settings, variation } => (settings.clone(), variation.clone()),
        Knobs::Explicit { .. } => panic!("only Makadam was requested"),
    };
    let all = plan.configurations.iter().map(|configuration| solver(&configuration.knobs));
    all.filter_map(|(settings, variation)| Some((settings, variation?))).collect()
}

#[test]
fn one_setting_is_varied_at_a_time() {
    let scene = smoke();
    let settings = varied(&scene);
    for (settings, variation) in &settings {
        assert!(scene.accepts(settings), "{variation}");
        // With step and stop as they are, one setting is left that differs; a residual is a stop itself.
        let back = SolverSettings { step: scene.solver.step, stop: scene.solver.stop, ..settings.clone() };
        if variation.starts_with("residual") {
            assert!(matches!(settings.stop, Stop::Residual { .. }));
            assert_eq!(back, scene.solver);
            continue;
        }
        let own = &scene.solver;
        // Calm contacts are three settings that go together.
        if variation.starts_with("calm contacts") {
            assert!(matches!(settings.stop, Stop::Residual { .. }));
            assert!(back.damping_steps > own.damping_steps && back.restitution_threshold >= own.restitution_threshold);
            let (damping_steps, restitution_threshold) = (own.damping_steps, own.restitution_threshold);
            assert_eq!(SolverSettings { damping_steps, restitution_threshold, ..back }, *own);
            continue;
        }
        assert!(matches!(settings.stop, Stop::Sweeps { .. }));
        let differences = [back.method != own.method, back.precision != own.precision];
        assert_eq!(differences.iter().filter(|differs| **differs).count(), 1, "{variation}");
        let restored = SolverSettings { method: own.method, precision: own.precision, ..back };
        assert_eq!(restored, *own, "{variation}");
    }
}

#[test]
fn each_variation_is_run_at_several_steps() {
    let scene = smoke();
    let settings = varied(&scene);
    for name in ["Anderson", "calm contacts, residual 0.1", "residual 0.03", "residual 0.1", "single precision"] {
        let own = settings.iter().filter(|(_, variation)| variation == name);
        let steps: BTreeSet<u64> = own.map(|(settings, _)| settings.step.to_bits()).collect();
        assert!(steps.len() >= 2, "{name}");
    }
    let names: BTreeSet<&String> = settings.iter().map(|(_, name)| name).collect();
    assert_eq!(names.len(), 5);
}

#[test]
fn what_a_scene_refuses_is_not_planned() {
    let mut scene = smoke();
    for material in scene.material.values_mut() {
        material.rolling_friction = 0.1;
    }
    let settings = varied(&scene);
    assert!(!settings.is_empty());
    for (settings, name) in settings {
        assert_eq!((settings.method, settings.precision), (SolverMethod::GaussSeidel, Precision::Double), "{name}");
    }
}

/// A run that measures a packing fraction.
fn run(seed: u64) -> MeasuredRun {
    let fraction = Measurement {
        observable: "packing_fraction".into(),
        unit: String::new(),
        value: 0.59 + 0.01 * seed as f64,
        standard_error: None,
        frames: 1,
    };
    MeasuredRun {
        code: "Makadam".into(),
        version: "1.2".into(),
        contact_law: String::new(),
        seed,
        time_step: 1e-3,
        rayleigh_fraction: None,
        wall_seconds: 6.0,
        core_seconds: None,
        simulated_seconds: 1.5,
        processor: String::new(),
        date: "2026-01-02T03:04:05Z".into(),
        scene_hash: String::new(),
        measurements: vec![fraction],
    }
}

#[test]
fn a_setting_that_failed_with_a_seed_keeps_no_bound() {
    let scene = smoke();
    let plan = Plan::new(&scene, &["Makadam"], &[]);
    let reference = plan.refinements[0].grids[2];
    let other = (0..plan.configurations.len()).find(|place| !plan.is_grid(*place)).unwrap();
    let mut outcome = Outcome::none(plan.configurations.len());
    for place in [reference, other] {
        outcome.runs[place] = [1, 2].map(run).to_vec();
    }
    let study = |outcome: &Outcome| {
        let bounds = vec![Bound { observable: "packing_fraction".into(), value: 0.01 }];
        let terms = Terms { seeds: 2, bounds, time_limit: 1.0, provenance: BTreeMap::new() };
        Study::new(&scene, &plan, outcome, terms)
    };
    let setting = plan.configurations[other].setting();
    let point = |study: &Study| study.points.iter().find(|point| point.setting == setting).unwrap().clone();
    assert_eq!(point(&study(&outcome)).within_bounds, Some(true));
    assert!(study(&outcome).notes.is_empty());
    outcome.failures.insert(other, (3, "it fell over".into()));
    let failed = study(&outcome);
    assert_eq!((point(&failed).failed, point(&failed).within_bounds), (true, Some(false)));
    assert_ne!(failed.fastest[0].setting.as_ref(), Some(&setting));
    let [note] = failed.notes.as_slice() else { panic!("{:?}", failed.notes) };
    assert!(note.contains(&setting) && note.contains("failed with seed 3") && note.ends_with("it fell over"), "{note}");
}

/// Time per simulated second and errors of a setting, one per seed, against a bound of 1.
type Setting<'a> = (&'a str, f64, &'a [f64]);

/// 90% interval of the ratio of YADE's fastest setting to Makadam's, whose reference keeps the bound in 100 s.
fn ratio_interval(settings: &[Setting<'_>]) -> [Option<f64>; 2] {
    let scene = smoke();
    let plan = Plan::new(&scene, &["Makadam", "YADE"], &[]);
    let mut outcome = Outcome::none(plan.configurations.len());
    let mut add = |place: usize, pace: f64, errors: &[f64]| {
        for (seed, error) in (1..).zip(errors) {
            let mut run = run(seed);
            run.core_seconds = Some(pace * run.simulated_seconds);
            run.measurements[0].value = *error;
            outcome.runs[place].push(run);
        }
    };
    let seeds = settings[0].2.len();
    add(plan.refinements[0].grids[2], 100.0, &vec![0.0; seeds]);
    let mut used = BTreeSet::new();
    for &(code, pace, errors) in settings {
        let free =
            |place: &usize| plan.configurations[*place].code == code && !plan.is_grid(*place) && !used.contains(place);
        let place = (0..plan.configurations.len()).find(free).unwrap();
        used.insert(place);
        add(place, pace, errors);
    }
    let bounds = vec![Bound { observable: "packing_fraction".into(), value: 1.0 }];
    let terms = Terms { seeds: seeds as u64, bounds, time_limit: 1.0, provenance: BTreeMap::new() };
    let study = Study::new(&scene, &plan, &outcome, terms);
    let [own, other] = ["Makadam", "YADE"].map(|code| study.fastest.iter().find(|row| row.code == code).unwrap());
    assert_eq!([own.ratio_low, own.ratio_high], [None, None], "Makadam's own ratio is one");
    [other.ratio_low, other.ratio_high]
}

#[test]
fn ratio_interval_of_errors_without_spread() {
    let sure = [("Makadam", 0.125, &[0.5; 4][..]), ("YADE", 2.5, &[-0.9; 4]), ("YADE", 1.25, &[1.1; 4])];
    assert_eq!(ratio_interval(&sure), [Some(20.0), Some(20.0)]);
}

#[test]
fn ratio_interval_widens_by_luck() {
    // The fast setting's mean is 0.9: of samples of four seeds a fair fraction has a mean above 1.
    let lucky = [0.0, 0.6, 1.2, 1.8];
    let settings = [("Makadam", 0.125, &lucky[..]), ("Makadam", 0.625, &[0.0; 4]), ("YADE", 2.5, &[0.0; 4])];
    assert_eq!(ratio_interval(&settings), [Some(4.0), Some(20.0)]);
    let settings = [("Makadam", 0.125, &[0.0; 4][..]), ("YADE", 2.5, &lucky)];
    assert_eq!(ratio_interval(&settings), [Some(20.0), None], "a code that often keeps no bound has no upper end");
    let settings = [("Makadam", 0.125, &[0.0; 4][..]), ("YADE", 2.5, &[1.5; 4])];
    assert_eq!(ratio_interval(&settings), [None, None]);
}

#[test]
fn ratio_interval_draws_common_seeds() {
    // Errors of both codes rise and fall together: the slow settings are needed in the same samples.
    let (errors, none) = ([0.0, 0.6, 1.2, 1.8], [0.0; 4]);
    let settings =
        [("Makadam", 0.125, &errors[..]), ("Makadam", 0.375, &none), ("YADE", 2.5, &errors), ("YADE", 7.5, &none)];
    assert_eq!(ratio_interval(&settings), [Some(20.0), Some(20.0)]);
}

#[test]
fn ratio_interval_needs_two_seeds() {
    assert_eq!(ratio_interval(&[("Makadam", 0.125, &[0.0][..]), ("YADE", 2.5, &[0.0])]), [None, None]);
}
