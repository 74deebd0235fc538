//! Grains sorted into cells by counting. Cells are a whole part of a box, so that grains in the order of cells are in the
//! order of boxes too.

use crate::effects::period::Period;
use crate::partition::BoxGrid;
use crate::schedule::{Disjoint, Phase, Team};
use crate::world::{World, chunk, chunks};
use nalgebra::Vector3;
use std::ops::Range;

/// Cubic cells over the domain: the boxes, each cut into the same number of cells.
#[derive(Clone, Debug)]
pub struct CellGrid {
    boxes: BoxGrid,
    /// Cells of a box along an axis.
    per_box: u32,
    size: [f64; 3],
    /// Place of each cell's first grain; one more entry than cells.
    start: Vec<u32>,
    /// Old places of the grains, cell after cell.
    order: Vec<u32>,
    cell_of: Vec<u32>,
}

/// Neighbours of a cell that come after it, so that each pair of cells is visited once.
pub(super) const FORWARD: [[i32; 3]; 13] = [
    [1, 0, 0],
    [-1, 1, 0],
    [0, 1, 0],
    [1, 1, 0],
    [-1, -1, 1],
    [0, -1, 1],
    [1, -1, 1],
    [-1, 0, 1],
    [0, 0, 1],
    [1, 0, 1],
    [-1, 1, 1],
    [0, 1, 1],
    [1, 1, 1],
];

impl CellGrid {
    /// Cells no smaller than `reach` (m) in the boxes of a world of so many grains.
    pub fn new(boxes: &BoxGrid, grains: usize, reach: f64) -> CellGrid {
        // Empty cells cost time too: no more than about eight a grain.
        let most = libm::cbrt((8.0 * grains as f64 + 4096.0) / boxes.boxes() as f64);
        // Around a periodic axis a cell's two neighbours must be different ones.
        let around = |axis: usize| f64::from(3_u32.div_ceil(boxes.counts()[axis]));
        let least = (0..3).filter(|&axis| boxes.period().is_periodic(axis)).map(around).fold(1.0, f64::max);
        let narrowest = boxes.widths().into_iter().fold(f64::INFINITY, f64::min);
        let per_box = (narrowest / reach.max(1e-300)).floor().min(most.floor()).clamp(least, 1024.0);
        CellGrid {
            boxes: boxes.clone(),
            per_box: per_box as u32,
            size: boxes.widths().map(|width| width / per_box),
            start: Vec::new(),
            order: Vec::new(),
            cell_of: Vec::new(),
        }
    }

    /// Sorts the grains of a world; grains outside the domain count to its outermost cells, or where their image is inside. Returns the old place of the
    /// grain that belongs at each new place. Grains of a cell keep their order.
    pub fn sort(&mut self, world: &World, team: &Team) -> &[u32] {
        let grains = world.grains();
        self.cell_of.resize(grains, 0);
        let mut cell_of = std::mem::take(&mut self.cell_of);
        let cells = Disjoint::new(&mut cell_of);
        team.each(Phase::Detect, chunks(world.grains()), |number| {
            let places = chunk(number, world.grains());
            // SAFETY: chunks do not overlap.
            let cells = unsafe { cells.range(places.clone()) };
            for (cell, sphere) in cells.iter_mut().zip(&world.spheres[places]) {
                *cell = self.cell(&sphere.centre);
            }
        });
        self.cell_of = cell_of;
        team.alone(Phase::Detect, || self.count());
        &self.order
    }

