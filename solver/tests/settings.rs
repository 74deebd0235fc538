//! Settings of a simulation take effect or are refused, never ignored.

use crate::common::bits::{reference_scene, start, steps};
use makadam::scene::{Precision, SolverMethod, SolverSettings};
use makadam::solve::{residual_text, residual_unit_name};
use makadam::{Obstacle, SettingError};

const JACOBI: SolverMethod = SolverMethod::Jacobi { damping: 0.5 };

#[test]
fn scenes_that_need_gauss_seidel_in_double_precision_refuse_all_else() {
    for (name, obstacle) in [("spinning-tops", Obstacle::Torques), ("oedometer", Obstacle::DrivenWalls)] {
        let scene = reference_scene(name);
        let (mut simulation, mut untouched) = (start(&scene), start(&scene));
        assert_eq!(simulation.use_precision(Precision::Single), Err(SettingError::SinglePrecision(obstacle)), "{name}");
        assert_eq!(simulation.use_method(JACOBI), Err(SettingError::Method { method: JACOBI, obstacle }), "{name}");
        assert_eq!(simulation.goes_with(JACOBI), Err(SettingError::Method { method: JACOBI, obstacle }), "{name}");
        assert_eq!(simulation.use_precision(Precision::Double), Ok(()), "{name}");
        assert_eq!(simulation.use_method(SolverMethod::GaussSeidel), Ok(()), "{name}");
        steps(&mut simulation, 20);
        steps(&mut untouched, 20);
        assert_eq!(simulation.state_hash(), untouched.state_hash(), "{name}: what is refused leaves no trace");
    }
}

#[test]
fn single_precision_and_other_methods_refuse_each_other_in_either_order() {
    let scene = reference_scene("drum");
    let mut simulation = start(&scene);
    simulation.use_precision(Precision::Single).unwrap();
    let error = simulation.use_method(JACOBI).unwrap_err();
    assert_eq!(error.to_string(), "method jacobi does not go with single precision; gauss-seidel does");
    simulation.use_precision(Precision::Double).unwrap();
    simulation.use_method(JACOBI).unwrap();
    let error = simulation.use_precision(Precision::Single).unwrap_err();
    assert_eq!(
        error.to_string(),
        "single precision does not go with methods other than gauss-seidel; double precision does"
    );
}

#[test]
fn lists_of_long_steps_reach_further() {
    let reach = |step: f64, gravity: f64| SolverSettings { step, ..SolverSettings::default() }.reach(0.005, gravity);
    assert_eq!(reach(5e-4, 9.81), 0.6 * 0.005, "the setting");
    assert_eq!(reach(0.1, 0.0), 0.6 * 0.005, "nothing falls");
    let (short, long) = (reach(1e-3, 9.81), reach(2e-3, 9.81));
    assert!((long / short - 2.0_f64.sqrt()).abs() < 1e-12 && (long / 0.005 - 1.19).abs() < 0.01, "{short} {long}");
    assert_eq!(reach(0.1, 9.81), 1.5 * 0.005, "the longest");
}

#[test]
fn residuals_show_two_digits() {
    let text = |value: f64| residual_text(value, residual_unit_name(9.81));
    assert_eq!(text(4.04e-5), "4.0e-5 g h");
    assert_eq!(text(1e-9), "1.0e-9 g h");
    assert_eq!((text(0.25), text(1.0), text(31.4)), ("0.25 g h".into(), "1.0 g h".into(), "31 g h".into()));
    assert_eq!(residual_text(2e7, residual_unit_name(0.0)), "2.0e7 m/s");
}
