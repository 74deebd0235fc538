//! Grains that were put to one place: each of them touches each other, and a step takes time and memory by the pair.

use makadam::world::Sphere;

/// Grains in one place from which on the caller is told. As many make a hundred thousand pairs.
const MANY: u32 = 500;

/// Counts the grains within the largest diameter along each axis if there are too many; usually none.
///
/// Cells fall together in the table that they are counted in: what looks like a crowd there is counted exactly afterwards.
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
