//! The page of a study: figures, a table and what they say, in one file that loads nothing.

use super::figures::title;
use super::findings::power;
use super::study::{Curve, Study};
use crate::draw::figure::Figure;
use crate::draw::numbers::{compact, count, two_digits};
use crate::report::page::{environment, style};
use minijinja::{Value, context};

/// Renders the page.
pub(super) fn render(study: &Study, figures: &[Figure]) -> Result<String, minijinja::Error> {
    let mut environment = environment()?;
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
        tolerances => study.tolerances.iter().map(|&tolerance| power(tolerance)).collect::<Vec<_>>(),
        rows => study.methods.iter().map(row).collect::<Vec<_>>(),
        provenance => study.provenance.pairs(),
    })
}

fn row(curve: &Curve) -> Value {
    let reached = curve.reached.iter().map(|reached| {
        let (iterations, seconds) = (reached.iterations?, reached.seconds?);
        Some(context! { iterations => iterations, time => two_digits(1e3 * seconds) })
    });
    context! {
        method => title(curve.method),
        iteration => two_digits(1e3 * curve.seconds_per_iteration),
        reached => reached.collect::<Vec<_>>(),
    }
}
