//! Configurations of each code, with the variations of Makadam's solver: method, precision, warm start, sweeps; and the plan, which lists
//! those of a scene.

use makadam::scene::{Precision, SolverMethod, SolverSettings, Stop};
use makadam_frames::plan::MeasuredScene;
use makadam_view::draw::numbers::compact;
use serde::{Deserialize, Serialize};

/// Wall time at which a run of few configurations is cut short where no other is given, s.
pub const QUICK_TIME_LIMIT: f64 = 60.0;

/// A code with its settings: a point of the trade-off once it has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
    /// Name of the code.
    pub code: String,
    /// Factor on every Young's modulus of the scene.
    pub stiffness_factor: f64,
    /// Its settings.
    pub knobs: Knobs,
}

/// Settings of a code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Knobs {
    /// Makadam's solver.
    Solver {
        /// All settings.
        settings: SolverSettings,
        /// The axis that is varied in addition to step and sweeps, and its value, such as "warm start 0".
        variation: Option<String>,
    },
    /// An explicit code's time step.
    Explicit {
        /// Time step over the Rayleigh step.
        rayleigh_fraction: f64,
    },
}

impl Configuration {
    /// The scene as this configuration runs it, its stiffness scaled.
    pub fn scene(&self, scene: &MeasuredScene) -> MeasuredScene {
        let mut scene = scene.with_stiffness_factor(self.stiffness_factor);
        if let Knobs::Solver { settings, .. } = &self.knobs {
            scene.solver = settings.clone();
        }
        scene
    }

    /// Time step over the Rayleigh step, for explicit codes.
    pub fn rayleigh_fraction(&self) -> Option<f64> {
        match self.knobs {
            Knobs::Explicit { rayleigh_fraction } => Some(rayleigh_fraction),
            Knobs::Solver { .. } => None,
        }
    }

    fn solver(&self) -> Option<(&SolverSettings, Option<&str>)> {
        match &self.knobs {
            Knobs::Solver { settings, variation } => Some((settings, variation.as_deref())),
            Knobs::Explicit { .. } => None,
        }
    }

    /// Time step of Makadam, s; explicit codes derive theirs from the grains.
    pub fn step(&self) -> Option<f64> {
        self.solver().map(|(settings, _)| settings.step)
    }

    /// Most iterations of a solve of Makadam: sweeps, with Gauss-Seidel.
    pub fn sweeps(&self) -> Option<u32> {
        self.solver().map(|(settings, _)| settings.stop.max_sweeps())
    }

    /// The axis that is varied in addition to step and sweeps, and its value, for Makadam.
    pub fn variation(&self) -> Option<&str> {
        self.solver().and_then(|(_, variation)| variation)
    }

    /// The knobs in a few words: "0.5 ms × 10 sweeps, warm start 0", or "20% of the Rayleigh step".
    pub fn setting(&self) -> String {
        let (settings, varied) = match &self.knobs {
            Knobs::Explicit { .. } => return format!("{} of the Rayleigh step", self.short_setting()),
            Knobs::Solver { settings, variation } => (settings, listed(variation)),
        };
        let bound = if matches!(settings.stop, Stop::Sweeps { .. }) { "" } else { "at most " };
        // An iteration of the other methods is no sweep, and inner sweeps make it several.
        let is_plain = settings.method == SolverMethod::GaussSeidel && settings.inner_sweeps <= 1;
        let unit = if is_plain { "sweeps" } else { "iterations" };
        format!("{} ms × {bound}{} {unit}{varied}", compact(1e3 * settings.step), settings.stop.max_sweeps())
    }

    /// The knobs where there is little room: "0.5 ms×10", or "20%".
    pub fn short_setting(&self) -> String {
        let (settings, varied) = match &self.knobs {
            Knobs::Explicit { rayleigh_fraction } => return format!("{}%", compact(100.0 * rayleigh_fraction)),
            Knobs::Solver { settings, variation } => (settings, listed(variation)),
        };
        let sweeps = match settings.stop {
            Stop::Sweeps { sweeps } => format!("×{sweeps}"),
            Stop::Residual { max_sweeps, .. } => format!("≤{max_sweeps}"),
            Stop::TimeBudget { .. } => String::new(),
        };
        format!("{} ms{sweeps}{varied}", compact(1e3 * settings.step))
    }
}

