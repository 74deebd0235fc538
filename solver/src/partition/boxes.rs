//! Boxes eight diameters wide, and the stage and task of a pair of grains.

use nalgebra::Vector3;

/// Number of conflict-free stages in three dimensions.
pub const STAGES: usize = 8;

/// Width of a box in largest diameters.
const WIDTH: f64 = 8.0;

/// Most boxes over those that a cubic domain of as many grains would have: a flat domain has more, a flat one that is next to
/// empty must not have millions.
const MOST_BOXES: f64 = 64.0;

/// Stage of a contact by the set of axes (x = 1, y = 2, z = 4) along which its two boxes differ.
const STAGE_OF_AXES: [usize; 8] = [0, 1, 2, 4, 3, 6, 5, 7];

/// The boxes that cut the domain.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxGrid {
    origin: Vector3<f64>,
    width: f64,
    count: [u32; 3],
}

impl BoxGrid {
    /// Cuts a domain into boxes for grains of the given largest radius (m).
    ///
    /// A box is never narrower than three times the reach of a pair, so that no body takes part in contacts across two
    /// opposite faces.
    pub fn new(domain: &(Vector3<f64>, Vector3<f64>), grains: usize, largest_radius: f64, skin: f64) -> BoxGrid {
        let size = domain.1 - domain.0;
        // In a domain that is mostly empty, wider boxes: empty ones cost time and memory.
        let boxes = 64.0 + grains as f64 / 8.0;
        let sparse = libm::cbrt(size.product() / boxes);
        let mut width = (2.0 * WIDTH * largest_radius).max(3.0 * (2.0 * largest_radius + skin)).max(sparse).max(1e-12);
        let count_at = |width: f64| [size.x, size.y, size.z].map(|length| (length / width).ceil().clamp(1.0, 1024.0));
        while count_at(width).iter().product::<f64>() > MOST_BOXES * boxes {
            width *= 2.0;
        }
        let count = count_at(width).map(|count| count as u32);
        BoxGrid { origin: domain.0, width, count }
    }

    /// Number of boxes.
    pub fn boxes(&self) -> usize {
        self.count.iter().map(|&count| count as usize).product()
    }

    /// Number of boxes along each axis.
    pub(crate) fn counts(&self) -> [u32; 3] {
        self.count
    }

    /// Corner of the first box, m.
    pub(crate) fn origin(&self) -> Vector3<f64> {
        self.origin
    }

    /// Width of a box, m.
    pub(crate) fn width(&self) -> f64 {
        self.width
    }

    /// Number of tasks: one a stage and box.
    pub fn tasks(&self) -> usize {
        STAGES * self.boxes()
    }

    /// Number of the box with these coordinates.
    #[inline]
    pub fn number(&self, at: [u32; 3]) -> usize {
        (at[2] as usize * self.count[1] as usize + at[1] as usize) * self.count[0] as usize + at[0] as usize
    }

    /// Coordinates of a box.
    pub(crate) fn at(&self, number: usize) -> [u32; 3] {
        let (columns, rows) = (self.count[0] as usize, self.count[1] as usize);
        [number % columns, number / columns % rows, number / (columns * rows)].map(|place| place as u32)
    }

    /// Task of a contact of grains in two boxes, the same or neighbours: stage by stage, box by box.
    #[inline]
    pub fn task(&self, first: [u32; 3], second: [u32; 3]) -> usize {
        let mut axes = 0;
        let mut lower = [0; 3];
        for axis in 0..3 {
            axes |= usize::from(first[axis] != second[axis]) << axis;
            lower[axis] = first[axis].min(second[axis]);
        }
        STAGE_OF_AXES[axes] * self.boxes() + self.number(lower)
    }
}
