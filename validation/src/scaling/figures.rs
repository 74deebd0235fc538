//! The figures, in the form of the thesis's figures 5.1 to 5.6: wall time a step and speed-up against threads, in pairs.
//! Points are measured, lines replayed.

use super::findings::curve_rows;
use super::machine::{MOST_WORKERS, Machine};
use super::rows::{MeasuredRow, ReplayedRow};
use super::study::Study;
use crate::draw::figure::Figure;
use crate::draw::names::{CodeStyle, Marker};
use crate::draw::plot::{Axis, Key, Plot};
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::Scheduler;

/// One curve: a replayed line, and measured points where there are any.
struct Series {
    style: CodeStyle,
    label: String,
    line: Vec<Point>,
    points: Vec<Bar>,
}

/// A replayed point: threads, time a step in s, speed-up.
struct Point {
    threads: f64,
    seconds: f64,
    speedup: f64,
}

/// A measured point: threads, time a step in s with its range over repetitions, speed-up.
struct Bar {
    threads: f64,
    seconds: [f64; 3],
    speedup: f64,
}

/// The ways to hand out work, each with its label and the class of its curve.
const WAYS: [(Scheduler, Portion, &str, &str); 4] = [
    (Scheduler::CentralQueue, Portion::Batches, "queue, batches", "scheduler-central-queue"),
    (Scheduler::WorkStealing, Portion::Batches, "stealing, batches", "scheduler-work-stealing"),
    (Scheduler::CentralQueue, Portion::Boxes, "queue, boxes", "scheduler-central-queue-boxes"),
    (Scheduler::WorkStealing, Portion::Boxes, "stealing, boxes", "scheduler-work-stealing-boxes"),
];

fn marker(scheduler: Scheduler) -> Marker {
    if scheduler == Scheduler::CentralQueue { Marker::Square } else { Marker::Circle }
}

fn set_style(set: InstructionSet) -> CodeStyle {
    match set {
        InstructionSet::Generic => CodeStyle { class: "set-generic", marker: Marker::Triangle },
        InstructionSet::Avx2 => CodeStyle { class: "set-avx2", marker: Marker::Square },
        InstructionSet::Avx512 => CodeStyle { class: "set-avx512", marker: Marker::Circle },
    }
}

/// All figures of a study, in pairs.
pub(super) fn figures(study: &Study) -> Vec<[Figure; 2]> {
    let Some(set) = study.widest() else { return Vec::new() };
    let mut all = Vec::new();
    for (number, machine) in study.machines.iter().enumerate() {
        let series: Vec<Series> = WAYS
            .iter()
            .map(|&(scheduler, portion, label, class)| Series {
                style: CodeStyle { class, marker: marker(scheduler) },
                label: label.into(),
                line: line(study, machine, (scheduler, portion), set),
                points: if number == 0 { points(study, (scheduler, portion), set) } else { Vec::new() },
            })
            .collect();
        let serial = curve_rows(study, machine, Scheduler::Serial, Portion::Batches).next().map(|row| row.step_seconds);
        let about = format!("the two schedulers on {}, {}", site(machine, ""), set.name());
        all.push(pair(&machine.name, &about, machine, &series, serial));
    }
    if let Some(here) = study.machines.first() {
        let mut sets: Vec<InstructionSet> = study.measured.iter().map(|row| row.instruction_set).collect();
        sets.dedup();
        let series: Vec<Series> = sets
            .into_iter()
            .map(|set| Series {
                style: set_style(set),
                label: set.name().into(),
                line: line(study, here, (Scheduler::WorkStealing, Portion::Batches), set),
                points: points(study, (Scheduler::WorkStealing, Portion::Batches), set),
            })
            .collect();
        let about = format!("work stealing with each instruction set on {}", site(here, ""));
        all.push(pair("instruction-sets", &about, here, &series, None));
    }
    all
}

/// A machine in a sentence; this one with a word more.
pub(super) fn site(machine: &Machine, more: &str) -> String {
    if machine.name == Machine::HERE { format!("this machine{more}") } else { format!("the model {}", machine.name) }
}

fn line(study: &Study, machine: &Machine, way: (Scheduler, Portion), set: InstructionSet) -> Vec<Point> {
    let own = |row: &&ReplayedRow| {
        row.machine == machine.name && (row.scheduler, row.portion) == way && row.instruction_set == set
    };
    (study.replayed.iter().filter(own))
        .map(|row| Point { threads: row.workers as f64, seconds: row.step_seconds, speedup: row.speedup })
        .collect()
}

fn points(study: &Study, way: (Scheduler, Portion), set: InstructionSet) -> Vec<Bar> {
    let own = |row: &&MeasuredRow| (row.scheduler, row.portion) == way && row.instruction_set == set;
    (study.measured.iter().filter(own))
        .map(|row| Bar {
            threads: row.threads as f64,
            seconds: [row.step_seconds_least, row.step_seconds, row.step_seconds_most],
            speedup: row.speedup,
        })
        .collect()
}

