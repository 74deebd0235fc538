//! A study as plain text for a terminal.

use super::point::{Kernel, Point};
use super::study::Study;
use crate::draw::columns;
use crate::draw::numbers::two_digits;

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
    let heads = ["scene", "kernel", "lives in", "threads", "M/s", "ns", "flop", "byte", "Gflop/s", "GB/s", "of roof"];
    let mut rows = vec![heads.map(String::from)];
    rows.extend(study.points.iter().map(|point| cells(study, point)));
    text.push('\n');
    text += &columns(&rows, |column| column < 3);
    text + "\nM/s: million contact sweeps a second; flop and byte: of one contact sweep.\n"
}

/// A row of the table: the same on a terminal and on the page.
pub(super) fn cells(study: &Study, point: &Point) -> [String; 11] {
    [
        point.scene.clone(),
        kernel(study, point.kernel),
        point.home.clone(),
        point.threads.to_string(),
        format!("{:.1}", point.contact_sweeps_per_second / 1e6),
        format!("{:.2}", point.nanoseconds_per_contact_sweep),
        format!("{:.1}", point.flops_per_contact_sweep),
        format!("{:.0}", point.bytes_per_contact_sweep),
        format!("{:.2}", point.flops_per_second / 1e9),
        format!("{:.1}", point.bytes_per_second / 1e9),
        format!("{:.0}%", 100.0 * point.share_of_roof),
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
