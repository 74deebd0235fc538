//! Limits on the work of a measure, in proportion to the number of grains, whatever their sizes and places.
//!
//! Grids are laid over extents that frames give, in cells of a grain's size. One grain far off, or one much larger than the
//! mean, would make a grid of any size from a few numbers. A measure that would need more than this is left out, as one is
//! whose bed has no surface: the cells of a sane bed are fewer than [`most`] by orders of magnitude.

/// Cells that any measure may use, however few the grains.
const ANYWAY: usize = 1_000_000;

/// Cells, or visits of grains to cells, that each grain adds. A grain of the mean size reaches some tens.
const EACH: usize = 1_000;

/// Most cells of a grid for so many grains, and most visits of these to cells.
pub fn most(grains: usize) -> usize {
    ANYWAY.saturating_add(EACH.saturating_mul(grains))
}

/// Returns true for a grain whose volume in one cell is lost to rounding: that is a difference of parts of the whole sphere, each
/// rounded to some 1e-15 of it, and a cubic cell of a thousandth of the radius holds 1e-9 of that.
pub fn too_large(radius: f64, cell: f64) -> bool {
    radius > 1e3 * cell
}

#[cfg(test)]
#[path = "../../tests/unit/observables_effort.rs"]
mod tests;
