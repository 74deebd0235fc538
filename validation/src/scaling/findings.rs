//! What a study found, in sentences: every number is computed from its rows.

use super::machine::Machine;
use super::rows::{Check, MeasuredRow, ReplayedRow, TaskRow};
use super::study::Study;
use crate::draw::numbers::two_digits;
use makadam::partition::Portion;
use makadam::schedule::{Phase, Scheduler};

/// Speed-up over number of threads down to which a curve is called linear.
pub const LINEAR_SHARE: f64 = 0.8;

/// Threads up to which the thesis found its central queue to scale linearly on the Xeon Phi 3120.
pub const THESIS_CENTRAL_QUEUE: usize = 25;
/// Threads beyond which its work stealing was still linear there.
pub const THESIS_WORK_STEALING: usize = 40;

/// The schedulers that share work.
pub(super) const PARALLEL: [Scheduler; 2] = [Scheduler::CentralQueue, Scheduler::WorkStealing];

impl Study {
    /// The same study, which says what was found.
    pub fn with_findings(mut self) -> Study {
        self.findings = findings(&self);
        self
    }
}

/// The sentences.
fn findings(study: &Study) -> Vec<String> {
    let mut sentences = vec![same_bits(study)];
    sentences.extend(measured(study));
    sentences.extend(instruction_sets(study));
    sentences.extend(checks(&study.checks));
    sentences.extend(slow_to_wake(study));
    sentences.extend(serial_share(study));
    for machine in &study.machines {
        for portion in [Portion::Batches, Portion::Boxes] {
            sentences.extend(PARALLEL.iter().filter_map(|&scheduler| curve(study, machine, scheduler, portion)));
            sentences.extend(queue_limit(study, machine, portion));
        }
    }
    sentences.extend(thesis(study));
    sentences
}

/// A scheduler's name in a sentence.
pub(super) fn scheduler_name(scheduler: Scheduler) -> &'static str {
    match scheduler {
        Scheduler::Serial => "serial",
        Scheduler::CentralQueue => "the central queue",
        Scheduler::WorkStealing => "work stealing",
    }
}

fn threads_word(threads: usize) -> String {
    format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
}

/// A time of computing in a unit that suits it.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", two_digits(s)),
        s if s >= 1e-3 => format!("{} ms", two_digits(1e3 * s)),
        s if s >= 1e-6 => format!("{} µs", two_digits(1e6 * s)),
        s => format!("{} ns", two_digits(1e9 * s)),
    }
}

fn same_bits(study: &Study) -> String {
    if study.same_bits {
        return format!(
            "All {} configurations and the traced steps ended in the same state, bit for bit.",
            study.measured.len()
        );
    }
    format!("Not all configurations gave the same bits; different from the first: {}.", study.differing.join("; "))
}

/// The largest measured number of threads of each scheduler.
fn measured(study: &Study) -> Option<String> {
    let set = study.widest()?;
    let most = study.measured.iter().map(|row| row.threads).max()?;
    let row = |scheduler| {
        study.measured.iter().find(|row| {
            (row.instruction_set, row.scheduler, row.threads, row.portion) == (set, scheduler, most, Portion::Batches)
        })
    };
    let one = |row: &MeasuredRow| {
        format!(
            "{} takes {} a step, {:.2} times as fast as serial (the sweeps alone {:.2} times)",
            scheduler_name(row.scheduler),
            time(row.step_seconds),
            row.speedup,
            row.sweep_speedup
        )
    };
    let parts: Vec<String> =
        [row(Scheduler::WorkStealing), row(Scheduler::CentralQueue)].into_iter().flatten().map(one).collect();
    (!parts.is_empty())
        .then(|| format!("Measured on {} with {}: {}.", threads_word(most), set.name(), parts.join("; ")))
}

/// What a contact sweep costs on one core.
fn instruction_sets(study: &Study) -> Option<String> {
    let serial = |row: &&MeasuredRow| (row.scheduler, row.portion) == (Scheduler::Serial, Portion::Batches);
    let serial: Vec<&MeasuredRow> = study.measured.iter().filter(serial).collect();
    let cost = |row: &&MeasuredRow| {
        Some(format!("{} ns with {}", two_digits(row.nanoseconds_per_contact_sweep?), row.instruction_set.name()))
    };
    let costs: Vec<String> = serial.iter().filter_map(cost).collect();
    let (first, last) = (serial.first()?, serial.last()?);
    let ratio = first.sweep_seconds / last.sweep_seconds;
    let ratio = match serial.len() {
        1 => String::new(),
        _ => {
            format!(": {} is {ratio:.2} times as fast as {}", last.instruction_set.name(), first.instruction_set.name())
        }
    };
    (!costs.is_empty())
        .then(|| format!("Measured on one core, serial, a contact sweep takes {}{ratio}.", costs.join(", ")))
}

