//! Compared observables with their margins: values of a run, or values at times.

use super::MeasuredScene;
use makadam::scene::{Checked, DocumentPath};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Observable for the comparison of codes, with its margin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// Name of the measured quantity, for example `packing_fraction`; hyphens are read as underscores.
    #[serde(deserialize_with = "underscored")]
    pub observable: String,
    /// Margin of equivalence in the observable's unit; without one it is reported without a verdict.
    pub margin: Option<f64>,
    /// Times after `measure.from` at which it is compared, s: the values of single frames. Default: the value of the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<f64>,
}

impl Expectation {
    /// Returns an expectation per time, named after it (`grain_count(bed) at 0.5 s`); itself without times.
    pub(super) fn each(&self) -> Vec<Expectation> {
        let of_time = |time: &f64| {
            let observable = format!("{} at {time} s", self.observable);
            Expectation { observable, margin: self.margin, at: Vec::new() }
        };
        match self.at.is_empty() {
            true => vec![self.clone()],
            false => self.at.iter().map(of_time).collect(),
        }
    }
}

/// Returns the quantity of an observable's name, and its time after `measure.from` (s), if the name has one.
pub fn moment(name: &str) -> (&str, Option<f64>) {
    let parts = name.strip_suffix(" s").and_then(|name| name.rsplit_once(" at "));
    match parts.and_then(|(quantity, time)| Some((quantity, time.parse().ok()?))) {
        Some((quantity, time)) => (quantity, Some(time)),
        None => (name, None),
    }
}

/// Reads a name; hyphens become underscores.
fn underscored<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Ok(observable_name(&String::deserialize(deserializer)?))
}

/// Returns the name of an observable with underscores instead of hyphens, except in its argument, such as `torque(blade-1)`.
pub fn observable_name(text: &str) -> String {
    let (base, argument) = text.split_at(text.find('(').unwrap_or(text.len()));
    base.replace('-', "_") + argument
}

/// Checks margins, and times: each must be that of a measured frame.
pub(super) fn check(scene: &MeasuredScene) -> Checked {
    let root = DocumentPath::default();
    let mut compared = HashMap::new();
    for (index, expectation) in scene.compare.iter().enumerate() {
        let at = root.key("compare").index(index);
        if let Some(before) = compared.insert(&expectation.observable, index) {
            let problem = format!("'{}' is compared by compare[{before}] already", expectation.observable);
            return Err(at.key("observable").fault(problem, "give each observable one margin"));
        }
        at.key("margin").range(expectation.margin.unwrap_or(1.0), 1e-12, 1e6, "in the observable's unit")?;
        let named = moment(&expectation.observable).1;
        for (place, &time) in expectation.at.iter().chain(&named).enumerate() {
            let at = if named.is_some() { at.key("observable") } else { at.key("at").index(place) };
            check_time(scene, &at, time)?;
        }
    }
    Ok(())
}

fn check_time(scene: &MeasuredScene, at: &DocumentPath, time: f64) -> Checked {
    let measure = &scene.measure;
    let Some(from) = measure.from else {
        let problem = "times count from measure.from, which is absent".into();
        return Err(at.fault(problem, "give measure.from"));
    };
    let longest = scene.measured_stage().map_or(scene.duration, |(_, stage)| stage.longest());
    at.range(time, 0.0, longest - from, "s after measure.from")?;
    let frames = (from + time) / measure.interval;
    if (frames - frames.round()).abs() * measure.interval > measure.slack() {
        let problem = format!("no frame is measured at {time} s after measure.from");
        return Err(at.fault(problem, &format!("give a multiple of measure.interval, {} s", measure.interval)));
    }
    Ok(())
}
