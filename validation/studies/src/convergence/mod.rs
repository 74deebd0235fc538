//! Convergence of each method on the problem of one step: the thesis's figure 6.1, for every method and against wall time.
//!
//! ```text
//! flowing state ─> the problem of its next step ─> method by method ─> residual after each iteration ─> study
//!                                                                                                        │
//!                                    terminal, page, figures, CSV <── tolerances reached <───────────────┘
//! ```
//!
//! Every method starts from the same state of the same problem, with one measure for all of them: the natural map of
//! [`makadam::methods`].

mod figures;

use figures::figures;
use makadam::scene::SolverMethod;
use makadam::solve::residual_unit_name;
use makadam::sweep::{Residual, Residuals};
use makadam::{ConvergencePoint, Simulation};
use makadam_compare::study::{Answer, Document, DocumentError, File, Report, Section, Table, cells, json};
use makadam_frames::execution::MeasureError;
use makadam_frames::output::JSON_VERSION;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::Provenance;
use makadam_measure::statistics::median;
use makadam_view::draw::figure::Figure;
use makadam_view::draw::numbers::{compact, count, plural, short_time as time, two_digits};
use serde::{Serialize, Serializer};

/// Residuals for which a method is timed, in the study's unit.
pub const TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6];

/// Output of `makadam lab convergence --json` and content of `convergence.json`; documented in `validation/docs/json.md`.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Study {
    pub version: u32,
    pub command: String,
    #[serde(flatten)]
    pub problem: Problem,
    #[serde(flatten)]
    pub effort: Effort,
    /// Residuals for which methods were timed, in units of `residual_unit`.
    pub tolerances: Vec<f64>,
    pub methods: Vec<Curve>,
    /// Methods that were not run, as sentences.
    pub findings: Vec<String>,
    pub provenance: Provenance,
}

/// Effort of each method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Effort {
    /// Iterations of a solve.
    pub iterations: u32,
    /// Solves of the same problem; each iteration counts with its shortest time.
    pub repetitions: u32,
}

/// Problem of one step.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Problem {
    pub scene: String,
    /// Simulated time of the state before the step, s.
    pub start_seconds: f64,
    pub time_step: f64,
    pub particles: usize,
    pub contacts: usize,
    /// Velocity unit of residuals, m/s.
    pub residual_unit: f64,
    /// Name of that unit: "g h", or "m/s" without gravity.
    pub residual_unit_name: String,
}

impl Problem {
    /// Returns the problem of a simulation's next step; the simulation does not change.
    fn next(scene: &MeasuredScene, simulation: &Simulation) -> Problem {
        let unit = simulation.residual_unit();
        let mut copy = simulation.clone();
        Problem {
            scene: scene.name.clone(),
            start_seconds: simulation.time(),
            time_step: simulation.time_step(),
            particles: simulation.snapshot().particles.len(),
            contacts: copy.step().contacts,
            residual_unit: unit,
            residual_unit_name: residual_unit_name(scene.gravity_field().largest()).into(),
        }
    }
}

/// Convergence of a method. Residuals are in the study's unit.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Curve {
    #[serde(serialize_with = "name")]
    pub method: SolverMethod,
    pub parameters: SolverMethod,
    /// Wall time of an iteration, median, s.
    pub seconds_per_iteration: f64,
    pub reached: Vec<Reached>,
    /// Initial state of the solve, and the state after each iteration.
    pub points: Vec<ConvergencePoint>,
}

/// First point with a root mean square residual over the three directions and turning at or below a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Reached {
    pub tolerance: f64,
    /// Iterations until then; absent if the tolerance was not reached.
    pub iterations: Option<u32>,
    /// Wall time until then, s; absent if the tolerance was not reached.
    pub seconds: Option<f64>,
}

impl Curve {
    /// Makes a curve of a method's solves of one problem, at least one, with residuals in m/s. Solves differ in their times
    /// alone. The shortest time of an iteration over all solves counts, since all disturbances lengthen it.
    pub fn new(method: SolverMethod, mut solves: Vec<Vec<ConvergencePoint>>, unit: f64) -> Curve {
        let fastest = fastest(&solves);
        let points: Vec<ConvergencePoint> = (solves.swap_remove(0).into_iter().zip(fastest))
            .map(|(point, seconds)| ConvergencePoint { seconds, residuals: over(&point.residuals, unit), ..point })
            .collect();
        let reached = TOLERANCES.map(|tolerance| {
            let first = points.iter().find(|point| point.residuals.rms() <= tolerance);
            Reached {
                tolerance,
                iterations: first.map(|point| point.iterations),
                seconds: first.map(|point| point.seconds),
            }
        });
        Curve {
            method,
            parameters: method,
            seconds_per_iteration: median(points.windows(2).map(|two| two[1].seconds - two[0].seconds)),
            reached: reached.into(),
            points,
        }
    }
}

