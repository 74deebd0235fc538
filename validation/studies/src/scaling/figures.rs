//! Figures 5.1 to 5.6 of the thesis: wall time per step and speed-up against threads, in pairs. Curves for schedulers on this machine, on
//! the model of the thesis's machine, and for the instruction sets. Points are measured, lines replayed.

use super::replay::{Machine, ReplayedRow};
use super::study::{MeasuredRow, Study, site};
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::Scheduler;
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{CodeStyle, Marker};
use makadam_view::draw::plot::{Axis, Key, Plot};

/// One curve: a replayed line, and measured points if there are any.
struct Series<'a> {
    style: CodeStyle,
    label: String,
    line: Vec<&'a ReplayedRow>,
    points: Vec<&'a MeasuredRow>,
}

impl<'a> Series<'a> {
    fn of(
        study: &'a Study,
        machine: &'a Machine,
        way: (Scheduler, Portion),
        set: InstructionSet,
        style: CodeStyle,
        label: &str,
    ) -> Series<'a> {
        let here = machine.name == Machine::HERE;
        let own = |row: &&MeasuredRow| here && (row.scheduler, row.portion) == way && row.instruction_set == set;
        Series {
            style,
            label: label.into(),
            line: study.curve(machine, way, Some(set)).collect(),
            points: study.measured.iter().filter(own).collect(),
        }
    }
}

/// Schedulers and portions, each with the label and the class of its curve.
const WAYS: [(Scheduler, Portion, &str, &str); 4] = [
    (Scheduler::CentralQueue, Portion::Batches, "queue, batches", "scheduler-central-queue"),
    (Scheduler::WorkStealing, Portion::Batches, "stealing, batches", "scheduler-work-stealing"),
    (Scheduler::CentralQueue, Portion::Boxes, "queue, boxes", "scheduler-central-queue-boxes"),
    (Scheduler::WorkStealing, Portion::Boxes, "stealing, boxes", "scheduler-work-stealing-boxes"),
];

fn set_style(set: InstructionSet) -> CodeStyle {
    match set {
        InstructionSet::Generic => CodeStyle { class: "set-generic", marker: Marker::Triangle },
        InstructionSet::Avx2 => CodeStyle { class: "set-avx2", marker: Marker::Square },
        InstructionSet::Avx512 => CodeStyle { class: "set-avx512", marker: Marker::Circle },
    }
}

/// Quantity against threads.
struct Quantity {
    name: &'static str,
    title: &'static str,
    replayed: fn(&ReplayedRow) -> f64,
    /// Minimum, median and maximum.
    measured: fn(&MeasuredRow) -> [f64; 3],
}

const TIME: Quantity = Quantity {
    name: "time",
    title: "Wall time a step",
    replayed: |row| 1e3 * row.step_seconds,
    measured: |row| [row.step_seconds_least, row.step_seconds, row.step_seconds_most].map(|seconds| 1e3 * seconds),
};

const SPEEDUP: Quantity = Quantity {
    name: "speedup",
    title: "Speed-up over one serial thread",
    replayed: |row| row.speedup,
    measured: |row| [row.speedup; 3],
};

pub(super) fn figures(study: &Study) -> Vec<Figure> {
    let Some(set) = study.widest() else { return Vec::new() };
    let mut all = Vec::new();
    for machine in &study.machines {
        let of_way = |&(scheduler, portion, label, class): &(Scheduler, Portion, &str, &'static str)| {
            let marker = if scheduler == Scheduler::CentralQueue { Marker::Square } else { Marker::Circle };
            Series::of(study, machine, (scheduler, portion), set, CodeStyle { class, marker }, label)
        };
        let all_ways: Vec<Series<'_>> = WAYS.iter().map(of_way).collect();
        let serial = study.curve(machine, (Scheduler::Serial, Portion::Batches), Some(set)).next();
        let about = format!("the two schedulers on {}, {}", site(machine, ""), set.name());
        all.extend(pair(&machine.name, &about, machine, &all_ways, serial.map(TIME.replayed)));
    }
    if let Some(here) = study.machines.first() {
        let mut sets: Vec<InstructionSet> = study.measured.iter().map(|row| row.instruction_set).collect();
        sets.dedup();
        let way = (Scheduler::WorkStealing, Portion::Batches);
        let all_sets: Vec<Series<'_>> =
            sets.into_iter().map(|set| Series::of(study, here, way, set, set_style(set), set.name())).collect();
        let about = format!("work stealing with each instruction set on {}", site(here, ""));
        all.extend(pair("instruction-sets", &about, here, &all_sets, None));
    }
    all
}

