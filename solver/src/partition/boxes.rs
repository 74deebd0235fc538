//! Boxes with a width of eight diameters, and the stage and task of a pair of grains.

use crate::laws::period::Period;
use crate::world::Sphere;
use nalgebra::Vector3;
use std::cmp::Reverse;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Number of conflict-free stages in three dimensions.
pub const STAGES: usize = 8;

/// Width of a box in diameters of the largest grain.
const WIDTH: f64 = 8.0;

/// Largest number of boxes, over that of a cubic domain with as many grains: a flat domain has more boxes, but a flat
/// and almost empty domain must not have millions.
const MOST_BOXES: f64 = 64.0;

/// Ratio of the width of a domain to the width that its grains need, along each axis. Above this ratio, the domain is
/// too empty for boxes over its whole volume: only occupied regions have boxes.
const EMPTY_FROM: f64 = 1.3;

/// Number of grains below which all pairs in a wide box are compared directly.
const FEW: usize = 1024;

/// Farthest box from the corner of the domain, along an axis that is not periodic. Points beyond belong to this box.
const FURTHEST: f64 = 1e9;

/// Stage of a contact by the set of axes (x = 1, y = 2, z = 4) along which its two boxes differ.
const STAGE_OF_AXES: [usize; 8] = [0, 1, 2, 4, 3, 6, 5, 7];

/// Boxes of the domain: over its whole volume or, for a mostly empty domain or with grains outside, over the occupied regions.
#[derive(Clone, Debug)]
pub struct BoxGrid {
    origin: Vector3<f64>,
    size: Vector3<f64>,
    width: [f64; 3],
    count: [u32; 3],
    period: Period,
    /// Smallest width of a box, m.
    narrowest: f64,
    /// Width of boxes over the whole domain, m; absent for a mostly empty domain.
    whole: Option<f64>,
    /// Largest number of boxes that pays.
    affordable: usize,
    /// Numbered boxes, if only occupied boxes have numbers.
    occupied: Option<Box<Occupied>>,
}

impl BoxGrid {
    /// Divides a domain into boxes for grains of the given largest radius (m).
    ///
    /// A box is at least three times as wide as the interaction range of a pair, so that no body has contacts across two opposite
    /// faces. An integer number of boxes fits a periodic axis, which must be at least three times as long as that range.
    pub fn new(
        domain: &(Vector3<f64>, Vector3<f64>),
        period: &Period,
        grains: usize,
        largest_radius: f64,
        skin: f64,
    ) -> BoxGrid {
        let size = domain.1 - domain.0;
        // A mostly empty domain has wider boxes: empty boxes cost time and memory.
        let boxes = 64.0 + grains as f64 / 8.0;
        let sparse = libm::cbrt(size.product() / boxes);
        let narrowest = (2.0 * WIDTH * largest_radius).max(3.0 * (2.0 * largest_radius + skin)).max(1e-12);
        let mut grid = BoxGrid {
            origin: domain.0,
            size,
            width: [0.0; 3],
            count: [0; 3],
            period: *period,
            narrowest,
            whole: None,
            affordable: boxes as usize,
            occupied: None,
        };
        let mut width = narrowest.max(sparse);
        let product = |count: [f64; 3]| count.iter().product::<f64>();
        while product(grid.count_at(width).map(|count| count.min(1024.0))) > MOST_BOXES * boxes {
            width *= 2.0;
        }
        if grains >= FEW && width > EMPTY_FROM * narrowest {
            (grid.occupied, width) = (Some(Box::default()), narrowest);
        } else {
            grid.whole = Some(width);
        }
        grid.set_width(width);
        grid
    }

