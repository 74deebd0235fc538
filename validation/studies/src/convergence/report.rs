//! Answer, tables and files of a study of convergence.

use super::figures::figures;
use super::study::{Curve, Reached, Study};
use makadam::sweep::Residuals;
use makadam_compare::study::{Answer, Document, DocumentError, File, Report, Section, Table, cells, json};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::numbers::{compact, count, plural, short_time as time, two_digits};

impl Document for Study {
    const NAME: &'static str = "convergence";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![points(self).csv(Self::NAME)?, json("provenance", &self.provenance)?])
    }

    fn figures(&self) -> Vec<Figure> {
        figures(self)
    }

    fn report(&self) -> Report {
        let (problem, provenance) = (&self.problem, &self.provenance);
        let unit = match problem.residual_unit_name.as_str() {
            "g h" => format!(
                "Residuals are in units of g h, the velocity that gravity adds in a step, here {} m/s.",
                compact(problem.residual_unit)
            ),
            _ => "There is no gravity: residuals are in m/s.".into(),
        };
        Report {
            kind: "Makadam, residual against iterations and wall time",
            title: format!("Convergence on the scene {}", problem.scene),
            facts: vec![
                format!("{} grains", count(problem.particles)),
                format!("{} contacts", count(problem.contacts)),
                format!("step {} ms", compact(1e3 * problem.time_step)),
                provenance.build.processor.clone(),
                provenance.build.instruction_set.clone(),
                format!("threads {}", provenance.threads),
                format!("version {}", provenance.build.version),
                provenance.time.clone(),
            ],
            answer: answer(self),
            findings: self.findings.clone(),
            sections: vec![Section::new(
                format!(
                    "Iterations and milliseconds to a root mean square residual ({}); - if not reached",
                    problem.residual_unit_name
                ),
                format!("Over contacts and directions, within {} iterations.", self.iterations),
                methods(self),
            )],
            notes: Vec::new(),
            limits: vec![
                format!(
                    "The problem is that of the next step of the state at {} s. Every method starts from it, with the share {} of the \
                     last step's impulses: iteration 0 is that start.",
                    compact(problem.start_seconds),
                    provenance.solver.warm_start
                ),
                "The residual of a contact is the change that relaxing it by itself, without over-relaxation, would still make: |change \
                 of the impulse| times the compliance of the contact, a velocity. It is zero at the solution and nowhere else, and the \
                 measure is common to all methods."
                    .into(),
                unit,
                "An iteration of Gauss-Seidel is one sweep over all contacts, of Anderson and of nonlinear conjugate gradients a sweep and \
                 more, of the others one or several passes: iterations compare methods as the thesis does, wall time as a user does."
                    .into(),
                format!(
                    "Sweeps are over-relaxed by {}; the factor falls back to 1 where the residual grows.",
                    provenance.solver.over_relaxation
                ),
                format!(
                    "Wall time is that of the iterations and of their preparation, without measuring the residual. The problem was solved \
                     {} with each method, in turn, and each iteration counts with its shortest time.",
                    plural(self.repetitions as usize, "time")
                ),
                "Curves of methods that diverge are cut off at ten times the residual that they start from.".into(),
            ],
            provenance: provenance.pairs(),
            files: "convergence.json and convergence.csv",
        }
    }
}

/// Residual at which methods are compared, in the study's unit; a qualification requires it of each method.
const TOLERANCE: f64 = 1e-2;

/// The method that reaches 0.01 of the unit soonest by wall time, the next one, and those that do not reach it. If the start is below
/// that already, the next smaller residual counts.
fn answer(study: &Study) -> Answer {
    let unit = &study.problem.residual_unit_name;
    let is_start = |tolerance: f64| {
        let at = |curve: &Curve| curve.reached.iter().find(|one| one.tolerance == tolerance)?.iterations;
        study.methods.first().and_then(at) == Some(0)
    };
    let smaller = study.tolerances.iter().copied().filter(|tolerance| *tolerance <= TOLERANCE);
    let Some(tolerance) = smaller.clone().find(|tolerance| !is_start(*tolerance)) else {
        let sentence = format!("The start is below {} {unit}.", compact(smaller.fold(TOLERANCE, f64::min)));
        return Answer { class: "agree", word: "There is nothing to solve.".into(), sentence };
    };
    let to = format!("{} {unit}", compact(tolerance));
    let started = match tolerance < TOLERANCE {
        true => format!(" The start is below {} {unit} already.", compact(TOLERANCE)),
        false => String::new(),
    };
    let reached = |curve: &Curve| -> Option<(u32, f64)> {
        let Reached { iterations, seconds, .. } = *curve.reached.iter().find(|one| one.tolerance == tolerance)?;
        iterations.zip(seconds)
    };
    let mut there: Vec<(&Curve, u32, f64)> = (study.methods.iter())
        .filter_map(|curve| reached(curve).map(|(iterations, seconds)| (curve, iterations, seconds)))
        .collect();
    there.sort_by(|(_, _, one), (_, _, other)| one.total_cmp(other));
    let others: Vec<&str> =
        study.methods.iter().filter(|curve| reached(curve).is_none()).map(|curve| curve.method.name()).collect();
    let short = match others.as_slice() {
        [] => started,
        _ => format!(" Not within {} iterations: {}.{started}", study.iterations, others.join(", ")),
    };
    let Some((first, iterations, seconds)) = there.first() else {
        let word = format!("No method reaches {to}.");
        return Answer { class: "undecided", word, sentence: short.trim_start().into() };
    };
    let next = there.get(1).map_or(String::new(), |(next, iterations, seconds)| {
        format!("; next is {} with {} in {}", next.method.name(), steps(next, *iterations), time(*seconds))
    });
    Answer {
        class: "agree",
        word: format!("Fastest to {to}: {}.", first.method.name()),
        sentence: format!("It takes {} in {}{next}.{short}", steps(first, *iterations), time(*seconds)),
    }
}

/// Iterations, called sweeps where each is one.
fn steps(curve: &Curve, iterations: u32) -> String {
    let word = if curve.method.name() == "gauss-seidel" { "sweep" } else { "iteration" };
    plural(iterations as usize, word)
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

/// Methods, each with iterations and milliseconds to each tolerance.
fn methods(study: &Study) -> Table {
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
