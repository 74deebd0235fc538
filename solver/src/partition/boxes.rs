//! Boxes eight diameters wide, and the stage and task of a pair of grains.

use crate::effects::period::Period;
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
    width: [f64; 3],
    count: [u32; 3],
    period: Period,
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
        let mut width = (2.0 * WIDTH * largest_radius).max(3.0 * (2.0 * largest_radius + skin)).max(sparse).max(1e-12);
        let count_at = |width: f64| {
            [0, 1, 2].map(|axis| {
                let count = size[axis] / width;
                if period.is_periodic(axis) { count.floor() } else { count.ceil() }.clamp(1.0, 1024.0)
            })
        };
        while count_at(width).iter().product::<f64>() > MOST_BOXES * boxes {
            width *= 2.0;
        }
        let count = count_at(width);
        let width = [0, 1, 2].map(|axis| if period.is_periodic(axis) { size[axis] / count[axis] } else { width });
        BoxGrid { origin: domain.0, width, count: count.map(|count| count as u32), period: *period }
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

    /// Task of a contact of grains in a box and in its neighbour that lies so many boxes (-1, 0 or 1) further along each axis:
    /// stage by stage, box by box.
    #[inline]
    pub fn task(&self, at: [u32; 3], towards: [i32; 3]) -> usize {
        let mut axes = 0;
        let mut lower = at;
        for axis in 0..3 {
            axes |= usize::from(towards[axis] != 0) << axis;
            if towards[axis] < 0 {
                // Before the first box of a periodic axis comes the last one.
                lower[axis] = at[axis].checked_sub(1).unwrap_or(self.count[axis] - 1);
            }
        }
        STAGE_OF_AXES[axes] * self.boxes() + self.number(lower)
    }
}
