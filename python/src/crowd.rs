//! Coincident grains: they are all in contact with each other, and the time and memory of a step grow with the number of pairs.

use makadam::world::Sphere;

/// Number of coincident grains at which the caller is warned: they form over a hundred thousand pairs.
const MANY: u32 = 500;

/// Counts the grains within the largest diameter along each axis if there are too many; usually none.
///
/// Cells share entries of the hash table: a suspected cluster is then counted exactly.
pub fn crowd(spheres: &[Sphere]) -> Option<u32> {
    if spheres.len() < MANY as usize {
        return None;
    }
    let side = 2.0 * spheres.iter().fold(0.0_f64, |largest, sphere| largest.max(sphere.radius));
    let cell = |sphere: &Sphere| sphere.centre.map(|place| (place / side).floor() as i64);
    let mut table = vec![0_u32; (2 * spheres.len()).next_power_of_two()];
    let shift = u64::BITS - table.len().trailing_zeros();
    let slot = |sphere: &Sphere| {
        let mixed = cell(sphere).iter().fold(0_u64, |hash, part| {
            (hash ^ part.cast_unsigned()).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        });
        (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> shift) as usize
    };
    spheres.iter().for_each(|sphere| table[slot(sphere)] += 1);
    let crowded = spheres.iter().find(|sphere| table[slot(sphere)] >= MANY)?;
    let there = cell(crowded);
    let count = spheres.iter().filter(|sphere| cell(sphere) == there).count() as u32;
    (count >= MANY).then_some(count)
}
