//! Plot: a frame with two axes, a light grid, a legend above; labels next to points.

use super::names::{CodeStyle, code_style};
use super::numbers::{compact, round_ticks, superscript};
use super::svg::{Anchor, Drawing};
use std::f64::consts::TAU;

const WIDTH: f64 = 540.0;
const HEIGHT: f64 = 330.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 44.0;
const TICK_HEIGHT: f64 = 11.0;
/// Height of a line of a legend.
const LEGEND_LINE: f64 = 18.0;
/// Height of a line of the key of numbers.
const KEY_LINE: f64 = 15.0;
/// Half the size of the largest marker.
const MARKER: f64 = 6.5;
/// Smallest distance between a marker's middle and its number that requires a leader line.
const LEADER: f64 = 11.0;
/// Left end of the lines of a legend with several lines.
const LEGEND_LEFT: f64 = 14.0;

/// Entry of a legend.
pub enum Key<'a> {
    /// Code, drawn as a line with its marker.
    Code(&'a str),
    /// Line of another class.
    Line(&'a str, &'a str),
    /// Line of a style, with its marker, and its label.
    Series(CodeStyle, &'a str),
    /// Marker alone, and its label.
    Points(CodeStyle, &'a str),
}

impl Key<'_> {
    /// Returns the width in a legend, with a gap after it.
    fn width(&self) -> f64 {
        let (Key::Code(label) | Key::Line(_, label) | Key::Series(_, label) | Key::Points(_, label)) = self;
        // Text is not measured here; 7.6 pixels per character is a generous width.
        50.0 + 7.6 * label.chars().count() as f64
    }
}

/// Plot under construction.
pub struct Plot {
    drawing: Drawing,
    x: Axis,
    y: Axis,
    /// Upper and lower edge of the frame.
    top: f64,
    bottom: f64,
    /// Areas of markers and numbers.
    room: Room,
}

impl Plot {
    /// Makes a frame with its axes, and above it a legend with the necessary number of lines.
    pub fn with_legend(x: Axis, y: Axis, keys: &[Key<'_>]) -> Plot {
        let (mut lines, mut right) = (vec![Vec::new()], LEGEND_LEFT);
        for key in keys {
            // A legend of one line begins at the frame.
            let over = if lines.len() > 1 { 0.0 } else { LEFT - LEGEND_LEFT };
            let line = lines.last_mut().expect("there is a line from the beginning");
            right += key.width();
            if right + over > WIDTH && !line.is_empty() {
                right = LEGEND_LEFT + key.width();
                lines.push(vec![key]);
            } else {
                line.push(key);
            }
        }
        let mut plot = Plot::below_legend(x, y, lines.len());
        let left = if lines.len() > 1 { LEGEND_LEFT } else { LEFT };
        for (place, line) in lines.into_iter().enumerate() {
            plot.legend_line(line.into_iter(), [left, 14.0 + LEGEND_LINE * place as f64]);
        }
        plot
    }

    fn below_legend(x: Axis, y: Axis, lines: usize) -> Plot {
        let more = LEGEND_LINE * lines.saturating_sub(1) as f64;
        let (top, bottom) = (TOP + more, HEIGHT + more - BOTTOM);
        let mut plot = Plot {
            drawing: Drawing::new(WIDTH, HEIGHT + more),
            x,
            y,
            top,
            bottom,
            room: Room::new(Area { low: [LEFT, top], high: [WIDTH - RIGHT, bottom] }),
        };
        plot.grid();
        plot
    }

    fn grid(&mut self) {
        let (left, right, top, bottom) = (LEFT, WIDTH - RIGHT, self.top, self.bottom);
        for (value, label) in self.x.ticks(7) {
            let x = self.at(value, self.y.low)[0];
            self.drawing.line("grid", [x, top], [x, bottom]);
            self.drawing.text("tick", [x, bottom + 15.0], Anchor::Middle, &label);
        }
        for (value, label) in self.y.ticks(6) {
            let y = self.at(self.x.low, value)[1];
            self.drawing.line("grid", [left, y], [right, y]);
            self.drawing.text("tick", [left - 7.0, y + 4.0], Anchor::End, &label);
        }
        self.drawing.rectangle("frame", [left, top], [right, bottom]);
        let (x, y) = (self.x.label.clone(), self.y.label.clone());
        self.drawing.text("label", [(left + right) / 2.0, bottom + BOTTOM - 8.0], Anchor::Middle, &x);
        self.drawing.text_upwards("label", [13.0, (top + bottom) / 2.0], &y);
    }

    /// Returns the position of a point of the plane on the drawing.
    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        [LEFT + self.x.share(x) * (WIDTH - LEFT - RIGHT), self.bottom - self.y.share(y) * (self.bottom - self.top)]
    }

    /// Marks a range of the horizontal axis.
    pub fn window(&mut self, from: f64, to: f64, label: &str) {
        let (from, to) = (from.max(self.x.low), to.min(self.x.high));
        if to <= from {
            return;
        }
        let (a, b) = (self.at(from, self.y.high), self.at(to, self.y.low));
        let (a, b) = ([a[0], self.top], [b[0], self.bottom]);
        self.drawing.rectangle("window", a, b);
        self.drawing.text("tick", [b[0] - 5.0, b[1] - 6.0], Anchor::End, label);
    }

    /// Draws a curve of a class, cut off at the frame.
    pub fn curve(&mut self, class: &str, points: impl Iterator<Item = [f64; 2]>) {
        let points: Vec<[f64; 2]> = points.map(|[x, y]| self.at(x, y)).collect();
        self.drawing.begin_clip([LEFT, self.top], WIDTH - LEFT - RIGHT, self.bottom - self.top);
        self.drawing.curve(class, points.into_iter());
        self.drawing.end_clip();
    }

    /// Draws a code's marker, if it lies inside the frame.
    pub fn marker(&mut self, style: CodeStyle, x: f64, y: f64, size: f64) {
        if self.contains(x, y) {
            self.mark(style, [x, y], size, false);
        }
    }

    /// Draws a code's open marker, if it lies inside the frame.
    pub fn open_marker(&mut self, style: CodeStyle, x: f64, y: f64, size: f64) {
        if self.contains(x, y) {
            self.mark(style, [x, y], size, true);
        }
    }

    fn mark(&mut self, style: CodeStyle, [x, y]: [f64; 2], size: f64, hollow: bool) {
        let at = self.at(x, y);
        // The widest shape is 1.25 times as wide as its nominal size.
        self.room.take(Area::around(at, [1.3 * size; 2]));
        self.drawing.marker(style, at, size, hollow);
    }

    /// Draws a vertical error bar, cut off at the frame.
    pub fn error_bar(&mut self, class: &str, x: f64, low: f64, high: f64) {
        let low = low.max(self.y.low);
        let high = high.min(self.y.high);
        if self.contains(x, low) && self.contains(x, high) {
            let (a, b) = (self.at(x, low), self.at(x, high));
            self.drawing.line(class, a, b);
        }
    }

    fn contains(&self, x: f64, y: f64) -> bool {
        (self.x.low..=self.x.high).contains(&x) && (self.y.low..=self.y.high).contains(&y)
    }

    fn legend_line<'a>(&mut self, keys: impl Iterator<Item = &'a Key<'a>>, [mut x, y]: [f64; 2]) {
        for key in keys {
            let label = match *key {
                Key::Code(code) => {
                    self.sample(code_style(code), x, y);
                    code
                }
                Key::Series(style, label) => {
                    self.sample(style, x, y);
                    label
                }
                Key::Points(style, label) => {
                    self.drawing.marker(style, [x + 20.0, y], 3.6, false);
                    label
                }
                Key::Line(class, label) => {
                    self.drawing.line(class, [x, y], [x + 26.0, y]);
                    label
                }
            };
            self.drawing.text("key", [x + 32.0, y + 4.0], Anchor::Start, label);
            x += key.width();
        }
    }

    fn sample(&mut self, style: CodeStyle, x: f64, y: f64) {
        self.drawing.line(&format!("{} curve", style.class), [x, y], [x + 26.0, y]);
        self.drawing.marker(style, [x + 13.0, y], 3.6, false);
    }

    /// Draws a short text next to a point, at an offset in pixels.
    pub fn label(&mut self, [x, y]: [f64; 2], [right, down]: [f64; 2], anchor: Anchor, text: &str) {
        let [x, y] = self.at(x, y);
        self.drawing.text("tick", [x + right, y + down], anchor, text);
    }

    /// Draws a number next to an existing marker, where it hides neither markers nor other numbers, with a leader line to a distant marker.
    /// Markers and curves must be drawn first.
    pub fn number(&mut self, [x, y]: [f64; 2], number: usize) {
        let (at, text) = (self.at(x, y), number.to_string());
        let Some(area) = self.room.place(at, [width_of(&text) + 2.0, TICK_HEIGHT]) else { return };
        let near = area.nearest(at);
        let way = distance(near, at);
        if way > LEADER {
            let edge = std::array::from_fn(|axis| at[axis] + (near[axis] - at[axis]) * MARKER / way);
            self.drawing.line("leader", edge, near);
        }
        let middle = (area.low[0] + area.high[0]) / 2.0;
        self.drawing.text("tick beside", [middle, area.high[1] - 2.0], Anchor::Middle, &text);
    }

    /// Draws the key of numbers below the axis: lines of entries after the marker of each style.
    pub fn key_of_numbers(&mut self, groups: &[(CodeStyle, Vec<(usize, &str)>)]) {
        let (mut y, first) = (self.bottom + BOTTOM + 4.0, LEGEND_LEFT + 14.0);
        for (style, entries) in groups {
            y += KEY_LINE;
            self.drawing.marker(*style, [LEGEND_LEFT, y - 4.0], 3.6, false);
            let mut x = first;
            for (number, words) in entries {
                let text = format!("{number}: {words}");
                if x > first && x + width_of(&text) > WIDTH {
                    (x, y) = (first, y + KEY_LINE);
                }
                let lines = broken(&text, WIDTH - first);
                for (place, line) in lines.iter().enumerate() {
                    (x, y) = if place > 0 { (first, y + KEY_LINE) } else { (x, y) };
                    self.drawing.text("tick", [x, y], Anchor::Start, line);
                }
                x += lines.last().map_or(0.0, |line| width_of(line)) + 14.0;
            }
        }
        self.drawing.grow(y + 6.0);
    }

    /// Draws a short text in the upper or the lower left corner.
    pub fn remark(&mut self, upper: bool, text: &str) {
        let y = if upper { self.top + 18.0 } else { self.bottom - 10.0 };
        self.drawing.text("tick", [LEFT + 9.0, y], Anchor::Start, text);
    }

    /// Returns the plot, with a name for readers who cannot see it.
    pub fn finish(self, name: &str) -> String {
        self.drawing.finish(name)
    }
}