    /// Returns the number of boxes of a width (m) along each axis of the domain.
    fn count_at(&self, width: f64) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let count = self.size[axis] / width;
            if self.period.is_periodic(axis) { count.floor() } else { count.ceil() }.max(1.0)
        })
    }

    /// Sets the width of the boxes, m.
    fn set_width(&mut self, width: f64) {
        let most = if self.occupied.is_some() { FURTHEST } else { 1024.0 };
        let count = self.count_at(width).map(|count| count.min(most));
        let periodic = |axis| self.period.is_periodic(axis);
        self.width = [0, 1, 2].map(|axis| if periodic(axis) { self.size[axis] / count[axis] } else { width });
        self.count = count.map(|count| count as u32);
    }

    /// Rebuilds the boxes over occupied regions, if the domain is mostly empty or has grains outside. Boxes have the smallest
    /// width, or wider by powers of two if scattered grains would need too many boxes. Writes the box index of each grain to
    /// `number_of`; returns true if boxes cover occupied regions only. The result depends on the positions of the grains alone.
    pub(crate) fn follow(&mut self, spheres: &[Sphere], number_of: &mut [u32]) -> bool {
        if let Some(width) = self.whole.filter(|_| self.hold(spheres)) {
            if self.occupied.take().is_some() {
                self.set_width(width);
            }
            return false;
        }
        let mut occupied = self.occupied.take().unwrap_or_default();
        let mut width = self.narrowest;
        loop {
            self.occupied = Some(Box::default());
            self.set_width(width);
            let grains = spheres.iter().map(|sphere| self.box_of(&self.period.wrapped(&sphere.centre, &self.origin)));
            let done = occupied.number(grains, number_of, self.affordable, |at, towards| self.step(at, towards));
            // The loop ends, at the latest with all grains in one box.
            if done {
                break;
            }
            width *= 2.0;
        }
        self.occupied = Some(occupied);
        true
    }

    /// Returns true if the centres of all grains are inside the domain.
    fn hold(&self, spheres: &[Sphere]) -> bool {
        let far = self.origin + self.size;
        spheres.iter().all(|Sphere { centre, .. }| {
            let outside = |axis: usize| centre[axis] < self.origin[axis] || centre[axis] > far[axis];
            (0..3).all(|axis| self.period.is_periodic(axis) || !outside(axis))
        })
    }

    /// Returns true if boxes cover occupied regions only.
    pub(crate) fn follows(&self) -> bool {
        self.occupied.is_some()
    }

    /// Returns the coordinates of the box of a point in the domain.
    #[inline]
    pub(crate) fn box_of(&self, point: &Vector3<f64>) -> [i32; 3] {
        [0, 1, 2].map(|axis| {
            let place = ((point[axis] - self.origin[axis]) / self.width[axis]).floor();
            let (least, most) = match self.period.is_periodic(axis) {
                true => (0.0, f64::from(self.count[axis] - 1)),
                false => (-FURTHEST, FURTHEST),
            };
            place.clamp(least, most) as i32
        })
    }

    /// Returns the coordinates of the box at an offset along each axis.
    fn step(&self, at: [i32; 3], towards: [i32; 3]) -> [i32; 3] {
        [0, 1, 2].map(|axis| {
            let next = at[axis] + towards[axis];
            if self.period.is_periodic(axis) { next.rem_euclid(self.count[axis] as i32) } else { next }
        })
    }

    /// Returns the number of boxes.
    pub fn boxes(&self) -> usize {
        match &self.occupied {
            Some(occupied) => occupied.boxes(),
            None => self.count.iter().map(|&count| count as usize).product(),
        }
    }

    /// Returns the largest possible number of boxes for this number of grains. Boxes over occupied regions include the occupied
    /// boxes, limited to the affordable number, and up to seven neighbours of each, as owners of the tasks between boxes.
    pub(crate) fn most(&self) -> usize {
        let whole =
            self.whole.map_or(0.0, |width| self.count_at(width).iter().map(|count| count.min(1024.0)).product());
        (8 * self.affordable.max(1)).max(whole as usize)
    }

    /// Returns the number of boxes along each axis, including empty ones.
    pub(crate) fn counts(&self) -> [u32; 3] {
        self.count
    }

    /// Returns the corner of the first box, m.
    pub(crate) fn origin(&self) -> Vector3<f64> {
        self.origin
    }

    /// Returns the widths of a box, m.
    pub(crate) fn widths(&self) -> [f64; 3] {
        self.width
    }

    /// Returns the periodic axes of the boxes.
    pub(crate) fn period(&self) -> &Period {
        &self.period
    }

    /// Returns the number of tasks: one per stage and box.
    pub fn tasks(&self) -> usize {
        STAGES * self.boxes()
    }

    /// Returns the index of the box with these coordinates, if all boxes are numbered.
    #[inline]
    pub fn number(&self, at: [u32; 3]) -> usize {
        (at[2] as usize * self.count[1] as usize + at[1] as usize) * self.count[0] as usize + at[0] as usize
    }

    /// Returns the coordinates of a box, if all boxes are numbered.
    fn at(&self, number: usize) -> [u32; 3] {
        let (columns, rows) = (self.count[0] as usize, self.count[1] as usize);
        [number % columns, number / columns % rows, number / (columns * rows)].map(|place| place as u32)
    }

    /// Returns the coordinates of a box.
    pub(crate) fn coordinates(&self, number: usize) -> [i32; 3] {
        match &self.occupied {
            Some(occupied) => occupied.at[number],
            None => self.at(number).map(|place| place as i32),
        }
    }

    /// Returns the indices of the neighbours of a box, by direction: see [`towards`]. `None` beyond the domain and for unnumbered boxes.
    #[inline]
    pub(crate) fn around(&self, number: usize) -> [Option<usize>; DIRECTIONS] {
        if let Some(occupied) = &self.occupied {
            return std::array::from_fn(|direction| occupied.neighbour(number, direction));
        }
        let at = self.at(number);
        let places: [[Option<usize>; 3]; 3] = std::array::from_fn(|axis| {
            let (own, last) = (at[axis] as usize, self.count[axis] as usize - 1);
            let repeats = self.period.is_periodic(axis);
            let before = if own > 0 { Some(own - 1) } else { repeats.then_some(last) };
            let after = if own < last { Some(own + 1) } else { repeats.then_some(0) };
            [before, Some(own), after]
        });
        let [columns, rows] = [self.count[0] as usize, self.count[1] as usize];
        std::array::from_fn(|direction| {
            let [x, y, z] = [places[0][direction % 3], places[1][direction / 3 % 3], places[2][direction / 9]];
            Some((z? * rows + y?) * columns + x?)
        })
    }

    /// Returns the task of a contact between grains in a box and its neighbour in a direction: tasks are numbered stage by stage, box by
    /// box. The task belongs to the lowest corner of the two boxes; along a periodic axis, the last box precedes the first.
    #[inline]
    pub(crate) fn task(&self, number: usize, direction: usize) -> usize {
        let towards = towards(direction);
        let axes = (0..3).map(|axis| usize::from(towards[axis] != 0) << axis).sum::<usize>();
        let home = self.home(number, direction);
        STAGE_OF_AXES[axes] * self.boxes() + home.expect("boxes between two that hold grains are numbered")
    }

    /// Returns the box of the task of such a contact; `None` if it has no number, and then no grains are in that direction.
    #[inline]
    pub(crate) fn home(&self, number: usize, direction: usize) -> Option<usize> {
        let [x, y, z] = towards(direction).map(|along| along.min(0));
        self.around(number)[((x + 1) + 3 * (y + 1) + 9 * (z + 1)) as usize]
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.occupied.as_ref().map_or(0, |occupied| occupied.memory_bytes())
    }
}

