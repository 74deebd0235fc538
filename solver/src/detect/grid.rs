//! Grains sorted into cells by counting sort. Boxes are divided into whole cells, so that grains in cell order are also in box
//! order.

use crate::partition::{BoxGrid, DIRECTIONS, SAME_BOX};
use crate::schedule::{Phase, Team};
use crate::world::{World, by_chunk, chunk, chunks};
use nalgebra::Vector3;
use std::ops::Range;

/// Cubic cells over the domain; each box is divided into the same number of cells.
#[derive(Clone, Debug)]
pub struct CellGrid {
    boxes: BoxGrid,
    /// Least width of a cell, m.
    reach: f64,
    /// Number of grains that the boxes and cells were chosen for.
    grains: usize,
    /// Cells of a box along an axis.
    per_box: u32,
    size: [f64; 3],
    /// Index of each cell's first grain, and a final end entry.
    start: Vec<u32>,
    /// Old indices of the grains, cell after cell.
    order: Vec<u32>,
    cell_of: Vec<u32>,
    /// Patches of a box's cells, in the order of the cells.
    runs: Vec<PatchRun>,
}

/// Consecutive cells of a box that belong to one patch.
#[derive(Clone, Copy, Debug)]
struct PatchRun {
    /// Number of the patch in the box.
    patch: u32,
    /// End of the run: first cell after it.
    end: u32,
}

