//! Answers of studies of convergence, on curves whose residuals fall by a known factor.

use makadam::ConvergencePoint;
use makadam::scene::SolverMethod;
use makadam::sweep::{Residual, Residuals};
use makadam_compare::study::Document as _;
use makadam_frames::execution::Execution;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::Provenance;
use makadam_studies::convergence::{Curve, Effort, Problem, Study, TOLERANCES};
use std::path::Path;

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
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing-100/scene.toml");
    let scene = MeasuredScene::load(&file).unwrap();
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
    Study {
        version: 1,
        command: "convergence".into(),
        problem,
        effort: Effort { iterations: 10, repetitions: 1 },
        tolerances: TOLERANCES.into(),
        methods,
        findings: Vec::new(),
        provenance,
    }
}

/// The answer, in the second line of a terminal.
fn text(study: &Study) -> String {
    study.report().text().lines().nth(1).unwrap().into()
}

#[test]
fn answer_names_first_and_missing() {
    // From 2 on: three divisions by 10, two by 100, more than ten by 1.1.
    let methods = vec![
        curve(SolverMethod::Jacobi { damping: 0.5 }, 1.1, 1e-4),
        curve(SolverMethod::Anderson { memory: 5 }, 100.0, 2.0),
        curve(SolverMethod::GaussSeidel, 10.0, 1e-3),
    ];
    assert_eq!(
        text(&study(methods.clone())),
        "Fastest to 0.01 g h: gauss-seidel. It takes 3 iterations in 3.0 ms. Not within 10 iterations: jacobi."
    );
    assert_eq!(
        text(&study(methods[2..].to_vec())),
        "Fastest to 0.01 g h: gauss-seidel. It takes 3 iterations in 3.0 ms."
    );
    let none = study(methods[..1].to_vec());
    assert_eq!(text(&none), "No method reaches 0.01 g h. Not within 10 iterations: jacobi.");
    assert!(none.report().page(&[]).unwrap().contains("<p class=\"verdict undecided\">"));
}

#[test]
fn page_and_terminal_begin_with_answer() {
    let study = study(vec![curve(SolverMethod::GaussSeidel, 10.0, 1e-3)]);
    let page = study.report().page(&[]).unwrap();
    let head = page.split_once("</h1>").unwrap().1;
    assert!(
        head.trim_start().starts_with("<p class=\"verdict agree\"><strong>Fastest to 0.01 g h: gauss-seidel.</strong>"),
        "{head}"
    );
    assert!(study.report().text().contains("Fastest to 0.01 g h: gauss-seidel. It takes 3 iterations in 3.0 ms."));
}
