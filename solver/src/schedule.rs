//! Who relaxes which task when. Serial for now: stage by stage, box by box, which is the order that every scheduler keeps.

use crate::partition::Layout;
use crate::sweep::{GroupResidual, Relaxation};
use crate::world::Body;

/// Relaxes every task once; returns the summed residuals if they are measured.
pub(crate) fn sweep_serial(
    relaxation: &Relaxation,
    bodies: &mut [Body],
    layout: &mut Layout,
    factor: f64,
    measure: bool,
) -> GroupResidual {
    let mut total = GroupResidual::default();
    for task in &layout.tasks {
        let mut own = GroupResidual::default();
        let pairs = &mut layout.pairs[task.pairs.clone()];
        let walls = &mut layout.walls[task.walls.clone()];
        relaxation.sweep(bodies, pairs, walls, factor, measure, &mut own);
        if measure {
            total.merge(&own);
        }
    }
    total
}
