//! What is varied beside step and sweeps: the method, the precision, the warm start and the settings of the sweeps.

use crate::draw::names::{CodeStyle, Marker};
use makadam::scene::{Precision, SolverMethod, SolverSettings, Stop};

/// A change of one setting of the solver, beside step and sweeps.
pub(super) struct Variation {
    /// The axis and its value, as tables name it.
    pub(super) name: &'static str,
    /// What it is drawn with.
    pub(super) family: Family,
    /// The change.
    pub(super) change: fn(&mut SolverSettings),
    /// Iterations of a solve at which it is run beside the scene's own settings. Those of methods whose iteration costs
    /// several sweeps are fewer, so that wall times overlap with those of sweeps.
    pub(super) iterations: &'static [u32],
}

/// Variations that share a mark and a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    WarmStart,
    SinglePrecision,
    OverRelaxation,
    InnerSweeps,
    Residual,
    Anderson,
    NonlinearConjugateGradients,
    AcceleratedProjectedGradients,
    Jacobi,
    ProjectedConjugateGradients,
}

/// All of them.
const VARIATIONS: [Variation; 15] = [
    Variation {
        name: "warm start 0",
        family: Family::WarmStart,
        change: |settings| settings.warm_start = 0.0,
        iterations: SWEEPS,
    },
    Variation {
        name: "over-relaxation 1",
        family: Family::OverRelaxation,
        change: |settings| settings.over_relaxation = 1.0,
        iterations: SWEEPS,
    },
    Variation {
        name: "2 inner sweeps",
        family: Family::InnerSweeps,
        change: |settings| settings.inner_sweeps = 2,
        iterations: FEW,
    },
    Variation {
        name: "4 inner sweeps",
        family: Family::InnerSweeps,
        change: |settings| settings.inner_sweeps = 4,
        iterations: &[2, 3, 5],
    },
    residual("residual 0.1", |settings| settings.stop = down_to(0.1, settings)),
    residual("residual 0.03", |settings| settings.stop = down_to(0.03, settings)),
    residual("residual 0.01", |settings| settings.stop = down_to(0.01, settings)),
    residual("residual 0.003", |settings| settings.stop = down_to(0.003, settings)),
    residual("calm contacts, residual 0.1", calm_contacts),
    Variation {
        name: "single precision",
        family: Family::SinglePrecision,
        change: |settings| settings.precision = Precision::Single,
        iterations: SWEEPS,
    },
    Variation {
        name: "Anderson",
        family: Family::Anderson,
        change: |settings| settings.method = SolverMethod::Anderson { memory: 3 },
        iterations: FEW,
    },
    Variation {
        name: "nonlinear conjugate gradients",
        family: Family::NonlinearConjugateGradients,
        change: |settings| settings.method = SolverMethod::NonlinearConjugateGradients,
        iterations: FEW,
    },
    Variation {
        name: "accelerated projected gradients",
        family: Family::AcceleratedProjectedGradients,
        change: |settings| settings.method = SolverMethod::AcceleratedProjectedGradients,
        iterations: FEW,
    },
    Variation {
        name: "Jacobi",
        family: Family::Jacobi,
        change: |settings| settings.method = SolverMethod::Jacobi { damping: 0.3 },
        iterations: SWEEPS,
    },
    Variation {
        name: "projected conjugate gradients",
        family: Family::ProjectedConjugateGradients,
        change: |settings| settings.method = SolverMethod::ProjectedConjugateGradients,
        iterations: FEW,
    },
];

/// Iterations of what costs about a sweep, or needs many.
const SWEEPS: &[u32] = &[5, 10, 20];
/// Iterations of what costs several sweeps.
const FEW: &[u32] = &[3, 5, 10];

/// A variation of when a solve stops.
const fn residual(name: &'static str, change: fn(&mut SolverSettings)) -> Variation {
    Variation { name, family: Family::Residual, change, iterations: MOST }
}

