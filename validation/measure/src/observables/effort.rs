//! Limits on the work of a measure, proportional to the number of grains, independent of their sizes and positions.
//!
//! Grids cover the extents of frames, in cells of a grain's size. One distant grain, or one much larger than the
//! mean, would make a grid of any size from a few numbers. A measure above this limit is left out, like a measure of a
//! bed without a surface: the cells of a normal bed are fewer than [`most`] by orders of magnitude.

/// Cells available to any measure, for any number of grains.
const ANYWAY: usize = 1_000_000;

/// Cells, or cell updates, added per grain. A grain of the mean size reaches some tens.
const EACH: usize = 1_000;

/// Returns the largest number of cells of a grid, and of cell updates, for a number of grains.
pub fn most(grains: usize) -> usize {
    ANYWAY.saturating_add(EACH.saturating_mul(grains))
}

/// Returns true for a grain too large for its volume in one cell: this volume is a difference of parts of the whole sphere, each
/// rounded to some 1e-15 of it, and a cubic cell of a thousandth of the radius holds 1e-9 of that.
pub fn too_large(radius: f64, cell: f64) -> bool {
    radius > 1e3 * cell
}

#[cfg(test)]
#[path = "../../tests/unit/observables_effort.rs"]
mod tests;
