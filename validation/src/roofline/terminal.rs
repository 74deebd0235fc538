//! A study as plain text for a terminal.

use super::point::{Kernel, Point};
use super::study::Study;
use crate::draw::numbers::two_digits;
use crate::study::{Cell, Table};

/// Roofs, and the sweeps beneath them.
pub fn table(study: &Study) -> String {
    let giga = |value: f64| two_digits(value / 1e9);
    let mut text = String::new();
    for roofs in &study.roofs {
        let levels = roofs.levels.iter().map(|level| format!("{} {} GB/s", level.name, giga(level.bytes_per_second)));
        text += &format!(
            "{}: peak {} Gflop/s, {}; in memory triad {} GB/s, copy {} GB/s\n",
            threads(roofs.threads),
            giga(roofs.peak_flops_per_second),
            levels.collect::<Vec<_>>().join(", "),
            giga(roofs.triad_bytes_per_second),
            giga(roofs.copy_bytes_per_second),
        );
    }
    text.push('\n');
    text += &sweeps(study).text();
    text + "\nM/s: million contact sweeps a second; flop and byte: of one contact sweep.\n"
}

/// The sweeps: the same on a terminal and on the page.
pub(super) fn sweeps(study: &Study) -> Table {
    Table::new(
        &["scene", "kernel", "lives in"],
        &["threads", "M/s", "ns", "flop", "byte", "Gflop/s", "GB/s", "of roof"],
    )
    .on_a_page(&[
        "million contact sweeps a second",
        "ns each",
        "operations each",
        "bytes each",
        "Gflop/s",
        "GB/s",
        "of its roof",
    ])
    .of(&study.points, |point| cells(study, point))
}

fn cells(study: &Study, point: &Point) -> Vec<Cell> {
    vec![
        point.scene.as_str().into(),
        kernel(study, point.kernel).into(),
        point.home.as_str().into(),
        point.threads.into(),
        format!("{:.1}", point.contact_sweeps_per_second / 1e6).into(),
        format!("{:.2}", point.nanoseconds_per_contact_sweep).into(),
        format!("{:.1}", point.flops_per_contact_sweep).into(),
        format!("{:.0}", point.bytes_per_contact_sweep).into(),
        format!("{:.2}", point.flops_per_second / 1e9).into(),
        format!("{:.1}", point.bytes_per_second / 1e9).into(),
        format!("{:.0}%", 100.0 * point.share_of_roof).into(),
    ]
}

/// A kernel's name.
pub(super) fn kernel(study: &Study, kernel: Kernel) -> String {
    match kernel {
        Kernel::Scalar => "scalar".into(),
        Kernel::Lanes => study.instruction_set.clone(),
    }
}

/// A number of threads in words.
pub(super) fn threads(count: usize) -> String {
    if count == 1 { "one thread".into() } else { format!("{count} threads") }
}