/// Later neighbours of a cell, so that each pair of cells is visited once.
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
    /// Creates cells no smaller than `reach` (m) in the boxes of a world with the given number of grains.
    pub fn new(boxes: &BoxGrid, grains: usize, reach: f64) -> CellGrid {
        let mut grid = CellGrid {
            boxes: boxes.clone(),
            reach,
            grains,
            per_box: 1,
            size: boxes.widths(),
            start: Vec::new(),
            order: Vec::new(),
            cell_of: Vec::new(),
            runs: Vec::new(),
        };
        grid.cut_boxes();
        grid
    }

    /// Returns the number of grains that the boxes and cells were chosen for.
    pub(crate) fn chosen_for(&self) -> usize {
        self.grains
    }

    /// Returns the boxes as of the last sort.
    pub fn boxes(&self) -> &BoxGrid {
        &self.boxes
    }

    /// Divides each box into cells, and groups these into patches.
    fn cut_boxes(&mut self) {
        let boxes = &self.boxes;
        // Empty cells cost time too: at most about eight per grain.
        let most = libm::cbrt((8.0 * self.grains as f64 + 4096.0) / boxes.boxes() as f64);
        // Around a periodic axis, the two neighbours of a cell must differ.
        let around = |axis: usize| f64::from(3_u32.div_ceil(boxes.counts()[axis]));
        let least = (0..3).filter(|&axis| boxes.period().is_periodic(axis)).map(around).fold(1.0, f64::max);
        let narrowest = boxes.widths().into_iter().fold(f64::INFINITY, f64::min);
        let per_box = (narrowest / self.reach.max(1e-300)).floor().min(most.floor()).clamp(least, 1024.0);
        self.per_box = per_box as u32;
        self.size = boxes.widths().map(|width| width / per_box);
        let (per_box, patches) = (self.per_box, self.patches_per_box());
        self.runs.clear();
        for cell in 0..per_box * per_box * per_box {
            let inside = [cell % per_box, cell / per_box % per_box, cell / (per_box * per_box)];
            let [x, y, z] = inside.map(|at| at * patches / per_box);
            let (patch, end) = ((z * patches + y) * patches + x, cell + 1);
            match self.runs.last_mut() {
                Some(run) if run.patch == patch => run.end = end,
                _ => self.runs.push(PatchRun { patch, end }),
            }
        }
    }

    /// Sorts the grains of a world. Returns the old index of the grain at each new index. Within a cell, grains are in the order
    /// of their ids, so that the order depends on positions and ids alone.
    pub fn sort(&mut self, world: &World, team: &Team) -> &[u32] {
        let grains = world.grains();
        let mut cell_of = std::mem::take(&mut self.cell_of);
        cell_of.resize(grains, 0);
        let followed = self.boxes.follows();
        let follows = team.alone(Phase::Detect, || self.boxes.follow(&world.spheres[..grains], &mut cell_of));
        if follows || followed {
            self.cut_boxes();
        }
        team.each_with(Phase::Detect, chunks(grains), by_chunk(&mut cell_of), |number, cells| {
            for (cell, sphere) in cells.iter_mut().zip(&world.spheres[chunk(number, grains)]) {
                *cell = match follows {
                    true => self.cell_in_box(*cell, &sphere.centre),
                    false => self.cell(&sphere.centre),
                };
            }
        });
        self.cell_of = cell_of;
        team.alone(Phase::Detect, || self.count(&world.ids));
        &self.order
    }

    /// Number of the cell of a point in the given box.
    fn cell_in_box(&self, number: u32, point: &Vector3<f64>) -> u32 {
        let origin = self.boxes.origin();
        let point = self.boxes.period().wrapped(point, &origin);
        let (first, widths) = (self.boxes.box_of(&point), self.boxes.widths());
        let at = [0, 1, 2].map(|axis| {
            let inside = point[axis] - origin[axis] - f64::from(first[axis]) * widths[axis];
            (inside / self.size[axis]).floor().clamp(0.0, f64::from(self.per_box - 1)) as u32
        });
        number * self.cells_of_box() as u32 + self.inside(at) as u32
    }

    /// Sorts by counting, and each cell by the ids of its grains.
    fn count(&mut self, ids: &[u32]) {
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
        for ends in self.start.windows(2).filter(|ends| ends[1] > ends[0] + 1) {
            self.order[ends[0] as usize..ends[1] as usize].sort_unstable_by_key(|&grain| ids[grain as usize]);
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        (self.start.capacity() + self.order.capacity() + self.cell_of.capacity()) * size_of::<u32>()
            + self.runs.capacity() * size_of::<PatchRun>()
            + self.boxes.memory_bytes()
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

    /// Returns the body indices of the grains of a box.
    pub fn grains_of_box(&self, number: usize) -> Range<usize> {
        let cells = self.cells_of_box();
        self.start[number * cells] as usize..self.start[(number + 1) * cells] as usize
    }

    /// Patches of a box along an axis: cubes of at least two cells per side, if the box has two.
    fn patches_per_box(&self) -> u32 {
        (self.per_box / 2).max(1)
    }

    /// Number of patches of a box.
    pub fn patches_of_box(&self) -> usize {
        self.patches_per_box().pow(3) as usize
    }

    /// Width of the narrowest patch, m.
    pub fn patch_width(&self) -> f64 {
        let narrowest = self.size.into_iter().fold(f64::INFINITY, f64::min);
        f64::from(self.per_box / self.patches_per_box()) * narrowest
    }

    /// Calls `visit(patch, places)` for the grains of a box, once per contiguous run of one patch; patches are numbered inside
    /// the box.
    #[inline]
    pub fn for_each_run(&self, number: usize, mut visit: impl FnMut(usize, Range<usize>)) {
        let first = number * self.cells_of_box();
        let start = &self.start[first..=first + self.cells_of_box()];
        let mut place = start[0] as usize;
        for run in &self.runs {
            let places = place..start[run.end as usize] as usize;
            place = places.end;
            if !places.is_empty() {
                visit(run.patch as usize, places);
            }
        }
    }

    /// Returns the neighbour patch at an offset from a patch of a box, as the direction of its box and its number there.
    #[inline]
    pub fn patch_beside(&self, patch: usize, step: [i32; 3]) -> (usize, usize) {
        beside(patch, self.patches_per_box() as usize, step)
    }

    /// Number of cells of a box.
    pub fn cells_of_box(&self) -> usize {
        (self.per_box * self.per_box * self.per_box) as usize
    }

    /// Returns the neighbours of a box.
    pub fn surroundings(&self, number: usize) -> Surroundings {
        Surroundings(self.boxes.around(number).map(|place| Some(place? * self.cells_of_box())))
    }

    /// Fills in the grains of a cell of a box, and the runs of grains in the later neighbour cells. Grains of one cell are
    /// neighbours too.
    pub fn neighbourhood(&self, surroundings: &Surroundings, cell: usize, found: &mut Neighbourhood) {
        let Some(home) = surroundings.0[SAME_BOX] else { return };
        (found.home, found.count) = (self.grains(home + cell), 0);
        if found.home.is_empty() {
            return;
        }
        for step in FORWARD {
            let (direction, place) = beside(cell, self.per_box as usize, step);
            if let Some(first) = surroundings.0[direction] {
                found.add(self.grains(first + place), direction);
            }
        }
    }

    /// Returns the task of the pairs of a box in a direction of a neighbourhood.
    pub fn task(&self, number: usize, direction: usize) -> usize {
        self.boxes.task(number, direction)
    }
}

/// Finds the neighbour cell or patch at an offset, given the number of cells or patches of a box per axis. Returns the direction
/// of its box, which may be the next one, and its number there.
#[inline(always)]
fn beside(number: usize, per_box: usize, step: [i32; 3]) -> (usize, usize) {
    let inside = [number % per_box, number / per_box % per_box, number / (per_box * per_box)];
    let (mut direction, mut place) = (0, 0);
    for axis in (0..3).rev() {
        // The next cell may be the first or last one of the neighbour box.
        let (towards, next) = match (step[axis], inside[axis]) {
            (-1, 0) => (0, per_box - 1),
            (1, last) if last + 1 == per_box => (2, 0),
            (step, at) => (1, at.wrapping_add_signed(step as isize)),
        };
        direction = 3 * direction + towards;
        place = per_box * place + next;
    }
    (direction, place)
}

/// Numbers of the first cells of a box and of its neighbours, by direction as in [`Neighbourhood::runs`]; `None` beyond the
/// domain.
pub struct Surroundings([Option<usize>; DIRECTIONS]);

/// Body indices of a cell's grains and their potential contacts.
#[derive(Default)]
pub struct Neighbourhood {
    /// Grains of the cell.
    pub home: Range<usize>,
    runs: [(Range<usize>, usize); FORWARD.len()],
    count: usize,
}

impl Neighbourhood {
    /// Returns runs of grains that are contiguous in memory, with the direction of their box: offset -1, 0 or 1 from the home box
    /// along x, y and z, as `(dx + 1) + 3 (dy + 1) + 9 (dz + 1)`.
    pub fn runs(&self) -> &[(Range<usize>, usize)] {
        &self.runs[..self.count]
    }

    /// Adds a run; contiguous cells are merged into one run.
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
