//! The roofline as a figure: operations a second over operations a byte, roofs as lines, sweeps as points.

use super::machine::Roofs;
use super::point::{Kernel, Point};
use super::study::Study;
use super::terminal::{kernel, threads};
use crate::report::names::{CodeStyle, Marker};
use crate::report::numbers::two_digits;
use crate::report::plot::{Axis, Key, Plot};
use crate::report::svg::Anchor;
use serde::Serialize;

/// A finished figure.
#[derive(Serialize)]
pub(super) struct Figure {
    /// Name of its file, without the ending.
    pub(super) name: String,
    /// The drawing.
    pub(super) svg: String,
    /// What it shows.
    pub(super) caption: String,
}

/// Range of the horizontal axis, operations a byte: sweeps lie between 0.5 and 0.7.
const INTENSITIES: (f64, f64) = (0.05, 10.0);
/// Points nearer than this factor share a label.
const NEAR: f64 = 1.12;

fn style(kernel: Kernel) -> CodeStyle {
    match kernel {
        Kernel::Lanes => CodeStyle { class: "code-makadam", marker: Marker::Circle },
        Kernel::Scalar => CodeStyle { class: "code-yade", marker: Marker::Triangle },
    }
}

/// The figure of one number of threads.
pub(super) fn figure(study: &Study, roofs: &Roofs) -> Figure {
    let points: Vec<&Point> = study.points.iter().filter(|point| point.threads == roofs.threads).collect();
    let peak = roofs.peak_flops_per_second / 1e9;
    let rates = points.iter().map(|point| point.flops_per_second / 1e9);
    let slowest = roofs.levels.iter().map(|level| level.bytes_per_second / 1e9).fold(f64::INFINITY, f64::min);
    let lowest = rates.fold(slowest * INTENSITIES.0, f64::min) / 1.3;
    let mut plot = Plot::new(
        Axis::fine("operations a byte", INTENSITIES.0, INTENSITIES.1),
        Axis::fine("operations a second (Gflop/s)", lowest, 1.3 * peak),
    );
    let mut keys: Vec<Kernel> = Vec::new();
    for level in &roofs.levels {
        let slope = level.bytes_per_second / 1e9;
        let bend = peak / slope;
        let from = INTENSITIES.0;
        plot.curve("curve neutral", [[from, from * slope], [bend, peak]].into_iter());
        // Named where the line comes in, to the right of it, so that it rises past the words.
        let words = format!("{} {} GB/s", level.name, two_digits(slope));
        plot.label([from, from * slope], [6.0, 14.0], Anchor::Start, &words);
    }
    let first_bend = roofs.levels.iter().map(|level| peak * 1e9 / level.bytes_per_second).fold(f64::INFINITY, f64::min);
    plot.curve("curve neutral", [[first_bend, peak], [INTENSITIES.1, peak]].into_iter());
    let words = format!("peak {} Gflop/s ({}, not fused)", two_digits(peak), study.instruction_set);
    plot.label([INTENSITIES.1, peak], [-6.0, -6.0], Anchor::End, &words);
    let mut named: Vec<(Vec<&str>, Vec<&Point>)> = Vec::new();
    for point in points {
        plot.marker(style(point.kernel), point.flops_per_byte, point.flops_per_second / 1e9, 4.2);
        if !keys.contains(&point.kernel) {
            keys.push(point.kernel);
        }
        let near = |other: &&Point| {
            let ratio = other.flops_per_second / point.flops_per_second;
            (1.0 / NEAR..NEAR).contains(&ratio)
        };
        match named.iter_mut().find(|(_, others)| others.iter().any(near)) {
            Some((names, others)) => {
                names.push(&point.scene);
                others.push(point);
            }
            None => named.push((vec![&point.scene], vec![point])),
        }
    }
    for (names, points) in &named {
        let mean = |of: fn(&Point) -> f64| points.iter().map(|point| of(point)).sum::<f64>() / points.len() as f64;
        let most = points.iter().map(|point| point.flops_per_byte).fold(0.0, f64::max);
        let rate = mean(|point| point.flops_per_second / 1e9);
        plot.label([most, rate], [9.0, 4.0], Anchor::Start, &names.join(", "));
    }
    let labels: Vec<String> = keys.iter().map(|&own| format!("sweep, {}", kernel(study, own))).collect();
    let keys: Vec<Key<'_>> = keys.iter().zip(&labels).map(|(&own, label)| Key::Points(style(own), label)).collect();
    plot.legend(&keys);
    let title = format!("Roofline of the sweep, {}", threads(roofs.threads));
    Figure {
        name: format!("roofline-{}", roofs.threads),
        svg: plot.finish(&title),
        caption: format!(
            "{title}. Lines: what each memory delivers (update in place) times operations a byte, and the peak of \
             multiplications and additions. Points: measured sweeps; the roof of a point is the line of the memory that \
             holds the scene."
        ),
    }
}