/// Breaks a text into lines of at most `width` pixels, unless a single word is wider.
fn broken(text: &str, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is a line from the beginning");
        if line.is_empty() {
            *line += word;
        } else if width_of(line) + width_of(word) + width_of(" ") <= width {
            *line += &format!(" {word}");
        } else {
            lines.push(word.into());
        }
    }
    lines
}

/// Returns the width of a tick label in pixels. Text is not measured here; 6.4 per character is a generous width.
fn width_of(text: &str) -> f64 {
    6.4 * text.chars().count() as f64
}

/// Axis of a plot: label, range and ticks.
pub struct Axis {
    /// Quantity with its unit.
    pub(crate) label: String,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    scale: Scale,
}

/// Scale of an axis, and its tick marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic, with marks at powers of ten.
    Decades,
    /// Logarithmic, with marks at 1, 2 and 5 times every power of ten.
    FineDecades,
    /// Logarithmic, with marks at powers of two.
    Doublings,
}

impl Axis {
    /// Returns an axis over a range, in steps of round numbers.
    pub fn linear(label: &str, low: f64, high: f64) -> Axis {
        // An axis of zero length would divide by zero.
        let high = if high > low { high } else { low + 1.0 };
        Axis { label: label.into(), low, high, scale: Scale::Linear }
    }

