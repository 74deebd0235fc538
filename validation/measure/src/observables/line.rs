//! Straight line through pieces of a contour, by total least squares.

use super::contour::Segment;

/// Straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Point on the line, m.
    pub point: [f64; 2],
    /// Unit direction, with a positive first component.
    pub direction: [f64; 2],
}

impl Line {
    /// Fits the line with the least squared distance, integrated along the pieces; `None` without pieces.
    ///
    /// Distances are perpendicular to the line, so that steep lines are treated like flat ones.
    pub fn fit(pieces: impl Iterator<Item = Segment>) -> Option<Line> {
        // Moments of a uniform rod: its middle, and a twelfth of its squared extent about it.
        let (mut length, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
        for [a, b] in pieces {
            let rod = [b[0] - a[0], b[1] - a[1]];
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let weight = rod[0].hypot(rod[1]);
            length += weight;
            for axis in 0..2 {
                first[axis] += weight * middle[axis];
                second[axis] += weight * (middle[axis].powi(2) + rod[axis].powi(2) / 12.0);
            }
            second[2] += weight * (middle[0] * middle[1] + rod[0] * rod[1] / 12.0);
        }
        if length <= 0.0 {
            return None;
        }
        let point = first.map(|sum| sum / length);
        let spread = [second[0] / length - point[0].powi(2), second[1] / length - point[1].powi(2)];
        let mixed = second[2] / length - point[0] * point[1];
        let (sine, cosine) = (0.5 * (2.0 * mixed).atan2(spread[0] - spread[1])).sin_cos();
        Some(Line { point, direction: [cosine, sine] })
    }

    /// Returns the position of a point along the line, m, from [`Self::point`].
    pub fn along(&self, point: [f64; 2]) -> f64 {
        (point[0] - self.point[0]) * self.direction[0] + (point[1] - self.point[1]) * self.direction[1]
    }

    /// Returns the distance of a point from the line, m, positive on its left (above it).
    pub fn above(&self, point: [f64; 2]) -> f64 {
        (point[1] - self.point[1]) * self.direction[0] - (point[0] - self.point[0]) * self.direction[1]
    }

    /// Returns the point of the line nearest to `point`, m.
    pub fn foot(&self, point: [f64; 2]) -> [f64; 2] {
        let along = self.along(point);
        [self.point[0] + along * self.direction[0], self.point[1] + along * self.direction[1]]
    }

    /// Returns the inclination, degrees, positive if the line rises with the first coordinate.
    pub fn degrees(&self) -> f64 {
        self.direction[1].atan2(self.direction[0]).to_degrees()
    }
}

/// Returns the part of a segment with a coordinate (a linear function of the point) between `low` and `high`.
pub fn clip([a, b]: Segment, coordinate: impl Fn([f64; 2]) -> f64, low: f64, high: f64) -> Option<Segment> {
    let (at_a, at_b) = (coordinate(a), coordinate(b));
    let change = at_b - at_a;
    if change.abs() < f64::MIN_POSITIVE {
        return (low..=high).contains(&at_a).then_some([a, b]);
    }
    let (to_low, to_high) = ((low - at_a) / change, (high - at_a) / change);
    let (start, end) = (to_low.min(to_high).max(0.0), to_low.max(to_high).min(1.0));
    let at = |share: f64| [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
    (start < end).then(|| [at(start), at(end)])
}
