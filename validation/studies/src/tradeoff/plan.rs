//! Configurations of each code, with the variations of Makadam's solver: method, precision, warm start, sweeps; and the plan: the
//! configurations of a scene.

use makadam::scene::{Precision, SolverMethod, SolverSettings, Stop};
use makadam_frames::plan::MeasuredScene;
use makadam_view::draw::numbers::compact;
use serde::{Deserialize, Serialize};

/// Code with its settings: a point of the trade-off after its run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
    /// Name of the code.
    pub code: String,
    /// Factor on every Young's modulus of the scene.
    pub stiffness_factor: f64,
    /// Settings.
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
        /// Varied axis in addition to step and sweeps, and its value, such as "warm start 0".
        variation: Option<String>,
    },
    /// Time step of an explicit code.
    Explicit {
        /// Time step over the Rayleigh step.
        rayleigh_fraction: f64,
    },
}

impl Configuration {
    /// Returns the scene with the settings of this configuration, its stiffness not scaled.
    pub fn scene(&self, scene: &MeasuredScene) -> MeasuredScene {
        let mut scene = scene.clone();
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

    /// Varied axis in addition to step and sweeps, and its value, for Makadam.
    pub fn variation(&self) -> Option<&str> {
        self.solver().and_then(|(_, variation)| variation)
    }

    /// Returns the settings in a few words: "0.5 ms × 10 sweeps, single precision", or "20% of the Rayleigh step".
    pub fn setting(&self) -> String {
        let (settings, variation) = match &self.knobs {
            Knobs::Explicit { rayleigh_fraction } => {
                return format!("{}% of the Rayleigh step", compact(100.0 * rayleigh_fraction));
            }
            Knobs::Solver { settings, variation } => (settings, variation),
        };
        let varied = variation.as_ref().map_or(String::new(), |variation| format!(", {variation}"));
        let bound = if matches!(settings.stop, Stop::Sweeps { .. }) { "" } else { "at most " };
        // An iteration of the other methods is not a sweep, and inner sweeps make it several.
        let is_plain = settings.method == SolverMethod::GaussSeidel && settings.inner_sweeps <= 1;
        let unit = if is_plain { "sweeps" } else { "iterations" };
        format!("{} ms × {bound}{} {unit}{varied}", compact(1e3 * settings.step), settings.stop.max_sweeps())
    }
}

/// Change of one setting of the solver, in addition to step and sweeps.
struct Variation {
    /// Axis and value, as named in tables.
    name: &'static str,
    change: fn(&mut SolverSettings),
    /// Steps over the scene's own, and iterations of a solve there, at the scene's stiffness.
    own: Grid,
    /// Steps and iterations at other stiffnesses.
    elsewhere: Grid,
}

/// Variations at the largest step, which reveals an inaccurate solve most, and at half of it, which 20,000 grains with a longer fall
/// need. An iteration of Anderson's method costs several sweeps.
const VARIATIONS: [Variation; 5] = [
    Variation {
        name: "residual 0.1",
        change: |settings| settings.stop = down_to(0.1, settings),
        own: &[(4.0, &[10, 20]), (2.0, &[10, 20])],
        elsewhere: &[(4.0, &[20, 40]), (2.0, &[10, 20])],
    },
    Variation {
        name: "residual 0.03",
        change: |settings| settings.stop = down_to(0.03, settings),
        own: &[(4.0, &[10, 20]), (2.0, &[10, 20])],
        elsewhere: &[],
    },
    Variation {
        name: "single precision",
        change: |settings| settings.precision = Precision::Single,
        own: &[(4.0, &[10]), (2.0, &[10])],
        elsewhere: &[],
    },
    Variation {
        name: "Anderson",
        change: |settings| settings.method = SolverMethod::Anderson { memory: 3 },
        own: &[(4.0, &[5]), (2.0, &[5])],
        elsewhere: &[],
    },
    // Stiff grains then pack as with short steps, soft ones too loosely.
    Variation {
        name: "calm contacts, residual 0.1",
        change: calm_contacts,
        own: &[(8.0, &[20]), (6.0, &[20]), (4.0, &[10, 20])],
        elsewhere: &[(8.0, &[20]), (6.0, &[20]), (4.0, &[10, 20])],
    },
];

/// Stop at a residual, in units of g h, or after the sweeps of the settings.
fn down_to(tolerance: f64, settings: &SolverSettings) -> Stop {
    Stop::Residual { tolerance, max_sweeps: settings.stop.max_sweeps() }
}

/// Settings for long steps, so that packings are no denser than with short ones. Overlaps recover over two steps instead of one, and
/// bounces last at least ten steps, because those of speeds below `5 g h` are suppressed. Both effects disturb grains that come to rest.
fn calm_contacts(settings: &mut SolverSettings) {
    /// 5 g on Earth, m/s2.
    const SLOWEST_IMPACT_OVER_STEP: f64 = 50.0;
    settings.damping_steps = 2.0;
    let slowest = SLOWEST_IMPACT_OVER_STEP * settings.step;
    settings.restitution_threshold = Some(settings.restitution_threshold.map_or(slowest, |own| own.max(slowest)));
    settings.stop = down_to(0.1, settings);
}

/// Steps of Makadam over the scene's own, and the sweeps of each.
type Grid = &'static [(f64, &'static [u32])];