/// Wall time and speed-up of the same series. `serial` is what one thread takes without any scheduler, s.
fn pair(name: &str, about: &str, machine: &Machine, series: &[Series], serial: Option<f64>) -> [Figure; 2] {
    let most = machine.most_workers().min(MOST_WORKERS) as f64;
    let measured = series.iter().any(|series| !series.points.is_empty());
    let how = if measured { "points: measured; lines: replayed" } else { "all replayed" };
    let times = series
        .iter()
        .flat_map(|series| series.line.iter().map(|p| p.seconds).chain(series.points.iter().flat_map(|p| p.seconds)));
    // Some room below for words.
    let (least, longest) = times.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), t| (a.min(t), b.max(t)));

    let seconds = Axis::fine("time a step (ms)", 700.0 * least, 1e3 * longest);
    let mut plot = plot_of(series, serial.is_some(), most, seconds);
    window(&mut plot, machine);
    ideal(&mut plot, most, |threads| serial.map(|serial| 1e3 * serial / threads));
    for (place, series) in series.iter().enumerate() {
        plot.curve(&format!("{} curve", series.style.class), series.line.iter().map(|p| [p.threads, 1e3 * p.seconds]));
        for point in &series.points {
            let [low, middle, high] = point.seconds.map(|seconds| 1e3 * seconds);
            plot.error_bar(&format!("{} error", series.style.class), point.threads, low, high);
            plot.marker(series.style, point.threads, middle, size(place));
        }
    }
    plot.remark(false, how);
    let time = Figure {
        name: format!("{name}-time"),
        svg: plot.finish(&format!("time a step against threads: {about}")),
        caption: format!("Wall time a step against threads: {about}. {}", legend_words(measured, true)),
    };

    let speedups = series
        .iter()
        .flat_map(|series| series.line.iter().map(|p| p.speedup).chain(series.points.iter().map(|p| p.speedup)));
    // What is slower than one serial thread has its place too.
    let slowest = speedups.fold(1.0, f64::min).log2().floor().exp2();
    let mut plot = plot_of(series, true, most, Axis::doublings("speed-up", slowest, most));
    window(&mut plot, machine);
    ideal(&mut plot, most, Some);
    for (place, series) in series.iter().enumerate() {
        plot.curve(&format!("{} curve", series.style.class), series.line.iter().map(|p| [p.threads, p.speedup]));
        for point in &series.points {
            plot.marker(series.style, point.threads, point.speedup, size(place));
        }
    }
    plot.remark(true, how);
    let speedup = Figure {
        name: format!("{name}-speedup"),
        svg: plot.finish(&format!("speed-up against threads: {about}")),
        caption: format!("Speed-up over one serial thread against threads: {about}. {}", legend_words(measured, false)),
    };
    [time, speedup]
}

/// Shades the numbers of threads at which cores are shared.
fn window(plot: &mut Plot, machine: &Machine) {
    if machine.cores < machine.most_workers() {
        plot.window(machine.cores as f64, machine.most_workers() as f64, "cores shared");
    }
}

/// Size of the markers of a series: earlier ones are larger, so that they show behind later ones.
fn size(place: usize) -> f64 {
    6.0 - 1.2 * place as f64
}

fn ideal(plot: &mut Plot, most: f64, value: impl Fn(f64) -> Option<f64>) {
    let ends = [1.0, most].into_iter().filter_map(|threads| Some([threads, value(threads)?]));
    plot.curve("ideal", ends);
}

/// A frame against numbers of threads, with a legend of the series above it.
fn plot_of(series: &[Series], ideal: bool, most: f64, y: Axis) -> Plot {
    let classes: Vec<String> = series.iter().map(|series| format!("{} curve", series.style.class)).collect();
    let mut keys: Vec<Key<'_>> = series
        .iter()
        .zip(&classes)
        .map(|(series, class)| match series.points.is_empty() {
            true => Key::Line(class, &series.label),
            false => Key::Series(series.style, &series.label),
        })
        .collect();
    if ideal {
        keys.push(Key::Line("ideal", "ideal"));
    }
    Plot::with_legend(Axis::doublings("threads", 1.0, most), y, &keys)
}

fn legend_words(measured: bool, bars: bool) -> String {
    match (measured, bars) {
        (true, true) => "Points are measured (bars: fastest and slowest repetition), lines are replayed.".into(),
        (true, false) => "Points are measured, lines are replayed.".into(),
        (false, _) => "Everything here is replayed; nothing was measured on such a machine. In the shaded range threads share cores.".into(),
    }
}
