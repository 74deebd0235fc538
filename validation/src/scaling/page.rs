//! The files of a study: its rows, its figures, and a page with tables and what they say.

use super::answer::answer;
use super::figures::{figures, site};
use super::findings::{LINEAR_SHARE, PARALLEL, curve_rows, curves, time};
use super::machine::Machine;
use super::study::Study;
use crate::draw::figure::Figure;
use crate::draw::numbers::{count, two_digits};
use crate::study::{Cell, Document, DocumentError, File, Table, cells, json, page, table};
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
            table("machine", &[self.machine()])?,
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
            answer => answer(self),
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

/// Measured configurations: the same on a terminal and on the page.
pub(super) fn measured(study: &Study) -> Table {
    let numbers = ["threads", "a step", "speed-up", "sweeps", "speed-up", "ns"];
    let mut table = Table::new(&CONFIGURATION, &numbers).on_a_page(&[
        "wall time per step",
        "speed-up",
        "of it sweeps",
        "speed-up of the sweeps",
        "contact sweep (ns)",
    ]);
    for row in &study.measured {
        let range = format!("{} to {}", time(row.step_seconds_least), time(row.step_seconds_most));
        let cells = cells![
            row.instruction_set.name(),
            row.scheduler.name(),
            row.portion.name(),
            row.threads,
            Cell::from(time(row.step_seconds)).above(Some(range)),
            format!("{:.2}", row.speedup),
            time(row.sweep_seconds),
            format!("{:.2}", row.sweep_speedup),
            row.nanoseconds_per_contact_sweep.map(two_digits),
        ];
        push(&mut table, row.scheduler, cells);
    }
    table
}

/// The replay beside the measurement: the same on a terminal and on the page.
pub(super) fn checks(study: &Study) -> Table {
    let numbers = ["threads", "measured", "replayed", "deviation", "tasks", "from them", "deviation"];
    let mut table =
        Table::new(&CONFIGURATION, &numbers).on_a_page(&["its tasks, over serial", "replayed from them", "deviation"]);
    for check in &study.checks {
        let cells = cells![
            check.instruction_set.name(),
            check.scheduler.name(),
            check.portion.name(),
            check.threads,
            time(check.measured_seconds),
            time(check.replayed_seconds),
            signed_percent(check.deviation_percent),
            signed_percent(100.0 * (check.task_time_ratio - 1.0)),
            time(check.replayed_from_own_tasks_seconds),
            signed_percent(check.own_tasks_deviation_percent),
        ];
        push(&mut table, check.scheduler, cells);
    }
    table
}
/// A deviation with its sign and a true minus.
fn signed_percent(percent: f64) -> String {
    format!("{percent:+.1}%").replace('-', "−")
}

fn machines(study: &Study) -> Vec<Value> {
    let rows = study.machines.iter().map(|machine| {
        let costs = machine.costs;
        context! {
            title => site(machine, " with more cores"),
            description => machine.description,
            costs => [
                ("pop of the queue, alone", costs.pop_alone),
                ("pop of the queue, contended", costs.pop_contended),
                ("beginning a task", costs.task_start),
                ("stealing", costs.steal),
                ("opening and closing a region", costs.region),
            ].map(|(name, seconds)| (name, time(seconds))),
            curves => curves(study, machine).html(),
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
    let rows = curve_rows(study, machine, Scheduler::CentralQueue, Portion::Batches);
    let rows = rows.filter(|row| SHOWN.contains(&row.workers));
    Table::new(&[], &numbers).of(rows, |queue| {
        let other = |scheduler, portion| {
            let found = curve_rows(study, machine, scheduler, portion).find(|row| row.workers == queue.workers);
            cells![found.map(|row| time(row.step_seconds)), found.map(|row| two_digits(row.speedup))]
        };
        let waiting = format!("{:.0}%", 100.0 * queue.waiting_share);
        let mut cells = cells![queue.workers, time(queue.step_seconds), two_digits(queue.speedup), waiting];
        cells.extend(other(Scheduler::WorkStealing, Portion::Batches));
        cells.extend(PARALLEL.into_iter().flat_map(|scheduler| other(scheduler, Portion::Boxes)));
        cells
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
        let name = match row.phase {
            Phase::Detect => "detect",
            Phase::Constrain => "constrain",
            Phase::Sweep => "sweep",
            Phase::Integrate => "integrate",
        };
        let phase = match row.stage {
            Some(stage) => format!("{name}, stage {stage}"),
            None if row.most_tasks < 2 => format!("{name}, serial"),
            None => name.into(),
        };
        let counts = [row.portion.name().into(), two_digits(row.regions), two_digits(row.tasks)];
        let durations = [row.mean, row.least, row.tenth, row.median, row.ninetieth, row.most].map(time);
        let share = format!("{:.1}%", 100.0 * row.share);
        [phase].into_iter().chain(counts).chain([share]).chain(durations).map(Cell::from).collect()
    })
}