/// Draws wall time and speed-up of the same series. `serial` is the time of one thread without a scheduler, ms.
fn pair(name: &str, about: &str, machine: &Machine, series: &[Series<'_>], serial: Option<f64>) -> [Figure; 2] {
    let most = machine.most_workers() as f64;
    let is_measured = series.iter().any(|series| !series.points.is_empty());
    let (how, legend) = match is_measured {
        true => ("points: measured; lines: replayed", "Points are measured, lines are replayed."),
        false => (
            "all replayed",
            "Everything here is replayed; nothing was measured on such a machine. In the shaded range threads share cores.",
        ),
    };
    [TIME, SPEEDUP].map(|quantity| {
        let is_time = quantity.name == TIME.name;
        let values = series.iter().flat_map(|series| {
            let lines = series.line.iter().map(|row| (quantity.replayed)(row));
            lines.chain(series.points.iter().flat_map(|row| (quantity.measured)(row)))
        });
        let (least, longest) = values.fold((f64::INFINITY, 0.0_f64), |(a, b), value| (a.min(value), b.max(value)));
        let (axis, ideal) = if is_time {
            // Space below for text.
            (Axis::fine("time a step (ms)", 0.7 * least, longest), serial.map(|serial| [serial, serial / most]))
        } else {
            // The axis includes speed-ups below one, too.
            (Axis::doublings("speed-up", least.min(1.0).log2().floor().exp2(), most), Some([1.0, most]))
        };
        let mut plot = plot_of(series, machine, axis, ideal);
        for (place, series) in series.iter().enumerate() {
            let class = series.style.class;
            let line = series.line.iter().map(|row| [row.workers as f64, (quantity.replayed)(row)]);
            plot.curve(&format!("{class} curve"), line);
            for row in &series.points {
                let (threads, [low, middle, high]) = (row.threads as f64, (quantity.measured)(row));
                if low < high {
                    plot.error_bar(&format!("{class} error"), threads, low, high);
                }
                // Earlier markers are larger, so that they are visible behind later ones.
                plot.marker(series.style, threads, middle, 6.0 - 1.2 * place as f64);
            }
        }
        plot.remark(!is_time, how);
        let about = format!("{} against threads: {about}", quantity.title);
        Figure {
            name: format!("{name}-{}", quantity.name),
            caption: format!("{about}. {legend}"),
            svg: plot.finish(&about),
        }
    })
}

/// Makes a plot against numbers of threads, with a legend, the range of shared cores and the ideal line between its ends.
fn plot_of(series: &[Series<'_>], machine: &Machine, y: Axis, ideal: Option<[f64; 2]>) -> Plot {
    let most = machine.most_workers() as f64;
    let classes: Vec<String> = series.iter().map(|series| format!("{} curve", series.style.class)).collect();
    let keys = series.iter().zip(&classes).map(|(series, class)| match series.points.is_empty() {
        true => Key::Line(class, &series.label),
        false => Key::Series(series.style, &series.label),
    });
    let keys: Vec<Key<'_>> = keys.chain(ideal.map(|_| Key::Line("ideal", "ideal"))).collect();
    let mut plot = Plot::with_legend(Axis::doublings("threads", 1.0, most), y, &keys);
    if machine.cores < machine.most_workers() {
        plot.window(machine.cores as f64, most, "cores shared");
    }
    plot.curve("ideal", ideal.into_iter().flat_map(|[first, last]| [[1.0, first], [most, last]]));
    plot
}
