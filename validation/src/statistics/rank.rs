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
#[path = "../../tests/unit/statistics_rank.rs"]
mod tests;
