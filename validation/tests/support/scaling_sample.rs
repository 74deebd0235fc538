//! A scaling study of invented traces: a drum of 50,000 grains as one might trace it, and times that are its replays,
//! a little slower.

use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{Phase, Region, Scheduler, StepTrace};
use makadam::sweep::SweepBytes;
use makadam_frames::execution::Execution;
use makadam_frames::provenance::Provenance;
use makadam_studies::scaling::{Bandwidth, Costs, Machine, Measurement, Plan, Study, Timing, Traces, replay};
use std::path::Path;

/// Factor of the invented measurement on its replay.
pub const SLOWER: f64 = 1.04;

const SETS: [(InstructionSet, f64); 2] = [(InstructionSet::Generic, 3.0), (InstructionSet::Avx512, 1.0)];
const COSTS: Costs = Costs { pop_alone: 15e-9, pop_contended: 90e-9, task_start: 30e-9, steal: 400e-9, region: 300e-9 };
const SWEEPS: u32 = 12;

/// Returns the same step box by box: each task of a sweep in six pieces.
fn cut(mut step: StepTrace) -> StepTrace {
    for region in step.regions.iter_mut().filter(|region| region.phase == Phase::Sweep) {
        region.tasks = region.tasks.iter().flat_map(|&task| [task / 6.0; 6]).collect();
    }
    step
}

/// A step: detection and set-up in parts, sweeps of eight stages, integration.
fn step(factor: f64) -> StepTrace {
    let spread = |count: usize, seconds: f64| -> Vec<f64> {
        (0..count).map(|k| seconds * (0.6 + 0.8 * ((k * 37) % 100) as f64 / 100.0)).collect()
    };
    let mut regions = vec![
        Region { phase: Phase::Detect, tasks: vec![20e-6] },
        Region { phase: Phase::Detect, tasks: spread(96, 8e-6) },
        Region { phase: Phase::Constrain, tasks: spread(96, 20e-6) },
    ];
    for _ in 0..SWEEPS {
        let stages = [
            (96, 10e-6),
            (80, 1.2e-6),
            (80, 1.2e-6),
            (80, 1.2e-6),
            (60, 0.15e-6),
            (60, 0.15e-6),
            (60, 0.15e-6),
            (40, 0.05e-6),
        ];
        let stage = |(count, seconds)| Region { phase: Phase::Sweep, tasks: spread(count, factor * seconds) };
        regions.extend(stages.map(stage));
    }
    regions.push(Region { phase: Phase::Integrate, tasks: spread(64, 3e-6) });
    StepTrace { regions }
}

/// The study of a changed measurement.
pub fn study_of(change: impl Fn(&mut Measurement)) -> Study {
    let plan = Plan {
        instruction_sets: SETS.map(|(set, _)| set).to_vec(),
        threads: vec![1, 2, 4, 8, 16],
        steps: 2,
        traced_steps: 2,
        repetitions: 3,
    };
    let here = Machine::here(COSTS, (300e9, 16), 8 << 20);
    let (mut timings, mut traces) = (Vec::new(), Vec::new());
    for configuration in plan.configurations() {
        let Execution { instruction_set, scheduler, threads, portion, .. } = configuration;
        let factor = SETS.iter().find(|(set, _)| *set == instruction_set).map_or(1.0, |&(_, factor)| factor);
        let step = if portion == Portion::Boxes { cut(step(factor)) } else { step(factor) };
        let seconds = SLOWER * replay(&step.regions, scheduler, &here, 0.0, threads).seconds;
        let noise = [0.97, 1.0, 1.06];
        if scheduler == Scheduler::Serial {
            traces.push(Traces { configuration, steps: vec![step; 2], sweeps: vec![SWEEPS; 2] });
        }
        timings.push(Timing {
            configuration,
            steps: noise.map(|noise| vec![noise * seconds; 2]).to_vec(),
            sweeps: noise.map(|noise| vec![0.7 * noise * seconds; 2]).to_vec(),
            hashes: vec![7; 3],
        });
    }
    let mut measurement = Measurement {
        start_seconds: 1.0,
        particles: 50_000,
        contacts: 130_000.0,
        contact_sweeps: 130_000.0 * f64::from(SWEEPS),
        simulation_bytes: 48 << 20,
        sweep_bytes: SweepBytes { touched: 96 * 130_000, moved: 110 * 130_000 },
        timings,
        traces,
    };
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let scene = makadam_frames::plan::MeasuredScene::load(&file).expect("the small scene is valid");
    change(&mut measurement);
    let bandwidth = Bandwidth { one_thread: 20e9, all_threads: 300e9, threads: 16 };
    let machines = vec![here, Machine::xeon_phi_3120(&COSTS, 3.3e9)];
    let provenance = Provenance::of_run(&scene, Path::new("invented.toml"), 1, &Execution::serial());
    Study::new("invented", plan, &measurement, bandwidth, machines, provenance)
}

/// The study.
pub fn study() -> Study {
    study_of(|_| {})
}