fn listed(variation: &Option<String>) -> String {
    variation.as_ref().map_or(String::new(), |variation| format!(", {variation}"))
}

/// A change of one setting of the solver, in addition to step and sweeps.
struct Variation {
    /// The axis and its value, as tables name it.
    name: &'static str,
    change: fn(&mut SolverSettings),
    /// Iterations of a solve at which it is run in addition to the scene's own settings. Methods whose iteration costs several sweeps
    /// have fewer, so that wall times overlap with those of sweeps.
    iterations: &'static [u32],
}

const fn vary(name: &'static str, iterations: &'static [u32], change: fn(&mut SolverSettings)) -> Variation {
    Variation { name, change, iterations }
}

/// Iterations of methods that cost about a sweep, or need many.
const SWEEPS: &[u32] = &[5, 10, 20];
/// Iterations of methods that cost several sweeps.
const FEW: &[u32] = &[3, 5, 10];
/// Most sweeps of a solve that stops at a residual, up to those of the reference.
const MOST: &[u32] = &[10, 20, 40];

const VARIATIONS: [Variation; 15] = [
    vary("warm start 0", SWEEPS, |settings| settings.warm_start = 0.0),
    vary("over-relaxation 1", SWEEPS, |settings| settings.over_relaxation = 1.0),
    vary("2 inner sweeps", FEW, |settings| settings.inner_sweeps = 2),
    vary("4 inner sweeps", &[2, 3, 5], |settings| settings.inner_sweeps = 4),
    vary("residual 0.1", MOST, |settings| settings.stop = down_to(0.1, settings)),
    vary("residual 0.03", MOST, |settings| settings.stop = down_to(0.03, settings)),
    vary("residual 0.01", MOST, |settings| settings.stop = down_to(0.01, settings)),
    vary("residual 0.003", MOST, |settings| settings.stop = down_to(0.003, settings)),
    vary("calm contacts, residual 0.1", MOST, calm_contacts),
    vary("single precision", SWEEPS, |settings| settings.precision = Precision::Single),
    vary("Anderson", FEW, |settings| settings.method = SolverMethod::Anderson { memory: 3 }),
    vary("nonlinear conjugate gradients", FEW, |settings| settings.method = SolverMethod::NonlinearConjugateGradients),
    vary("accelerated projected gradients", FEW, |settings| {
        settings.method = SolverMethod::AcceleratedProjectedGradients
    }),
    vary("Jacobi", SWEEPS, |settings| settings.method = SolverMethod::Jacobi { damping: 0.3 }),
    vary("projected conjugate gradients", FEW, |settings| settings.method = SolverMethod::ProjectedConjugateGradients),
];

/// Stops at a residual, in units of g h, or after the sweeps of the settings.
fn down_to(tolerance: f64, settings: &SolverSettings) -> Stop {
    Stop::Residual { tolerance, max_sweeps: settings.stop.max_sweeps() }
}

/// Settings for long steps, so that packings are no denser than with short ones: overlaps recover over two steps instead of one, and
/// bounces last at least ten steps, because those of speeds below `5 g h` are suppressed. Both shake grains that come to rest.
fn calm_contacts(settings: &mut SolverSettings) {
    /// 5 g on Earth, m/s2.
    const SLOWEST_IMPACT_OVER_STEP: f64 = 50.0;
    settings.damping_steps = 2.0;
    let slowest = SLOWEST_IMPACT_OVER_STEP * settings.step;
    settings.restitution_threshold = Some(settings.restitution_threshold.map_or(slowest, |own| own.max(slowest)));
    settings.stop = down_to(0.1, settings);
}

/// Steps of Makadam, and the sweeps of each.
type Grid = &'static [(f64, &'static [u32])];

