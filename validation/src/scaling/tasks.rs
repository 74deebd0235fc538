//! How long tasks take.

use super::measure::Traces;
use super::rows::TaskRow;
use makadam::schedule::Phase;

/// Durations of tasks, by phase, and by stage in sweeps.
pub(super) fn task_rows(traces: &Traces) -> Vec<TaskRow> {
    let mut kinds: Vec<Kind> = Vec::new();
    for (step, &sweeps) in traces.steps.iter().zip(&traces.sweeps) {
        let in_sweeps = step.regions.iter().filter(|region| region.phase == Phase::Sweep).count();
        // Every sweep goes through the same stages.
        let stages = in_sweeps.checked_div(sweeps as usize).filter(|stages| stages * sweeps as usize == in_sweeps);
        let mut sweep_region = 0;
        for region in &step.regions {
            let mut stage = None;
            if region.phase == Phase::Sweep {
                stage = stages.map(|stages| sweep_region % stages + 1);
                sweep_region += 1;
            }
            let serial = stage.is_none() && region.tasks.len() < 2;
            let known = |kind: &Kind| (kind.phase, kind.stage, kind.serial) == (region.phase, stage, serial);
            let place = kinds.iter().position(known).unwrap_or_else(|| {
                kinds.push(Kind { phase: region.phase, stage, serial, regions: 0, most_tasks: 0, tasks: Vec::new() });
                kinds.len() - 1
            });
            let kind = &mut kinds[place];
            kind.regions += 1;
            kind.most_tasks = kind.most_tasks.max(region.tasks.len());
            kind.tasks.extend(&region.tasks);
        }
    }
    let phases = [Phase::Detect, Phase::Constrain, Phase::Sweep, Phase::Integrate];
    kinds.sort_by_key(|kind| (phases.iter().position(|&phase| phase == kind.phase), kind.stage, kind.serial));
    let total: f64 = kinds.iter().flat_map(|kind| &kind.tasks).sum();
    let rows = kinds.into_iter().filter(|kind| !kind.tasks.is_empty()).map(|mut kind| {
        kind.tasks.sort_by(f64::total_cmp);
        let tasks = &kind.tasks;
        let quantile = |share: f64| tasks[((tasks.len() - 1) as f64 * share).round() as usize];
        TaskRow {
            instruction_set: traces.configuration.instruction_set,
            portion: traces.configuration.portion,
            phase: kind.phase,
            stage: kind.stage,
            regions: kind.regions as f64 / traces.steps.len() as f64,
            tasks: tasks.len() as f64 / kind.regions as f64,
            most_tasks: kind.most_tasks,
            share: tasks.iter().sum::<f64>() / total,
            mean: mean(tasks),
            least: quantile(0.0),
            tenth: quantile(0.1),
            median: quantile(0.5),
            ninetieth: quantile(0.9),
            most: quantile(1.0),
        }
    });
    rows.collect()
}

/// The regions of one kind, gathered over steps.
struct Kind {
    phase: Phase,
    stage: Option<usize>,
    serial: bool,
    regions: usize,
    most_tasks: usize,
    tasks: Vec<f64>,
}

/// Mean of a few numbers; 0 if there are none.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
