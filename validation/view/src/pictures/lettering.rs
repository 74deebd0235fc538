//! Words and the colour scale on a picture.

use super::colours::{Scale, viridis};
use super::shade::{Colour, blend};
use crate::draw::numbers::round_ticks;
use makadam_frames::run_frames::Quantity;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Prefixes of units, by the power of a thousand.
const PREFIXES: [(i32, &str); 8] =
    [(-4, "p"), (-3, "n"), (-2, "\u{b5}"), (-1, "m"), (0, ""), (1, "k"), (2, "M"), (3, "G")];

/// Fewest pixels of a line that are left for grains beside a colour scale.
const LEAST: usize = 32;

const INK: Colour = [0.13, 0.15, 0.18];

/// A picture that is written upon.
pub(super) struct Sheet<'a> {
    pub colours: &'a mut [Colour],
    pub width: usize,
    pub height: usize,
}

/// Alignment of a text at its place.
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

    /// Height of a line of text, pixels.
    pub fn line(&self) -> usize {
        self.font().val()
    }

    /// Width of a letter, pixels.
    pub fn letter(&self) -> usize {
        get_raster_width(FontWeight::Regular, self.font())
    }

    /// Pixels on the right that the colour scale takes; none where it would leave too few for the grains.
    pub fn strip(&self) -> usize {
        let strip = 13 * self.letter();
        if self.width < strip + LEAST { 0 } else { strip }
    }

    fn put(&mut self, x: i64, y: i64, colour: Colour, share: f32) {
        if (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y) {
            blend(&mut self.colours[y as usize * self.width + x as usize], colour, share);
        }
    }

    /// Writes a text with its upper corner at a place; letters that the font has not are left out.
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

    /// The colour scale on the right, with its ticks and the quantity's name; kinds have a colour and a name each.
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

/// The unit with its prefix, and the ticks of a scale: their values and what is written beside them.
pub(crate) fn ticks(unit: &str, [low, high]: [f64; 2]) -> (String, Vec<(f64, String)>) {
    let power = prefix_of(unit, low.abs().max(high.abs()));
    let factor = 1000_f64.powi(power);
    let (ticks, digits) = round_ticks(low / factor, high / factor, 5);
    let inside = |at: &f64| (-1e-9..=1.0 + 1e-9).contains(&((at - low) / (high - low)));
    let ticks = ticks.into_iter().map(|tick| (tick * factor, format!("{tick:.digits$}")));
    (format!("{}{unit}", prefix_name(power)), ticks.filter(|(at, _)| inside(at)).collect())
}

/// Power of a thousand by which values are divided, so that they are read easily; zero where a unit takes no prefix.
fn prefix_of(unit: &str, largest: f64) -> i32 {
    if unit.is_empty() || unit == "kg" || largest <= 0.0 || !largest.is_finite() {
        return 0;
    }
    // Numbers up to a thousandth are as easily read as they are.
    let power = ((largest.log10() + 1e-9) / 3.0).floor() as i32;
    if (-0.5..3.0).contains(&largest.log10()) { 0 } else { power.clamp(-4, 3) }
}

fn prefix_name(power: i32) -> &'static str {
    PREFIXES.iter().find(|(of, _)| *of == power).map_or("", |(_, name)| name)
}

/// A length in words: "10 mm".
pub(super) fn length(metres: f64) -> String {
    let power = prefix_of("m", metres);
    let value = metres / 1000_f64.powi(power);
    let digits = (2 - value.abs().max(1e-12).log10().floor() as i32).clamp(0, 3) as usize;
    format!("{value:.digits$} {}m", prefix_name(power))
}
