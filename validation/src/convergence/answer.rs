//! What a study of convergence answers: which method is first at the residual that a run asks for, and how soon.

use super::study::{Curve, Reached, Study};
use crate::draw::numbers::{compact, plural, two_digits};
use crate::study::Answer;

/// The residual that methods are held against, in the study's unit: what a qualification asks of each method.
const TOLERANCE: f64 = 1e-2;

/// Which method reaches 0.01 of the unit soonest by wall time, which is next, and which do not reach it. Where the start is there already,
/// the next smaller residual is what tells methods apart.
pub(super) fn answer(study: &Study) -> Answer {
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

fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", two_digits(s)),
        s => format!("{} ms", two_digits(1e3 * s)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convergence::study::{Effort, Problem};
    use crate::convergence::terminal::table;
    use crate::execution::Execution;
    use crate::provenance::Provenance;
    use crate::scenes;
    use crate::study::Document as _;
    use makadam::ConvergencePoint;
    use makadam::scene::SolverMethod;
    use makadam::sweep::{Residual, Residuals};

    /// A method whose residual is divided by `factor` in each iteration of `seconds`.
    fn curve(method: SolverMethod, factor: f64, seconds: f64) -> Curve {
        let points = (0..=10).map(|iterations| {
            let rms = factor.powi(-(iterations as i32));
            let one = Residual { rms, max: rms };
            let residuals = Residuals { normal: one, tangential_u: one, tangential_v: one, turning: one };
            ConvergencePoint { iterations, seconds: seconds * f64::from(iterations), residuals }
        });
        Curve::new(method, vec![points.collect()], 1.0)
    }

    fn study(methods: Vec<Curve>) -> Study {
        let file = scenes::find("packing-100", &[]).unwrap();
        let scene = scenes::load(&file).unwrap();
        let provenance = Provenance::of_run(&scene, &file, 1, &Execution::serial());
        let problem = Problem {
            scene: scene.name.clone(),
            start_seconds: 0.1,
            time_step: 1e-3,
            particles: 100,
            contacts: 300,
            residual_unit: 1.0,
            residual_unit_name: "g h".into(),
        };
        Study::new(problem, Effort { iterations: 10, repetitions: 1 }, methods, Vec::new(), provenance)
    }

    #[test]
    fn the_first_the_next_and_those_that_are_left_are_told() {
        // From 2 on: three divisions by 10, two by 100, more than ten by 1.1.
        let methods = vec![
            curve(SolverMethod::Jacobi { damping: 0.5 }, 1.1, 1e-4),
            curve(SolverMethod::Anderson { memory: 5 }, 100.0, 2.0),
            curve(SolverMethod::GaussSeidel, 10.0, 1e-3),
        ];
        assert_eq!(
            answer(&study(methods.clone())).text(),
            "Fastest to 0.01 g h: gauss-seidel. It takes 3 sweeps in 3.0 ms; next is anderson with 2 iterations in 4.0 s. \
             Not within 10 iterations: jacobi."
        );
        assert_eq!(
            answer(&study(methods[2..].to_vec())).text(),
            "Fastest to 0.01 g h: gauss-seidel. It takes 3 sweeps in 3.0 ms."
        );
        let none = answer(&study(methods[..1].to_vec()));
        assert_eq!(
            (none.class, none.text().as_str()),
            ("undecided", "No method reaches 0.01 g h. Not within 10 iterations: jacobi.")
        );
    }

    #[test]
    fn a_start_that_is_there_already_is_no_answer() {
        // The first point lies at 2; scaled down, at 0.002.
        let near = |method, factor| {
            let solve = curve(method, factor, 1e-3);
            Curve::new(method, vec![solve.points], 1e3)
        };
        let found = answer(&study(vec![near(SolverMethod::GaussSeidel, 10.0)])).text();
        assert_eq!(
            found,
            "Fastest to 0.001 g h: gauss-seidel. It takes 1 sweep in 1.0 ms. The start is below 0.01 g h already."
        );
        let mut solved = curve(SolverMethod::GaussSeidel, 10.0, 1e-3);
        solved.reached.iter_mut().for_each(|one| (one.iterations, one.seconds) = (Some(0), Some(0.0)));
        let found = answer(&study(vec![solved])).text();
        assert_eq!(found, "There is nothing to solve. The start is below 1×10⁻⁶ g h.");
    }

    #[test]
    fn the_page_and_the_terminal_begin_with_it() {
        let study = study(vec![curve(SolverMethod::GaussSeidel, 10.0, 1e-3)]);
        let page = study.page(&[]).unwrap();
        let head = page.split_once("</h1>").unwrap().1;
        assert!(
            head.trim_start()
                .starts_with("<p class=\"verdict agree\"><strong>Fastest to 0.01 g h: gauss-seidel.</strong>"),
            "{head}"
        );
        assert!(table(&study).contains("Fastest to 0.01 g h: gauss-seidel. It takes 3 sweeps in 3.0 ms."));
    }
}
