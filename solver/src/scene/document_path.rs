//! A place in a scene's document, and the ranges that its value can be checked against.

use super::error::{Fault, Step, label, line_at, short, whole_span};

/// Whether a value is what it may be.
pub type Checked = Result<(), Fault>;

/// A place in the document, built up as the check goes down into it.
#[derive(Clone, Default)]
pub struct DocumentPath(Vec<Step>);

impl DocumentPath {
    /// The value of a key of the table here.
    pub fn key(&self, key: &'static str) -> DocumentPath {
        self.with(Step::Key(key))
    }

    /// The value of a name that the document itself gives.
    pub fn name(&self, name: &str) -> DocumentPath {
        self.with(Step::Name(name.to_string()))
    }

    /// An entry of the list here, from 0.
    pub fn index(&self, index: usize) -> DocumentPath {
        self.with(Step::Index(index))
    }

    fn with(&self, step: Step) -> DocumentPath {
        let mut path = self.0.clone();
        path.push(step);
        DocumentPath(path)
    }

    /// Line (from 1) on which the text of a scene's document says what stands here; `None` where it says nothing of it.
    pub fn line(&self, text: &str) -> Option<usize> {
        whole_span(text, &self.0).map(|at| line_at(text, at))
    }

    pub(super) fn path(&self) -> Vec<Step> {
        self.0.clone()
    }

    /// What is wrong here, and what would be right.
    pub fn fault(&self, problem: String, remedy: &str) -> Fault {
        Fault::new(self.path(), format!("{}: {problem}", label(&self.0)), remedy)
    }

    /// Refuses a number outside a range. `unit` is named in the remedy.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn range(&self, value: f64, low: f64, high: f64, unit: &str) -> Checked {
        match value.is_finite() && value >= low && value <= high {
            true => Ok(()),
            false => {
                let [value, low, high] = [value, low, high].map(short);
                Err(self
                    .fault(format!("{value} is out of range"), &format!("give a number from {low} to {high} {unit}")))
            }
        }
    }

    /// Refuses a number outside the range that it has in most scenes, or, where the scene accepts unusual values, outside one in which it
    /// can be computed with. `unit` is named in the remedy.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn usual(&self, value: f64, usual: [f64; 2], possible: [f64; 2], unusual_values: bool, unit: &str) -> Checked {
        let [low, high] = if unusual_values { possible } else { usual };
        if value.is_finite() && value >= low && value <= high {
            return Ok(());
        }
        let [value, low, high, least, most] = [value, low, high, possible[0], possible[1]].map(short);
        let remedy = match unusual_values {
            true => format!("give a number from {low} to {high} {unit}"),
            false => format!(
                "give a number from {low} to {high} {unit}; if it is meant, unusual_values = true at the top of the scene accepts \
                 {least} to {most} {unit}"
            ),
        };
        Err(self.fault(format!("{value} is out of range"), &remedy))
    }

    /// Refuses a vector that is not of three SI numbers below 1e6.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn finite(&self, vector: &[f64; 3]) -> Checked {
        match vector.iter().all(|x| x.is_finite() && x.abs() < 1e6) {
            true => Ok(()),
            false => Err(self.fault(format!("{vector:?} is not usable"), "give three finite SI numbers below 1e6")),
        }
    }

    /// Refuses a vector without a direction.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn direction(&self, vector: &[f64; 3]) -> Checked {
        self.finite(vector)?;
        match vector.iter().map(|x| x * x).sum::<f64>() > 1e-24 {
            true => Ok(()),
            false => Err(self.fault("has no direction".into(), "give a vector that is not zero")),
        }
    }
}