/// Wall time until each point if every iteration takes its shortest time over all solves, s.
fn fastest(solves: &[Vec<ConvergencePoint>]) -> Vec<f64> {
    let count = solves.iter().map(Vec::len).min().unwrap_or(0);
    let mut total = 0.0;
    let times = (0..count).map(|place| {
        let before = |points: &[ConvergencePoint]| if place > 0 { points[place - 1].seconds } else { 0.0 };
        let own = solves.iter().map(|points| points[place].seconds - before(points));
        total += own.fold(f64::INFINITY, f64::min);
        total
    });
    times.collect()
}

fn over(residuals: &Residuals, unit: f64) -> Residuals {
    let one = |residual: Residual| Residual { rms: residual.rms / unit, max: residual.max / unit };
    Residuals {
        normal: one(residuals.normal),
        tangential_u: one(residuals.tangential_u),
        tangential_v: one(residuals.tangential_v),
        turning: one(residuals.turning),
    }
}

fn name<S: Serializer>(method: &SolverMethod, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(method.name())
}

/// Returns the methods of these names, each once; the scene's own method has its parameters, others have the defaults.
pub fn methods(scene: &MeasuredScene, names: Option<&[String]>) -> Vec<SolverMethod> {
    let own = scene.solver.method;
    let wanted = |method: &SolverMethod| names.is_none_or(|names| names.iter().any(|name| name == method.name()));
    let all = SolverMethod::ALL.into_iter().filter(wanted);
    all.map(|method| if method.name() == own.name() { own } else { method }).collect()
}

/// Solves the problem of a simulation's next step with all of the requested methods that suit it, several times in turn, so that a
/// disturbance affects all of them. `progress` receives the method and the completed fraction.
///
/// # Errors
/// [`MeasureError::Interrupted`].
pub fn measure(
    scene: &MeasuredScene,
    simulation: &Simulation,
    wanted: Vec<SolverMethod>,
    effort: Effort,
    provenance: Provenance,
    progress: &dyn Fn(SolverMethod, f64),
) -> Result<Study, MeasureError> {
    let Effort { iterations, repetitions } = effort;
    let (mut methods, mut findings) = (Vec::new(), Vec::new());
    for method in wanted {
        match simulation.goes_with(method) {
            Ok(()) => methods.push(method),
            Err(error) => findings.push(format!("Not run: {error}.")),
        }
    }
    let mut solves = vec![Vec::new(); methods.len()];
    for repetition in 0..repetitions {
        for (place, &method) in methods.iter().enumerate() {
            let fraction = place as f64 / methods.len() as f64;
            progress(method, (f64::from(repetition) + fraction) / f64::from(repetitions));
            solves[place].push(simulation.convergence(method, iterations).expect("the method suits the simulation"));
            if makadam_frames::interrupt::requested() {
                return Err(MeasureError::Interrupted);
            }
        }
    }
    let unit = simulation.residual_unit();
    let curves = methods.iter().zip(solves).map(|(&method, solves)| Curve::new(method, solves, unit));
    Ok(Study {
        version: JSON_VERSION,
        command: "convergence".into(),
        problem: Problem::next(scene, simulation),
        effort,
        tolerances: TOLERANCES.into(),
        methods: curves.collect(),
        findings,
        provenance,
    })
}

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
                format!("Over contacts and directions, within {} iterations.", self.effort.iterations),
                reached(self),
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
                    plural(self.effort.repetitions as usize, "time")
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

/// Method that reaches 0.01 of the unit soonest by wall time, and those that do not reach it.
fn answer(study: &Study) -> Answer {
    let to = format!("{} {}", compact(TOLERANCE), study.problem.residual_unit_name);
    let (mut fastest, mut missing) = (None, Vec::new());
    for curve in &study.methods {
        let name = curve.method.name();
        match curve.points.iter().find(|point| point.residuals.rms() <= TOLERANCE) {
            Some(point) if fastest.is_none_or(|(_, seconds, _)| point.seconds < seconds) => {
                fastest = Some((name, point.seconds, point.iterations));
            }
            Some(_) => {}
            None => missing.push(name),
        }
    }
    let (class, word, mut sentence) = match fastest {
        Some((name, seconds, iterations)) => {
            let effort = format!("It takes {} in {}.", plural(iterations as usize, "iteration"), time(seconds));
            ("agree", format!("Fastest to {to}: {name}."), effort)
        }
        None => ("undecided", format!("No method reaches {to}."), String::new()),
    };
    if !missing.is_empty() {
        sentence += &format!(" Not within {} iterations: {}.", study.effort.iterations, missing.join(", "));
    }
    Answer { class, word, sentence: sentence.trim_start().into() }
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
fn reached(study: &Study) -> Table {
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

/// Formats a tolerance, such as 0.01 or 10⁻⁶.
fn power(tolerance: f64) -> String {
    compact(tolerance).trim_start_matches("1×").into()
}
