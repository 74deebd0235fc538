//! Solid fraction on a grid of square cells in a plane.

use super::sphere_volume::{half_space, quadrant};
use makadam::lanes::{Available, Eight, Kernel, LANES, Lanes};

/// Tolerance, in cells, of extents that are a whole number of cells: rounding errors are smaller.
const ROUNDING: f64 = 1e-6;

/// Field on square cells, row after row.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Lower corner of the first cell, m.
    pub origin: [f64; 2],
    /// Width of a cell, m.
    pub cell: f64,
    /// Cells along the first coordinate.
    pub columns: usize,
    /// Cells along the second coordinate.
    pub rows: usize,
    /// Values, `rows` times `columns`.
    pub values: Vec<f64>,
}

impl Field {
    /// Makes a field of zeros that covers `min` to `max` (m) with cells of width `cell` (m), centred; `None` for more
    /// than `most` cells. An extent of a whole number of cells takes this number, regardless of rounding.
    pub fn new(min: [f64; 2], max: [f64; 2], cell: f64, most: usize) -> Option<Self> {
        let count = |axis: usize| ((max[axis] - min[axis]) / cell - ROUNDING).ceil().max(1.0);
        if count(0) * count(1) > most as f64 {
            return None;
        }
        let (columns, rows) = (count(0) as usize, count(1) as usize);
        let start = |axis: usize, count: usize| 0.5 * (min[axis] + max[axis] - count as f64 * cell);
        Some(Self {
            origin: [start(0, columns), start(1, rows)],
            cell,
            columns,
            rows,
            values: vec![0.0; columns * rows],
        })
    }

    /// Returns the value of a cell; zero outside the grid.
    pub fn get(&self, column: isize, row: isize) -> f64 {
        match (0..self.columns as isize).contains(&column) && (0..self.rows as isize).contains(&row) {
            true => self.values[row as usize * self.columns + column as usize],
            false => 0.0,
        }
    }

    /// Returns the centre of a cell, m; also of cells outside the grid.
    pub fn centre(&self, column: isize, row: isize) -> [f64; 2] {
        [self.origin[0] + (column as f64 + 0.5) * self.cell, self.origin[1] + (row as f64 + 0.5) * self.cell]
    }

    /// Adds the exact volumes of spheres, divided by `volume` (m3), to the cells that they reach, each cell being a prism without ends.
    /// Spheres are given by their centres in the plane and their radii, m.
    pub fn add_spheres(&mut self, spheres: &[([f64; 2], f64)], volume: f64) {
        Available::detect().run(Spheres { field: self, spheres, volume });
    }

    /// Returns the first and last column, and the first and last row, of a sphere's cells; last before first for no cells.
    #[inline(always)]
    fn reach(&self, centre: [f64; 2], radius: f64) -> [(isize, isize); 2] {
        // Cells beyond the grid receive nothing, for any position and radius of the sphere.
        let cells = [self.columns as isize, self.rows as isize];
        [0, 1].map(|axis| {
            let cell = |edge: f64| ((edge - self.origin[axis]) / self.cell).floor() as isize;
            (cell(centre[axis] - radius).max(0), cell(centre[axis] + radius).min(cells[axis] - 1))
        })
    }

    /// Returns the number of cells of a sphere.
    pub fn reached(&self, centre: [f64; 2], radius: f64) -> usize {
        let sides = self.reach(centre, radius).map(|(first, last)| (last - first + 1).max(0) as usize);
        sides[0] * sides[1]
    }

    /// Adds another field of the same grid, cell by cell.
    pub fn add(&mut self, other: &Field) {
        for (value, more) in self.values.iter_mut().zip(&other.values) {
            *value += more;
        }
    }

    /// Multiplies every value.
    pub fn scale(&mut self, factor: f64) {
        self.values.iter_mut().for_each(|value| *value *= factor);
    }

    /// Averages each cell with its neighbours, weights 1, 2, 1 along either coordinate; the sum of all cells is conserved
    /// for a field that is empty at its rim.
    pub fn smooth(&mut self) {
        for (across, down) in [(1, 0), (0, 1)] {
            let old = self.clone();
            for row in 0..self.rows as isize {
                for column in 0..self.columns as isize {
                    let beside = old.get(column - across, row - down) + old.get(column + across, row + down);
                    let value = 0.5 * old.get(column, row) + 0.25 * beside;
                    self.values[row as usize * self.columns + column as usize] = value;
                }
            }
        }
    }

