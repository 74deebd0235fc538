//! A place in a scene's document, and the ranges that its value can be checked against.

use super::error::{Fault, Step, label, short};

pub(super) type Checked = Result<(), Fault>;

/// A place in the document, built up as the check goes down into it.
#[derive(Clone, Default)]
pub(super) struct Place(Vec<Step>);

impl Place {
    pub(super) fn key(&self, key: &'static str) -> Place {
        self.with(Step::Key(key))
    }

    pub(super) fn name(&self, name: &str) -> Place {
        self.with(Step::Name(name.to_string()))
    }

    pub(super) fn index(&self, index: usize) -> Place {
        self.with(Step::Index(index))
    }

    fn with(&self, step: Step) -> Place {
        let mut path = self.0.clone();
        path.push(step);
        Place(path)
    }

    pub(super) fn path(&self) -> Vec<Step> {
        self.0.clone()
    }

    pub(super) fn fault(&self, problem: String, remedy: &str) -> Fault {
        Fault::new(self.path(), format!("{}: {problem}", label(&self.0)), remedy)
    }

    pub(super) fn range(&self, value: f64, low: f64, high: f64, unit: &str) -> Checked {
        match value.is_finite() && value >= low && value <= high {
            true => Ok(()),
            false => {
                let [value, low, high] = [value, low, high].map(short);
                Err(self
                    .fault(format!("{value} is out of range"), &format!("give a number from {low} to {high} {unit}")))
            }
        }
    }

    pub(super) fn finite(&self, vector: &[f64; 3]) -> Checked {
        match vector.iter().all(|x| x.is_finite() && x.abs() < 1e6) {
            true => Ok(()),
            false => Err(self.fault(format!("{vector:?} is not usable"), "give three finite SI numbers below 1e6")),
        }
    }

    pub(super) fn direction(&self, vector: &[f64; 3]) -> Checked {
        self.finite(vector)?;
        match vector.iter().map(|x| x * x).sum::<f64>() > 1e-24 {
            true => Ok(()),
            false => Err(self.fault("has no direction".into(), "give a vector that is not zero")),
        }
    }
}
