//! Pairs of neighbouring grains.

use makadam::scene::Domain;
use makadam::snapshot::Particle;
use nalgebra::Vector3;
use std::ops::Range;

/// Two grains and the gap between their surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Index of the first grain in the frame's table.
    pub first: usize,
    /// Index of the second grain, larger than the first.
    pub second: usize,
    /// Distance of the surfaces, m; negative for an overlap.
    pub gap: f64,
}

/// Returns all pairs of grains with a gap below `reach` (m), found on a grid of cells.
pub fn close_pairs(grains: &[Particle], reach: f64) -> Vec<Pair> {
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    if grains.len() < 2 || largest <= 0.0 {
        return Vec::new();
    }
    let places: Vec<Vector3<f64>> = grains.iter().map(|grain| grain.position.into()).collect();
    let low = places.iter().fold(places[0], |low, place| low.inf(place));
    let extent = places.iter().fold(places[0], |high, place| high.sup(place)) - low;
    // Limits the grid for grains far apart: the number of cells stays of the order of the number of grains.
    let most = (2.0 * (grains.len() as f64).cbrt()).max(8.0);
    let size = (2.0 * largest + reach.max(0.0)).max(extent.max() / (4.0 * most)) * (1.0 + 1e-9);
    let dims = extent.map(|width| (width / size) as usize + 1);
    let cell_of = |place: &Vector3<f64>| (place - low).map(|x| (x / size) as usize);
    let flat = |cell: Vector3<usize>| (cell.z * dims.y + cell.y) * dims.x + cell.x;

    // Grains sorted by cell (counting sort): those of cell c are sorted[start[c]..start[c + 1]].
    let mut start = vec![0_usize; dims.x * dims.y * dims.z + 1];
    let cells: Vec<usize> = places.iter().map(|place| flat(cell_of(place))).collect();
    cells.iter().for_each(|&cell| start[cell + 1] += 1);
    (1..start.len()).for_each(|cell| start[cell] += start[cell - 1]);
    let (mut sorted, mut fill) = (vec![(0, Vector3::zeros(), 0.0); grains.len()], start.clone());
    for (grain, &cell) in cells.iter().enumerate() {
        sorted[fill[cell]] = (grain, places[grain], grains[grain].radius);
        fill[cell] += 1;
    }

    let mut pairs = Vec::with_capacity(4 * grains.len());
    for (index, &(one, place, radius)) in sorted.iter().enumerate() {
        let mut add = |range: Range<usize>| {
            for &(other, other_place, other_radius) in &sorted[range] {
                let (touch, square) = (radius + other_radius, (other_place - place).norm_squared());
                if square < (touch + reach).powi(2) {
                    let gap = square.sqrt() - touch;
                    pairs.push(Pair { first: one.min(other), second: one.max(other), gap });
                }
            }
        };
        let cell = cell_of(&place);
        let (from, to) = (cell.x.saturating_sub(1), (cell.x + 1).min(dims.x - 1));
        let row = |y: usize, z: usize| start[flat(Vector3::new(from, y, z))]..start[flat(Vector3::new(to, y, z)) + 1];
        // Half of the neighbouring cells, so that each pair is found once: the rest of the row, then the rows behind it.
        add(index + 1..row(cell.y, cell.z).end);
        if cell.y + 1 < dims.y {
            add(row(cell.y + 1, cell.z));
        }
        if cell.z + 1 < dims.z {
            for y in cell.y.saturating_sub(1)..dims.y.min(cell.y + 2) {
                add(row(y, cell.z + 1));
            }
        }
    }
    pairs
}

/// Returns all pairs of grains with a gap below `reach` (m), also across the ends of periodic axes; grains lie inside the domain along these.
pub fn close_pairs_in(domain: &Domain, grains: &[Particle], reach: f64) -> Vec<Pair> {
    let mut pairs = close_pairs(grains, reach);
    let is_periodic = [0, 1, 2].map(|axis| domain.periodic.iter().any(|known| known.number() == axis));
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    let near = 2.0 * largest + reach.max(0.0);
    let is_at_end = |grain: &Particle| {
        let at_end = |axis: usize| {
            let place = grain.position[axis];
            place - domain.min[axis] < near || domain.max[axis] - place < near
        };
        (0..3).any(|axis| is_periodic[axis] && at_end(axis))
    };
    // Grains near an end, then their images beyond it: one of two opposite shifts, so that each pair is found once.
    let own: Vec<usize> = (0..grains.len()).filter(|&place| is_at_end(&grains[place])).collect();
    let mut sources = own.clone();
    let mut all: Vec<Particle> = own.iter().map(|&place| grains[place]).collect();
    for shift in shifts(is_periodic) {
        for &place in &own {
            let mut image = grains[place];
            for (axis, laps) in shift.iter().enumerate() {
                image.position[axis] += laps * (domain.max[axis] - domain.min[axis]);
            }
            let is_near =
                |axis: usize| (domain.min[axis] - near..=domain.max[axis] + near).contains(&image.position[axis]);
            if (0..3).all(|axis| shift[axis] == 0.0 || is_near(axis)) {
                sources.push(place);
                all.push(image);
            }
        }
    }
    let across = close_pairs(&all, reach).into_iter().filter(|pair| pair.first < own.len() && pair.second >= own.len());
    pairs.extend(across.filter_map(|pair| {
        let (one, other) = (sources[pair.first], sources[pair.second]);
        (one != other).then(|| Pair { first: one.min(other), second: one.max(other), gap: pair.gap })
    }));
    pairs
}

/// Returns the shifts by whole periods to the images next to the domain, one of each two opposite shifts.
fn shifts(is_periodic: [bool; 3]) -> impl Iterator<Item = [f64; 3]> {
    let every = (0..27).map(|n| [n / 9, n / 3 % 3, n % 3].map(|lap| f64::from(lap) - 1.0));
    every.filter(move |shift| {
        let is_allowed = (0..3).all(|axis| is_periodic[axis] || shift[axis] == 0.0);
        is_allowed && shift.iter().find(|lap| **lap != 0.0).is_some_and(|lap| *lap > 0.0)
    })
}