/// Number of directions from a box to its neighbours, including itself: `(dx + 1) + 3 (dy + 1) + 9 (dz + 1)`.
pub(crate) const DIRECTIONS: usize = 27;

/// Direction from a box to itself.
pub(crate) const SAME_BOX: usize = 13;

/// Marks a box without a number.
const NOWHERE: u32 = u32::MAX;

/// Boxes with grains, and the owners of the tasks between them. The order of their numbers is by the power of two of
/// their grains, the fullest first, and then by the order of all boxes in the domain.
#[derive(Clone, Debug, Default)]
pub(crate) struct Occupied {
    at: Vec<[i32; 3]>,
    numbers: HashMap<[i32; 3], u32, BuildHasherDefault<CoordinateHasher>>,
    /// Number of grains of each box, in the order of discovery.
    grains: Vec<u32>,
    /// Indices of the neighbours of each box, by direction.
    around: Vec<[u32; DIRECTIONS]>,
    /// Indices of the boxes, in the order of discovery.
    found: Vec<u32>,
}

impl Occupied {
    /// Numbers the boxes of the grains, given by their coordinates one after another, unless there are more than `most`
    /// boxes; writes the box index of each grain to `number_of`. `step` returns a neighbour of a box.
    ///
    /// Returns true if the boxes are numbered.
    pub fn number(
        &mut self,
        grains: impl Iterator<Item = [i32; 3]>,
        number_of: &mut [u32],
        most: usize,
        step: impl Fn([i32; 3], [i32; 3]) -> [i32; 3],
    ) -> bool {
        let Occupied { at, numbers, grains: counts, around, found } = self;
        at.clear();
        numbers.clear();
        counts.clear();
        // Grains are stored in the order of the last boxes: the previous grain is usually in the same box.
        let mut last = None;
        for (grain, number_of) in grains.zip(&mut *number_of) {
            let number = match last {
                Some((before, number)) if before == grain => number,
                _ => *numbers.entry(grain).or_insert_with(|| {
                    at.push(grain);
                    counts.push(0);
                    at.len() as u32 - 1
                }),
            };
            counts[number as usize] += 1;
            last = Some((grain, number));
            *number_of = number;
            if at.len() > most {
                return false;
            }
        }
        let count = at.len();
        // A task belongs to the lowest corner of its two boxes, which may be an empty box.
        for place in 0..count {
            let own = at[place];
            // The search from the box on the other side has the same result.
            for direction in 0..SAME_BOX {
                let towards = towards(direction);
                if numbers.get(&step(own, towards)).is_some_and(|&other| (other as usize) < count) {
                    let home = step(own, towards.map(|along| along.min(0)));
                    numbers.entry(home).or_insert_with(|| {
                        at.push(home);
                        at.len() as u32 - 1
                    });
                }
            }
        }
        found.clear();
        found.resize(at.len(), 0);
        counts.resize(at.len(), 0);
        at.sort_unstable_by_key(|own| {
            let (grains, [x, y, z]) = (counts[numbers[own] as usize], *own);
            (Reverse(grains.checked_ilog2()), [z, y, x])
        });
        for (number, own) in at.iter().enumerate() {
            if let Some(known) = numbers.get_mut(own) {
                found[*known as usize] = number as u32;
                *known = number as u32;
            }
        }
        number_of.iter_mut().for_each(|number| *number = found[*number as usize]);
        around.clear();
        around.extend(at.iter().map(|&own| {
            std::array::from_fn(|direction| *numbers.get(&step(own, towards(direction))).unwrap_or(&NOWHERE))
        }));
        true
    }

