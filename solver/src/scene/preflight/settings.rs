//! Checks for settings without effect.

use crate::scene::document::DocumentPath;
use crate::scene::error::{Fault, short};
use crate::scene::{Motion, Scene, SolverMethod, SolverSettings};

/// Largest unreported difference between the duration and a whole number of steps, over the duration.
const UNEVEN: f64 = 0.01;

/// Reports settings that the method ignores, motions, sources and sinks that never act, and a duration that is not a whole number of steps.
pub(super) fn faults(scene: &Scene) -> Vec<Fault> {
    let root = DocumentPath::default();
    let mut faults = Vec::new();
    let (settings, usual) = (&scene.solver, SolverSettings::default());
    let sweeps = match settings.method {
        SolverMethod::GaussSeidel | SolverMethod::Anderson { .. } | SolverMethod::NonlinearConjugateGradients => true,
        SolverMethod::AcceleratedProjectedGradients
        | SolverMethod::Jacobi { .. }
        | SolverMethod::ProjectedConjugateGradients => false,
    };
    let requested = [
        ("inner_sweeps", settings.inner_sweeps != usual.inner_sweeps),
        ("over_relaxation", settings.over_relaxation != usual.over_relaxation),
    ];
    for (key, requested) in requested {
        if requested && !sweeps {
            let problem = format!("has no effect with method {}, which does not sweep", settings.method.name());
            faults.push(root.key("solver").key(key).fault(problem, "leave it out, or take a method that sweeps"));
        }
    }
    for (index, wall) in scene.wall.iter().enumerate() {
        for (at, motion) in wall.motion.parts_at(&root.key("wall").index(index).key("motion")) {
            if *motion == Motion::Fixed {
                continue;
            }
            let (start, stop) = motion.span();
            if let Some(stop) = stop.filter(|stop| *stop <= start) {
                let problem =
                    format!("wall '{}' never moves: it stops at {} s, when it starts", wall.name, short(stop));
                faults.push(at.key("stop").fault(problem, "let it stop later, or leave the motion out"));
            }
            if start >= scene.duration && scene.duration > 0.0 {
                let problem =
                    format!("wall '{}' never moves: the scene ends at {} s", wall.name, short(scene.duration));
                faults.push(at.key("start").fault(problem, "let it begin earlier, or raise duration"));
            }
        }
    }
    let sources = scene.insert.iter().enumerate().map(|(index, source)| ("insert", index, source.from, &source.stage));
    let sinks = scene.remove.iter().enumerate().map(|(index, sink)| ("remove", index, sink.from, &sink.stage));
    for (list, index, from, stage) in sources.chain(sinks) {
        let (at, end) = (root.key(list).index(index), scene.longest_of(stage.as_ref()));
        if from >= end && end > 0.0 {
            let problem = format!("never acts: the run, or its stage, ends at {} s", short(end));
            faults.push(at.key("from").fault(problem, "let it begin earlier, or raise the duration"));
        } else if list == "insert" && scene.expected(&scene.insert[index]) < 1.0 {
            faults.push(
                at.fault("less than one grain is due before it ends".into(), "raise its rate, or let it act longer"),
            );
        }
    }
    let steps = (scene.duration / settings.step).round();
    let simulated = steps * settings.step;
    if steps > 0.0 && (simulated - scene.duration).abs() > UNEVEN * scene.duration {
        let problem = format!(
            "{} s are no whole number of steps of {} s: {} s are simulated",
            short(scene.duration),
            short(settings.step),
            short(simulated)
        );
        faults.push(root.key("duration").fault(problem, "give a duration that is, or a smaller solver.step"));
    }
    // Gravity is linear between consecutive changes.
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
