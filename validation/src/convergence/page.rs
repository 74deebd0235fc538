//! The page of a study: figures, a table and what they say, in one file that loads nothing.

use super::study::Study;
use super::terminal::{cells, heads};
use crate::report::figure::Figure;
use crate::report::numbers::{compact, count};
use crate::report::page::{environment, style};
use minijinja::context;

/// Renders the page.
pub(super) fn render(study: &Study, figures: &[Figure]) -> Result<String, minijinja::Error> {
    let mut environment = environment();
    environment.add_template("page", include_str!("page.html"))?;
    let problem = &study.problem;
    environment.get_template("page")?.render(context! {
        title => format!("Convergence on the scene {}", problem.scene),
        style => style(),
        study => study,
        particles => count(problem.particles),
        contacts => count(problem.contacts),
        step => compact(1e3 * problem.time_step),
        start => compact(problem.start_seconds),
        unit => format!("{} m/s", compact(problem.residual_unit)),
        gravity => problem.residual_unit_name == "g h",
        figures => figures,
        tolerances => study.tolerances.iter().map(|&tolerance| compact(tolerance)).collect::<Vec<_>>(),
        heads => heads(study),
        rows => study.methods.iter().map(cells).collect::<Vec<_>>(),
        provenance => study.provenance.pairs(),
    })
}
