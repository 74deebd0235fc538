//! Boxes eight diameters wide, and the stage and task of a pair of grains.

use crate::laws::period::Period;
use crate::world::Sphere;
use nalgebra::Vector3;
use std::cmp::Reverse;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Number of conflict-free stages in three dimensions.
pub const STAGES: usize = 8;

/// Width of a box in largest diameters.
const WIDTH: f64 = 8.0;

/// Most boxes over those that a cubic domain of as many grains would have: a flat domain has more, a flat one that is next to
/// empty must not have millions.
const MOST_BOXES: f64 = 64.0;

/// A domain that is so much wider, along each axis, than its grains need is emptier than it pays to cut as a whole: boxes are cut
/// where grains are.
const EMPTY_FROM: f64 = 1.3;

/// Of fewer grains than these, the pairs that share a wide box are few enough to be compared one by one.
const FEW: usize = 1024;

/// Furthest box from the corner of the domain, along an axis that does not repeat itself. What is beyond counts to it.
const FURTHEST: f64 = 1e9;

/// Stage of a contact by the set of axes (x = 1, y = 2, z = 4) along which its two boxes differ.
const STAGE_OF_AXES: [usize; 8] = [0, 1, 2, 4, 3, 6, 5, 7];

/// The boxes that cut the domain: all of it, or, where it is mostly empty or grains have left it, what holds grains.
#[derive(Clone, Debug)]
pub struct BoxGrid {
    origin: Vector3<f64>,
    size: Vector3<f64>,
    width: [f64; 3],
    count: [u32; 3],
    period: Period,
    /// Least width of a box, m.
    narrowest: f64,
    /// Width of the boxes that cut all of the domain, m; absent where it is mostly empty.
    whole: Option<f64>,
    /// Boxes that are worth their while.
    affordable: usize,
    /// Numbered boxes, where not all of them are.
    occupied: Option<Box<Occupied>>,
}

impl BoxGrid {
    /// Cuts a domain into boxes for grains of the given largest radius (m).
    ///
    /// A box is never narrower than three times the reach of a pair, so that no body takes part in contacts across two
    /// opposite faces. A whole number of boxes fits a periodic axis, which must not be shorter than three times that reach.
    pub fn new(
        domain: &(Vector3<f64>, Vector3<f64>),
        period: &Period,
        grains: usize,
        largest_radius: f64,
        skin: f64,
    ) -> BoxGrid {
        let size = domain.1 - domain.0;
        // In a domain that is mostly empty, wider boxes: empty ones cost time and memory.
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

    /// Number of boxes of a width (m) along each axis of the domain.
    fn count_at(&self, width: f64) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let count = self.size[axis] / width;
            if self.period.is_periodic(axis) { count.floor() } else { count.ceil() }.max(1.0)
        })
    }

    /// Cuts boxes of a width, m.
    fn set_width(&mut self, width: f64) {
        let most = if self.occupied.is_some() { FURTHEST } else { 1024.0 };
        let count = self.count_at(width).map(|count| count.min(most));
        let periodic = |axis| self.period.is_periodic(axis);
        self.width = [0, 1, 2].map(|axis| if periodic(axis) { self.size[axis] / count[axis] } else { width });
        self.count = count.map(|count| count as u32);
    }

    /// Cuts boxes anew where grains are, if the domain is mostly empty or does not hold all of them: as narrow as boxes may be, or wider by
    /// powers of two if grains are so scattered that there would be more boxes than it pays to have. Leaves the number of each grain's
    /// box in `number_of`; returns whether boxes are cut where grains are. It all depends on the places of the grains alone.
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
            // All are in one box sooner or later.
            if done {
                break;
            }
            width *= 2.0;
        }
        self.occupied = Some(occupied);
        true
    }

    /// Reports whether the domain holds the centres of all grains.
    fn hold(&self, spheres: &[Sphere]) -> bool {
        let far = self.origin + self.size;
        spheres.iter().all(|Sphere { centre, .. }| {
            let outside = |axis: usize| centre[axis] < self.origin[axis] || centre[axis] > far[axis];
            (0..3).all(|axis| self.period.is_periodic(axis) || !outside(axis))
        })
    }

    /// Reports whether boxes are cut where grains are.
    pub(crate) fn follows(&self) -> bool {
        self.occupied.is_some()
    }

    /// Coordinates of the box of a point that is wrapped into the domain.
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

    /// Coordinates of the box so many boxes further along each axis.
    fn step(&self, at: [i32; 3], towards: [i32; 3]) -> [i32; 3] {
        [0, 1, 2].map(|axis| {
            let next = at[axis] + towards[axis];
            if self.period.is_periodic(axis) { next.rem_euclid(self.count[axis] as i32) } else { next }
        })
    }

    /// Number of boxes.
    pub fn boxes(&self) -> usize {
        match &self.occupied {
            Some(occupied) => occupied.boxes(),
            None => self.count.iter().map(|&count| count as usize).product(),
        }
    }

    /// Most boxes that there ever are with as many grains: where they follow the grains, those that hold some are at most as many as are
    /// affordable, and each brings up to seven that tasks between them belong to.
    pub(crate) fn most(&self) -> usize {
        let whole =
            self.whole.map_or(0.0, |width| self.count_at(width).iter().map(|count| count.min(1024.0)).product());
        (8 * self.affordable.max(1)).max(whole as usize)
    }

    /// Number of boxes along each axis, empty ones among them.
    pub(crate) fn counts(&self) -> [u32; 3] {
        self.count
    }

    /// Corner of the first box, m.
    pub(crate) fn origin(&self) -> Vector3<f64> {
        self.origin
    }

    /// Widths of a box, m.
    pub(crate) fn widths(&self) -> [f64; 3] {
        self.width
    }

    /// Axes along which the boxes repeat themselves.
    pub(crate) fn period(&self) -> &Period {
        &self.period
    }

    /// Number of tasks: one a stage and box.
    pub fn tasks(&self) -> usize {
        STAGES * self.boxes()
    }

    /// Number of the box with these coordinates, where all boxes are numbered.
    #[inline]
    pub fn number(&self, at: [u32; 3]) -> usize {
        (at[2] as usize * self.count[1] as usize + at[1] as usize) * self.count[0] as usize + at[0] as usize
    }

    /// Coordinates of a box, where all boxes are numbered.
    fn at(&self, number: usize) -> [u32; 3] {
        let (columns, rows) = (self.count[0] as usize, self.count[1] as usize);
        [number % columns, number / columns % rows, number / (columns * rows)].map(|place| place as u32)
    }

    /// Numbers of the boxes around a box, by direction: see [`towards`]. None where the domain ends or no box is numbered.
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

    /// Task of a contact of grains in a box and in its neighbour in a direction: stage by stage, box by box. It belongs to the
    /// lowest corner of the two; before the first box of a periodic axis comes the last one.
    #[inline]
    pub(crate) fn task(&self, number: usize, direction: usize) -> usize {
        let towards = towards(direction);
        let axes = (0..3).map(|axis| usize::from(towards[axis] != 0) << axis).sum::<usize>();
        let [x, y, z] = towards.map(|along| along.min(0));
        let home = self.around(number)[((x + 1) + 3 * (y + 1) + 9 * (z + 1)) as usize];
        STAGE_OF_AXES[axes] * self.boxes() + home.expect("boxes between two that hold grains are numbered")
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.occupied.as_ref().map_or(0, |occupied| occupied.memory_bytes())
    }
}

