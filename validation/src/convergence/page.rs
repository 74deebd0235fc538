//! The files of a study: its curves, its figures, and a page with a table and what they say.

use super::answer::answer;
use super::figures::figures;
use super::study::{Reached, Study};
use crate::draw::figure::Figure;
use crate::draw::numbers::{compact, count, two_digits};
use crate::study::{Document, DocumentError, File, Table, cells, json, page};
use makadam::sweep::Residuals;
use minijinja::context;

impl Document for Study {
    const NAME: &'static str = "convergence";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![points(self).csv(Self::NAME)?, json("provenance", &self.provenance)?])
    }

    fn figures(&self) -> Vec<Figure> {
        figures(self)
    }

    fn page(&self, figures: &[Figure]) -> Result<String, minijinja::Error> {
        let problem = &self.problem;
        let title = format!("Convergence on the scene {}", problem.scene);
        let others = context! {
            study => self,
            answer => answer(self),
            particles => count(problem.particles),
            contacts => count(problem.contacts),
            step => compact(1e3 * problem.time_step),
            start => compact(problem.start_seconds),
            unit => format!("{} m/s", compact(problem.residual_unit)),
            gravity => problem.residual_unit_name == "g h",
            methods => methods(self).html(),
        };
        page(include_str!("page.html"), &title, figures, self.provenance.pairs(), others)
    }
}

/// Each method after each number of iterations. Residuals are in units of g h, or in m/s where there is no gravity.
fn points(study: &Study) -> Table {
    let rows = study.methods.iter().flat_map(|curve| curve.points.iter().map(move |point| (curve, point)));
    Table::named(
        "method iteration seconds normal_rms normal_max tangential_u_rms tangential_u_max tangential_v_rms \
         tangential_v_max turning_rms turning_max",
    )
    .of(rows, |(curve, point)| {
        let Residuals { normal, tangential_u, tangential_v, turning } = point.residuals;
        let of_point = cells![curve.method.name(), point.iterations, point.seconds];
        let residuals = [normal, tangential_u, tangential_v, turning];
        of_point.into_iter().chain(residuals.into_iter().flat_map(|one| cells![one.rms, one.max])).collect()
    })
}

/// Methods, each with iterations and milliseconds to each tolerance: the same on a terminal and on the page.
pub(super) fn methods(study: &Study) -> Table {
    let short = study.tolerances.iter().flat_map(|&tolerance| [power(tolerance), "ms".into()]);
    let unit = &study.problem.residual_unit_name;
    let long = study.tolerances.iter().flat_map(|&tolerance| [format!("to {} {unit}", power(tolerance)), "ms".into()]);
    let long: Vec<String> = long.collect();
    Table::new(&["method"], &["ms an iteration"])
        .with_numbers(short)
        .on_a_page(&long.iter().map(String::as_str).collect::<Vec<_>>())
        .of(&study.methods, |curve| {
            let milliseconds = |seconds: f64| two_digits(1e3 * seconds);
            let reached = |reached: &Reached| cells![reached.iterations, reached.seconds.map(milliseconds)];
            let method = cells![curve.method.name(), milliseconds(curve.seconds_per_iteration)];
            method.into_iter().chain(curve.reached.iter().flat_map(reached)).collect()
        })
}

/// A tolerance, such as 0.01 or 10⁻⁶.
fn power(tolerance: f64) -> String {
    compact(tolerance).trim_start_matches("1×").into()
}
