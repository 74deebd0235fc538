//! What each measured number is: its symbol, its unit, how it is computed, and where the definition comes from.

use crate::plan::Observable;
use crate::recording::Content;
use serde::Serialize;

/// A number that can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Definition {
    /// Its name, as `[[compare]]`, tables and documents spell it.
    pub name: &'static str,
    /// Its symbol in formulas.
    pub symbol: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// How it is computed.
    pub formula: &'static str,
    /// Where the definition comes from; empty where it is this program's own or follows from its words.
    pub source: &'static str,
    /// What frames must hold beside the places and sizes of their grains.
    pub needs: &'static [Content],
    /// True if all measured frames give it together. The value of any other number is the mean over the measured frames of what each gives
    /// by itself, or the maximum.
    #[serde(skip)]
    pub span: bool,
}

impl Definition {
    /// The same, where frames must hold more than places and sizes of grains.
    const fn needs(self, needs: &'static [Content]) -> Definition {
        Definition { needs, ..self }
    }

    /// A number that all measured frames give together.
    const fn of_span(self) -> Definition {
        Definition { span: true, ..self }
    }
}

const fn define(
    name: &'static str,
    symbol: &'static str,
    unit: &'static str,
    formula: &'static str,
    source: &'static str,
) -> Definition {
    Definition { name, symbol, unit, formula, source, needs: &[], span: false }
}

const CONTACTS: &[Content] = &[Content::Contacts];
const WALL_CONTACTS: &[Content] = &[Content::WallContacts];
const ALL_CONTACTS: &[Content] = &[Content::Contacts, Content::WallContacts];
const VELOCITIES: &[Content] = &[Content::Velocities];
const MOTION: &[Content] = &[Content::Velocities, Content::Spins];

/// A group of numbers: what measures them, its name in `measure.observables`, and the numbers.
pub(super) type Group = (Observable, &'static str, &'static [Definition]);

/// All groups.
pub(super) const GROUPS: [Group; 11] = [
    (Observable::DynamicAngleOfRepose, "dynamic-angle-of-repose", &DYNAMIC_ANGLE),
    (Observable::StaticAngleOfRepose, "static-angle-of-repose", &STATIC_ANGLE),
    (Observable::PackingFraction, "packing-fraction", &PACKING_FRACTION),
    (Observable::CoordinationNumber, "coordination-number", &COORDINATION),
    (Observable::ContactForces, "contact-forces", &CONTACT_FORCES),
    (Observable::Balances, "balances", &BALANCES),
    (Observable::DrumFlow, "drum-flow", &DRUM_FLOW),
    (Observable::SizeMixing, "size-mixing", &SIZE_MIXING),
    (Observable::DrivenWall, "driven-wall", &DRIVEN_WALL),
    (Observable::Discharge, "discharge", &DISCHARGE),
    (Observable::Intruder, "intruder", &INTRUDER),
];

const DYNAMIC_ANGLE: [Definition; 2] = [
    define(
        "dynamic_angle_of_repose",
        "θ",
        "degree",
        "inclination of the line through the two points at which the outline of the bed (half of the largest time-averaged solid \
         fraction) crosses a circle of a fifth of the drum's diameter about the middle of the surface; positive in the sense of rotation",
        "",
    ).of_span(),
    define(
        "surface_line_angle",
        "θ_l",
        "degree",
        "inclination of the total-least-squares line through the middle half of the surface of the bed",
        "",
    ).of_span(),
];

const STATIC_ANGLE: [Definition; 2] = [
    define(
        "static_angle_of_repose",
        "α",
        "degree",
        "inclination of the total-least-squares line through the outline of the heap, averaged over azimuth, between 20% and 80% of its \
         height; standard error over six sectors",
        "",
    ).of_span(),
    define("heap_height", "H", "m", "height of the outline of the heap above its foot: the highest level plane or disc below the median height of the grains, else the \
         lowest grain", "").of_span(),
];

const PACKING_FRACTION: [Definition; 1] = [define(
    "packing_fraction",
    "φ",
    "",
    "volume of the grains inside the bulk region over the volume of the region, spheres cut exactly by its border; the region is a box in \
     a fixed box without other walls, elsewhere the cubes of half a diameter, on a lattice from the middle of the domain, whose corners \
     lie in the bulk. The position of the lattice changes the value, by 0.003 in `vibrated-bed` and by 0.03 in a shallow bed of 500 grains",
    "",
)];

const SILBERT: &str = "Silbert, Soft Matter 6, 2918 (2010); Shundyak et al., Phys. Rev. E 75, 010301 (2007)";

const COORDINATION: [Definition; 5] = [
    define(
        "coordination_number",
        "Z",
        "",
        "neighbours per grain of the bulk whose gap is below 1% of the mean diameter",
        "",
    ),
    define(
        "coordination_number_without_rattlers",
        "Z_nr",
        "",
        "Z of the grains that remain after repeated removal of rattlers (fewer than 2 supports with friction, 4 without)",
        SILBERT,
    ),
    define("rattler_share", "χ_r", "", "fraction of the grains of the bulk that are rattlers", SILBERT),
    define(
        "mechanical_coordination_number",
        "Z_m",
        "",
        "contacts with f_n > 0 per grain of the bulk, with grains and walls",
        "",
    )
    .needs(ALL_CONTACTS),
    define("bulk_grains", "N_b", "", "grains in the bulk: two mean diameters from walls and free surface", ""),
];

