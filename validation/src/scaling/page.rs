//! The files of a study: its rows, its figures, and a page with tables and what they say.

use super::figures::figures;
use super::findings::{LINEAR_SHARE, PARALLEL, time};
use super::machine::Machine;
use super::study::Study;
use crate::draw::figure::Figure;
use crate::draw::numbers::{count, two_digits};
use crate::study::{Cell, Document, DocumentError, File, Table, json, page, table};
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{Phase, Scheduler};
use minijinja::{Value, context};

/// Numbers of workers that the table of replays shows; the figures and `replayed.csv` have them all.
const SHOWN: [usize; 10] = [1, 2, 4, 8, 16, 25, 40, 57, 114, 228];

impl Document for Study {
    const NAME: &'static str = "scaling";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![
            table("measured", &self.measured)?,
            table("replayed", &self.replayed)?,
            table("checks", &self.checks)?,
            table("tasks", &self.tasks)?,
            json("provenance", &self.provenance)?,
        ])
    }

    fn figures(&self) -> Vec<Figure> {
        figures(self).into_iter().flatten().collect()
    }

    fn page(&self, figures: &[Figure]) -> Result<String, minijinja::Error> {
        let others = context! {
            study => self,
            particles => count(self.particles),
            contacts => count(self.contacts.round() as usize),
            bytes => self.bytes_per_contact_sweep.map(two_digits),
            bandwidth => format!(
                "{} GB/s to one thread, {} GB/s to {}",
                two_digits(self.bandwidth.one_thread / 1e9),
                two_digits(self.bandwidth.all_threads / 1e9),
                self.bandwidth.threads
            ),
            linear => format!("{:.0}%", 100.0 * LINEAR_SHARE),
            measured => measured(self).html(),
            checks => checks(self).html(),
            machines => machines(self),
            tasks => tasks(self).html(),
            widest => self.widest().map(InstructionSet::name),
        };
        let title = format!("Scaling of the scene {}", self.scene);
        page(include_str!("page.html"), &title, figures, self.provenance.pairs(), others)
    }
}

/// Columns of a configuration.
const CONFIGURATION: [&str; 3] = ["instruction set", "scheduler", "of"];

/// Adds a row, which begins a group where the scheduler is the serial one.
fn push(table: &mut Table, scheduler: Scheduler, cells: Vec<Cell>) {
    match scheduler {
        Scheduler::Serial => table.first_row(cells),
        _ => table.row(cells),
    }
}

fn measured(study: &Study) -> Table {
    let numbers =
        ["threads", "wall time a step", "speed-up", "of it sweeps", "speed-up of the sweeps", "a contact sweep (ns)"];
    let mut table = Table::new(&CONFIGURATION, &numbers);
    for row in &study.measured {
        let range = format!("{} to {}", time(row.step_seconds_least), time(row.step_seconds_most));
        push(
            &mut table,
            row.scheduler,
            vec![
                row.instruction_set.name().into(),
                row.scheduler.name().replace('-', " ").into(),
                row.portion.name().into(),
                row.threads.into(),
                Cell::from(time(row.step_seconds)).above(Some(range)),
                format!("{:.2}", row.speedup).into(),
                time(row.sweep_seconds).into(),
                format!("{:.2}", row.sweep_speedup).into(),
                row.nanoseconds_per_contact_sweep.map(two_digits).into(),
            ],
        );
    }
    table
}

fn checks(study: &Study) -> Table {
    let numbers =
        ["threads", "measured", "replayed", "deviation", "its tasks, over serial", "replayed from them", "deviation"];
    let mut table = Table::new(&CONFIGURATION, &numbers);
    for check in &study.checks {
        push(
            &mut table,
            check.scheduler,
            vec![
                check.instruction_set.name().into(),
                check.scheduler.name().replace('-', " ").into(),
                check.portion.name().into(),
                check.threads.into(),
                time(check.measured_seconds).into(),
                time(check.replayed_seconds).into(),
                signed_percent(check.deviation_percent).into(),
                signed_percent(100.0 * (check.task_time_ratio - 1.0)).into(),
                time(check.replayed_from_own_tasks_seconds).into(),
                signed_percent(check.own_tasks_deviation_percent).into(),
            ],
        );
    }
    table
}

/// A deviation with its sign and a true minus.
pub(super) fn signed_percent(percent: f64) -> String {
    format!("{percent:+.1}%").replace('-', "−")
}

fn machines(study: &Study) -> Vec<Value> {
    let rows = study.machines.iter().map(|machine| {
        let costs = machine.costs;
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
            table => replayed(study, machine).html(),
        }
    });
    rows.collect()
}

/// What is replayed on a machine, a number of workers a row.
fn replayed(study: &Study, machine: &Machine) -> Table {
    let numbers = [
        "workers",
        "central queue, a step (replayed)",
        "speed-up",
        "waiting for the lock",
        "work stealing, a step (replayed)",
        "speed-up",
        "the queue box by box",
        "speed-up",
        "stealing box by box",
        "speed-up",
    ];
    let rows = study.replayed.iter().filter(|row| {
        row.machine == machine.name
            && Some(row.instruction_set) == study.widest()
            && (row.scheduler, row.portion) == (Scheduler::CentralQueue, Portion::Batches)
            && SHOWN.contains(&row.workers)
    });
    Table::new(&[], &numbers).of(rows, |queue| {
        let other = |scheduler, portion| {
            let found = study.replayed.iter().find(|row| {
                (row.scheduler, row.portion) == (scheduler, portion)
                    && row.machine == queue.machine
                    && row.workers == queue.workers
                    && row.instruction_set == queue.instruction_set
            });
            [found.map(|row| time(row.step_seconds)).into(), found.map(|row| two_digits(row.speedup)).into()]
        };
        let own = [
            Cell::from(queue.workers),
            time(queue.step_seconds).into(),
            two_digits(queue.speedup).into(),
            format!("{:.0}%", 100.0 * queue.waiting_share).into(),
        ];
        let stealing = other(Scheduler::WorkStealing, Portion::Batches);
        let boxes = PARALLEL.map(|scheduler| other(scheduler, Portion::Boxes));
        own.into_iter().chain(stealing).chain(boxes.into_iter().flatten()).collect()
    })
}

fn tasks(study: &Study) -> Table {
    let numbers = [
        "regions a step",
        "tasks a region",
        "share of the step",
        "mean",
        "shortest",
        "a tenth below",
        "half below",
        "a tenth above",
        "longest",
    ];
    let rows = study.tasks.iter().filter(|row| Some(row.instruction_set) == study.widest());
    Table::new(&["phase", "tasks are"], &numbers).of(rows, |row| {
        let phase = match row.stage {
            Some(stage) => format!("{}, stage {stage}", phase_name(row.phase)),
            None if row.most_tasks < 2 => format!("{}, serial", phase_name(row.phase)),
            None => phase_name(row.phase).into(),
        };
        let counts = [row.portion.name().into(), two_digits(row.regions), two_digits(row.tasks)];
        let durations = [row.mean, row.least, row.tenth, row.median, row.ninetieth, row.most].map(time);
        let share = format!("{:.1}%", 100.0 * row.share);
        [phase].into_iter().chain(counts).chain([share]).chain(durations).map(Cell::from).collect()
    })
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