/// Values of the settings of a plan. Steps are over the scene's own step.
struct Extent {
    /// Steps of Makadam's grid.
    steps: &'static [f64],
    /// Sweeps of Makadam's grid.
    sweeps: &'static [u32],
    /// Steps at which the other axes are varied, in a full plan in addition to the scene's own settings.
    varied_steps: &'static [f64],
    /// Steps of the three grids that the reference rests on, from coarse to fine, each half the one before.
    refinement: [f64; 3],
    /// Their sweeps.
    most_sweeps: u32,
    /// Steps and sweeps of Makadam at other stiffnesses than the scene's.
    elsewhere: Grid,
    /// Steps and most sweeps of solves there that stop at the residual of [`FORGIVING`].
    elsewhere_forgiving: Grid,
    /// Time steps of explicit codes over the Rayleigh step at the scene's stiffness.
    rayleigh_fractions: &'static [f64],
    /// Time steps of explicit codes at other stiffnesses.
    rayleigh_fractions_elsewhere: &'static [f64],
}

const FULL: Extent = Extent {
    steps: &[4.0, 2.0, 1.0, 0.5, 0.25],
    sweeps: &[2, 3, 5, 10, 20, 40],
    varied_steps: &[4.0, 2.0, 1.0],
    refinement: [1.0, 0.5, 0.25],
    most_sweeps: 40,
    elsewhere: &[(4.0, &[10, 20]), (2.0, &[5, 10]), (1.0, &[5, 10, 20]), (0.5, &[5, 10, 20])],
    elsewhere_forgiving: &[(4.0, &[20, 40]), (2.0, &[10, 20]), (1.0, &[20])],
    rayleigh_fractions: &[0.8, 0.5, 0.3, 0.2, 0.1, 0.05, 0.01],
    rayleigh_fractions_elsewhere: &[0.8, 0.5, 0.3, 0.2, 0.05],
};

/// Few configurations, with those that the full extent has found to be worth their time. Other axes are varied at the
/// largest step, where a solve that is not good enough shows most, and at half of it, which 20,000 grains that fall deeper need.
const QUICK: Extent = Extent {
    steps: &[4.0, 2.0, 1.0],
    sweeps: &[3, 5, 10],
    varied_steps: &[4.0, 2.0],
    refinement: [2.0, 1.0, 0.5],
    most_sweeps: 20,
    elsewhere: &[(4.0, &[10, 20]), (2.0, &[5, 10, 20]), (1.0, &[10])],
    elsewhere_forgiving: &[(4.0, &[20, 40]), (2.0, &[10, 20])],
    // With tangential damping LIGGGHTS packs too densely from 40% on (`validation/docs/timing.md`).
    rayleigh_fractions: &[0.5, 0.3, 0.25, 0.2],
    rayleigh_fractions_elsewhere: &[0.5, 0.3, 0.2],
};

/// Variations of a quick plan and their iterations.
const QUICK_VARIATIONS: [(&str, &[u32]); 4] =
    [("single precision", &[10]), ("Anderson", &[5]), ("residual 0.1", &[10, 20]), ("residual 0.03", &[10, 20])];

/// The variation by the largest residual that packing fractions and angles forgive, as solves at the scene's stiffness show.
const FORGIVING: &str = "residual 0.1";

/// The variation for long steps: stiff grains pack with it as with short ones, soft ones too loosely.
const CALM: &str = "calm contacts, residual 0.1";

/// Steps over the scene's own, and most sweeps, at which it is tried at every stiffness.
const LONG_STEPS: Grid = &[(8.0, &[20]), (6.0, &[20]), (4.0, &[10, 20])];

/// Factors on every Young's modulus that the full extent covers: 5 MPa to 1 GPa where the scene's is 10 MPa.
pub const STIFFNESS_FACTORS: [f64; 4] = [0.5, 1.0, 10.0, 100.0];

/// Three grids of Makadam that differ by their step alone; the finest is the reference at its stiffness.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Places in [`Plan::configurations`], from the coarsest step to the finest.
    pub grids: [usize; 3],
}

/// Configurations of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Every configuration once.
    pub configurations: Vec<Configuration>,
    /// The references, one a stiffness.
    pub refinements: Vec<Refinement>,
}

