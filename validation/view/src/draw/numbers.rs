//! Number formats for readers: digits according to the margin or the spread, a true minus sign.

/// Rounding of the values of one observable, the same in every column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Number of decimals.
    Decimals(usize),
    /// Values in this power of ten, which is next to the unit; two decimals.
    PowerOfTen(i32),
}

/// Resolution of values, in parts of the margin.
const PARTS_OF_MARGIN: f64 = 20.0;

impl Rounding {
    /// Returns the rounding of values up to `value`: to a twentieth of the margin; without a margin (0) to two digits of the largest spread;
    /// without a spread (0) to three digits of the largest value.
    pub fn for_values(margin: f64, spread: f64, value: f64) -> Rounding {
        // A spread far below the value is rounding noise of a deterministic quantity, not a reason for more digits.
        let resolution = if margin > 0.0 {
            margin / PARTS_OF_MARGIN
        } else if spread > 1e-6 * value {
            spread / 10.0
        } else {
            value / 500.0
        };
        if value > 0.0 && !(1e-3..1e6).contains(&value) && resolution < value {
            return Rounding::PowerOfTen(value.log10().floor() as i32);
        }
        Rounding::Decimals(decimals(resolution))
    }

    /// Returns the rounding that resolves a twentieth of a margin.
    pub fn to_margin(margin: f64) -> Rounding {
        Rounding::Decimals(decimals(margin / PARTS_OF_MARGIN))
    }

    /// Formats a number.
    pub fn value(self, value: f64) -> String {
        if !value.is_finite() {
            return "not finite".into();
        }
        match self {
            Rounding::Decimals(decimals) => with_minus(format!("{value:.decimals$}")),
            Rounding::PowerOfTen(exponent) => with_minus(format!("{:.2}", value / 10f64.powi(exponent))),
        }
    }

    /// Formats a margin of equivalence, without needless zeros.
    pub fn margin(self, margin: f64) -> String {
        format!("±{}", compact(margin / self.scale()))
    }

    fn scale(self) -> f64 {
        match self {
            Rounding::Decimals(_) => 1.0,
            Rounding::PowerOfTen(exponent) => 10f64.powi(exponent),
        }
    }

    /// Returns the common factor of all values, such as "10⁻⁴"; empty if it is one.
    pub(crate) fn factor(self) -> String {
        match self {
            Rounding::Decimals(_) => String::new(),
            Rounding::PowerOfTen(exponent) => format!("10{}", superscript(exponent)),
        }
    }

    /// Formats a difference, with its sign; without a sign if it rounds to zero.
    pub fn signed(self, value: f64) -> String {
        let text = self.value(value);
        let zero = text.chars().all(|c| matches!(c, '0' | '.'));
        if value > 0.0 && !zero { format!("+{text}") } else { text }
    }

    /// Formats an interval of differences.
    pub fn interval(self, interval: [f64; 2]) -> String {
        format!("[{}, {}]", self.signed(interval[0]), self.signed(interval[1]))
    }
}

/// Returns the fewest decimals that resolve `resolution`.
fn decimals(resolution: f64) -> usize {
    if !(resolution.is_finite() && resolution > 0.0) {
        return 3;
    }
    (-resolution.log10()).ceil().clamp(0.0, 6.0) as usize
}

fn with_minus(text: String) -> String {
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) {
        return text.trim_start_matches('-').to_string();
    }
    text.replace('-', "−")
}

/// Formats a count: "1 test", "2 tests".
pub fn plural(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// Formats a whole number as superscript digits.
pub(crate) fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32(0x2070 + digit as u32 - '0' as u32).unwrap_or(digit),
        })
        .collect()
}