/// A word of caution where a second thread was slow to come.
fn slow_to_wake(study: &Study) -> Option<String> {
    let costs = study.machines.first()?.costs;
    (study.cores > 1 && !costs.threads_met()).then(|| {
        format!(
            "A second thread took part in a region of 50 µs in {} of the trials: waking one took longer in the others, or \
             another program held its core. The cost of stealing is that of the trials in which it came.",
            percent(costs.met_share)
        )
    })
}

/// How far the replay is from what was measured.
fn checks(checks: &[Check]) -> Option<String> {
    let worst = |checks: &[&Check]| {
        let all = checks.iter().max_by(|a, b| a.deviation_percent.abs().total_cmp(&b.deviation_percent.abs()));
        all.map(|check| {
            format!(
                "{:.1}% ({}, {}, {}, {})",
                check.deviation_percent.abs(),
                check.instruction_set.name(),
                check.scheduler.name(),
                threads_word(check.threads),
                check.portion.name()
            )
        })
    };
    let all: Vec<&Check> = checks.iter().collect();
    let parallel: Vec<&Check> = checks.iter().filter(|check| check.threads > 1).collect();
    let several = match worst(&parallel) {
        Some(worst) => format!("; on more than one thread by at most {worst}"),
        None => "; none of them on more than one thread".into(),
    };
    Some(format!(
        "The replay misses the {} measured configurations by at most {}{several}.{}",
        checks.len(),
        worst(&all)?,
        own_tasks(&parallel).unwrap_or_default()
    ))
}

/// What is left of the deviations where tasks are as long as they were on several threads.
fn own_tasks(parallel: &[&Check]) -> Option<String> {
    let worst = |key: fn(&Check) -> f64| {
        parallel.iter().copied().max_by(|a, b| key(a).total_cmp(&key(b))).map(|check| (key(check), check))
    };
    let (ratio, longest) = worst(|check| check.task_time_ratio)?;
    let (deviation, _) = worst(|check| check.own_tasks_deviation_percent.abs())?;
    Some(format!(
        " Threads change the duration of each other's tasks, by at most {:+.1}% ({}, {}, {}); replayed from tasks as long as \
         they were there, the parallel configurations are missed by at most {deviation:.1}%.",
        100.0 * (ratio - 1.0),
        longest.instruction_set.name(),
        longest.scheduler.name(),
        threads_word(longest.threads)
    ))
}

/// Amdahl's bound.
fn serial_share(study: &Study) -> Option<String> {
    let set = study.widest()?;
    let rows = study.tasks.iter().filter(|row| (row.instruction_set, row.portion) == (set, Portion::Batches));
    let serial: f64 = rows.filter(|row| row.most_tasks < 2).map(|row| row.share).sum();
    let bound = if serial > 0.0 {
        format!(", which bounds any speed-up to {}", two_digits(1.0 / serial))
    } else {
        String::new()
    };
    Some(format!("Of a traced step {} is serial work{bound}.", percent(serial)))
}

fn percent(share: f64) -> String {
    format!("{}%", two_digits(100.0 * share))
}

/// The rows of one curve, by number of workers.
pub(super) fn curve_rows<'a>(
    study: &'a Study,
    machine: &'a Machine,
    scheduler: Scheduler,
    portion: Portion,
) -> impl Iterator<Item = &'a ReplayedRow> {
    let set = study.widest();
    study.replayed.iter().filter(move |row| {
        row.machine == machine.name
            && (row.scheduler, row.portion) == (scheduler, portion)
            && Some(row.instruction_set) == set
    })
}

/// The largest number of workers up to which the speed-up is at least [`LINEAR_SHARE`] of their number.
pub(super) fn linear_up_to<'a>(
    rows: impl Iterator<Item = &'a ReplayedRow>,
    speedup: fn(&ReplayedRow) -> f64,
) -> Option<usize> {
    rows.take_while(|row| speedup(row) >= LINEAR_SHARE * row.workers as f64).last().map(|row| row.workers)
}

