//! The tiers: what each consists of, as one table.

use serde::{Deserialize, Serialize};

/// How much is judged. Each tier has all that the one before it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tier {
    /// Minutes.
    Quick,
    /// Hours.
    Full,
    /// A night.
    Release,
}

/// What a qualification consists of.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Its name.
    pub name: &'static str,
    /// The tier whose tests on record have to be made; none in a qualification of one's own.
    pub on_record: Option<Tier>,
    /// Scenes that are judged against recorded references of both peers, in the order of the report.
    pub scenes: &'static [&'static str],
    /// Makadam runs no fewer seeds of a scene than this, however few are recorded: its own are quick, and narrow the intervals.
    pub fewest_seeds: u64,
    /// Scenes on which the codes are timed one after the other, and on which the peers are run where they are run live. A live run is
    /// held against recorded ones, so these are scenes that are recorded under the law of contacts that the peers have now.
    pub timed: &'static [&'static str],
    /// Studies that are a part.
    pub studies: &'static [Study],
}

/// A study and how much of it is a part.
#[derive(Clone, Copy, Debug)]
pub enum Study {
    /// The hard cases of `makadam stability` whose name or group contains one of these; all, if there is none.
    HardCases(&'static [&'static str]),
    /// Published laws of `makadam laws`, each with its number of seeds.
    Laws(&'static [(&'static str, u64)]),
    /// Scenes of `makadam effects --ablate`.
    Ablation(&'static [Ablated]),
    /// Scenes of `makadam convergence`.
    Convergence(&'static [&'static str]),
    /// Problems of `makadam problem check` that the program holds.
    ContactProblems,
    /// Scenes of `makadam tradeoff --quick --codes makadam`, each with the seeds by which its own setting is judged.
    Tradeoff(&'static [(&'static str, u64)]),
}

/// A scene with each of its effects off, or on.
#[derive(Clone, Copy, Debug)]
pub struct Ablated {
    /// The scene.
    pub scene: &'static str,
    /// Seeds of each variation.
    pub seeds: u64,
    /// Effects that it is known to need (`validation/docs/ablation.md`): an effect that has been lost moves nothing.
    pub needed: &'static [&'static str],
    /// Of these, those without which a run fails or an observable has no value: elsewhere a run that fails proves no need.
    pub unmeasurable: &'static [&'static str],
}

/// Seeds that the recorded rows of a law have.
const LAWS: Study = Study::Laws(&[("janssen", 3), ("beverloo", 3), ("collapse", 1), ("chute", 1)]);

const SMALL_ABLATIONS: [Ablated; 5] = [
    Ablated {
        scene: "packing",
        seeds: 12,
        needed: &["Coulomb friction", "rolling resistance", "twisting resistance"],
        unmeasurable: &[],
    },
    Ablated {
        scene: "heap",
        seeds: 12,
        needed: &["Coulomb friction", "twisting resistance", "wall motion"],
        unmeasurable: &["wall motion"],
    },
    Ablated {
        scene: "oedometer",
        seeds: 8,
        needed: &[
            "Coulomb friction",
            "restitution",
            "elastic compliance",
            "rolling resistance",
            "twisting resistance",
            "driven walls",
        ],
        unmeasurable: &["elastic compliance"],
    },
    Ablated {
        scene: "landslide",
        seeds: 8,
        needed: &[
            "Coulomb friction",
            "kinetic friction",
            "rolling resistance",
            "twisting resistance",
            "changing gravity",
        ],
        unmeasurable: &[],
    },
    Ablated {
        scene: "cooling-gas",
        seeds: 8,
        needed: &["Coulomb friction", "falling restitution", "rolling resistance", "periodic axes"],
        unmeasurable: &["periodic axes"],
    },
];

const ALL_ABLATIONS: [Ablated; 8] = [
    SMALL_ABLATIONS[0],
    SMALL_ABLATIONS[1],
    SMALL_ABLATIONS[2],
    SMALL_ABLATIONS[3],
    SMALL_ABLATIONS[4],
    Ablated {
        scene: "drum",
        seeds: 4,
        needed: &["Coulomb friction", "elastic compliance", "rolling resistance", "twisting resistance", "wall motion"],
        unmeasurable: &["wall motion"],
    },
    Ablated {
        scene: "vibrated-bed",
        seeds: 4,
        needed: &["Coulomb friction", "restitution", "elastic compliance", "wall motion"],
        unmeasurable: &[],
    },
    Ablated {
        scene: "cohesive-heap",
        seeds: 4,
        needed: &[
            "Coulomb friction",
            "elastic compliance",
            "rolling resistance",
            "twisting resistance",
            "wall motion",
            "cohesion",
        ],
        unmeasurable: &["Coulomb friction", "wall motion", "cohesion"],
    },
];

/// Every scene with margins and recorded references of both peers.
const REFERENCE_SCENES: [&str; 12] = [
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
];

/// What each tier consists of.
pub const TIERS: [Extent; 3] = [
    Extent {
        name: "quick",
        on_record: Some(Tier::Quick),
        scenes: &["packing", "drum", "drum-caps", "heap"],
        fewest_seeds: 8,
        timed: &["packing", "drum"],
        studies: &[],
    },
    Extent {
        name: "full",
        on_record: Some(Tier::Full),
        scenes: &REFERENCE_SCENES,
        fewest_seeds: 8,
        timed: &["packing", "drum", "heap"],
        studies: &[
            Study::HardCases(&[]),
            LAWS,
            Study::Ablation(&SMALL_ABLATIONS),
            Study::ContactProblems,
            Study::Convergence(&["packing", "drum"]),
        ],
    },
    Extent {
        name: "release",
        on_record: Some(Tier::Release),
        scenes: &REFERENCE_SCENES,
        fewest_seeds: 16,
        timed: &["packing", "drum", "heap"],
        studies: &[
            Study::HardCases(&[]),
            LAWS,
            Study::Ablation(&ALL_ABLATIONS),
            Study::ContactProblems,
            Study::Convergence(&["packing", "drum"]),
            Study::Tradeoff(&[("packing", 96), ("drum", 32), ("heap", 40)]),
        ],
    },
];

impl Tier {
    /// What it consists of.
    pub fn extent(self) -> &'static Extent {
        &TIERS[self as usize]
    }
}

impl Study {
    /// The command that makes such a study alone.
    pub fn name(&self) -> &'static str {
        match self {
            Study::HardCases(_) => "stability",
            Study::Laws(_) => "laws",
            Study::Ablation(_) => "effects",
            Study::ContactProblems => "contact-problems",
            Study::Convergence(_) => "convergence",
            Study::Tradeoff(_) => "tradeoff",
        }
    }
}
