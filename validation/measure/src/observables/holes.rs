//! Holes in a region that grains should fill: points farther than a mean diameter from the surface of every grain.
//!
//! The search covers a lattice half a mean diameter wide, from the grains of the region outwards, step by step within the region: space
//! that walls separate from the grains is not part of the region. Random packings have no pore of that size.

use super::effort;
use super::setting::Setting;
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;

/// Lattice width over the mean diameter.
const WIDTH: f64 = 0.5;

/// Smallest distance of a hole's points from the surface of every grain, over the mean diameter.
const HOLE: f64 = 1.0;

/// Extension of the lattice beyond the grains of the region, in steps. A point of the region beyond lies in a hole.
const MARGIN: f64 = 6.0;

/// Finds a point of a hole (m) in the region of these grains, as defined by `contains`; `None` without a hole.
///
/// # Errors
/// Message if grains lie too far apart, or differ too much in size, for a lattice of [`effort::most`] points.
pub fn hole(
    setting: &Setting<'_>,
    frame: &Snapshot,
    inside: &[&Particle],
    contains: &dyn Fn(&Vector3<f64>) -> bool,
) -> Result<Option<Vector3<f64>>, String> {
    let lattice = Lattice::around(setting, inside).ok_or("grains lie too far apart, or are too unlike in size")?;
    let filled = lattice.filled(setting, &frame.particles).ok_or("grains are too unlike in size")?;
    let mut seen = vec![false; lattice.points()];
    let mut next: Vec<[i64; 3]> = inside.iter().flat_map(|grain| lattice.beside(&grain.position.into())).collect();
    while let Some(point) = next.pop() {
        let Some(index) = lattice.index(point) else {
            let place = lattice.place(point);
            if contains(&place) {
                return Ok(Some(place));
            }
            continue;
        };
        if std::mem::replace(&mut seen[index], true) {
            continue;
        }
        let place = lattice.place(point);
        if !contains(&place) {
            continue;
        }
        if !filled[index] {
            return Ok(Some(place));
        }
        for axis in 0..3 {
            for step in [-1, 1] {
                let mut neighbour = point;
                neighbour[axis] += step;
                next.push(neighbour);
            }
        }
    }
    Ok(None)
}

/// Points of a cubic lattice in a box.
struct Lattice {
    /// Position of point (0, 0, 0), m.
    origin: Vector3<f64>,
    width: f64,
    /// First point along each axis.
    first: [i64; 3],
    /// Number of points along each axis.
    count: [usize; 3],
}

impl Lattice {
    fn around(setting: &Setting<'_>, inside: &[&Particle]) -> Option<Lattice> {
        let (origin, width) = (setting.middle(), WIDTH * setting.diameter);
        let places = || inside.iter().map(|grain| (Vector3::from(grain.position) - origin) / width);
        let far = Vector3::repeat(f64::INFINITY);
        let low = places().fold(far, |low, place| low.inf(&place)).map(|x| (x - MARGIN).floor());
        let high = places().fold(-far, |high, place| high.sup(&place)).map(|x| (x + MARGIN).ceil());
        let extent = (high - low).add_scalar(1.0);
        // Points are bits of a map, so each grain may have many points.
        let fits = extent.product() <= 8.0 * effort::most(inside.len()) as f64 && low.amax() < 1e15;
        fits.then(|| Lattice {
            origin,
            width,
            first: low.map(|x| x as i64).into(),
            count: extent.map(|x| x as usize).into(),
        })
    }

    fn points(&self) -> usize {
        self.count.iter().product()
    }

    fn place(&self, point: [i64; 3]) -> Vector3<f64> {
        // Offset by half a step, so that the lattice is its own mirror image.
        self.origin + Vector3::from(point.map(|index| (index as f64 + 0.5) * self.width))
    }

    fn index(&self, point: [i64; 3]) -> Option<usize> {
        let mut index = 0;
        for axis in [2, 1, 0] {
            let along = usize::try_from(point[axis] - self.first[axis]).ok().filter(|n| *n < self.count[axis])?;
            index = index * self.count[axis] + along;
        }
        Some(index)
    }

    /// Returns the eight points about a position.
    fn beside(&self, place: &Vector3<f64>) -> impl Iterator<Item = [i64; 3]> + use<> {
        let low = ((place - self.origin) / self.width).map(|x| (x - 0.5).floor() as i64);
        (0..8).map(move |n| [low[0] + (n & 1), low[1] + (n >> 1 & 1), low[2] + (n >> 2 & 1)])
    }

    /// Returns flags of the points outside holes; `None` if too many pairs of grains and points are tested.
    fn filled(&self, setting: &Setting<'_>, grains: &[Particle]) -> Option<Vec<bool>> {
        let mut filled = vec![false; self.points()];
        let mut left = effort::most(grains.len()).saturating_mul(8);
        for grain in grains {
            let reach = (grain.radius + HOLE * setting.diameter) / self.width;
            let centre: [f64; 3] = ((Vector3::from(grain.position) - self.origin) / self.width).add_scalar(-0.5).into();
            let range = |axis: usize| {
                let (low, high) = (self.first[axis], self.first[axis] + self.count[axis] as i64 - 1);
                let clamped = |x: f64| x.clamp(low as f64 - 1.0, high as f64 + 1.0) as i64;
                clamped((centre[axis] - reach).ceil()).max(low)..=clamped((centre[axis] + reach).floor()).min(high)
            };
            let [xs, ys, zs] = [0, 1, 2].map(range);
            let length = |range: &std::ops::RangeInclusive<i64>| (range.end() - range.start() + 1).max(0) as usize;
            left = left.checked_sub(length(&xs) * length(&ys) * length(&zs))?;
            for z in zs {
                for y in ys.clone() {
                    for x in xs.clone() {
                        let square: f64 = [x, y, z].iter().zip(centre).map(|(&n, c)| (n as f64 - c).powi(2)).sum();
                        if let Some(index) = self.index([x, y, z]).filter(|_| square <= reach * reach) {
                            filled[index] = true;
                        }
                    }
                }
            }
        }
        Some(filled)
    }
}
