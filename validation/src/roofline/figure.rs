//! The roofline as a figure: operations a second over operations a byte, roofs as lines, sweeps as points.

use super::machine::Roofs;
use super::point::{Kernel, Point};
use super::study::Study;
use super::terminal::{kernel, threads};
use crate::draw::figure::Figure;
use crate::draw::names::{CodeStyle, Marker};
use crate::draw::numbers::two_digits;
use crate::draw::plot::{Axis, Key, Plot};
use crate::draw::svg::Anchor;

/// Range of the horizontal axis, operations a byte: sweeps lie between 0.5 and 0.7.
const INTENSITIES: (f64, f64) = (0.05, 10.0);
/// Factor between the heights of two names, so that they do not touch.
const LINE: f64 = 1.3;

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
    let kernels = [Kernel::Lanes, Kernel::Scalar];
    let kernels = kernels.into_iter().filter(|own| points.iter().any(|point| point.kernel == *own));
    let labels: Vec<(Kernel, String)> = kernels.map(|own| (own, format!("sweep, {}", kernel(study, own)))).collect();
    let mut plot = Plot::with_legend(
        Axis::fine("operations a byte", INTENSITIES.0, INTENSITIES.1),
        Axis::fine("operations a second (Gflop/s)", lowest, 1.3 * peak),
        &labels.iter().map(|(own, label)| Key::Points(style(*own), label)).collect::<Vec<_>>(),
    );
    for level in &roofs.levels {
        let slope = level.bytes_per_second / 1e9;
        let bend = peak / slope;
        let from = INTENSITIES.0;
        plot.curve("curve neutral", [[from, from * slope], [bend, peak]].into_iter());
        let words = format!("{} {} GB/s", level.name, two_digits(slope));
        plot.label_along([from, from * slope], [bend, peak], &words);
    }
    let first_bend = roofs.levels.iter().map(|level| peak * 1e9 / level.bytes_per_second).fold(f64::INFINITY, f64::min);
    plot.curve("curve neutral", [[first_bend, peak], [INTENSITIES.1, peak]].into_iter());
    let words = format!("peak {} Gflop/s ({}, not fused)", two_digits(peak), study.instruction_set);
    plot.label([INTENSITIES.1, peak], [-6.0, -6.0], Anchor::End, &words);
    // Names of lanes to the right and of scalar sweeps to the left, pushed down where they would lie on each other.
    for (own, side, anchor) in [(Kernel::Lanes, 9.0, Anchor::Start), (Kernel::Scalar, -9.0, Anchor::End)] {
        let mut points: Vec<&&Point> = points.iter().filter(|point| point.kernel == own).collect();
        points.sort_by(|a, b| b.flops_per_second.total_cmp(&a.flops_per_second));
        let mut lowest = f64::INFINITY;
        for point in points {
            let at = [point.flops_per_byte, point.flops_per_second / 1e9];
            plot.marker(style(own), at[0], at[1], 4.2);
            lowest = at[1].min(lowest / LINE);
            plot.label([at[0], lowest], [side, 4.0], anchor, &point.scene);
        }
    }
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
