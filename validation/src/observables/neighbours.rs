//! Pairs of grains that are close to each other.

use makadam::snapshot::Particle;
use nalgebra::Vector3;

/// Two grains and the gap between their surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Place of the first grain in the frame's table.
    pub first: usize,
    /// Place of the second grain; above the first.
    pub second: usize,
    /// Distance of the surfaces, m; negative where they overlap.
    pub gap: f64,
}

/// All pairs of grains whose gap is below `reach` (m), found on a grid of cells.
pub fn close_pairs(grains: &[Particle], reach: f64) -> Vec<Pair> {
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    if grains.len() < 2 || largest <= 0.0 {
        return Vec::new();
    }
    let places: Vec<Vector3<f64>> = grains.iter().map(|grain| grain.position.into()).collect();
    let low = places.iter().fold(places[0], |low, place| low.inf(place));
    let extent = places.iter().fold(places[0], |high, place| high.sup(place)) - low;
    // Grains that flew far apart must not blow up the grid: cells are never much more numerous than grains.
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
    let (mut sorted, mut fill) = (vec![0; grains.len()], start.clone());
    for (grain, &cell) in cells.iter().enumerate() {
        sorted[fill[cell]] = grain;
        fill[cell] += 1;
    }

    let mut pairs = Vec::with_capacity(4 * grains.len());
    for (first, place) in places.iter().enumerate() {
        let cell = cell_of(place);
        let (from, to) =
            (cell.map(|c| c.saturating_sub(1)), (cell.add_scalar(1)).inf(&dims.add_scalar(0).map(|d| d - 1)));
        for z in from.z..=to.z {
            for y in from.y..=to.y {
                let row = flat(Vector3::new(from.x, y, z))..=flat(Vector3::new(to.x, y, z));
                for &second in &sorted[start[*row.start()]..start[*row.end() + 1]] {
                    if second <= first {
                        continue;
                    }
                    let touch = grains[first].radius + grains[second].radius;
                    let square = (places[second] - place).norm_squared();
                    if square < (touch + reach).powi(2) {
                        pairs.push(Pair { first, second, gap: square.sqrt() - touch });
                    }
                }
            }
        }
    }
    pairs
}