impl Plan {
    /// The plan for a scene, with few configurations if `quick`: `codes` by name, `factors` on every Young's modulus. Makadam's references
    /// are a part of it whether or not Makadam is among the codes, and so is the scene's own stiffness.
    pub fn new(scene: &MeasuredScene, quick: bool, codes: &[&str], factors: &[f64]) -> Plan {
        let extent = if quick { &QUICK } else { &FULL };
        let mut plan = Plan { configurations: Vec::new(), refinements: Vec::new() };
        let mut factors: Vec<f64> = std::iter::once(1.0).chain(factors.iter().copied()).collect();
        factors.sort_by(f64::total_cmp);
        factors.dedup();
        // The scene's settings with a step over its own, and a number of sweeps.
        let at = |step: f64, sweeps: u32| {
            let stop = Stop::Sweeps { sweeps };
            SolverSettings { step: step * scene.solver.step, stop, ..scene.solver.clone() }
        };
        let all =
            |grid: Grid| grid.iter().flat_map(move |(step, sweeps)| sweeps.iter().map(move |&count| at(*step, count)));
        for stiffness_factor in factors {
            let is_own = stiffness_factor == 1.0;
            let makadam = |settings, variation| {
                let knobs = Knobs::Solver { settings, variation };
                Configuration { code: "Makadam".into(), stiffness_factor, knobs }
            };
            let grids = extent.refinement.map(|step| plan.add(makadam(at(step, extent.most_sweeps), None)));
            plan.refinements.push(Refinement { stiffness_factor, grids });
            let (mut plain, mut varied): (Vec<SolverSettings>, Vec<(&str, SolverSettings)>) = (Vec::new(), Vec::new());
            if is_own {
                let grid =
                    extent.steps.iter().flat_map(|&step| extent.sweeps.iter().map(move |&sweeps| (step, sweeps)));
                plain.push(scene.solver.clone());
                plain.extend(grid.map(|(step, sweeps)| at(step, sweeps)));
                for Variation { name, iterations, .. } in &VARIATIONS {
                    varied.extend((!quick).then(|| (*name, scene.solver.clone())));
                    let planned =
                        QUICK_VARIATIONS.iter().find(|(planned, _)| planned == name).map(|(_, counts)| *counts);
                    let counts = if quick { planned.unwrap_or_default() } else { iterations };
                    for &step in extent.varied_steps {
                        varied.extend(counts.iter().map(|&sweeps| (*name, at(step, sweeps))));
                    }
                }
            } else {
                plain.extend(all(extent.elsewhere));
                varied.extend(all(extent.elsewhere_forgiving).map(|settings| (FORGIVING, settings)));
            }
            varied.extend(all(LONG_STEPS).map(|settings| (CALM, settings)));
            if codes.contains(&"Makadam") {
                for settings in plain {
                    plan.add(makadam(settings, None));
                }
                for (name, settings) in varied {
                    let mut changed = settings.clone();
                    VARIATIONS.iter().filter(|one| one.name == name).for_each(|one| (one.change)(&mut changed));
                    // Settings may be so already, or the scene may refuse them.
                    if changed != settings && scene.accepts(&changed) {
                        plan.add(makadam(changed, Some(name.into())));
                    }
                }
            }
            let fractions = if is_own { extent.rayleigh_fractions } else { extent.rayleigh_fractions_elsewhere };
            for code in codes.iter().filter(|code| **code != "Makadam") {
                for &rayleigh_fraction in fractions {
                    let knobs = Knobs::Explicit { rayleigh_fraction };
                    plan.add(Configuration { code: (*code).into(), stiffness_factor, knobs });
                }
            }
        }
        plan
    }

    /// Adds a configuration unless it is there, and returns its index.
    fn add(&mut self, configuration: Configuration) -> usize {
        self.configurations.iter().position(|known| *known == configuration).unwrap_or_else(|| {
            self.configurations.push(configuration);
            self.configurations.len() - 1
        })
    }

    /// The reference at a stiffness.
    pub fn refinement(&self, stiffness_factor: f64) -> Option<&Refinement> {
        self.refinements.iter().find(|refinement| refinement.stiffness_factor == stiffness_factor)
    }

    /// True if a configuration is one of the three grids of a reference, which are never cut short.
    pub fn is_grid(&self, place: usize) -> bool {
        self.refinements.iter().any(|refinement| refinement.grids.contains(&place))
    }
}
