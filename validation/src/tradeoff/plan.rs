//! What is run: the knobs of each code and the values that they take.

use super::configuration::{Configuration, Knobs};
use makadam::scene::{Precision, Scene, SolverMethod, SolverSettings, Stop};

/// A change of one setting of the solver, beside step and sweeps.
struct Variation {
    /// The axis and its value, as tables name it.
    name: &'static str,
    /// The change.
    change: fn(&mut SolverSettings),
}

/// The axes that are varied one at a time about the scene's own settings.
const VARIATIONS: [Variation; 13] = [
    Variation { name: "warm start 0", change: |settings| settings.warm_start = 0.0 },
    Variation { name: "over-relaxation 1", change: |settings| settings.over_relaxation = 1.0 },
    Variation { name: "2 inner sweeps", change: |settings| settings.inner_sweeps = 2 },
    Variation { name: "4 inner sweeps", change: |settings| settings.inner_sweeps = 4 },
    Variation { name: "residual 0.1", change: |settings| settings.stop = down_to(0.1) },
    Variation { name: "residual 0.03", change: |settings| settings.stop = down_to(0.03) },
    Variation { name: "residual 0.01", change: |settings| settings.stop = down_to(0.01) },
    Variation { name: "residual 0.003", change: |settings| settings.stop = down_to(0.003) },
    Variation { name: "single precision", change: |settings| settings.precision = Precision::Single },
    Variation { name: "Anderson", change: |settings| settings.method = SolverMethod::Anderson { memory: 3 } },
    Variation {
        name: "nonlinear conjugate gradients",
        change: |settings| settings.method = SolverMethod::NonlinearConjugateGradients,
    },
    Variation {
        name: "accelerated projected gradients",
        change: |settings| settings.method = SolverMethod::AcceleratedProjectedGradients,
    },
    Variation { name: "Jacobi", change: |settings| settings.method = SolverMethod::Jacobi { damping: 0.3 } },
];

/// Sweeps until the residual is so small, in units of g h, but no more than the reference takes.
fn down_to(tolerance: f64) -> Stop {
    Stop::Residual { tolerance, max_sweeps: FULL.most_sweeps }
}

/// How much is run. Steps are over the scene's own step.
struct Extent {
    /// Steps of Makadam's grid.
    steps: &'static [f64],
    /// Sweeps of Makadam's grid.
    sweeps: &'static [u32],
    /// Whether the other axes are varied.
    variations: bool,
    /// Steps of the three grids that the reference rests on, from coarse to fine, each half the one before.
    refinement: [f64; 3],
    /// Their sweeps.
    most_sweeps: u32,
    /// Steps and sweeps of Makadam at other stiffnesses than the scene's.
    elsewhere: &'static [(f64, u32)],
    /// Time steps of explicit codes over the Rayleigh step at the scene's stiffness.
    rayleigh_fractions: &'static [f64],
    /// The same at other stiffnesses.
    rayleigh_fractions_elsewhere: &'static [f64],
}

const FULL: Extent = Extent {
    steps: &[4.0, 2.0, 1.0, 0.5, 0.25],
    sweeps: &[2, 3, 5, 10, 20, 40],
    variations: true,
    refinement: [1.0, 0.5, 0.25],
    most_sweeps: 40,
    elsewhere: &[(2.0, 5), (2.0, 10), (1.0, 5), (1.0, 10), (1.0, 20), (0.5, 5), (0.5, 10), (0.5, 20)],
    rayleigh_fractions: &[0.8, 0.5, 0.2, 0.1, 0.05, 0.01],
    rayleigh_fractions_elsewhere: &[0.8, 0.5, 0.2, 0.05],
};