/// Rounds a value to six significant digits.
pub fn significant(value: f64) -> String {
    // Adding zero removes the sign of a negative zero.
    let rounded = format!("{value:.5e}").parse().unwrap_or(value) + 0.0;
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// Formats a value to four digits or three decimals.
pub fn four_digits(value: f64) -> String {
    let size = value.abs();
    let decimals = match size {
        100.0.. => 1,
        10.0.. => 2,
        _ => 3,
    };
    match size == 0.0 || (1e-2..1e4).contains(&size) {
        true => format!("{value:.decimals$}"),
        false => format!("{value:.3e}"),
    }
}

/// Formats a positive number to two significant digits, or to the unit above 100: 0.092, 3.1, 14, 230.
pub fn two_digits(value: f64) -> String {
    if !value.is_finite() {
        return "not finite".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10().floor();
    let rounded = if exponent >= 2.0 {
        value.round()
    } else {
        (value / 10f64.powf(exponent - 1.0)).round() * 10f64.powf(exponent - 1.0)
    };
    if value.abs() < 1e-4 {
        return compact(value);
    }
    let decimals = (1.0 - exponent).max(0.0) as usize;
    with_minus(format!("{rounded:.decimals$}"))
}

/// Formats a value with its error: the error to two significant digits, the value to the same digit: 31.67 ± 0.38.
pub fn with_error(value: f64, error: f64) -> String {
    if !(value.is_finite() && error.is_finite()) || error.abs() <= 1e-9 * value.abs() {
        return format!("{} ± {}", significant(value), two_digits(error));
    }
    // Exponent of the rounded error: 0.0996 is 0.10.
    let rounded = format!("{:.1e}", error.abs());
    let exponent: i32 = rounded.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    let size = value.abs().max(error.abs());
    if (1e-4..1e7).contains(&size) && exponent >= -6 {
        let decimals = (1 - exponent).max(0) as usize;
        return format!("{value:.decimals$} ± {error:.decimals$}");
    }
    // Both in the power of ten of the larger one.
    let power = size.log10().floor() as i32;
    let decimals = (power - exponent + 1).clamp(0, 15) as usize;
    let scale = 10f64.powi(power);
    format!("({:.decimals$} ± {:.decimals$})e{power}", value / scale, error / scale)
}

/// Formats a computing time: 0.31 s, 42 s, 3 min 20 s, 1 h 5 min.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if !s.is_finite() => "not finite".into(),
        s if s < 99.5 => format!("{} s", two_digits(s)),
        s if s < 5970.0 => format!("{} min {} s", (s.round() as u64) / 60, (s.round() as u64) % 60),
        s => format!("{} h {} min", ((s / 60.0).round() as u64) / 60, ((s / 60.0).round() as u64) % 60),
    }
}

/// Formats a short time in a suitable unit, with two digits.
pub fn short_time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", two_digits(s)),
        s if s >= 1e-3 => format!("{} ms", two_digits(1e3 * s)),
        s if s >= 1e-6 => format!("{} µs", two_digits(1e6 * s)),
        s => format!("{} ns", two_digits(1e9 * s)),
    }
}

/// Formats a count with thin spaces between thousands.
pub fn count(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// Formats bounds; an empty text without bounds.
pub fn bounds(bounds: [Option<f64>; 2], number: impl Fn(f64) -> String) -> String {
    match bounds {
        [Some(low), Some(high)] => format!("{} to {}", number(low), number(high)),
        [Some(low), None] => format!("at least {}", number(low)),
        [None, Some(high)] => format!("at most {}", number(high)),
        [None, None] => String::new(),
    }
}

/// Formats a small quantity: 5×10⁻⁴, or 0.02.
pub fn compact(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) && value.is_finite() {
        let exponent = value.abs().log10().floor() as i32;
        let mantissa = format!("{:.2}", value / 10f64.powi(exponent));
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
        return format!("{}×10{}", mantissa.replace('-', "−"), superscript(exponent));
    }
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    with_minus(text.to_string())
}

/// Returns about `count` evenly spaced round numbers that cover a range, and the decimals that distinguish them.
pub(crate) fn round_ticks(low: f64, high: f64, count: usize) -> (Vec<f64>, usize) {
    let span = (high - low).max(f64::MIN_POSITIVE);
    let raw = span / count.max(1) as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * power).find(|&s| s >= raw * 0.999).unwrap_or(raw);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let digits = (0..9).find(|&d| ((step * 10f64.powi(d)).round() - step * 10f64.powi(d)).abs() < 1e-6).unwrap_or(9);
    ((first..=last).map(|k| k as f64 * step).collect(), digits as usize)
}

#[cfg(test)]
#[path = "../../tests/unit/draw_numbers.rs"]
mod tests;
