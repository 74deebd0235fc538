//! Where words go that belong to points: near their point, on no mark and on no other words, and off the lines if that costs little way.

/// A rectangle on a drawing, pixels; vertical coordinates point down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    /// Left and upper corner.
    pub(crate) low: [f64; 2],
    /// Right and lower corner.
    pub(crate) high: [f64; 2],
}

/// Distance between candidates for a place, pixels.
const STEP: f64 = 3.0;

/// Way that is gone around a line, pixels.
const DETOUR: f64 = 12.0;

/// Way that is gone so that the way to the point does not cross other words, pixels.
const LONG_DETOUR: f64 = 60.0;

impl Area {
    /// So far to all sides of a point.
    pub(crate) fn around(at: [f64; 2], half: [f64; 2]) -> Area {
        Area { low: [at[0] - half[0], at[1] - half[1]], high: [at[0] + half[0], at[1] + half[1]] }
    }

    /// Whether two have something in common.
    pub(crate) fn meets(&self, other: &Area) -> bool {
        (0..2).all(|axis| self.low[axis] < other.high[axis] && other.low[axis] < self.high[axis])
    }

    fn holds(&self, other: &Area) -> bool {
        (0..2).all(|axis| self.low[axis] <= other.low[axis] && other.high[axis] <= self.high[axis])
    }

    /// The point of it that is nearest to another.
    pub(crate) fn nearest(&self, to: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|axis| to[axis].clamp(self.low[axis], self.high[axis]))
    }

    /// Whether a straight line runs into it, after Liang and Barsky.
    fn is_crossed(&self, [from, to]: [[f64; 2]; 2]) -> bool {
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let way = to[axis] - from[axis];
            let ends = [self.low[axis], self.high[axis]].map(|edge| (edge - from[axis]) / way);
            if way == 0.0 {
                if from[axis] <= self.low[axis] || from[axis] >= self.high[axis] {
                    return false;
                }
            } else {
                first = first.max(ends[0].min(ends[1]));
                last = last.min(ends[0].max(ends[1]));
            }
        }
        first < last
    }
}

/// What stands in a frame already.
pub(crate) struct Room {
    frame: Area,
    marks: Vec<Area>,
    lines: Vec<[[f64; 2]; 2]>,
    words: Vec<Area>,
}

impl Room {
    /// A frame in which nothing stands.
    pub(crate) fn new(frame: Area) -> Room {
        Room { frame, marks: Vec::new(), lines: Vec::new(), words: Vec::new() }
    }

    /// What words may not hide.
    pub(crate) fn mark(&mut self, area: Area) {
        self.marks.push(area);
    }

    /// What words had better not hide.
    pub(crate) fn line(&mut self, line: [[f64; 2]; 2]) {
        self.lines.push(line);
    }

    /// A place for words of some size beside a point; absent where the frame is full. The place is taken, with the way to it.
    pub(crate) fn place(&mut self, point: [f64; 2], size: [f64; 2]) -> Option<Area> {
        let half = size.map(|length| length / 2.0);
        let Area { low, high } = self.frame;
        let steps: [i64; 2] = std::array::from_fn(|axis| ((high[axis] - low[axis]) / STEP) as i64);
        let offsets = (-steps[0]..=steps[0]).flat_map(|x| (-steps[1]..=steps[1]).map(move |y| [x, y]));
        let near = offsets.filter_map(|offset| {
            let centre = std::array::from_fn(|axis| point[axis] + STEP * offset[axis] as f64);
            let area = Area::around(centre, half);
            self.frame.holds(&area).then(|| (distance(area.nearest(point), point), area))
        });
        let mut near: Vec<(f64, Area)> = near.collect();
        near.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let mut best: Option<(f64, Area)> = None;
        for (way, area) in near {
            if best.is_some_and(|(cost, _)| cost <= way) {
                break;
            }
            let leader = [point, area.nearest(point)];
            if !self.marks.iter().chain(&self.words).any(|other| other.meets(&area)) {
                let hidden = self.lines.iter().filter(|line| area.is_crossed(**line)).count();
                let crossed = self.words.iter().filter(|other| other.is_crossed(leader)).count();
                let cost = way + DETOUR * hidden as f64 + LONG_DETOUR * crossed as f64;
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, area));
                }
            }
        }
        let (_, area) = best?;
        self.words.push(area);
        self.lines.push([point, area.nearest(point)]);
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
