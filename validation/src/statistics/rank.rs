//! A number of a given rank, of numbers that are too many to be held at once.

/// Bits that one look tells.
const DIGIT: u32 = 16;

/// The number of a rank, from 0 for the smallest, among those that `each` goes through: none of them negative, and more of them
/// than the rank. `each` is called four times and gives the same numbers each time; they are counted, not kept.
///
/// # Errors
/// Those of `each`.
pub fn ranked<E>(rank: u64, mut each: impl FnMut(&mut dyn FnMut(f64)) -> Result<(), E>) -> Result<f64, E> {
    // The bits of numbers that are not negative are in the order of the numbers: a digit is known after each look.
    let (mut known, mut left) = (0_u64, rank);
    for shift in [3 * DIGIT, 2 * DIGIT, DIGIT, 0] {
        let mut counts = vec![0_u64; 1 << DIGIT];
        each(&mut |number| {
            let bits = number.to_bits() >> shift;
            if bits >> DIGIT == known {
                counts[(bits & ((1 << DIGIT) - 1)) as usize] += 1;
            }
        })?;
        let mut digit = 0;
        while left >= counts[digit] && digit + 1 < counts.len() {
            left -= counts[digit];
            digit += 1;
        }
        known = known << DIGIT | digit as u64;
    }
    Ok(f64::from_bits(known))
}

#[cfg(test)]
mod tests {
    use super::ranked;
    use std::convert::Infallible;

    #[test]
    fn a_rank_is_found_as_by_sorting() {
        let mut random = 1_u64;
        let mut numbers: Vec<f64> = (0..2000)
            .map(|n| {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                // Equal ones, tiny ones, zeros, and neighbours that differ in their last bits alone.
                match n % 5 {
                    0 => 0.0,
                    1 => 0.25,
                    2 => f64::from_bits(0x3fe0_0000_0000_0000 + (random >> 60)),
                    _ => (random >> 11) as f64 * 1e-18_f64.powi(n % 3),
                }
            })
            .collect();
        let find = |rank: u64| {
            let Ok(found) = ranked::<Infallible>(rank, |look| {
                numbers.iter().for_each(|number| look(*number));
                Ok(())
            });
            found
        };
        let found: Vec<f64> = (0..2000).map(find).collect();
        numbers.sort_by(f64::total_cmp);
        assert_eq!(found, numbers);
    }
}
