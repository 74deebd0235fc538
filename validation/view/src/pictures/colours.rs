//! Colours of grains: a scale for quantities, a palette for kinds; the text and the colour scale on a picture.

use super::shade::{Colour, blend};
use crate::draw::numbers::round_ticks;
use makadam_frames::run_frames::{Quantity, RunFrame};
use nalgebra::Vector3;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Scale `viridis` in equal steps from its second eighth, since the first is too dark for shading: its order is visible in grey
/// and to colour-blind readers.
pub const VIRIDIS: [[u8; 3]; 15] = [
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];

/// Colours that colour-blind readers can distinguish: M. Okabe and K. Ito, Color universal design, 2008.
pub const PALETTE: [[u8; 3]; 8] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [0, 114, 178],
    [213, 94, 0],
    [240, 228, 66],
    [150, 150, 150],
];

/// Fields for kinds of grains.
const KINDS: [&str; 2] = ["material", "population"];

/// Largest number of kinds with different colours.
pub const MOST_KINDS: usize = PALETTE.len();

/// Map of values to colours.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Range from one value to another.
    Range([f64; 2]),
    /// One colour for each kind, by the values in order.
    Kinds(Vec<i64>),
}

impl Scale {
    /// Returns the scale for all values of some frames: kinds if few, otherwise from zero or the smallest value to a value that few exceed.
    pub fn of(title: &str, values: &[f64]) -> Scale {
        if KINDS.contains(&title) {
            let mut kinds: Vec<i64> = values.iter().map(|value| *value as i64).collect();
            kinds.sort_unstable();
            kinds.dedup();
            if kinds.len() <= MOST_KINDS {
                return Scale::Kinds(kinds);
            }
        }
        let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else { return Scale::Range([0.0, 1.0]) };
        let nearly = sorted[(sorted.len() - 1) * 99 / 100];
        // A narrow spread about a large value, such as diameters, is shown from its smallest value.
        let low = if least > 0.5 * most { least } else { 0.0 };
        let high = if low > 0.0 { most } else { nearly };
        if high <= low {
            return Scale::Range([low, if low > 0.0 { 1.001 * low } else { most.max(f64::MIN_POSITIVE) }]);
        }
        match low {
            0.0 => Scale::Range([
                0.0,
                round_ticks(0.0, 2.0 * high, 20).0.into_iter().find(|&tick| tick >= high).unwrap_or(high),
            ]),
            _ => Scale::Range([low, high]),
        }
    }

    /// Returns the colour of a value.
    pub(super) fn colour(&self, value: f64) -> Colour {
        match self {
            Scale::Range([low, high]) => viridis((value - low) / (high - low)),
            Scale::Kinds(kinds) => {
                let place = kinds.iter().position(|kind| *kind == value as i64).unwrap_or(MOST_KINDS - 1);
                PALETTE[place % MOST_KINDS].map(|share| f32::from(share) / 255.0)
            }
        }
    }
}

/// Returns the colour at a fraction of the scale.
pub(super) fn viridis(share: f64) -> Colour {
    let at = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 } * (VIRIDIS.len() - 1) as f64;
    let below = (at as usize).min(VIRIDIS.len() - 2);
    let part = (at - below as f64) as f32;
    std::array::from_fn(|k| {
        let [low, high] = [below, below + 1].map(|stop| f32::from(VIRIDIS[stop][k]) / 255.0);
        low + (high - low) * part
    })
}

/// Chooses the field for colouring a frame: speed, or pressure if all grains are at rest, if available.
pub fn telling(frame: &RunFrame) -> &'static str {
    let has = |name: &str| frame.quantity(name).map(|quantity| quantity.values);
    let diameter = 2.0 * frame.grains.radii.iter().copied().fold(0.0, f64::max);
    let gravity = Vector3::from(frame.gravity).norm();
    let moves = |speeds: Vec<f64>| {
        let mut speeds = speeds;
        speeds.sort_by(f64::total_cmp);
        let high = speeds.get(speeds.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
        // 1% of the speed of a fall by one diameter.
        high > 0.01 * (gravity * diameter).sqrt() && high > 0.0
    };
    match (has("speed"), has("pressure")) {
        (Some(speeds), _) if moves(speeds.clone()) => "speed",
        (_, Some(_)) => "pressure",
        (Some(_), None) => "speed",
        (None, None) => "diameter",
    }
}

/// Prefixes of units, by the power of a thousand.
const PREFIXES: [(i32, &str); 8] =
    [(-4, "p"), (-3, "n"), (-2, "\u{b5}"), (-1, "m"), (0, ""), (1, "k"), (2, "M"), (3, "G")];

/// Smallest width left for grains next to a colour scale, pixels.
const LEAST: usize = 32;

const INK: Colour = [0.13, 0.15, 0.18];

/// Picture with text.
pub(super) struct Sheet<'a> {
    pub colours: &'a mut [Colour],
    pub width: usize,
    pub height: usize,
}

/// Alignment of a text at its position.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Left,
    Right,
}

