//! The page of a study: figures, tables and what they say, in one file that loads nothing.

use super::findings::{LINEAR_SHARE, PARALLEL, time};
use super::rows::{MeasuredRow, ReplayedRow, TaskRow};
use super::study::Study;
use crate::draw::figure::Figure;
use crate::draw::numbers::{count, two_digits};
use crate::report::page::{environment, style};
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{Phase, Scheduler};
use minijinja::{Value, context};

/// Numbers of workers that the table of replays shows; the figures and `replayed.csv` have them all.
const SHOWN: [usize; 10] = [1, 2, 4, 8, 16, 25, 40, 57, 114, 228];

/// Renders the page.
pub(super) fn render(study: &Study, figures: &[[Figure; 2]]) -> Result<String, minijinja::Error> {
    let mut environment = environment()?;
    environment.add_template("page", include_str!("page.html"))?;
    environment.get_template("page")?.render(context! {
        title => format!("Scaling of the scene {}", study.scene),
        style => style(),
        study => study,
        particles => count(study.particles),
        contacts => count(study.contacts.round() as usize),
        bytes => study.bytes_per_contact_sweep.map(two_digits),
        bandwidth => format!(
            "{} GB/s to one thread, {} GB/s to {}",
            two_digits(study.bandwidth.one_thread / 1e9),
            two_digits(study.bandwidth.all_threads / 1e9),
            study.bandwidth.threads
        ),
        linear => format!("{:.0}%", 100.0 * LINEAR_SHARE),
        figures => figures,
        measured => study.measured.iter().map(measured).collect::<Vec<_>>(),
        checks => checks(study),
        machines => machines(study),
        tasks => study.tasks.iter().filter(|row| Some(row.instruction_set) == study.widest()).map(task).collect::<Vec<_>>(),
        widest => study.widest().map(InstructionSet::name),
        provenance => study.provenance.pairs(),
    })
}

fn measured(row: &MeasuredRow) -> Value {
    context! {
        first => row.scheduler == Scheduler::Serial,
        set => row.instruction_set.name(),
        scheduler => row.scheduler.name().replace('-', " "),
        portion => row.portion.name(),
        threads => row.threads,
        step => time(row.step_seconds),
        range => format!("{} to {}", time(row.step_seconds_least), time(row.step_seconds_most)),
        sweep => time(row.sweep_seconds),
        speedup => format!("{:.2}", row.speedup),
        sweep_speedup => format!("{:.2}", row.sweep_speedup),
        cost => row.nanoseconds_per_contact_sweep.map(two_digits),
    }
}

fn checks(study: &Study) -> Vec<Value> {
    let rows = study.checks.iter().map(|check| {
        context! {
            first => check.scheduler == Scheduler::Serial,
            set => check.instruction_set.name(),
            scheduler => check.scheduler.name().replace('-', " "),
            portion => check.portion.name(),
            threads => check.threads,
            measured => time(check.measured_seconds),
            replayed => time(check.replayed_seconds),
            deviation => signed_percent(check.deviation_percent),
            task_time => signed_percent(100.0 * (check.task_time_ratio - 1.0)),
            own => time(check.replayed_from_own_tasks_seconds),
            own_deviation => signed_percent(check.own_tasks_deviation_percent),
        }
    });
    rows.collect()
}

/// A deviation with its sign and a true minus.
pub(super) fn signed_percent(percent: f64) -> String {
    format!("{percent:+.1}%").replace('-', "−")
}

fn machines(study: &Study) -> Vec<Value> {
    let rows = study.machines.iter().map(|machine| {
        let costs = machine.costs;
        let shown = |row: &&ReplayedRow| {
            row.machine == machine.name
                && Some(row.instruction_set) == study.widest()
                && (row.scheduler, row.portion) == (Scheduler::CentralQueue, Portion::Batches)
                && SHOWN.contains(&row.workers)
        };
        let lines: Vec<Value> = (study.replayed.iter().filter(shown))
            .map(|queue| {
                let other = |scheduler, portion| {
                    study.replayed.iter().find(|row| {
                        (row.scheduler, row.portion) == (scheduler, portion)
                            && row.machine == queue.machine
                            && row.workers == queue.workers
                            && row.instruction_set == queue.instruction_set
                    })
                };
                let stealing = other(Scheduler::WorkStealing, Portion::Batches);
                let boxes = PARALLEL.map(|scheduler| other(scheduler, Portion::Boxes));
                context! {
                    workers => queue.workers,
                    queue => time(queue.step_seconds),
                    queue_speedup => two_digits(queue.speedup),
                    waiting => format!("{:.0}%", 100.0 * queue.waiting_share),
                    stealing => stealing.map(|row| time(row.step_seconds)),
                    stealing_speedup => stealing.map(|row| two_digits(row.speedup)),
                    boxes => boxes.map(|row| row.map(|row| (time(row.step_seconds), two_digits(row.speedup)))),
                }
            })
            .collect();
        context! {
            name => machine.name,
            description => machine.description,
            costs => [
                ("pop of the queue, alone", costs.pop_alone),
                ("pop of the queue, contended", costs.pop_contended),
                ("beginning a task", costs.task_start),
                ("stealing", costs.steal),
                ("opening and closing a region", costs.region),
            ].map(|(name, seconds)| (name, time(seconds))),
            lines => lines,
        }
    });
    rows.collect()
}

fn task(row: &TaskRow) -> Value {
    context! {
        phase => match row.stage {
            Some(stage) => format!("{}, stage {stage}", phase_name(row.phase)),
            None if row.most_tasks < 2 => format!("{}, serial", phase_name(row.phase)),
            None => phase_name(row.phase).into(),
        },
        portion => row.portion.name(),
        regions => two_digits(row.regions),
        tasks => two_digits(row.tasks),
        share => format!("{:.1}%", 100.0 * row.share),
        durations => [row.mean, row.least, row.tenth, row.median, row.ninetieth, row.most].map(time),
    }
}

/// A phase's name in a table.
fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Detect => "detect",
        Phase::Constrain => "constrain",
        Phase::Sweep => "sweep",
        Phase::Integrate => "integrate",
    }
}