fn curve(study: &Study, machine: &Machine, scheduler: Scheduler, portion: Portion) -> Option<String> {
    let rows = || curve_rows(study, machine, scheduler, portion);
    let best = rows().max_by(|a, b| a.speedup.total_cmp(&b.speedup))?;
    // A curve that has levelled off creeps on; what counts is where it comes near its end.
    let near = rows().find(|row| row.speedup >= 0.95 * best.speedup)?;
    let linear = |speedup| {
        linear_up_to(rows(), speedup)
            .map_or("linear nowhere".to_string(), |workers| format!("linear up to {}", threads_word(workers)))
    };
    let sweeps = rows().map(|row| row.sweep_speedup).fold(0.0, f64::max);
    Some(format!(
        "Replayed on {}: {} of {} is {}, its sweeps are {}; at most it is {} times as fast as one thread (95% of that with \
         {}), its sweeps {} times.",
        place(machine),
        scheduler_name(scheduler),
        portion.name(),
        linear(|row| row.speedup),
        linear(|row| row.sweep_speedup),
        two_digits(best.speedup),
        threads_word(near.workers),
        two_digits(sweeps),
    ))
}

/// A machine in a sentence.
pub(super) fn place(machine: &Machine) -> String {
    if machine.name == Machine::HERE {
        "this machine with more cores".into()
    } else {
        format!("the model {}", machine.name)
    }
}

/// Mean duration of the tasks of sweeps in regions of several tasks, s, where they were traced.
fn mean_task(study: &Study, portion: Portion) -> Option<f64> {
    let set = study.widest()?;
    let swept = |row: &&TaskRow| {
        (row.instruction_set, row.portion, row.phase) == (set, portion, Phase::Sweep) && row.most_tasks > 1
    };
    let rows = study.tasks.iter().filter(swept);
    let (time, tasks) = rows.fold((0.0, 0.0), |(time, tasks), row| {
        let count = row.regions * row.tasks;
        (time + count * row.mean, tasks + count)
    });
    (tasks > 0.0).then(|| time / tasks)
}

/// How many workers one queue can feed.
fn queue_limit(study: &Study, machine: &Machine, portion: Portion) -> Option<String> {
    let (task, pop) = (machine.duration_factor * mean_task(study, portion)?, machine.costs.pop_contended);
    let one = match portion {
        Portion::Batches => "a batch of a sweep",
        Portion::Boxes => "what one box has in one stage of a sweep",
    };
    Some(format!(
        "On {} {one} takes {} in the mean and a pop of the contended queue {}: one queue can feed about {} workers \
         (replayed).",
        place(machine),
        time(task),
        time(pop),
        two_digits(task / pop)
    ))
}

/// The thesis beside the replay on its machine.
fn thesis(study: &Study) -> Option<String> {
    let phi = study.machines.iter().find(|machine| machine.name == Machine::XEON_PHI)?;
    let reach = |scheduler, portion| {
        linear_up_to(curve_rows(study, phi, scheduler, portion), |row| row.sweep_speedup)
            .map_or("nowhere".to_string(), |workers| format!("up to {workers}"))
    };
    let most = |scheduler, portion| {
        let speedups = curve_rows(study, phi, scheduler, portion).map(|row| row.sweep_speedup);
        two_digits(speedups.fold(0.0, f64::max))
    };
    let (queue, stealing) = (Scheduler::CentralQueue, Scheduler::WorkStealing);
    Some(format!(
        "The thesis, measured on a Xeon Phi 3120 with its own tasks, found the sweeps of the central queue linear up to about \
         {THESIS_CENTRAL_QUEUE} threads and those of work stealing linear beyond {THESIS_WORK_STEALING}. Replayed on the model \
         of that machine with this scene's tasks: handed out box by box they are linear {} with the central queue (at most {} \
         times one thread) and {} with work stealing ({} times); in batches {} ({} times) and {} ({} times).",
        reach(queue, Portion::Boxes),
        most(queue, Portion::Boxes),
        reach(stealing, Portion::Boxes),
        most(stealing, Portion::Boxes),
        reach(queue, Portion::Batches),
        most(queue, Portion::Batches),
        reach(stealing, Portion::Batches),
        most(stealing, Portion::Batches),
    ))
}
