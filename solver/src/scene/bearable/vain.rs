//! Settings that have no effect beside the others.

use crate::scene::error::{Fault, short};
use crate::scene::place::Place;
use crate::scene::{Motion, Scene, SolverMethod, SolverSettings};

/// What the scene says in vain.
pub(super) fn faults(scene: &Scene) -> Vec<Fault> {
    let root = Place::default();
    let mut faults = Vec::new();
    let (settings, usual) = (&scene.solver, SolverSettings::default());
    let sweeps = match settings.method {
        SolverMethod::GaussSeidel | SolverMethod::Anderson { .. } | SolverMethod::NonlinearConjugateGradients => true,
        SolverMethod::AcceleratedProjectedGradients
        | SolverMethod::Jacobi { .. }
        | SolverMethod::ProjectedConjugateGradients => false,
    };
    let asked = [
        ("inner_sweeps", settings.inner_sweeps != usual.inner_sweeps),
        ("over_relaxation", settings.over_relaxation != usual.over_relaxation),
    ];
    for (key, asked) in asked {
        if asked && !sweeps {
            let problem = format!("has no effect with method {}, which does not sweep", settings.method.name());
            faults.push(root.key("solver").key(key).fault(problem, "leave it out, or take a method that sweeps"));
        }
    }
    for (index, wall) in scene.wall.iter().enumerate() {
        let start = match wall.motion {
            Motion::Fixed => continue,
            Motion::Translating { start, .. }
            | Motion::Rotating { start, .. }
            | Motion::Vibrating { start, .. }
            | Motion::ForceDriven { start, .. }
            | Motion::TorqueDriven { start, .. } => start,
        };
        if start >= scene.duration && scene.duration > 0.0 {
            let at = root.key("wall").index(index).key("motion").key("start");
            let problem = format!("wall '{}' never moves: the scene ends at {} s", wall.name, short(scene.duration));
            faults.push(at.fault(problem, "let it begin earlier, or raise duration"));
        }
    }
    // Straight lines lead to each change from the one before.
    let before = std::iter::once(0.0).chain(scene.gravity_changes.iter().map(|change| change.time));
    if let Some((index, _)) =
        before.enumerate().take(scene.gravity_changes.len()).find(|(_, time)| *time >= scene.duration)
        && scene.duration > 0.0
    {
        let at = root.key("gravity_changes").index(index).key("time");
        let problem = format!("gravity never turns to this: the scene ends at {} s", short(scene.duration));
        faults.push(at.fault(problem, "let it change earlier, or raise duration"));
    }
    faults
}
