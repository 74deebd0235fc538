//! Figures 5.1 to 5.6 of the thesis: wall time per step and speed-up against threads, in pairs, for the schedulers on this machine, on
//! the model of the thesis's machine, and for the instruction sets. Points are measured, lines replayed.

use super::replay::Machine;
use super::study::{Study, site};
use super::{MeasuredRow, ReplayedRow};
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

pub(super) fn figures(study: &Study) -> Vec<[Figure; 2]> {
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
        all.push(pair(&machine.name, &about, machine, &all_ways, serial.map(|row| row.step_seconds)));
    }
    if let Some(here) = study.machines.first() {
        let mut sets: Vec<InstructionSet> = study.measured.iter().map(|row| row.instruction_set).collect();
        sets.dedup();
        let way = (Scheduler::WorkStealing, Portion::Batches);
        let all_sets: Vec<Series<'_>> =
            sets.into_iter().map(|set| Series::of(study, here, way, set, set_style(set), set.name())).collect();
        let about = format!("work stealing with each instruction set on {}", site(here, ""));
        all.push(pair("instruction-sets", &about, here, &all_sets, None));
    }
    all
}

/// Draws wall time and speed-up of the same series. `serial` is the time of one thread without a scheduler, s.
fn pair(name: &str, about: &str, machine: &Machine, series: &[Series<'_>], serial: Option<f64>) -> [Figure; 2] {
    let most = machine.most_workers() as f64;
    let measured = series.iter().any(|series| !series.points.is_empty());
    let how = if measured { "points: measured; lines: replayed" } else { "all replayed" };
    let legend = match measured {
        true => "Points are measured, lines are replayed.",
        false => {
            "Everything here is replayed; nothing was measured on such a machine. In the shaded range threads share cores."
        }
    };
    let finished = |plot: Plot, kind: &str, about: String| Figure {
        name: format!("{name}-{kind}"),
        caption: format!("{about}. {legend}"),
        svg: plot.finish(&about),
    };

    let measured_times = |row: &&MeasuredRow| [row.step_seconds_least, row.step_seconds, row.step_seconds_most];
    let times = series.iter().flat_map(|series| {
        series.line.iter().map(|row| row.step_seconds).chain(series.points.iter().flat_map(measured_times))
    });
    // Room below for words.
    let (least, longest) = times.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), t| (a.min(t), b.max(t)));
    let seconds = Axis::fine("time a step (ms)", 700.0 * least, 1e3 * longest);
    let mut plot = plot_of(series, machine, seconds, |threads| serial.map(|serial| 1e3 * serial / threads));
    for (place, series) in series.iter().enumerate() {
        let line = series.line.iter().map(|row| [row.workers as f64, 1e3 * row.step_seconds]);
        plot.curve(&format!("{} curve", series.style.class), line);
        for row in &series.points {
            let [low, middle, high] = measured_times(row).map(|seconds| 1e3 * seconds);
            plot.error_bar(&format!("{} error", series.style.class), row.threads as f64, low, high);
            plot.marker(series.style, row.threads as f64, middle, size(place));
        }
    }
    plot.remark(false, how);
    let time = finished(plot, "time", format!("Wall time a step against threads: {about}"));

    let speedups = series.iter().flat_map(|series| {
        series.line.iter().map(|row| row.speedup).chain(series.points.iter().map(|row| row.speedup))
    });
    // Speed-ups below one have their place too.
    let slowest = speedups.fold(1.0, f64::min).log2().floor().exp2();
    let mut plot = plot_of(series, machine, Axis::doublings("speed-up", slowest, most), Some);
    for (place, series) in series.iter().enumerate() {
        let line = series.line.iter().map(|row| [row.workers as f64, row.speedup]);
        plot.curve(&format!("{} curve", series.style.class), line);
        series.points.iter().for_each(|row| plot.marker(series.style, row.threads as f64, row.speedup, size(place)));
    }
    plot.remark(true, how);
    [time, finished(plot, "speedup", format!("Speed-up over one serial thread against threads: {about}"))]
}

/// Size of the markers of a series: earlier ones are larger, so that they show behind later ones.
fn size(place: usize) -> f64 {
    6.0 - 1.2 * place as f64
}

/// Makes a plot against numbers of threads, with a legend, the range of shared cores and the ideal line.
fn plot_of(series: &[Series<'_>], machine: &Machine, y: Axis, ideal: impl Fn(f64) -> Option<f64>) -> Plot {
    let most = machine.most_workers() as f64;
    let classes: Vec<String> = series.iter().map(|series| format!("{} curve", series.style.class)).collect();
    let keys = series.iter().zip(&classes).map(|(series, class)| match series.points.is_empty() {
        true => Key::Line(class, &series.label),
        false => Key::Series(series.style, &series.label),
    });
    let ends: Vec<[f64; 2]> = [1.0, most].into_iter().filter_map(|threads| Some([threads, ideal(threads)?])).collect();
    let keys: Vec<Key<'_>> = keys.chain((!ends.is_empty()).then_some(Key::Line("ideal", "ideal"))).collect();
    let mut plot = Plot::with_legend(Axis::doublings("threads", 1.0, most), y, &keys);
    if machine.cores < machine.most_workers() {
        plot.window(machine.cores as f64, most, "cores shared");
    }
    plot.curve("ideal", ends.into_iter());
    plot
}
