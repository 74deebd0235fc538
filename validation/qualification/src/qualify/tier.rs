//! Tiers: the extent of each, as one table.

use clap::ValueEnum;

/// Extent of a qualification. Each tier includes the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tier {
    /// Packing, drum, drum with caps and heap: 15 minutes on two cores.
    Quick,
    /// Every scene with recorded references of both reference codes, stress tests, published laws, effects, convergence: under 3 hours on two cores.
    Full,
    /// Full tier with at least 16 seeds of Makadam, effects of more scenes, accuracy of settings: a night.
    Release,
}

/// Scenes and studies of a qualification.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Name.
    pub name: &'static str,
    /// Scenes that are compared with recorded references of both reference codes, in the order of the report.
    pub scenes: &'static [&'static str],
    /// Minimum number of seeds of Makadam for each scene: its own runs are quick, and narrow the intervals.
    pub fewest_seeds: u64,
    /// Scenes on which the codes are timed one after the other, and on which the reference codes are run live. A live run is compared with recorded
    /// ones, so these scenes are recorded under today's contact law of the reference codes.
    pub timed: &'static [&'static str],
    /// Studies of the qualification.
    pub studies: &'static [Study],
}

/// A study and its extent.
#[derive(Clone, Copy, Debug)]
pub enum Study {
    /// Stress tests of `makadam stability` whose name or group contains one of these; all, if there is none.
    HardCases(&'static [&'static str]),
    /// Published laws of `makadam laws`, each with its number of seeds.
    Laws(&'static [(&'static str, u64)]),
    /// Scenes of `makadam effects --ablate`.
    Ablation(&'static [Ablated]),
    /// Scenes of `makadam lab convergence`.
    Convergence(&'static [&'static str]),
    /// Problems of `makadam lab problem check` inside the program.
    ContactProblems,
    /// Scenes whose own settings are compared with the converged reference of `makadam tradeoff`, each with its number of seeds.
    Tradeoff(&'static [(&'static str, u64)]),
}

/// Scene with each of its effects off or on.
#[derive(Clone, Copy, Debug)]
pub struct Ablated {
    /// Scene.
    pub scene: &'static str,
    /// Seeds of each variation.
    pub seeds: u64,
    /// Effects that the scene is known to need (`validation/docs/ablation.md`), separated by commas: a lost effect changes no value.
    pub needed: &'static str,
    /// Needed effects without which a run fails or an observable has no value: elsewhere a failed run proves no need.
    pub unmeasurable: &'static str,
}

const fn ablated(scene: &'static str, seeds: u64, needed: &'static str, unmeasurable: &'static str) -> Ablated {
    Ablated { scene, seeds, needed, unmeasurable }
}

/// Ablations of the release tier; the full tier has the first five.
const ABLATIONS: &[Ablated] = &[
    ablated("packing", 12, "Coulomb friction, rolling resistance, twisting resistance", ""),
    ablated("heap", 12, "Coulomb friction, twisting resistance, wall motion", "wall motion"),
    ablated(
        "oedometer",
        8,
        "Coulomb friction, restitution, elastic compliance, rolling resistance, twisting resistance, driven walls",
        "elastic compliance",
    ),
    ablated(
        "landslide",
        8,
        "Coulomb friction, kinetic friction, rolling resistance, twisting resistance, changing gravity",
        "",
    ),
    ablated(
        "cooling-gas",
        8,
        "Coulomb friction, falling restitution, rolling resistance, periodic axes",
        "periodic axes",
    ),
    ablated(
        "drum",
        4,
        "Coulomb friction, elastic compliance, rolling resistance, twisting resistance, wall motion",
        "wall motion",
    ),
    ablated("vibrated-bed", 4, "Coulomb friction, restitution, elastic compliance, wall motion", ""),
    ablated(
        "cohesive-heap",
        4,
        "Coulomb friction, elastic compliance, rolling resistance, twisting resistance, wall motion, cohesion",
        "Coulomb friction, wall motion, cohesion",
    ),
];

/// Seeds of the recorded rows of a law.
const LAWS: Study = Study::Laws(&[("janssen", 3), ("beverloo", 3), ("collapse", 1), ("chute", 1)]);

const FULL_STUDIES: &[Study] = &[
    Study::HardCases(&[]),
    LAWS,
    Study::Ablation(ABLATIONS.split_at(5).0),
    Study::ContactProblems,
    Study::Convergence(&["packing", "drum"]),
];

const RELEASE_STUDIES: &[Study] = &[
    Study::HardCases(&[]),
    LAWS,
    Study::Ablation(ABLATIONS),
    Study::ContactProblems,
    Study::Convergence(&["packing", "drum"]),
    Study::Tradeoff(&[("packing", 96), ("drum", 32), ("heap", 40)]),
];

/// Every scene with margins and recorded references of both reference codes.
const REFERENCE_SCENES: [&str; 16] = [
    "packing",
    "packing-low-friction",
    "packing-high-friction",
    "packing-stiff",
    "packing-low-friction-stiff",
    "packing-high-friction-stiff",
    "drum",
    "drum-caps",
    "heap",
    "drum-rolling",
    "heap-rolling",
    "packing-100",
    "drum-lifters",
    "blade-mixer",
    "belt-heap",
    "screw",
];

impl Tier {
    /// Returns the extent of the tier.
    pub fn extent(self) -> Extent {
        match self {
            Tier::Quick => Extent {
                name: "quick",
                scenes: &["packing", "drum", "drum-caps", "heap"],
                fewest_seeds: 8,
                timed: &["packing", "drum"],
                studies: &[],
            },
            Tier::Full => Extent {
                name: "full",
                scenes: &REFERENCE_SCENES,
                fewest_seeds: 8,
                timed: &["packing", "drum", "heap"],
                studies: FULL_STUDIES,
            },
            Tier::Release => {
                Extent { name: "release", fewest_seeds: 16, studies: RELEASE_STUDIES, ..Tier::Full.extent() }
            }
        }
    }
}