/// Most sweeps of a solve that stops at a residual: what a solve that does not takes, and what the reference takes.
const MOST: &[u32] = &[10, 20, 40];

/// Sweeps until the residual is so small, in units of g h, but no more than without that.
fn down_to(tolerance: f64, settings: &SolverSettings) -> Stop {
    Stop::Residual { tolerance, max_sweeps: settings.stop.max_sweeps() }
}

/// What long steps need for a packing that is no denser than that of short ones: overlaps that recover over two steps in place of
/// one, and no bounces that last fewer than ten steps, those of speeds below `5 g h`. Both shake grains that come to rest.
fn calm_contacts(settings: &mut SolverSettings) {
    /// 5 g on Earth, m/s2.
    const SLOWEST_IMPACT_OVER_STEP: f64 = 50.0;
    settings.damping_steps = 2.0;
    let slowest = SLOWEST_IMPACT_OVER_STEP * settings.step;
    settings.restitution_threshold = Some(settings.restitution_threshold.map_or(slowest, |own| own.max(slowest)));
    settings.stop = down_to(0.1, settings);
}

impl Variation {
    /// All of them.
    pub(super) fn all() -> &'static [Variation] {
        &VARIATIONS
    }

    /// The one with a name.
    pub(super) fn named(name: &str) -> Option<&'static Variation> {
        VARIATIONS.iter().find(|variation| variation.name == name)
    }

    /// Settings with its change; absent where they are so already.
    pub(super) fn apply(&self, settings: &SolverSettings) -> Option<SolverSettings> {
        let mut changed = settings.clone();
        (self.change)(&mut changed);
        (changed != *settings).then_some(changed)
    }
}

impl Family {
    /// Those of the sweeps, then the other methods, each in the order of legends.
    pub(super) const PANELS: [(&str, &[Family]); 2] = [
        (
            "precision, warm start and sweeps",
            &[
                Family::SinglePrecision,
                Family::WarmStart,
                Family::OverRelaxation,
                Family::InnerSweeps,
                Family::Residual,
            ],
        ),
        (
            "methods",
            &[
                Family::Anderson,
                Family::NonlinearConjugateGradients,
                Family::AcceleratedProjectedGradients,
                Family::Jacobi,
                Family::ProjectedConjugateGradients,
            ],
        ),
    ];

    /// What legends call it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Family::WarmStart => "no warm start",
            Family::SinglePrecision => "single precision",
            Family::OverRelaxation => "no over-relaxation",
            Family::InnerSweeps => "inner sweeps",
            Family::Residual => "down to a residual",
            Family::Anderson => "Anderson",
            Family::NonlinearConjugateGradients => "nonlinear conjugate gradients",
            Family::AcceleratedProjectedGradients => "accelerated projected gradients",
            Family::Jacobi => "Jacobi",
            Family::ProjectedConjugateGradients => "projected conjugate gradients",
        }
    }

    /// Its colour, line and mark.
    pub(super) fn style(self) -> CodeStyle {
        let (class, marker) = match self {
            Family::WarmStart => ("variation-warm-start", Marker::Triangle),
            Family::SinglePrecision => ("variation-single-precision", Marker::Square),
            Family::OverRelaxation => ("variation-over-relaxation", Marker::Diamond),
            Family::InnerSweeps => ("variation-inner-sweeps", Marker::Wedge),
            Family::Residual => ("variation-residual", Marker::Cross),
            Family::Anderson => ("method-anderson", Marker::Square),
            Family::NonlinearConjugateGradients => ("method-nonlinear-conjugate-gradients", Marker::Triangle),
            Family::AcceleratedProjectedGradients => ("method-accelerated-projected-gradients", Marker::Diamond),
            Family::Jacobi => ("method-jacobi", Marker::Cross),
            Family::ProjectedConjugateGradients => ("method-projected-conjugate-gradients", Marker::Wedge),
        };
        CodeStyle { class, marker }
    }
}
