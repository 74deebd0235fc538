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
mod tests {
    use super::super::SPREAD;
    use super::*;

    #[test]
    fn the_bed_has_no_gap_that_a_grain_falls_through() {
        let centres = centres();
        assert_eq!(centres.len(), ROWS[0] * ROWS[1]);
        // Where the smallest grain comes to rest above each place.
        let (reach, [length, width]) = ((1.0 - 0.5 * SPREAD) * DIAMETER, PERIOD.map(|diameters| diameters * DIAMETER));
        let lap = |distance: f64, period: f64| distance - period * (distance / period).round();
        let rest = |x: f64, y: f64| {
            let heights = centres.iter().map(|centre| {
                let square = lap(x - centre[0], length).powi(2) + lap(y - centre[1], width).powi(2);
                centre[2] + (reach * reach - square).sqrt()
            });
            heights.fold(f64::NEG_INFINITY, f64::max)
        };
        let places =
            (0..200).flat_map(|i| (0..200).map(move |j| (f64::from(i) * length / 200.0, f64::from(j) * width / 200.0)));
        let lowest = places.map(|(x, y)| rest(x, y)).fold(f64::INFINITY, f64::min);
        assert!(lowest > -0.5 * DIAMETER, "a grain sinks to {lowest} m");
    }
}
