//! What arguments can be: names of things, and numbers in their ranges.

use crate::observables::catalogue;
use clap::ValueEnum;
use clap::builder::PossibleValuesParser;
use makadam::lanes::InstructionSet;
use makadam::scene::suggestion;
use makadam::scene::{Accuracy, Precision, SolverMethod};
use makadam::schedule::Scheduler;

/// A way in which threads share tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SchedulerName {
    /// One thread.
    Serial,
    /// One queue behind a lock.
    CentralQueue,
    /// A queue a thread; idle threads steal.
    WorkStealing,
}

impl From<SchedulerName> for Scheduler {
    fn from(name: SchedulerName) -> Scheduler {
        match name {
            SchedulerName::Serial => Scheduler::Serial,
            SchedulerName::CentralQueue => Scheduler::CentralQueue,
            SchedulerName::WorkStealing => Scheduler::WorkStealing,
        }
    }
}

/// A precision of the sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PrecisionName {
    /// 64 bits, eight contacts at a time.
    Double,
    /// 32 bits, sixteen contacts at a time.
    Single,
}

impl From<PrecisionName> for Precision {
    fn from(name: PrecisionName) -> Precision {
        match name {
            PrecisionName::Double => Precision::Double,
            PrecisionName::Single => Precision::Single,
        }
    }
}

/// An instruction set that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum InstructionSetName {
    /// Whatever the build's target has.
    Generic,
    /// 256-bit registers.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

impl From<InstructionSetName> for InstructionSet {
    fn from(name: InstructionSetName) -> InstructionSet {
        match name {
            InstructionSetName::Generic => InstructionSet::Generic,
            InstructionSetName::Avx2 => InstructionSet::Avx2,
            InstructionSetName::Avx512 => InstructionSet::Avx512,
        }
    }
}

/// A tolerated deviation of an observable.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundArgument {
    /// Name of the observable.
    pub observable: String,
    /// Largest absolute deviation, in the observable's unit.
    pub value: f64,
}

/// Largest share that is read from a number without a percent sign.
const LARGEST_BARE: f64 = 0.2;

/// Reads an accuracy: one share of everything, or deviations by name.
pub(super) fn accuracy(text: &str) -> Result<Accuracy, String> {
    let number = |text: &str| match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse::<f64>().map(|percent| percent / 100.0),
        None => text.trim().parse::<f64>(),
    };
    let mut accuracy = Accuracy::default();
    for part in text.split(',') {
        let (name, value) = part.split_once('=').unwrap_or(("relative", part));
        // A bare 1 is as likely to be meant as one percent, or one degree, as it is to be all of everything.
        if name.trim() == "relative" && number(value).is_ok_and(|share| share > LARGEST_BARE) && !value.contains('%') {
            return Err(format!("{part}: a share of that size is hardly meant; write {}% or angle={0}", value.trim()));
        }
        let value = number(value).ok().filter(|value| (1e-6..=10.0).contains(value));
        let value = value.ok_or_else(|| format!("{part}: give a number from 1e-6 to 10, or a share such as 1%"))?;
        let place = match name.trim() {
            "angle" => &mut accuracy.angle,
            "packing_fraction" => &mut accuracy.packing_fraction,
            "overlap" => &mut accuracy.overlap,
            "relative" => &mut accuracy.relative,
            other => return Err(format!("{other} is none of angle, packing_fraction, overlap, relative")),
        };
        if place.replace(value).is_some() {
            return Err(format!("{} is given twice", name.trim()));
        }
    }
    Ok(accuracy)
}

pub(super) fn method() -> PossibleValuesParser {
    PossibleValuesParser::new(SolverMethod::ALL.map(SolverMethod::name))
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a number above 0".into()),
    }
}

/// A value of a file, and the name that it stands for.
pub(super) fn kind(text: &str) -> Result<(String, String), String> {
    match text.split_once('=').map(|(value, name)| (value.trim(), name.trim())) {
        Some((value, name)) if !value.is_empty() && !name.is_empty() => Ok((value.into(), name.into())),
        _ => Err("give VALUE=NAME, such as 1=glass".into()),
    }
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1e9).contains(&value) => Ok(value),
        _ => Err("give a number of seconds from 0 to 1e9".into()),
    }
}

/// Wall time after which something is stopped.
pub(super) fn time_limit(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e9 => Ok(value),
        _ => Err("give a number of seconds above 0 and at most 1e9".into()),
    }
}

pub(super) fn rayleigh_fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 0.5 => Ok(value),
        _ => Err("give a number above 0 and at most 0.5; beyond it the peers lose their restitution".into()),
    }
}

pub(super) fn bound(text: &str) -> Result<BoundArgument, String> {
    let (name, value) = text.split_once('=').ok_or("give an observable and a value, such as packing_fraction=0.002")?;
    Ok(BoundArgument { observable: observable(name)?, value: positive(value.trim())? })
}

/// Reads the name of a number that can be measured.
pub(super) fn observable(text: &str) -> Result<String, String> {
    let name = text.trim().replace('-', "_");
    match catalogue::group_of(&name) {
        Some(_) => Ok(name),
        None => {
            let remedy = suggestion(&name, catalogue::known(), "`makadam print observables` lists all names");
            Err(format!("nothing measures '{name}'; {remedy}"))
        }
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/commands_arguments_values.rs"]
mod tests;
