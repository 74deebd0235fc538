//! The study: one problem, solved by every suitable method in turn, as data.

use makadam::scene::SolverMethod;
use makadam::solve::residual_unit_name;
use makadam::sweep::{Residual, Residuals};
use makadam::{ConvergencePoint, Simulation};
use makadam_frames::execution::MeasureError;
use makadam_frames::output::JSON_VERSION;
use makadam_frames::plan::Scene;
use makadam_frames::provenance::Provenance;
use makadam_measure::statistics::median;
use serde::{Serialize, Serializer};

/// Residuals that a method is timed to, in the study's unit.
pub const TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6];

/// Output of `makadam lab convergence --json` and content of `convergence.json`; documented in `validation/docs/json.md`.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Study {
    pub version: u32,
    pub command: String,
    #[serde(flatten)]
    pub problem: Problem,
    pub iterations: u32,
    /// Solves of the problem by each method; each iteration counts with its shortest time.
    pub repetitions: u32,
    /// Residuals that methods were timed to, in units of `residual_unit`.
    pub tolerances: Vec<f64>,
    pub methods: Vec<Curve>,
    pub left_out: Vec<LeftOut>,
    /// Methods that were not run, in sentences.
    pub findings: Vec<String>,
    pub provenance: Provenance,
}

/// Effort of each method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Iterations of a solve.
    pub iterations: u32,
    /// Solves of the same problem.
    pub repetitions: u32,
}

/// A method that was not run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Its name.
    pub method: &'static str,
    /// The reason that it cannot solve the scene.
    pub reason: String,
}

/// The problem of one step.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Problem {
    pub scene: String,
    /// Simulated time of the state whose next step it is, s.
    pub start_seconds: f64,
    pub time_step: f64,
    pub particles: usize,
    pub contacts: usize,
    /// Velocity that residuals are given in, m/s.
    pub residual_unit: f64,
    /// Its name: "g h", or "m/s" without gravity.
    pub residual_unit_name: String,
}

impl Problem {
    /// The problem of a simulation's next step; the simulation stays as it is.
    fn next(scene: &Scene, simulation: &Simulation) -> Problem {
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
    /// The state that the solve started from, and that after each iteration.
    pub points: Vec<ConvergencePoint>,
}

/// First point with a root mean square residual over the three directions and turning at or below a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Reached {
    pub tolerance: f64,
    /// Iterations until then; absent if it was not reached.
    pub iterations: Option<u32>,
    /// Wall time until then, s; absent if it was not reached.
    pub seconds: Option<f64>,
}

impl Curve {
    /// Makes a curve of a method's solves of one problem, at least one, with residuals in m/s. Solves differ in their times
    /// alone; an iteration's is the shortest that it took in any of them, since all that interferes makes it longer.
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

impl Study {
    /// Makes a study of curves.
    pub fn new(
        problem: Problem,
        effort: Effort,
        methods: Vec<Curve>,
        left_out: Vec<LeftOut>,
        provenance: Provenance,
    ) -> Study {
        Study {
            version: JSON_VERSION,
            command: "convergence".into(),
            problem,
            iterations: effort.iterations,
            repetitions: effort.repetitions,
            tolerances: TOLERANCES.into(),
            methods,
            findings: left_out.iter().map(|one| format!("Not run: {}.", one.reason)).collect(),
            left_out,
            provenance,
        }
    }
}

/// Wall time until each point if every iteration takes the shortest time that it took in any solve, s.
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

/// The methods of these names, each once; the scene's own method has its parameters, others have the defaults.
pub fn methods(scene: &Scene, names: Option<&[String]>) -> Vec<SolverMethod> {
    let own = scene.solver.method;
    let wanted = |method: &SolverMethod| names.is_none_or(|names| names.iter().any(|name| name == method.name()));
    let all = SolverMethod::ALL.into_iter().filter(wanted);
    all.map(|method| if method.name() == own.name() { own } else { method }).collect()
}

/// Solves the problem of a simulation's next step with all of the wanted methods that suit it, several times in turn, so that a
/// disturbance falls on all of them. `progress` receives the method and the completed fraction.
///
/// # Errors
/// [`MeasureError::Interrupted`].
pub fn measure(
    scene: &Scene,
    simulation: &Simulation,
    wanted: Vec<SolverMethod>,
    effort: Effort,
    provenance: Provenance,
    progress: &dyn Fn(SolverMethod, f64),
) -> Result<Study, MeasureError> {
    let Effort { iterations, repetitions } = effort;
    let (mut methods, mut left_out) = (Vec::new(), Vec::new());
    for method in wanted {
        match simulation.goes_with(method) {
            Ok(()) => methods.push(method),
            Err(error) => left_out.push(LeftOut { method: method.name(), reason: error.to_string() }),
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
    let curves = methods.iter().zip(solves).map(|(&method, solves)| Curve::new(method, solves, unit)).collect();
    Ok(Study::new(Problem::next(scene, simulation), effort, curves, left_out, provenance))
}
