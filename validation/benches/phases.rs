//! The phases of a step and whole steps, from flowing states: each on every instruction set and
//! on all cores, in one run.
//!
//! ```text
//! cargo bench -p makadam-validation                        # drum, and larger drums whose flowing state is in the cache
//! cargo bench -p makadam-validation -- sweep/drum          # sweeps alone
//! MAKADAM_BENCH_SCENES=drum-500k cargo bench -p makadam-validation    # these scenes, prepared first if they must be
//! ```
//!
//! Throughput is in contacts: of `sweep`, contact sweeps a second. `sweep` is twelve sweeps without measuring residuals;
//! `detect` builds the candidate list, `stale` asks whether that is needed, `set-up` lays out the constraints and starts
//! them; `look` is one look of the watchdogs. A phase is repeated on one state; steps go on from it.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use makadam::lanes::InstructionSet;
use makadam::scene::{Precision, Watch};
use makadam::schedule::Scheduler;
use makadam::watch::Watchdog;
use makadam::{Simulation, StepReport};
use makadam_compare::prepared::{Start, is_ready, start};
use makadam_frames::execution::{Execution, cores};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::stepping::steps_in;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// From in the first core's own cache to far beyond any.
const SCENES: [&str; 4] = ["drum", "drum-50k", "drum-100k", "drum-500k"];
/// Sweeps of one call: those of a step by default.
const SWEEPS: u32 = 12;
/// Simulated time after which the small drum flows, s.
const SETTLE: f64 = 1.5;
/// Contacts beyond which a phase takes so long that fewer samples must do.
const LARGE: usize = 500_000;
/// Steps that fill caches and buffers first.
const WARM_UP: usize = 3;

/// One way to carry out a step.
#[derive(Clone, Copy)]
struct Way {
    precision: Precision,
    execution: Execution,
}

impl Way {
    /// All of them: each instruction set on one thread and on all cores, in both precisions.
    fn all() -> Vec<Way> {
        let way = |precision, instruction_set, threads| {
            let scheduler = if threads > 1 { Scheduler::WorkStealing } else { Scheduler::Serial };
            Way { precision, execution: Execution { scheduler, threads, instruction_set, ..Execution::serial() } }
        };
        let sets = InstructionSet::ALL.into_iter().filter(|set| set.is_available());
        let threads = if cores() > 1 { vec![1, cores()] } else { vec![1] };
        let wide = sets.flat_map(|set| threads.iter().map(move |&threads| way(Precision::Double, set, threads)));
        let wide: Vec<Way> = wide.collect();
        let single = wide.iter().map(|&double| Way { precision: Precision::Single, ..double });
        wide.iter().copied().chain(single).collect()
    }

    fn name(self) -> String {
        let set = self.execution.instruction_set.name();
        let set = if self.precision == Precision::Single { format!("{set}-single") } else { set.to_owned() };
        format!("{set}-{}-thread{}", self.execution.threads, if self.execution.threads > 1 { "s" } else { "" })
    }

    /// A copy of a state that goes on this way.
    fn of(self, state: &Simulation) -> Simulation {
        let mut simulation = state.clone();
        simulation.use_precision(self.precision).expect("these scenes go with either precision");
        self.execution.apply(&mut simulation).expect("the set is there and threads can be started");
        simulation
    }
}

/// The scene in motion; none if its flowing state would have to be prepared and nobody asked for that.
fn flowing(name: &str, asked: bool) -> Option<Simulation> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    let scene = MeasuredScene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    if !asked && !is_ready(&scene, scene.seed) {
        eprintln!("{name} is left out: its flowing state is not prepared; MAKADAM_BENCH_SCENES={name} prepares it");
        return None;
    }
    let execution = Execution { scheduler: Scheduler::WorkStealing, threads: cores(), ..Execution::serial() };
    let (mut simulation, begun) =
        start(&scene, scene.seed, &file, &execution, &|_| {}).unwrap_or_else(|error| panic!("{error}"));
    let settle = if begun == Start::Fresh { steps_in(SETTLE, simulation.time_step()) } else { 0 };
    (0..settle as usize + WARM_UP).for_each(|_| {
        simulation.step();
    });
    Some(simulation)
}

/// Benches one phase in all the ways that matter to it.
fn phase(
    criterion: &mut Criterion,
    (name, scene): (&str, &str),
    state: &Simulation,
    elements: u64,
    matters: impl Fn(&Way) -> bool,
    call: impl Fn(&mut Simulation),
) {
    let mut group: BenchmarkGroup<'_, WallTime> = criterion.benchmark_group(format!("{name}/{scene}"));
    group.throughput(Throughput::Elements(elements));
    group.sample_size(if state.layout().contacts > LARGE { 10 } else { 20 });
    for way in Way::all().into_iter().filter(matters) {
        group.bench_function(way.name(), |bencher| {
            let mut simulation = way.of(state);
            bencher.iter(|| call(&mut simulation));
        });
    }
    group.finish();
}

fn phases(criterion: &mut Criterion) {
    let asked = std::env::var("MAKADAM_BENCH_SCENES").ok();
    let names: Vec<&str> = match &asked {
        Some(list) => list.split(',').map(str::trim).filter(|name| !name.is_empty()).collect(),
        None => SCENES.to_vec(),
    };
    for name in names {
        let Some(state) = flowing(name, asked.is_some()) else { continue };
        let contacts = state.layout().contacts as u64;
        let everywhere = |_: &Way| true;
        // Only sweeps have another precision; the generic set on one thread is the serial baseline of the rest.
        let wide = |way: &Way| way.precision == Precision::Double;
        let generic = |way: &Way| wide(way) && way.execution.instruction_set == InstructionSet::Generic;
        phase(criterion, ("sweep", name), &state, u64::from(SWEEPS) * contacts, everywhere, |simulation| {
            black_box(simulation.sweep_times(SWEEPS));
        });
        phase(criterion, ("detect", name), &state, contacts, wide, Simulation::detect_once);
        phase(criterion, ("stale", name), &state, contacts, generic, |simulation| {
            black_box(simulation.is_stale_once());
        });
        phase(criterion, ("set-up", name), &state, contacts, wide, |simulation| {
            black_box(simulation.constrain_once());
        });
        // One look of the watchdogs; a run takes one every 64 steps.
        let watch = Watch { every: 1, ..Watch::default() };
        phase(criterion, ("look", name), &state, contacts, generic, |simulation| {
            black_box(Watchdog::new(&watch, simulation).observe(simulation, &StepReport::default()));
        });
        // What they take note of in every step.
        let watch = Watch { every: u32::MAX, ..Watch::default() };
        let watchdog = Watchdog::new(&watch, &state);
        let mut next = state.clone();
        let report = next.step();
        phase(criterion, ("note", name), &next, contacts, generic, |simulation| {
            black_box(watchdog.clone().observe(simulation, &report));
        });
        phase(criterion, ("step", name), &state, contacts, everywhere, |simulation| {
            black_box(simulation.step());
        });
    }
}

fn settings() -> Criterion {
    // Three quarters of a minute a scene.
    Criterion::default()
        .nresamples(10_000)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
}

criterion_group!(name = benches; config = settings(); targets = phases);
criterion_main!(benches);
