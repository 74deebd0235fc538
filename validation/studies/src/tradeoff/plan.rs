//! The plan: the settings of each code and their values.

use super::configuration::{Configuration, Knobs, VARIATIONS, Variation};
use makadam::scene::{SolverSettings, Stop};
use makadam_frames::plan::Scene;

/// Wall time at which a run of few configurations is cut short where no other is given, s.
pub const QUICK_TIME_LIMIT: f64 = 60.0;

/// Values of the settings of a plan. Steps are over the scene's own step.
struct Extent {
    /// Steps of Makadam's grid.
    steps: &'static [f64],
    /// Sweeps of Makadam's grid.
    sweeps: &'static [u32],
    /// True if the other axes are varied about the scene's own settings.
    about_own: bool,
    /// Steps at which they are varied too.
    varied_steps: &'static [f64],
    /// Steps of the three grids that the reference rests on, from coarse to fine, each half the one before.
    refinement: [f64; 3],
    /// Their sweeps.
    most_sweeps: u32,
    /// Steps and sweeps of Makadam at other stiffnesses than the scene's.
    elsewhere: &'static [(f64, u32)],
    /// Steps and most sweeps of solves there that stop at the residual of [`FORGIVING`].
    elsewhere_forgiving: &'static [(f64, u32)],
    /// Time steps of explicit codes over the Rayleigh step at the scene's stiffness.
    rayleigh_fractions: &'static [f64],
    /// Time steps of explicit codes at other stiffnesses.
    rayleigh_fractions_elsewhere: &'static [f64],
}

const FULL: Extent = Extent {
    steps: &[4.0, 2.0, 1.0, 0.5, 0.25],
    sweeps: &[2, 3, 5, 10, 20, 40],
    about_own: true,
    varied_steps: &[4.0, 2.0, 1.0],
    refinement: [1.0, 0.5, 0.25],
    most_sweeps: 40,
    elsewhere: &[
        (4.0, 10),
        (4.0, 20),
        (2.0, 5),
        (2.0, 10),
        (1.0, 5),
        (1.0, 10),
        (1.0, 20),
        (0.5, 5),
        (0.5, 10),
        (0.5, 20),
    ],
    elsewhere_forgiving: &[(4.0, 20), (4.0, 40), (2.0, 10), (2.0, 20), (1.0, 20)],
    rayleigh_fractions: &[0.8, 0.5, 0.3, 0.2, 0.1, 0.05, 0.01],
    rayleigh_fractions_elsewhere: &[0.8, 0.5, 0.3, 0.2, 0.05],
};

/// Few configurations, with those that the full extent has found to be worth their time. Other axes are varied at the
/// largest step, where a solve that is not good enough shows most, and at half of it, which 20,000 grains that fall deeper need.
const QUICK: Extent = Extent {
    steps: &[4.0, 2.0, 1.0],
    sweeps: &[3, 5, 10],
    about_own: false,
    varied_steps: &[4.0, 2.0],
    refinement: [2.0, 1.0, 0.5],
    most_sweeps: 20,
    elsewhere: &[(4.0, 10), (4.0, 20), (2.0, 5), (2.0, 10), (2.0, 20), (1.0, 10)],
    elsewhere_forgiving: &[(4.0, 20), (4.0, 40), (2.0, 10), (2.0, 20)],
    // With tangential damping LIGGGHTS packs too densely from 40% on (`validation/docs/timing.md`).
    rayleigh_fractions: &[0.5, 0.3, 0.25, 0.2],
    rayleigh_fractions_elsewhere: &[0.5, 0.3, 0.2],
};

/// Variations of a quick plan and their iterations.
const QUICK_VARIATIONS: [(&str, u32); 6] = [
    ("single precision", 10),
    ("Anderson", 5),
    ("residual 0.1", 10),
    ("residual 0.1", 20),
    ("residual 0.03", 10),
    ("residual 0.03", 20),
];

/// The variation by the largest residual that packing fractions and angles forgive, as solves at the scene's stiffness show.
const FORGIVING: &str = "residual 0.1";

/// The variation for long steps: stiff grains pack with it as with short ones, soft ones too loosely.
const CALM: &str = "calm contacts, residual 0.1";