const CONTACT_FORCES: [Definition; 8] = [
    define("share_below_mean", "s", "", "fraction of contacts between grains, with points in the bulk, with f_n < ⟨f_n⟩", "")
        .needs(CONTACTS),
    define("gini", "G", "", "Gini coefficient of f_n: Σ_ij |f_i − f_j| / (2 N² ⟨f⟩); 0 where all are equal", "")
        .needs(CONTACTS),
    define("force_second_moment", "M_2", "", "⟨f_n²⟩ / ⟨f_n⟩²", "").needs(CONTACTS),
    define(
        "weak_load_share",
        "w",
        "",
        "Σ f_n over contacts below the mean, over Σ f_n of all: the load on the weak network",
        "Radjai et al., Phys. Rev. Lett. 77, 274 (1996)",
    )
    .needs(CONTACTS),
    define("friction_mobilisation", "I_m", "", "⟨f_t / (μ f_n)⟩ with the static friction μ", "").needs(CONTACTS),
    define(
        "sliding_share",
        "χ_s",
        "",
        "fraction of contacts at a limit of friction: f_t ≥ 0.99 μ f_n, or f_t within 1% of μ_k f_n, with the static friction μ and the \
         kinetic friction μ_k",
        "",
    )
    .needs(CONTACTS),
    define(
        "fabric_anisotropy",
        "a_c",
        "",
        "√(3/2 a:a) with a = 15/2 (⟨n nᵀ⟩ − 1/3) over contact normals n",
        "Guo & Zhao, J. Mech. Phys. Solids 61, 1 (2013)",
    )
    .needs(CONTACTS),
    define("mean_normal_force", "⟨f_n⟩", "N", "mean normal force of contacts between grains whose points lie in the bulk", "")
        .needs(CONTACTS),
];

const BALANCES: [Definition; 5] = [
    define(
        "wall_force_over_weight",
        "F_w/W",
        "",
        "force of the grains on all walls along gravity over the weight of the grains, both as gravity is at the time of the frame; 1 in \
         balance",
        "",
    )
    .needs(WALL_CONTACTS),
    define("largest_overlap", "δ_max", "radius", "largest overlap of two grains, across periodic ends too, over the smaller radius", ""),
    define("mean_overlap", "⟨δ⟩", "radius", "mean overlap of pairs that overlap, over the smaller radius", ""),
    define(
        "coulomb_excess",
        "ε_C",
        "",
        "largest f_t / (μ f_n) − 1 over contacts with friction, with the static friction μ; at most 0 where Coulomb's law holds",
        "",
    )
    .needs(ALL_CONTACTS),
    define("kinetic_energy", "E_k", "J", "Σ ½ m v² + ½ (2/5 m r²) ω²", "").needs(MOTION),
];

const DRUM_FLOW: [Definition; 5] = [
    define(
        "shell_layer_speed_ratio",
        "ω_s/Ω",
        "",
        "angular speed of the grains at the shell over the drum's; 1 where they turn with it",
        "",
    )
    .needs(VELOCITIES),
    define(
        "wall_torque",
        "T",
        "N m",
        "torque of the walls that turn with the shell on the grains about the axis, positive in the sense of rotation",
        "",
    )
    .needs(WALL_CONTACTS),
    define(
        "flowing_layer_thickness",
        "h_f",
        "diameter",
        "depth below the middle of the surface at which the velocity along the surface changes sign",
        "",
    ).of_span()
    .needs(VELOCITIES),
    define("surface_speed", "v_s", "m/s", "velocity down the slope in the uppermost half diameter there", "").of_span()
        .needs(VELOCITIES),
    define(
        "lacey_mixing_index",
        "M",
        "",
        "(s₀² − s²)/(s₀² − s_r²) of grains marked by the side of the drum on which they were at the first measured frame",
        "Lacey, J. Appl. Chem. 4, 257 (1954)",
    ).of_span(),
];

const SIZE_MIXING: [Definition; 4] = [
    define(
        "size_mixing_index",
        "M_d",
        "",
        "Lacey's index of the small grains in cells of three mean diameters: 0 apart, 1 mixed at random",
        "Lacey, J. Appl. Chem. 4, 257 (1954)",
    ),
    define(
        "small_over_large_distance",
        "R_d",
        "",
        "root mean square distance of small grains from the middle of the bed over that of large ones; below 1 where they form a core",
        "",
    ),
    define(
        "population_mixing_index",
        "M_p",
        "",
        "Lacey's index of the first population",
        "Lacey, J. Appl. Chem. 4, 257 (1954)",
    ),
    define(
        "first_over_other_distance",
        "R_p",
        "",
        "root mean square distance of the first population from the middle of the bed over that of the others",
        "",
    ),
];

const DRIVEN_WALL: [Definition; 1] = [define(
    "driven_wall_displacement",
    "x_w",
    "m or rad",
    "how far a force or a torque has moved the first driven wall, along or about its axis",
    "",
)
.needs(&[Content::DrivenWalls])];

const DISCHARGE: [Definition; 2] = [
    define(
        "mass_flow_rate",
        "W",
        "kg/s",
        "(m(t_n) − m(t_1)) / (t_n − t_1) of the discharged mass m over the measured frames; standard error over blocks of time",
        "",
    ).of_span(),
    define("discharged_mass", "m", "kg", "mass that has passed the hole of the first disc with one by the last measured frame, with grains deleted since. It consists of the \
         grains below the disc at the first measured frame and those that came through the hole, not over the outer edge. Not measured \
         where a grain was deleted above the disc, or where frames are too far apart to distinguish hole and edge", "").of_span(),
];

const INTRUDER: [Definition; 2] = [
    define(
        "intruder_height",
        "z_i",
        "m",
        "height of the centre of the first grain that the scene lists by itself above the origin, against gravity",
        "",
    ),
    define("intruder_speed", "v_i", "m/s", "speed of the first grain that the scene lists by itself", "")
        .needs(VELOCITIES),
];
