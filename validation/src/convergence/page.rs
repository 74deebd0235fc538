//! The files of a study: its curves, its figures, and a page with a table and what they say.

use super::figures::{figures, title};
use super::findings::power;
use super::study::{Curve, Reached, Study};
use crate::draw::figure::Figure;
use crate::draw::numbers::{compact, count, two_digits};
use crate::study::{Cell, Document, DocumentError, File, Table, json, page, table};
use makadam::ConvergencePoint;
use minijinja::context;
use serde::Serialize;

/// A method after some iterations, as a row of `convergence.csv`. Residuals are in units of g h, or in m/s where there is no
/// gravity.
#[derive(Serialize)]
struct Row {
    method: &'static str,
    iteration: u32,
    seconds: f64,
    normal_rms: f64,
    normal_max: f64,
    tangential_u_rms: f64,
    tangential_u_max: f64,
    tangential_v_rms: f64,
    tangential_v_max: f64,
    turning_rms: f64,
    turning_max: f64,
}

impl Row {
    fn of(curve: &Curve, point: &ConvergencePoint) -> Row {
        let residuals = &point.residuals;
        Row {
            method: curve.method.name(),
            iteration: point.iterations,
            seconds: point.seconds,
            normal_rms: residuals.normal.rms,
            normal_max: residuals.normal.max,
            tangential_u_rms: residuals.tangential_u.rms,
            tangential_u_max: residuals.tangential_u.max,
            tangential_v_rms: residuals.tangential_v.rms,
            tangential_v_max: residuals.tangential_v.max,
            turning_rms: residuals.turning.rms,
            turning_max: residuals.turning.max,
        }
    }
}

impl Document for Study {
    const NAME: &'static str = "convergence";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        let rows = self.methods.iter().flat_map(|curve| curve.points.iter().map(|point| Row::of(curve, point)));
        Ok(vec![table(Self::NAME, &rows.collect::<Vec<_>>())?, json("provenance", &self.provenance)?])
    }

    fn figures(&self) -> Vec<Figure> {
        figures(self)
    }

    fn page(&self, figures: &[Figure]) -> Result<String, minijinja::Error> {
        let problem = &self.problem;
        let title = format!("Convergence on the scene {}", problem.scene);
        let others = context! {
            study => self,
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

/// Methods, each with what it took to each tolerance.
fn methods(study: &Study) -> Table {
    let to = |&tolerance: &f64| format!("to {} {}", power(tolerance), study.problem.residual_unit_name);
    Table::new(&["method"], &["ms an iteration"])
        .with_numbers(study.tolerances.iter().map(to))
        .of(&study.methods, cells)
}

fn cells(curve: &Curve) -> Vec<Cell> {
    let reached = |reached: &Reached| {
        let below = reached.seconds.map(|seconds| format!("{} ms", two_digits(1e3 * seconds)));
        Cell::from(reached.iterations.map(|iterations| iterations.to_string())).above(below)
    };
    let method = [title(curve.method).into(), two_digits(1e3 * curve.seconds_per_iteration).into()];
    method.into_iter().chain(curve.reached.iter().map(reached)).collect()
}
