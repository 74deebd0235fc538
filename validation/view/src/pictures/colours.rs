//! Colours of grains: a scale for quantities, a palette for kinds.

use super::shade::Colour;
use crate::draw::numbers::round_ticks;
use makadam_frames::run_frames::RunFrame;
use nalgebra::Vector3;

/// The scale `viridis` in equal steps from its second eighth on, since the first is too dark for light and shade: its order is seen in grey
/// and by colour-blind readers.
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

/// Colours that are told apart by colour-blind readers: M. Okabe and K. Ito, Color universal design, 2008.
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

/// Fields that count kinds of grains.
const KINDS: [&str; 2] = ["material", "population"];

/// Most kinds that are told apart by colours.
pub const MOST_KINDS: usize = PALETTE.len();

/// Map of values to colours.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// From one value to another.
    Range([f64; 2]),
    /// A colour for each kind, by the values in order.
    Kinds(Vec<i64>),
}

impl Scale {
    /// The scale of all values of some frames: kinds if they are few, otherwise from zero or the least value to one that hardly any exceeds.
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
        // A narrow spread about a large value, such as diameters, is shown from its least value on.
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

/// The colour at a share of the scale.
pub(super) fn viridis(share: f64) -> Colour {
    let at = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 } * (VIRIDIS.len() - 1) as f64;
    let below = (at as usize).min(VIRIDIS.len() - 2);
    let part = (at - below as f64) as f32;
    std::array::from_fn(|k| {
        let [low, high] = [below, below + 1].map(|stop| f32::from(VIRIDIS[stop][k]) / 255.0);
        low + (high - low) * part
    })
}

/// Chooses the field to colour a frame by: speed, or pressure where all grains are at rest, whichever there is.
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