    /// Returns the number of numbered boxes.
    pub fn boxes(&self) -> usize {
        self.at.len()
    }

    /// Returns the index of the box in a direction from another box, if the box is numbered.
    #[inline]
    pub fn neighbour(&self, number: usize, direction: usize) -> Option<usize> {
        let neighbour = self.around[number][direction];
        (neighbour != NOWHERE).then_some(neighbour as usize)
    }

    pub fn memory_bytes(&self) -> usize {
        self.at.capacity() * size_of::<[i32; 3]>()
            + self.numbers.capacity() * size_of::<([i32; 3], u32)>()
            + self.grains.capacity() * size_of::<u32>()
            + self.around.capacity() * size_of::<[u32; DIRECTIONS]>()
            + self.found.capacity() * size_of::<u32>()
    }
}

/// Hashes the coordinates of boxes with one multiplication each: the input is not adversarial.
#[derive(Clone, Debug, Default)]
struct CoordinateHasher(u64);

impl Hasher for CoordinateHasher {
    fn write(&mut self, bytes: &[u8]) {
        for word in bytes.chunks(size_of::<u32>()) {
            let value = word.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte));
            self.0 = (self.0.rotate_left(26) ^ value).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }

    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }
}

/// Returns the steps along the axes in a direction.
#[inline]
pub(crate) fn towards(direction: usize) -> [i32; 3] {
    [direction % 3, direction / 3 % 3, direction / 9].map(|step| step as i32 - 1)
}
