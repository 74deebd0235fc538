//! An axis of a plot: where values lie on it, and which are marked.

use super::numbers::{compact, round_ticks, superscript};

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

/// Scale of an axis, and its marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithm; powers of ten are marked.
    Decades,
    /// By their logarithm; 1, 2 and 5 of every power of ten are marked.
    FineDecades,
    /// By their logarithm; powers of two are marked.
    Doublings,
}

impl Axis {
    /// Returns an axis over a range, in steps of round numbers.
    pub fn linear(label: &str, low: f64, high: f64) -> Axis {
        // An axis of no length would divide by zero.
        let high = if high > low { high } else { low + 1.0 };
        Axis { label: label.into(), low, high, scale: Scale::Linear }
    }

    /// A logarithmic axis; its ends are moved out to powers of ten.
    pub fn logarithmic(label: &str, low: f64, high: f64) -> Axis {
        let [low, high] = positive(low, high);
        let low = 10f64.powf((low.log10() + 1e-9).floor());
        let high = 10f64.powf((high.log10() - 1e-9).ceil()).max(10.0 * low);
        Axis { label: label.into(), low, high, scale: Scale::Decades }
    }

    /// A logarithmic axis that is marked in steps of 1, 2, 5; its ends are moved out to marks.
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

    /// A logarithmic axis that is marked at powers of two.
    pub fn doublings(label: &str, low: f64, high: f64) -> Axis {
        let [low, high] = positive(low, high);
        Axis { label: label.into(), low, high: high.max(2.0 * low), scale: Scale::Doublings }
    }

    /// Position of a value, 0 at the lower end and 1 at the upper.
    pub(crate) fn share(&self, value: f64) -> f64 {
        if self.scale != Scale::Linear {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Values that are marked, with their labels; on a linear axis about so many.
    pub(crate) fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        let within = |value: &f64| (self.low * (1.0 - 1e-9)..=self.high * (1.0 + 1e-9)).contains(value);
        let decades = (self.low.log10() - 1e-9).floor() as i32..=(self.high.log10() + 1e-9).ceil() as i32;
        match self.scale {
            Scale::Decades => {
                return decades.map(|k| (10f64.powi(k), power_of_ten(k))).filter(|t| within(&t.0)).collect();
            }
            Scale::FineDecades => {
                let marks = decades.flat_map(|k| [1.0, 2.0, 5.0].map(|step| step * 10f64.powi(k)));
                return marks.filter(within).map(|mark| (mark, compact(mark))).collect();
            }
            Scale::Doublings => {
                let marks = (self.low.log2().floor() as i32..=self.high.log2().ceil() as i32).map(|k| 2f64.powi(k));
                return marks.filter(within).map(|mark| (mark, format!("{mark}"))).collect();
            }
            Scale::Linear => {}
        }
        let (ticks, digits) = round_ticks(self.low, self.high, count);
        ticks.into_iter().map(|t| (t, format!("{t:.digits$}").replace('-', "−"))).collect()
    }
}

/// The ends of a logarithmic axis: zero has no place on it, and would take marks without end.
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

#[cfg(test)]
#[path = "../../tests/unit/draw_axis.rs"]
mod tests;