    /// Returns a logarithmic axis; its ends are moved out to powers of ten.
    pub fn logarithmic(label: &str, low: f64, high: f64) -> Axis {
        let [low, high] = positive(low, high);
        let low = 10f64.powf((low.log10() + 1e-9).floor());
        let high = 10f64.powf((high.log10() - 1e-9).ceil()).max(10.0 * low);
        Axis { label: label.into(), low, high, scale: Scale::Decades }
    }

    /// Returns a logarithmic axis with marks in steps of 1, 2, 5; its ends are moved out to marks.
    pub fn fine(label: &str, low: f64, high: f64) -> Axis {
        let [low, high] = positive(low, high);
        let mark = |value: f64, up: bool| {
            let power = 10f64.powf((value.log10() + 1e-9).floor());
            let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
            let found = match up {
                true => steps.into_iter().find(|&step| step >= value * (1.0 - 1e-9)),
                false => steps.into_iter().rev().find(|&step| step <= value * (1.0 + 1e-9)),
            };
            found.unwrap_or(value)
        };
        let (low, high) = (mark(low, false), mark(high, true));
        Axis { label: label.into(), low, high: high.max(2.0 * low), scale: Scale::FineDecades }
    }

    /// Returns a logarithmic axis with marks at powers of two.
    pub fn doublings(label: &str, low: f64, high: f64) -> Axis {
        let [low, high] = positive(low, high);
        Axis { label: label.into(), low, high: high.max(2.0 * low), scale: Scale::Doublings }
    }

