//! Packing fraction: solid volume over volume in the bulk, with exact volumes of spheres cut by its border.
//!
//! In a fixed box with a level bed the region is a box, two mean diameters inside its faces and below the free
//! surface. In any other container the region consists of cubes of half a diameter with all eight corners in the bulk.

use super::bulk::Bulk;
use super::catalogue::{Group, define};
use super::effort;
use super::measurement::Readings;
use super::sphere_volume::{sphere, sphere_in_box};
use super::view::View;
use makadam::scene::{Motion, Shape};
use makadam::snapshot::Particle;
use makadam_frames::plan::Observable;
use nalgebra::Vector3;
use std::collections::HashSet;

pub(super) const GROUP: Group = Group {
    observable: Observable::PackingFraction,
    name: "packing-fraction",
    read,
    definitions: &[define(
        ["packing_fraction", "φ", ""],
        "volume of the grains inside the bulk region over the volume of the region, spheres cut exactly by its \
             border; the region is a box in a fixed box without other walls, elsewhere the cubes of half a diameter, \
             on a lattice from the middle of the domain, whose corners lie in the bulk. The position of the lattice \
             changes the value, by 0.003 in `vibrated-bed` and by 0.03 in a shallow bed of 500 grains",
    )],
};

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    let bulk = view.bulk()?;
    let fraction = match box_region(view, bulk) {
        Some((min, max)) => fraction_in_box(&view.frame.particles, min, max),
        None => fraction_in_cubes(view, bulk),
    };
    readings.add("packing_fraction", fraction.ok_or("no cube of half a diameter lies in the bulk")?);
    Ok(())
}

/// Returns the solid volume over the volume of a box; `None` for an empty box.
pub fn fraction_in_box(grains: &[Particle], min: [f64; 3], max: [f64; 3]) -> Option<f64> {
    if (0..3).any(|axis| max[axis] <= min[axis]) {
        return None;
    }
    let volume: f64 = (0..3).map(|axis| max[axis] - min[axis]).product();
    let solid: f64 = grains.iter().map(|grain| sphere_in_box(grain.position, grain.radius, min, max)).sum();
    Some(solid / volume)
}

/// Returns the box of the bulk, for a container that is one fixed box and a free surface that is level along one of its axes.
fn box_region(view: &View<'_>, bulk: &Bulk) -> Option<([f64; 3], [f64; 3])> {
    let [wall] = view.setting.scene().wall.as_slice() else {
        return None;
    };
    let (Shape::Box { min, max, .. }, Motion::Fixed) = (&wall.shape, &wall.motion) else {
        return None;
    };
    let (up, level) = (view.setting.up?, bulk.level()?);
    let axis = up.iamax();
    if up[axis].abs() < 1.0 - 1e-9 {
        return None;
    }
    let (inset, domain) = (bulk.inset, &view.setting.scene().domain);
    // Along a periodic axis the box has no faces, and the ends of the axis count as walls.
    let (mut low, mut high) = (*min, *max);
    for end in domain.periodic.iter().map(|axis| axis.number()) {
        (low[end], high[end]) = (domain.min[end], domain.max[end]);
    }
    (low, high) = (low.map(|x| x + inset), high.map(|x| x - inset));
    match up[axis] > 0.0 {
        true => high[axis] = high[axis].min(level - inset),
        false => low[axis] = low[axis].max(-level + inset),
    }
    Some((low, high))
}

/// Largest distance of cubes from the origin, in cubes, limited by rounding.
const FARTHEST: f64 = 1e15;

/// Returns the fraction in cubes; `None` if no cube lies in the bulk, or if grains lie too far apart, or differ too much in size, for
/// [`effort::most`] cell updates.
fn fraction_in_cubes(view: &View<'_>, bulk: &Bulk) -> Option<f64> {
    let size = 0.5 * view.setting.diameter;
    let middle = view.setting.middle();
    let corner = |cube: [i64; 3]| Vector3::from(cube.map(|index| index as f64 * size));
    // Positions from the middle of the domain.
    let grains: Vec<Particle> = (view.frame.particles.iter())
        .map(|grain| Particle { position: (Vector3::from(grain.position) - middle).into(), ..*grain })
        .collect();
    let index = |x: f64| (x / size).floor() as i64;
    let is_far = |grain: &Particle| grain.position.iter().any(|x| x.abs() / size > FARTHEST);
    if grains.iter().any(|grain| is_far(grain) || effort::too_large(grain.radius, size)) {
        return None;
    }

    // Cubes near grains of the bulk with all corners in the bulk.
    let mut nodes = std::collections::HashMap::new();
    let mut inside =
        |node: [i64; 3]| *nodes.entry(node).or_insert_with(|| bulk.contains(&view.walls, &(middle + corner(node))));
    let (mut cubes, mut seen) = (HashSet::new(), HashSet::new());
    let reach = 2;
    for grain in grains.iter().zip(view.in_bulk()).filter(|(_, bulk)| **bulk).map(|(grain, _)| grain) {
        let home = grain.position.map(index);
        for n in 0..(2 * reach + 1_i64).pow(3) {
            let side = 2 * reach + 1;
            let cube =
                [home[0] + n % side - reach, home[1] + n / side % side - reach, home[2] + n / side / side - reach];
            if seen.insert(cube)
                && (0..8).all(|c| inside([cube[0] + (c & 1), cube[1] + (c >> 1 & 1), cube[2] + (c >> 2 & 1)]))
            {
                cubes.insert(cube);
            }
        }
    }
    if cubes.is_empty() {
        return None;
    }
    let mut solid = 0.0;
    let mut left = effort::most(grains.len());
    for grain in &grains {
        let (low, high) =
            (grain.position.map(|x| index(x - grain.radius)), grain.position.map(|x| index(x + grain.radius)));
        let sides: [f64; 3] = std::array::from_fn(|axis| (high[axis] - low[axis] + 1) as f64);
        let count: f64 = sides.iter().product();
        left = left.checked_sub(count.min(cubes.len() as f64) as usize)?;
        let reached = match count <= cubes.len() as f64 {
            true => in_range(low, high).filter(|cube| cubes.contains(cube)).collect(),
            // A large grain: the set contains fewer cubes than the grain's range.
            false => among(&cubes, low, high),
        };
        solid += match reached.len() as f64 == count {
            true => sphere(grain.radius),
            false => (reached.into_iter())
                .map(|cube| {
                    let min = corner(cube);
                    sphere_in_box(grain.position, grain.radius, min.into(), min.add_scalar(size).into())
                })
                .sum(),
        };
    }
    Some(solid / (cubes.len() as f64 * size.powi(3)))
}

/// Returns the cubes from `low` to `high`, x first.
fn in_range(low: [i64; 3], high: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let row = move |y: i64, z: i64| (low[0]..=high[0]).map(move |x| [x, y, z]);
    (low[2]..=high[2]).flat_map(move |z| (low[1]..=high[1]).flat_map(move |y| row(y, z)))
}

/// Returns the given cubes from `low` to `high`, in the order of [`in_range`], so that sums have one order.
fn among(cubes: &HashSet<[i64; 3]>, low: [i64; 3], high: [i64; 3]) -> Vec<[i64; 3]> {
    let inside = |cube: &&[i64; 3]| (0..3).all(|axis| (low[axis]..=high[axis]).contains(&cube[axis]));
    let mut inside: Vec<[i64; 3]> = cubes.iter().filter(inside).copied().collect();
    inside.sort_unstable_by_key(|&[x, y, z]| [z, y, x]);
    inside
}

#[cfg(test)]
#[path = "../../tests/unit/observables_packing_fraction.rs"]
mod tests;