/// Few configurations, with those that the full extent has found to be worth their time.
const QUICK: Extent = Extent {
    steps: &[4.0, 2.0, 1.0],
    sweeps: &[3, 5, 10],
    variations: false,
    refinement: [2.0, 1.0, 0.5],
    most_sweeps: 20,
    elsewhere: &[(4.0, 20), (2.0, 5), (2.0, 10), (2.0, 20), (1.0, 10)],
    rayleigh_fractions: &[0.5, 0.2],
    rayleigh_fractions_elsewhere: &[0.5, 0.2],
};

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

/// What is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Every configuration once.
    pub configurations: Vec<Configuration>,
    /// The references, one a stiffness.
    pub refinements: Vec<Refinement>,
}

impl Plan {
    /// The plan for a scene: `codes` by name, `factors` on every Young's modulus. Makadam's references are a part of it
    /// whether or not Makadam is among the codes, and so is the scene's own stiffness.
    pub fn new(scene: &Scene, quick: bool, codes: &[&str], factors: &[f64]) -> Plan {
        let extent = if quick { &QUICK } else { &FULL };
        let mut plan = Plan { configurations: Vec::new(), refinements: Vec::new() };
        let mut factors: Vec<f64> = std::iter::once(1.0).chain(factors.iter().copied()).collect();
        factors.sort_by(f64::total_cmp);
        factors.dedup();
        for factor in factors {
            let grid = |step: f64, sweeps: u32| {
                let settings = SolverSettings {
                    step: step * scene.solver.step,
                    stop: Stop::Sweeps { sweeps },
                    ..scene.solver.clone()
                };
                makadam(factor, settings, None)
            };
            let grids = extent.refinement.map(|step| plan.place(grid(step, extent.most_sweeps)));
            plan.refinements.push(Refinement { stiffness_factor: factor, grids });
            let own = factor == 1.0;
            if codes.contains(&"Makadam") {
                match own {
                    true => plan.grid(scene, extent, grid),
                    false => extent.elsewhere.iter().for_each(|&(step, sweeps)| {
                        plan.place(grid(step, sweeps));
                    }),
                }
            }
            let fractions = if own { extent.rayleigh_fractions } else { extent.rayleigh_fractions_elsewhere };
            for code in codes.iter().filter(|code| **code != "Makadam") {
                for &rayleigh_fraction in fractions {
                    let knobs = Knobs::Explicit { rayleigh_fraction };
                    plan.place(Configuration { code: (*code).into(), stiffness_factor: factor, knobs });
                }
            }
        }
        plan
    }

    /// Makadam at the scene's stiffness.
    fn grid(&mut self, scene: &Scene, extent: &Extent, grid: impl Fn(f64, u32) -> Configuration) {
        self.place(makadam(1.0, scene.solver.clone(), None));
        for &step in extent.steps {
            for &sweeps in extent.sweeps {
                self.place(grid(step, sweeps));
            }
        }
        for variation in VARIATIONS.iter().filter(|_| extent.variations) {
            let mut settings = scene.solver.clone();
            (variation.change)(&mut settings);
            // The scene may have chosen so itself.
            if settings != scene.solver {
                self.place(makadam(1.0, settings, Some(variation.name.into())));
            }
        }
    }

    /// Adds a configuration unless it is there, and tells its place.
    fn place(&mut self, configuration: Configuration) -> usize {
        self.configurations.iter().position(|known| *known == configuration).unwrap_or_else(|| {
            self.configurations.push(configuration);
            self.configurations.len() - 1
        })
    }

    /// The reference at a stiffness.
    pub fn refinement(&self, stiffness_factor: f64) -> Option<&Refinement> {
        self.refinements.iter().find(|refinement| refinement.stiffness_factor == stiffness_factor)
    }

    /// Whether a configuration is one of the three grids of a reference, which are never cut short.
    pub fn is_grid(&self, place: usize) -> bool {
        self.refinements.iter().any(|refinement| refinement.grids.contains(&place))
    }
}

fn makadam(stiffness_factor: f64, settings: SolverSettings, variation: Option<String>) -> Configuration {
    Configuration { code: "Makadam".into(), stiffness_factor, knobs: Knobs::Solver { settings, variation } }
}
