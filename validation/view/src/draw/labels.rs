//! Placement of words next to points: near their point, on no mark and on no other words.

use std::f64::consts::TAU;

/// A rectangle on a drawing, pixels; vertical coordinates point down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    /// Left and upper corner.
    pub(crate) low: [f64; 2],
    /// Right and lower corner.
    pub(crate) high: [f64; 2],
}

/// Distance between the rings of candidates about a point, pixels.
const STEP: f64 = 3.0;

/// Candidates of a ring.
const TURNS: u32 = 32;

impl Area {
    pub(crate) fn around(at: [f64; 2], half: [f64; 2]) -> Area {
        Area { low: [at[0] - half[0], at[1] - half[1]], high: [at[0] + half[0], at[1] + half[1]] }
    }

    fn meets(&self, other: &Area) -> bool {
        (0..2).all(|axis| self.low[axis] < other.high[axis] && other.low[axis] < self.high[axis])
    }

    fn holds(&self, other: &Area) -> bool {
        (0..2).all(|axis| self.low[axis] <= other.low[axis] && other.high[axis] <= self.high[axis])
    }

    /// Returns its point nearest to another.
    pub(crate) fn nearest(&self, to: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|axis| to[axis].clamp(self.low[axis], self.high[axis]))
    }
}

/// A frame with the areas that are occupied.
pub(crate) struct Room {
    frame: Area,
    taken: Vec<Area>,
}

impl Room {
    pub(crate) fn new(frame: Area) -> Room {
        Room { frame, taken: Vec::new() }
    }

    /// Occupies an area.
    pub(crate) fn take(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// Occupies a free area of some size near a point; `None` where the frame is full.
    pub(crate) fn place(&mut self, point: [f64; 2], size: [f64; 2]) -> Option<Area> {
        let reach = distance(self.frame.low, self.frame.high) / STEP;
        let candidates = (1..reach as u32).flat_map(|ring| (0..TURNS).map(move |turn| (ring, turn)));
        let mut areas = candidates.map(|(ring, turn)| {
            let (sine, cosine) = (TAU * f64::from(turn) / f64::from(TURNS)).sin_cos();
            let away = STEP * f64::from(ring);
            Area::around([point[0] + away * cosine, point[1] - away * sine], size.map(|length| length / 2.0))
        });
        let is_free = |area: &Area| self.frame.holds(area) && !self.taken.iter().any(|other| other.meets(area));
        let area = areas.find(is_free)?;
        self.taken.push(area);
        Some(area)
    }
}

/// Distance of two points.
pub(crate) fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

#[cfg(test)]
#[path = "../../tests/unit/draw_labels.rs"]
mod tests;
