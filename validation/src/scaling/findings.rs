//! What a study found that no table says, in sentences, and how far each curve is linear.

use super::machine::Machine;
use super::rows::{ReplayedRow, TaskRow};
use super::study::Study;
use crate::draw::numbers::two_digits;
use crate::study::{Table, cells};
use makadam::partition::Portion;
use makadam::schedule::{Phase, Scheduler};

/// Speed-up over number of threads down to which a curve is called linear.
pub const LINEAR_SHARE: f64 = 0.8;

/// The schedulers that share work.
pub(super) const PARALLEL: [Scheduler; 2] = [Scheduler::CentralQueue, Scheduler::WorkStealing];

impl Study {
    /// The same study, which says what was found.
    pub fn with_findings(mut self) -> Study {
        let sentences = [same_bits(&self), deviations(&self), slow_to_wake(&self), serial_share(&self)];
        self.findings = sentences.into_iter().flatten().collect();
        self
    }
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

fn same_bits(study: &Study) -> Option<String> {
    Some(match study.same_bits {
        true => {
            format!(
                "All {} configurations and the traced steps ended in the same state, bit for bit.",
                study.measured.len()
            )
        }
        false => {
            format!(
                "Not all configurations gave the same bits; different from the first: {}.",
                study.differing.join("; ")
            )
        }
    })
}

/// The largest deviations of the replay, on any number of threads and on several, and what is left of the latter where tasks are
/// as long as they were there.
fn deviations(study: &Study) -> Option<String> {
    let most = |values: &mut dyn Iterator<Item = f64>| values.reduce(|a, b| if a.abs() >= b.abs() { a } else { b });
    let parallel = || study.checks.iter().filter(|check| check.threads > 1);
    let all = most(&mut study.checks.iter().map(|check| check.deviation_percent))?.abs();
    let mut sentence =
        format!("The replay misses the {} measured configurations by at most {all:.1}%", study.checks.len());
    let Some(several) = most(&mut parallel().map(|check| check.deviation_percent)) else {
        return Some(sentence + "; none of them on more than one thread.");
    };
    let longer = parallel().map(|check| 100.0 * (check.task_time_ratio - 1.0)).fold(f64::NEG_INFINITY, f64::max);
    let own = most(&mut parallel().map(|check| check.own_tasks_deviation_percent)).unwrap_or_default().abs();
    sentence += &format!(
        "; on more than one thread by at most {:.1}%. Threads change the duration of each other's tasks, by at most {longer:+.1}%; \
         replayed from tasks as long as they were there, the parallel configurations are missed by at most {own:.1}%.",
        several.abs()
    );
    Some(sentence)
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

/// Amdahl's bound.
fn serial_share(study: &Study) -> Option<String> {
    let set = study.widest()?;
    let rows = study.tasks.iter().filter(|row| (row.instruction_set, row.portion) == (set, Portion::Batches));
    let serial: f64 = rows.filter(|row| row.most_tasks < 2).map(|row| row.share).sum();
    let bound = match serial > 0.0 {
        true => format!(", which bounds any speed-up to {}", two_digits(1.0 / serial)),
        false => String::new(),
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

/// How far the curves of a machine are linear, and where they end: one row a scheduler and portion.
pub(super) fn curves(study: &Study, machine: &Machine) -> Table {
    let numbers = [
        "linear up to (threads)",
        "its sweeps up to",
        "largest speed-up",
        "95% of it with",
        "largest of the sweeps",
        "a task of a sweep",
        "threads that one queue feeds",
    ];
    let mut table = Table::new(&["scheduler", "of"], &numbers);
    for portion in [Portion::Batches, Portion::Boxes] {
        for scheduler in PARALLEL {
            let rows: Vec<&ReplayedRow> = curve_rows(study, machine, scheduler, portion).collect();
            let most = |speedup: fn(&ReplayedRow) -> f64| rows.iter().map(|row| speedup(row)).fold(0.0, f64::max);
            let linear = |speedup: fn(&ReplayedRow) -> f64| {
                let linear = rows.iter().take_while(|row| speedup(row) >= LINEAR_SHARE * row.workers as f64).last();
                linear.map_or("nowhere".into(), |row| row.workers.to_string())
            };
            let best = most(|row| row.speedup);
            // A curve that has levelled off creeps on; what counts is where it comes near its end.
            let Some(near) = rows.iter().find(|row| row.speedup >= 0.95 * best) else { continue };
            let task = mean_task(study, portion).map(|task| machine.duration_factor * task);
            let fed = task.filter(|_| scheduler == Scheduler::CentralQueue);
            table.row(cells![
                scheduler.name().replace('-', " "),
                portion.name(),
                linear(|row| row.speedup),
                linear(|row| row.sweep_speedup),
                two_digits(best),
                near.workers,
                two_digits(most(|row| row.sweep_speedup)),
                task.map(time),
                fed.map(|task| two_digits(task / machine.costs.pop_contended)),
            ]);
        }
    }
    table
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
