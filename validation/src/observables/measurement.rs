//! A measured number, and how readings of single frames become one.

use crate::plan::Observable;
use crate::statistics::block_average;
use serde::{Deserialize, Serialize};

/// One measured quantity of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Name of the quantity, for example `packing_fraction`.
    pub observable: String,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// Its value: of a number of single frames the mean over the measured frames in which it has a value, or for the `largest_...` kind
    /// the maximum; of a number of the whole span ([`Definition::span`](super::catalogue::Definition::span)) what all frames give together.
    pub value: f64,
    /// Standard error within the run, over blocks of time; absent where there are too few frames for blocks.
    /// Of a heap's angle it is over azimuth instead.
    pub standard_error: Option<f64>,
    /// Number of frames measured.
    pub frames: usize,
}

/// What a reading is of, and how readings of many frames are put together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    name: &'static str,
    unit: &'static str,
    largest: bool,
}

impl Quantity {
    /// A quantity that is averaged over frames; `unit` is empty where it has none.
    pub const fn mean(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, largest: false }
    }

    /// A quantity of which the largest value over frames counts.
    pub const fn largest(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, largest: true }
    }

    /// A measurement of this quantity.
    pub fn measured(self, value: f64, standard_error: Option<f64>, frames: usize) -> Measurement {
        Measurement { observable: self.name.into(), unit: self.unit.into(), value, standard_error, frames }
    }
}

/// Numbers measured of frames, and reasons why groups of numbers have none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// The numbers.
    pub measurements: Vec<Measurement>,
    /// Groups that could not be measured in some frame or over all of them, and why; the first reason of each.
    pub refusals: Vec<(Observable, String)>,
}

impl Measured {
    /// Notes why a group could not be measured.
    pub fn refuse(&mut self, group: Observable, why: &str) {
        if self.refusals.iter().all(|(known, _)| *known != group) {
            self.refusals.push((group, why.into()));
        }
    }
}

/// Readings of single frames, kept by quantity in the order in which they first came.
#[derive(Clone, Debug, Default)]
pub struct Readings(Vec<(Quantity, Vec<f64>)>);

impl Readings {
    /// Adds one frame's value; what is not finite is left out.
    pub fn add(&mut self, quantity: Quantity, value: f64) {
        if !value.is_finite() {
            return;
        }
        match self.0.iter_mut().find(|(known, _)| *known == quantity) {
            Some((_, values)) => values.push(value),
            None => self.0.push((quantity, vec![value])),
        }
    }

    /// One measurement a quantity: the mean with its standard error over blocks of time, or the maximum.
    pub fn averages(self) -> Vec<Measurement> {
        let measured = |(quantity, values): (Quantity, Vec<f64>)| {
            let frames = values.len();
            match quantity.largest {
                true => quantity.measured(values.into_iter().fold(f64::NEG_INFINITY, f64::max), None, frames),
                false => {
                    let average = block_average(&values);
                    quantity.measured(average.mean, average.standard_error, frames)
                }
            }
        };
        self.0.into_iter().map(measured).collect()
    }
}