impl Sheet<'_> {
    fn font(&self) -> RasterHeight {
        match self.height.min(self.width) {
            ..500 => RasterHeight::Size16,
            500..1000 => RasterHeight::Size20,
            1000..1500 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        }
    }

    /// Returns the height of a line of text, pixels.
    pub fn line(&self) -> usize {
        self.font().val()
    }

    /// Returns the width of a letter, pixels.
    pub fn letter(&self) -> usize {
        get_raster_width(FontWeight::Regular, self.font())
    }

    /// Returns the width of the colour scale on the right, pixels; zero if too few pixels would remain for the grains.
    pub fn strip(&self) -> usize {
        let strip = 13 * self.letter();
        if self.width < strip + LEAST { 0 } else { strip }
    }

    fn put(&mut self, x: i64, y: i64, colour: Colour, share: f32) {
        if (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y) {
            blend(&mut self.colours[y as usize * self.width + x as usize], colour, share);
        }
    }

    /// Writes a text with its upper corner at a position; letters missing from the font are left out.
    pub fn write(&mut self, text: &str, [x, y]: [i64; 2], anchor: Anchor) {
        let (font, letter) = (self.font(), self.letter() as i64);
        let start = x - if anchor == Anchor::Right { letter * text.chars().count() as i64 } else { 0 };
        for (number, sign) in (0..).zip(text.chars()) {
            let Some(shape) = get_raster(sign, FontWeight::Regular, font) else { continue };
            for (line, row) in (0..).zip(shape.rows()) {
                for (column, dark) in (0..).zip(row.iter()) {
                    self.put(start + number * letter + column, y + line, INK, f32::from(*dark) / 255.0);
                }
            }
        }
    }

    fn fill(&mut self, [left, top]: [i64; 2], [right, bottom]: [i64; 2], colour: impl Fn(i64) -> Colour) {
        for y in top..bottom {
            (left..right).for_each(|x| self.put(x, y, colour(y), 1.0));
        }
    }

    /// Draws the colour scale on the right, with its ticks and the quantity's name; kinds have a colour and a name each.
    pub fn scale(&mut self, quantity: &Quantity, scale: &Scale) {
        if self.strip() == 0 {
            return;
        }
        let (line, letter) = (self.line() as i64, self.letter() as i64);
        let (left, top) = ((self.width - self.strip()) as i64 + letter, 3 * line);
        let bottom = (self.height as i64 - 2 * line).max(top + 2 * line);
        match scale {
            Scale::Kinds(kinds) => {
                self.write(&quantity.title, [left, line], Anchor::Left);
                for (place, kind) in (0..).zip(kinds) {
                    let y = top + place * (line + line / 2);
                    self.fill([left, y], [left + line, y + line], |_| scale.colour(*kind as f64));
                    let name: String = kind_name(quantity, *kind).chars().take(9).collect();
                    self.write(&name, [left + line + letter / 2, y], Anchor::Left);
                }
            }
            Scale::Range([low, high]) => {
                let (unit, ticks) = ticks(quantity.unit, [*low, *high]);
                let heading =
                    if unit.is_empty() { quantity.title.clone() } else { format!("{} ({unit})", quantity.title) };
                let right = self.width as i64 - letter;
                // Long names take a second line.
                match heading.split_once(" (") {
                    Some((name, unit)) if heading.chars().count() > 12 => {
                        self.write(name, [right, line / 2], Anchor::Right);
                        self.write(&format!("({unit}"), [right, line / 2 + line], Anchor::Right);
                    }
                    _ => self.write(&heading, [right, line], Anchor::Right),
                }
                let share = |y: i64| (bottom - y) as f64 / (bottom - top) as f64;
                self.fill([left, top], [left + line, bottom], |y| viridis(share(y)));
                for (value, text) in ticks {
                    let at = (value - low) / (high - low);
                    let y = bottom - (at * (bottom - top) as f64).round() as i64;
                    (0..letter / 2).for_each(|x| self.put(left + line + x, y.clamp(top, bottom - 1), INK, 1.0));
                    self.write(&text, [left + line + letter, y - line / 2], Anchor::Left);
                }
            }
        }
    }
}

/// Returns the name of a kind of grains.
pub(crate) fn kind_name(quantity: &Quantity, kind: i64) -> String {
    let name = usize::try_from(kind).ok().and_then(|kind| quantity.names.get(kind)).cloned();
    name.unwrap_or_else(|| if kind < 0 { "listed".into() } else { kind.to_string() })
}

/// Returns the unit with its prefix, and the ticks of a scale: their values and their labels.
pub(crate) fn ticks(unit: &str, [low, high]: [f64; 2]) -> (String, Vec<(f64, String)>) {
    let power = prefix_of(unit, low.abs().max(high.abs()));
    let factor = 1000_f64.powi(power);
    let (ticks, digits) = round_ticks(low / factor, high / factor, 5);
    let inside = |at: &f64| (-1e-9..=1.0 + 1e-9).contains(&((at - low) / (high - low)));
    let ticks = ticks.into_iter().map(|tick| (tick * factor, format!("{tick:.digits$}")));
    (format!("{}{unit}", prefix_name(power)), ticks.filter(|(at, _)| inside(at)).collect())
}

/// Returns the power of a thousand that divides values for readability; zero if a unit takes no prefix.
fn prefix_of(unit: &str, largest: f64) -> i32 {
    if unit.is_empty() || unit == "kg" || largest <= 0.0 || !largest.is_finite() {
        return 0;
    }
    // Numbers down to a thousandth are readable without a prefix.
    let power = ((largest.log10() + 1e-9) / 3.0).floor() as i32;
    if (-0.5..3.0).contains(&largest.log10()) { 0 } else { power.clamp(-4, 3) }
}

fn prefix_name(power: i32) -> &'static str {
    PREFIXES.iter().find(|(of, _)| *of == power).map_or("", |(_, name)| name)
}

/// Formats a length: "10 mm".
pub(super) fn length(metres: f64) -> String {
    let power = prefix_of("m", metres);
    let value = metres / 1000_f64.powi(power);
    let digits = (2 - value.abs().max(1e-12).log10().floor() as i32).clamp(0, 3) as usize;
    format!("{value:.digits$} {}m", prefix_name(power))
}