    /// Sorts by counting.
    fn count(&mut self) {
        let cells = self.boxes.boxes() * self.cells_of_box();
        self.start.clear();
        self.start.resize(cells + 1, 0);
        for &cell in &self.cell_of {
            self.start[cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            self.start[cell + 1] += self.start[cell];
        }
        self.order.resize(self.cell_of.len(), 0);
        for (grain, &cell) in self.cell_of.iter().enumerate() {
            let place = &mut self.start[cell as usize];
            self.order[*place as usize] = grain as u32;
            *place += 1;
        }
        // Filling moved each start to its end: shift back.
        self.start.copy_within(0..cells, 1);
        self.start[0] = 0;
    }

    pub(super) fn memory_bytes(&self) -> usize {
        (self.start.capacity() + self.order.capacity() + self.cell_of.capacity()) * size_of::<u32>()
    }

    /// Number of cells along each axis.
    fn counts(&self) -> [i32; 3] {
        self.boxes.counts().map(|count| (count * self.per_box) as i32)
    }

    /// Number of the cell of a point: box by box, layer by layer inside a box.
    fn cell(&self, point: &Vector3<f64>) -> u32 {
        let (counts, origin) = (self.counts(), self.boxes.origin());
        let point = self.boxes.period().wrapped(point, &origin);
        let mut at = [0; 3];
        for axis in 0..3 {
            let place = ((point[axis] - origin[axis]) / self.size[axis]).floor();
            at[axis] = place.clamp(0.0, f64::from(counts[axis] - 1)) as u32;
        }
        let number = self.boxes.number(at.map(|place| place / self.per_box));
        (number * self.cells_of_box() + self.inside(at.map(|place| place % self.per_box))) as u32
    }

    /// Number of a cell inside its box.
    fn inside(&self, [x, y, z]: [u32; 3]) -> usize {
        ((z * self.per_box + y) * self.per_box + x) as usize
    }

    fn grains(&self, cell: usize) -> Range<usize> {
        self.start[cell] as usize..self.start[cell + 1] as usize
    }

    /// Places of the grains of a box.
    pub fn grains_of_box(&self, number: usize) -> Range<usize> {
        let cells = self.cells_of_box();
        self.start[number * cells] as usize..self.start[(number + 1) * cells] as usize
    }

    /// Patches of a box along an axis: cubes of at least two cells a side, where a box has so many.
    fn patches_per_box(&self) -> u32 {
        (self.per_box / 2).max(1)
    }

    /// Number of patches of all boxes along each axis.
    pub fn patch_counts(&self) -> [u32; 3] {
        self.boxes.counts().map(|count| count * self.patches_per_box())
    }

    /// Width of the narrowest patch, m.
    pub fn patch_width(&self) -> f64 {
        let narrowest = self.size.into_iter().fold(f64::INFINITY, f64::min);
        f64::from(self.per_box / self.patches_per_box()) * narrowest
    }

    /// Calls `visit(patch, places)` for each cell of a box that holds grains; patches are numbered layer by layer over
    /// the whole domain.
    #[inline]
    pub fn for_each_cell(&self, number: usize, mut visit: impl FnMut(usize, Range<usize>)) {
        let [columns, rows, _] = self.patch_counts().map(|count| count as usize);
        let (per_box, patches) = (self.per_box as usize, self.patches_per_box() as usize);
        let first = self.boxes.at(number).map(|place| place as usize * patches);
        for cell in 0..self.cells_of_box() {
            let places = self.grains(number * self.cells_of_box() + cell);
            if !places.is_empty() {
                let inside = [cell % per_box, cell / per_box % per_box, cell / (per_box * per_box)];
                let [x, y, z] = std::array::from_fn(|axis| first[axis] + inside[axis] * patches / per_box);
                visit((z * rows + y) * columns + x, places);
            }
        }
    }

    /// Number of cells of a box.
    pub fn cells_of_box(&self) -> usize {
        (self.per_box * self.per_box * self.per_box) as usize
    }

    /// The boxes around a box.
    pub fn surroundings(&self, number: usize) -> Surroundings {
        let home = self.boxes.at(number).map(|place| place as i32);
        let counts = self.boxes.counts().map(|count| count as i32);
        Surroundings(std::array::from_fn(|direction| {
            let towards = [direction % 3, direction / 3 % 3, direction / 9];
            let at = std::array::from_fn(|axis| home[axis] + towards[axis] as i32 - 1);
            let image = around(at, counts, self.boxes.period())?;
            Some(self.boxes.number(image.map(|place| place as u32)) * self.cells_of_box())
        }))
    }

    /// Fills in the grains of a cell of a box, and the runs of grains in the cells around it that come after it. Grains of one
    /// cell are neighbours too.
    pub fn neighbourhood(&self, surroundings: &Surroundings, cell: usize, found: &mut Neighbourhood) {
        let Some(home) = surroundings.0[SAME_BOX] else { return };
        (found.home, found.count) = (self.grains(home + cell), 0);
        if found.home.is_empty() {
            return;
        }
        let per_box = self.per_box as usize;
        let inside = [cell % per_box, cell / per_box % per_box, cell / (per_box * per_box)];
        for step in FORWARD {
            let (mut direction, mut place) = (0, 0);
            for axis in (0..3).rev() {
                // One cell further may be the first or last one of the next box.
                let (towards, next) = match (step[axis], inside[axis]) {
                    (-1, 0) => (0, per_box - 1),
                    (1, last) if last + 1 == per_box => (2, 0),
                    (step, at) => (1, at.wrapping_add_signed(step as isize)),
                };
                direction = 3 * direction + towards;
                place = per_box * place + next;
            }
            if let Some(first) = surroundings.0[direction] {
                found.add(self.grains(first + place), direction);
            }
        }
    }

    /// Task of the pairs of a box in a direction of a neighbourhood.
    pub fn task(&self, number: usize, direction: usize) -> usize {
        let towards = [direction % 3, direction / 3 % 3, direction / 9].map(|shift| shift as i32 - 1);
        self.boxes.task(self.boxes.at(number), towards)
    }
}

/// The cell or patch that lies at these coordinates, among so many along each axis; none where the domain ends.
#[inline]
pub(super) fn around(at: [i32; 3], counts: [i32; 3], period: &Period) -> Option<[i32; 3]> {
    let mut image = at;
    for axis in 0..3 {
        if at[axis] < 0 || at[axis] >= counts[axis] {
            if !period.is_periodic(axis) {
                return None;
            }
            image[axis] = at[axis].rem_euclid(counts[axis]);
        }
    }
    Some(image)
}

/// Numbers of the first cells of a box and of those around it, by direction as in [`Neighbourhood::runs`]; none where the domain
/// ends.
pub struct Surroundings([Option<usize>; DIRECTIONS]);

/// A cell's grains and those that may touch them, by place.
#[derive(Default)]
pub struct Neighbourhood {
    /// Grains of the cell.
    pub home: Range<usize>,
    runs: [(Range<usize>, usize); FORWARD.len()],
    count: usize,
}

impl Neighbourhood {
    /// Runs of grains that lie together in memory, with the direction of their box: from the home box by -1, 0 or 1 along
    /// x, y and z, as `(dx + 1) + 3 (dy + 1) + 9 (dz + 1)`.
    pub fn runs(&self) -> &[(Range<usize>, usize)] {
        &self.runs[..self.count]
    }

    /// Adds a run; cells that follow each other in memory make one.
    fn add(&mut self, run: Range<usize>, direction: usize) {
        if run.is_empty() {
            return;
        }
        match self.runs[..self.count].last_mut() {
            Some((last, before)) if last.end == run.start && *before == direction => last.end = run.end,
            _ => {
                self.runs[self.count] = (run, direction);
                self.count += 1;
            }
        }
    }
}

/// Direction of a pair inside one box.
pub const SAME_BOX: usize = 13;

/// Number of directions.
pub const DIRECTIONS: usize = 27;