/// Makadam at the scene's stiffness.
const OWN: Grid = &[(4.0, &[3, 5, 10]), (2.0, &[3, 5, 10]), (1.0, &[3, 5, 10])];

/// Makadam at other stiffnesses.
const ELSEWHERE: Grid = &[(4.0, &[10, 20]), (2.0, &[5, 10, 20]), (1.0, &[10])];

/// Steps of the three grids of the reference, over the scene's own, from coarse to fine, each half the one before.
const REFINEMENT: [f64; 3] = [2.0, 1.0, 0.5];

/// Sweeps of these grids.
const MOST_SWEEPS: u32 = 20;

/// Time steps of explicit codes over the Rayleigh step: with tangential damping LIGGGHTS packs too densely from 40% on
/// (`validation/docs/timing.md`).
const RAYLEIGH_FRACTIONS: [f64; 4] = [0.5, 0.3, 0.25, 0.2];

/// Three grids of Makadam that differ by their step alone; the finest is the reference at its stiffness.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Indices in [`Plan::configurations`], from the coarsest step to the finest.
    pub grids: [usize; 3],
}

/// Configurations of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Every configuration once.
    pub configurations: Vec<Configuration>,
    /// References, one per stiffness.
    pub refinements: Vec<Refinement>,
}

impl Plan {
    /// Returns the plan for a scene: `codes` by name, `factors` on every Young's modulus. The plan includes Makadam's references even if
    /// Makadam is not among the codes, and always the scene's own stiffness.
    pub fn new(scene: &MeasuredScene, codes: &[&str], factors: &[f64]) -> Plan {
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
            let grids = REFINEMENT.map(|step| plan.add(makadam(at(step, MOST_SWEEPS), None)));
            plan.refinements.push(Refinement { stiffness_factor, grids });
            if codes.contains(&"Makadam") {
                let own = is_own.then(|| scene.solver.clone());
                for settings in own.into_iter().chain(all(if is_own { OWN } else { ELSEWHERE })) {
                    plan.add(makadam(settings, None));
                }
                for Variation { name, change, own, elsewhere } in &VARIATIONS {
                    for settings in all(if is_own { own } else { elsewhere }) {
                        let mut changed = settings.clone();
                        change(&mut changed);
                        // The settings may already be equal, or the scene may refuse them.
                        if changed != settings && scene.accepts(&changed) {
                            plan.add(makadam(changed, Some((*name).into())));
                        }
                    }
                }
            }
            for code in codes.iter().filter(|code| **code != "Makadam") {
                for rayleigh_fraction in RAYLEIGH_FRACTIONS {
                    let knobs = Knobs::Explicit { rayleigh_fraction };
                    plan.add(Configuration { code: (*code).into(), stiffness_factor, knobs });
                }
            }
        }
        plan
    }

    /// Adds a configuration if it is missing, and returns its index.
    fn add(&mut self, configuration: Configuration) -> usize {
        self.configurations.iter().position(|known| *known == configuration).unwrap_or_else(|| {
            self.configurations.push(configuration);
            self.configurations.len() - 1
        })
    }

    /// Reference at a stiffness.
    pub fn refinement(&self, stiffness_factor: f64) -> Option<&Refinement> {
        self.refinements.iter().find(|refinement| refinement.stiffness_factor == stiffness_factor)
    }

    /// Returns true if a configuration is one of the three grids of a reference, in which every seed counts.
    pub fn is_grid(&self, place: usize) -> bool {
        self.refinements.iter().any(|refinement| refinement.grids.contains(&place))
    }
}