/// Number of directions from a box to those around it, itself among them: `(dx + 1) + 3 (dy + 1) + 9 (dz + 1)`.
pub(crate) const DIRECTIONS: usize = 27;

/// Direction of a box to itself.
pub(crate) const SAME_BOX: usize = 13;

/// Marks a box that is not numbered.
const NOWHERE: u32 = u32::MAX;

/// Boxes with grains, and those that tasks between them belong to: numbered by the power of two of their grains, the fullest first, and
/// among these in the order in which all boxes of the domain would be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Occupied {
    at: Vec<[i32; 3]>,
    numbers: HashMap<[i32; 3], u32, BuildHasherDefault<CoordinateHasher>>,
    /// Grains of each box, in the order in which boxes were found.
    grains: Vec<u32>,
    /// Numbers of the boxes around each, by direction.
    around: Vec<[u32; DIRECTIONS]>,
    /// Numbers of the boxes in the order in which they were found.
    found: Vec<u32>,
}

impl Occupied {
    /// Numbers the boxes that grains lie in, given by their coordinates one after the other, unless these are more than `most`;
    /// leaves each grain's in `number_of`. `step` tells which box lies beside one.
    ///
    /// Returns whether it did.
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
        // Grains lie in memory in the order of the last boxes: mostly it is the one before.
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
        // A task belongs to the lowest corner of its two boxes, which may be empty.
        for place in 0..count {
            let own = at[place];
            // The box on the other side finds the same.
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

    /// Number of numbered boxes.
    pub fn boxes(&self) -> usize {
        self.at.len()
    }

    /// Number of the box in a direction from another, if it has one.
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

/// Hashes the coordinates of boxes: a multiplication for each, since no one chooses them to collide.
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

/// Steps along the axes that a direction names.
#[inline]
pub(crate) fn towards(direction: usize) -> [i32; 3] {
    [direction % 3, direction / 3 % 3, direction / 9].map(|step| step as i32 - 1)
}
