//! The bed of the chute: spheres that do not move.

use super::{DIAMETER, PERIOD};

/// Rows of the spheres that the bed is made of, along and across: about 1.2 diameters apart.
const ROWS: [usize; 2] = [10, 7];
/// How far they are shifted from their lattice at most, along, across and upwards, in diameters: an even bed would let layers slide.
const SHIFT: [f64; 3] = [0.12, 0.12, 0.2];

/// Centres of the bed's spheres, m: a lattice with shifts that look random and are always the same.
pub(super) fn centres() -> Vec<[f64; 3]> {
    let mut state = 1_u64;
    let mut shift = |most: f64| {
        // Knuth's linear congruential generator, its upper bits.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        most * (2.0 * (state >> 11) as f64 / (1_u64 << 53) as f64 - 1.0)
    };
    let mut centres = Vec::new();
    for row in 0..ROWS[1] {
        for column in 0..ROWS[0] {
            let at = |number: usize, axis: usize| (number as f64 + 0.5) * PERIOD[axis] / ROWS[axis] as f64;
            let place = [at(column, 0), at(row, 1), -0.5];
            centres.push(std::array::from_fn(|axis| DIAMETER * (place[axis] + shift(SHIFT[axis]))));
        }
    }
    centres
}

#[cfg(test)]
#[path = "../../../tests/unit/laws_chute_bed.rs"]
mod tests;
