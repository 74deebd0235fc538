//! The measurement: one problem, solved by every method that suits it, in turn.

use super::study::{Curve, Effort, LeftOut};
use crate::execution::MeasureError;
use crate::plan::Scene;
use makadam::Simulation;
use makadam::scene::SolverMethod;

/// The methods of these names, each once; the scene's own method has its parameters, others have the defaults.
pub fn methods(scene: &Scene, names: Option<&[String]>) -> Vec<SolverMethod> {
    let own = scene.solver.method;
    let wanted = |method: &SolverMethod| names.is_none_or(|names| names.iter().any(|name| name == method.name()));
    let all = SolverMethod::ALL.into_iter().filter(wanted);
    all.map(|method| if method.name() == own.name() { own } else { method }).collect()
}

/// The methods that can solve a simulation's next step, and the others.
pub fn suitable(simulation: &Simulation, wanted: Vec<SolverMethod>) -> (Vec<SolverMethod>, Vec<LeftOut>) {
    let (mut methods, mut left_out) = (Vec::new(), Vec::new());
    for method in wanted {
        match simulation.goes_with(method) {
            Ok(()) => methods.push(method),
            Err(error) => left_out.push(LeftOut { method: method.name(), reason: error.to_string() }),
        }
    }
    (methods, left_out)
}

/// Solves a simulation's next step with methods that suit it, each as often as asked for, in turn, so that what interferes for a
/// while falls on all of them. `progress` is told the method and the share that is done.
///
/// # Errors
/// [`MeasureError::Interrupted`].
pub fn solve(
    simulation: &Simulation,
    methods: &[SolverMethod],
    effort: Effort,
    progress: &dyn Fn(SolverMethod, f64),
) -> Result<Vec<Curve>, MeasureError> {
    let Effort { iterations, repetitions } = effort;
    let mut solves = vec![Vec::new(); methods.len()];
    for repetition in 0..repetitions {
        for (place, &method) in methods.iter().enumerate() {
            let share = place as f64 / methods.len() as f64;
            progress(method, (f64::from(repetition) + share) / f64::from(repetitions));
            solves[place].push(simulation.convergence(method, iterations).expect("it suits"));
            if crate::interrupt::requested() {
                return Err(MeasureError::Interrupted);
            }
        }
    }
    let unit = simulation.residual_unit();
    Ok(methods.iter().zip(solves).map(|(&method, solves)| Curve::new(method, solves, unit)).collect())
}