    /// Returns the largest value.
    pub fn largest(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }
}

/// Addition of spheres to a field.
struct Spheres<'a> {
    field: &'a mut Field,
    spheres: &'a [([f64; 2], f64)],
    volume: f64,
}

impl Kernel for Spheres<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Spheres { field, spheres, volume } = self;
        let (cell, origin, columns) = (field.cell, field.origin, field.columns);
        // Lines of the grid relative to a sphere, and the volumes of the quadrants at their crossings, row after row.
        let (mut across, mut along, mut corners): (Vec<f64>, Vec<f64>, Vec<f64>) = Default::default();
        for &(centre, radius) in spheres {
            let [(left, right), (bottom, top)] = field.reach(centre, radius);
            if left > right || bottom > top {
                continue;
            }
            let line = |axis: usize, index: isize| (origin[axis] + index as f64 * cell - centre[axis]) / radius;
            let (width, share) = ((right - left + 1) as usize, radius.powi(3) / volume);
            across.clear();
            across.extend((left..=right + 1).map(|index| line(0, index)));
            along.clear();
            along.extend((bottom..=top + 1).map(|index| line(1, index)));
            quadrants::<L>(&across, &along, &mut corners);
            // A cell is a difference of quadrants; corners are shared by four cells.
            let stride = width + 1;
            for (row, pair) in corners.windows(2 * stride).step_by(stride).enumerate() {
                let (below, here) = pair.split_at(stride);
                let start = (bottom as usize + row) * columns + left as usize;
                let cells = &mut field.values[start..start + width];
                for (place, value) in cells.iter_mut().enumerate() {
                    *value += share * (below[place] - below[place + 1] - (here[place] - here[place + 1]));
                }
            }
        }
    }
}

/// Sets `corners` to the volumes of the unit ball in the quadrants X > a, Y > b, for each of the ascending `b` all of the ascending `a`.
#[inline(always)]
fn quadrants<L: Lanes>(a: &[f64], b: &[f64], corners: &mut Vec<f64>) {
    // Only lines through the ball need a quadrant.
    let inner = |lines: &[f64]| {
        let first = lines.iter().take_while(|line| **line <= -1.0).count();
        first..first + lines[first..].iter().take_while(|line| **line < 1.0).count()
    };
    let (columns, rows) = (inner(a), inner(b));
    corners.clear();
    corners.resize(a.len() * b.len(), 0.0);
    for row in 0..rows.start {
        for (column, corner) in corners[row * a.len()..][..columns.end].iter_mut().enumerate() {
            *corner = half_space(a[column]);
        }
    }
    for row in rows.clone() {
        corners[row * a.len()..][..columns.start].fill(half_space(b[row]));
    }
    // Their crossings fill the lanes, row after row.
    let count = columns.len() * rows.len();
    let (mut column, mut row) = (columns.start, rows.start);
    for first in (0..count).step_by(LANES) {
        let (mut at, mut places) = ([Eight::default(); 2], [0; LANES]);
        let taken = LANES.min(count - first);
        for (lane, place) in places.iter_mut().enumerate().take(taken) {
            (at[0].0[lane], at[1].0[lane], *place) = (a[column], b[row], row * a.len() + column);
            column += 1;
            if column == columns.end {
                (column, row) = (columns.start, row + 1);
            }
        }
        let mut volumes = Eight::default();
        quadrant(L::load(&at[0]), L::load(&at[1])).store(&mut volumes);
        for (place, volume) in places.iter().zip(&volumes.0).take(taken) {
            corners[*place] = *volume;
        }
    }
}

/// Returns the weighted mean of the values above half of the mean: the value inside a bed, without its rim.
pub(super) fn mean_within(values: &[f64], weight: impl Fn(usize) -> f64) -> f64 {
    let mean_above = |level: f64| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (index, &value) in values.iter().enumerate().filter(|(_, value)| **value > level) {
            sum += value * weight(index);
            weights += weight(index);
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    };
    (0..20).fold(mean_above(0.0), |mean, _| mean_above(0.5 * mean))
}
