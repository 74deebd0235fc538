//! Grains sorted into cells by counting.

use nalgebra::Vector3;

/// A grid of cubic cells over the domain, with the grains of each cell in a row.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    origin: Vector3<f64>,
    size: f64,
    count: [usize; 3],
    /// Place in `order` of each cell's first grain; one more entry than cells.
    start: Vec<u32>,
    /// Grains, cell after cell, by id within a cell.
    order: Vec<u32>,
    cell_of: Vec<u32>,
}

/// Neighbours of a cell that come after it, so that each pair of cells is visited once.
const FORWARD: [[i64; 3]; 13] = [
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
    /// Sorts grains into cells no smaller than `reach` (m), over the part of the domain that holds grains. Grains outside
    /// it count to its outermost cells.
    pub fn sort(&mut self, positions: &[Vector3<f64>], domain: &(Vector3<f64>, Vector3<f64>), reach: f64) {
        let (mut low, mut high) = (domain.1, domain.0);
        for position in positions {
            low = low.inf(position);
            high = high.sup(position);
        }
        self.origin = low.sup(&domain.0);
        let extent = (high.inf(&domain.1) - self.origin).map(|width| width.max(reach));
        // Empty cells cost time too: no more than about eight a grain.
        let most = 8.0 * positions.len() as f64 + 512.0;
        self.size = reach.max(libm::cbrt(extent.product() / most));
        self.count = [extent.x, extent.y, extent.z].map(|width| (width / self.size).ceil().clamp(1.0, 4096.0) as usize);
        let cells: usize = self.count.iter().product();
        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell_of.clear();
        for position in positions {
            let cell = self.cell(position) as u32;
            self.cell_of.push(cell);
            self.start[cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            self.start[cell + 1] += self.start[cell];
        }
        self.order.clear();
        self.order.resize(positions.len(), 0);
        for (grain, &cell) in self.cell_of.iter().enumerate() {
            let place = &mut self.start[cell as usize];
            self.order[*place as usize] = grain as u32;
            *place += 1;
        }
        // Filling moved each start to its end: shift back.
        for cell in (1..=cells).rev() {
            self.start[cell] = self.start[cell - 1];
        }
        self.start[0] = 0;
    }

    pub(super) fn memory_bytes(&self) -> usize {
        (self.start.capacity() + self.order.capacity() + self.cell_of.capacity()) * size_of::<u32>()
    }

    fn cell(&self, position: &Vector3<f64>) -> usize {
        let mut cell = [0; 3];
        for axis in 0..3 {
            let place = ((position[axis] - self.origin[axis]) / self.size).floor();
            cell[axis] = place.clamp(0.0, (self.count[axis] - 1) as f64) as usize;
        }
        (cell[2] * self.count[1] + cell[1]) * self.count[0] + cell[0]
    }

    fn grains(&self, cell: usize) -> &[u32] {
        &self.order[self.start[cell] as usize..self.start[cell + 1] as usize]
    }

    /// Calls `visit` for each pair of grains in the same or in neighbouring cells, in an order that positions alone fix.
    pub fn for_each_pair(&self, mut visit: impl FnMut(u32, u32)) {
        let [columns, rows, layers] = self.count.map(|count| count as i64);
        for z in 0..layers {
            for y in 0..rows {
                for x in 0..columns {
                    let here = self.grains(((z * rows + y) * columns + x) as usize);
                    for (place, &first) in here.iter().enumerate() {
                        for &second in &here[place + 1..] {
                            visit(first, second);
                        }
                    }
                    if here.is_empty() {
                        continue;
                    }
                    for [dx, dy, dz] in FORWARD {
                        let (x, y, z) = (x + dx, y + dy, z + dz);
                        if x < 0 || x >= columns || y < 0 || y >= rows || z >= layers {
                            continue;
                        }
                        for &second in self.grains(((z * rows + y) * columns + x) as usize) {
                            for &first in here {
                                visit(first, second);
                            }
                        }
                    }
                }
            }
        }
    }
}