    /// Returns the relative position of a value, 0 at the lower end and 1 at the upper.
    pub(crate) fn share(&self, value: f64) -> f64 {
        if self.scale != Scale::Linear {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Returns the marked values with their labels; on a linear axis about `count` of them.
    pub(crate) fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        let within = |value: &f64| (self.low * (1.0 - 1e-9)..=self.high * (1.0 + 1e-9)).contains(value);
        let decades = (self.low.log10() - 1e-9).floor() as i32..=(self.high.log10() + 1e-9).ceil() as i32;
        let of = |marks: &mut dyn Iterator<Item = (f64, String)>| marks.filter(|(mark, _)| within(mark)).collect();
        match self.scale {
            Scale::Decades => of(&mut decades.map(|k| (10f64.powi(k), power_of_ten(k)))),
            Scale::FineDecades => {
                let marks = decades.flat_map(|k| [1.0, 2.0, 5.0].map(|step| step * 10f64.powi(k)));
                of(&mut marks.map(|mark| (mark, compact(mark))))
            }
            Scale::Doublings => {
                let marks = (self.low.log2().floor() as i32..=self.high.log2().ceil() as i32).map(|k| 2f64.powi(k));
                of(&mut marks.map(|mark| (mark, format!("{mark}"))))
            }
            Scale::Linear => {
                let (ticks, digits) = round_ticks(self.low, self.high, count);
                ticks.into_iter().map(|t| (t, format!("{t:.digits$}").replace('-', "−"))).collect()
            }
        }
    }
}

/// Returns positive ends for a logarithmic axis: zero is undefined on it, and would take marks without end.
fn positive(low: f64, high: f64) -> [f64; 2] {
    const DECADES: f64 = 1e6;
    let high = if high > 0.0 && high.is_finite() { high } else { 1.0 };
    let low = if low > 0.0 && low.is_finite() { low } else { high / DECADES };
    [low.clamp(f64::MIN_POSITIVE, high), high]
}

fn power_of_ten(exponent: i32) -> String {
    match exponent {
        0 => "1".into(),
        1 => "10".into(),
        2 => "100".into(),
        k => format!("10{}", superscript(k)),
    }
}

/// Rectangle on a drawing, pixels; vertical coordinates point down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    /// Left and upper corner.
    pub(crate) low: [f64; 2],
    /// Right and lower corner.
    pub(crate) high: [f64; 2],
}

/// Distance between the rings of candidates about a point, pixels.
const STEP: f64 = 3.0;

/// Candidates per ring.
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

    /// Returns the point of the area nearest to another point.
    pub(crate) fn nearest(&self, to: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|axis| to[axis].clamp(self.low[axis], self.high[axis]))
    }
}

/// Frame with the occupied areas.
pub(crate) struct Room {
    frame: Area,
    taken: Vec<Area>,
}

impl Room {
    pub(crate) fn new(frame: Area) -> Room {
        Room { frame, taken: Vec::new() }
    }

    /// Marks an area as occupied.
    pub(crate) fn take(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// Occupies a free area of some size near a point; `None` if the frame is full.
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

/// Returns the distance of two points.
pub(crate) fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

#[cfg(test)]
#[path = "../../tests/unit/draw_plot.rs"]
mod tests;
