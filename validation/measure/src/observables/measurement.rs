//! Measured numbers, and their averages over frames.

use super::catalogue::definition;
use crate::statistics::block_average;
use makadam_frames::plan::Observable;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// One measured quantity of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Name of the quantity, for example `packing_fraction`.
    pub observable: String,
    /// Unit; empty for plain numbers.
    pub unit: String,
    /// Value: for a number of single frames, the mean over the measured frames with a value, or the maximum for the `largest_...` kind;
    /// for a number of the whole span ([`Definition::span`](super::catalogue::Definition::span)), the result of all frames together.
    pub value: f64,
    /// Standard error within the run, over blocks of time; absent if there are too few frames for blocks.
    /// The error of a heap's angle is over azimuth instead.
    pub standard_error: Option<f64>,
    /// Number of frames measured.
    pub frames: usize,
}

impl Measurement {
    /// Makes a measurement in the unit of its definition.
    pub(super) fn of(name: &str, value: f64, standard_error: Option<f64>, frames: usize) -> Measurement {
        let unit = definition(name).map_or("", |definition| definition.unit);
        Measurement { observable: name.into(), unit: unit.into(), value, standard_error, frames }
    }
}

/// An observable over time in one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Series {
    /// The code.
    pub code: String,
    /// Seed of the run.
    pub seed: u64,
    /// Name of the observable.
    pub observable: String,
    /// Times, s.
    pub time: Vec<f64>,
    /// Values at these times.
    pub value: Vec<f64>,
}

/// Numbers measured in frames, and reasons for groups without numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Measured numbers.
    pub measurements: Vec<Measurement>,
    /// Groups that could not be measured in some frame or over all of them, each with its first reason.
    pub refusals: Vec<(Observable, String)>,
}

impl Measured {
    /// Adds the reason for a group without numbers.
    pub fn refuse(&mut self, group: Observable, why: &str) {
        if self.refusals.iter().all(|(known, _)| *known != group) {
            self.refusals.push((group, why.into()));
        }
    }
}

/// Readings of single frames by observable and unit, in the order of first appearance.
#[derive(Default)]
pub(super) struct Readings(Vec<(Cow<'static, str>, &'static str, Vec<f64>)>);

impl Readings {
    /// Adds one frame's value; values that are not finite are left out.
    pub fn add(&mut self, name: &'static str, value: f64) {
        self.add_in(name, definition(name).map_or("", |definition| definition.unit), value);
    }

    /// Adds one frame's value for a wall; `(wall)` at the end of the name becomes that of the wall.
    pub fn add_of(&mut self, name: &'static str, wall: &str, value: f64) {
        let unit = definition(name).map_or("", |definition| definition.unit);
        self.add_in(name.replace("(wall)", &format!("({wall})")), unit, value);
    }

    /// Adds one frame's value in one of the units of its observable.
    pub fn add_in(&mut self, name: impl Into<Cow<'static, str>>, unit: &'static str, value: f64) {
        let name = name.into();
        if !value.is_finite() {
            return;
        }
        match self.0.iter_mut().find(|(known, its_unit, _)| *known == name && *its_unit == unit) {
            Some((_, _, values)) => values.push(value),
            None => self.0.push((name, unit, vec![value])),
        }
    }

    /// Appends the readings of later frames.
    pub fn append(&mut self, later: Readings) {
        for (name, unit, mut values) in later.0 {
            match self.0.iter_mut().find(|(known, its_unit, _)| *known == name && *its_unit == unit) {
                Some((_, _, known)) => known.append(&mut values),
                None => self.0.push((name, unit, values)),
            }
        }
    }

    /// Returns one measurement per observable: the mean with its standard error over blocks of time, or the maximum.
    pub fn averages(&self) -> impl Iterator<Item = Measurement> {
        self.0.iter().map(|(name, unit, values)| {
            let frames = values.len();
            let (value, standard_error) = match definition(name).is_some_and(|definition| definition.largest) {
                true => (values.iter().copied().fold(f64::NEG_INFINITY, f64::max), None),
                false => {
                    let average = block_average(values);
                    (average.mean, average.standard_error)
                }
            };
            Measurement { observable: name.to_string(), unit: (*unit).into(), value, standard_error, frames }
        })
    }
}
