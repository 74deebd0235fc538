//! Settings of a simulation take effect or are refused, never ignored.

use crate::common::bits::{reference_scene, start, steps};
use makadam::scene::{Precision, SolverMethod};
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