/// Steps over the scene's own, and most sweeps, at which it is tried at every stiffness.
const LONG_STEPS: &[(f64, u32)] = &[(8.0, 20), (6.0, 20), (4.0, 10), (4.0, 20)];

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
    /// The plan for a scene, with few configurations if `quick`: `codes` by name, `factors` on every Young's modulus. Makadam's references are a part of it
    /// whether or not Makadam is among the codes, and so is the scene's own stiffness.
    pub fn new(scene: &Scene, quick: bool, codes: &[&str], factors: &[f64]) -> Plan {
        let extent = if quick { &QUICK } else { &FULL };
        let mut plan = Plan { configurations: Vec::new(), refinements: Vec::new() };
        let mut factors: Vec<f64> = std::iter::once(1.0).chain(factors.iter().copied()).collect();
        factors.sort_by(f64::total_cmp);
        factors.dedup();
        for factor in factors {
            let grid = |step: f64, sweeps: u32| makadam(factor, settings_of(scene, step, sweeps), None);
            let grids = extent.refinement.map(|step| plan.place(grid(step, extent.most_sweeps)));
            plan.refinements.push(Refinement { stiffness_factor: factor, grids });
            let own = factor == 1.0;
            if codes.contains(&"Makadam") {
                match own {
                    true => plan.own_stiffness(scene, quick, extent, grid),
                    false => plan.other_stiffness(scene, extent, factor, grid),
                }
                plan.vary_at(scene, factor, CALM, LONG_STEPS);
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

    fn own_stiffness(&mut self, scene: &Scene, quick: bool, extent: &Extent, grid: impl Fn(f64, u32) -> Configuration) {
        self.place(makadam(1.0, scene.solver.clone(), None));
        for &step in extent.steps {
            for &sweeps in extent.sweeps {
                self.place(grid(step, sweeps));
            }
        }
        for variation in &VARIATIONS {
            if extent.about_own {
                self.vary(scene, 1.0, variation, &scene.solver);
            }
            for &step in extent.varied_steps {
                let planned = |count: &&u32| !quick || QUICK_VARIATIONS.contains(&(variation.name, **count));
                for &sweeps in variation.iterations.iter().filter(planned) {
                    self.vary(scene, 1.0, variation, &settings_of(scene, step, sweeps));
                }
            }
        }
    }

    fn other_stiffness(
        &mut self,
        scene: &Scene,
        extent: &Extent,
        factor: f64,
        grid: impl Fn(f64, u32) -> Configuration,
    ) {
        for &(step, sweeps) in extent.elsewhere {
            self.place(grid(step, sweeps));
        }
        self.vary_at(scene, factor, FORGIVING, extent.elsewhere_forgiving);
    }

    /// Adds the variation of a name at steps and sweeps.
    fn vary_at(&mut self, scene: &Scene, factor: f64, name: &str, places: &[(f64, u32)]) {
        if let Some(variation) = Variation::named(name) {
            for &(step, sweeps) in places {
                self.vary(scene, factor, variation, &settings_of(scene, step, sweeps));
            }
        }
    }

    /// Adds a variation of settings, unless they are so already or the scene refuses it.
    fn vary(&mut self, scene: &Scene, factor: f64, variation: &Variation, settings: &SolverSettings) {
        if let Some(settings) = variation.apply(settings).filter(|settings| scene.accepts(settings)) {
            self.place(makadam(factor, settings, Some(variation.name.into())));
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

    /// True if a configuration is one of the three grids of a reference, which are never cut short.
    pub fn is_grid(&self, place: usize) -> bool {
        self.refinements.iter().any(|refinement| refinement.grids.contains(&place))
    }
}

/// The scene's settings with so many steps of its own in one, and so many sweeps.
fn settings_of(scene: &Scene, step: f64, sweeps: u32) -> SolverSettings {
    SolverSettings { step: step * scene.solver.step, stop: Stop::Sweeps { sweeps }, ..scene.solver.clone() }
}

fn makadam(stiffness_factor: f64, settings: SolverSettings, variation: Option<String>) -> Configuration {
    Configuration { code: "Makadam".into(), stiffness_factor, knobs: Knobs::Solver { settings, variation } }
}
