//! Published laws of granular matter, measured in Makadam and judged against the published value.
//!
//! ```text
//! Law ─> cases ─> Run (a case, a seed) ─> measure ─> Row ─> means over seeds ─> judge ─> Finding
//!                                          kept at once                        ─> figures, CSV, JSON, table
//! ```
//!
//! A law is one file that implements `Law` and one line in `all`. What it takes as given (sizes, friction, definitions) is
//! constant in that file and was chosen before anything was measured (`validation/docs/laws.md` tells of what was not); only what the
//! law leaves open is fitted.

mod beverloo;
mod campaign;
mod chute;
mod collapse;
mod fit;
mod janssen;
mod results;
#[cfg(test)]
mod tests;

pub(crate) use campaign::{Case, LawError, Plan, Run, StoredRows, Values, run_cases, work};
pub(crate) use results::{LawResult, Mean, Row, Study, in_words, runs, table, write, write_scenes};

use crate::draw::figure::Figure;
use crate::study::Finding;

/// A published law.
pub(crate) trait Law: Sync {
    /// Its name on the command line.
    fn name(&self) -> &'static str;

    /// What it says, with its formula.
    fn statement(&self) -> &'static str;

    /// Where it was published.
    fn source(&self) -> &'static str;

    /// What is simulated, in the order of tables; fewer and smaller cases if `quick`.
    fn cases(&self, quick: bool) -> Vec<Case>;

    /// Rows of all its cases as they were last recorded: the `rows.csv` of `makadam laws`.
    #[cfg(test)]
    fn recorded(&self) -> &'static str;

    /// Takes a case through its simulation and measures it.
    ///
    /// # Errors
    /// [`LawError`] if the user asked to stop or a number is not finite.
    fn measure(&self, case: &Case, run: &mut Run<'_>) -> Result<Values, LawError>;

    /// Figures with the bounds that the law sets for them; those without bounds are reported only.
    fn judge(&self, means: &[Mean]) -> Vec<Finding>;

    /// Measured values beside the law.
    fn figures(&self, means: &[Mean]) -> Vec<Figure>;
}

/// All laws, in the order in which they are shown.
pub(crate) fn all() -> [&'static dyn Law; 4] {
    [&janssen::Janssen, &beverloo::Beverloo, &collapse::Collapse, &chute::Chute]
}

/// A figure without bounds.
fn reported(what: impl Into<String>, unit: &'static str, value: f64) -> Finding {
    Finding::between(what, unit, value, f64::NEG_INFINITY, f64::INFINITY)
}
