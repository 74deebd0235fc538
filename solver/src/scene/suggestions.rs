//! Suggestions for an unknown name.

/// Returns at most `most` known names that are close to a word, the closest first; an empty list if no known name is close.
///
/// A name is close if at most a third of the letters of the word must be added, dropped, changed or swapped with a
/// neighbour. A name is also close if either name is a sequence of whole parts of the other, such as `below` in
/// `share_below_mean`. Hyphens equal underscores, and case is ignored.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, most: usize) -> Vec<&'a str> {
    let word = plain(word);
    let letters = letters_of(&word);
    let mut ranked: Vec<(usize, &str)> = known
        .into_iter()
        .filter_map(|name| {
            let plain = plain(name);
            let slips = match is_part(&word, &plain) || is_part(&plain, &word) {
                true => 0,
                false => edits(&letters, &letters_of(&plain)),
            };
            (3 * slips <= letters.len()).then_some((slips, name))
        })
        .collect();
    ranked.sort();
    ranked.dedup();
    ranked.into_iter().take(most).map(|(_, name)| name).collect()
}

/// Returns `did you mean a, b or c?`, or `otherwise` if no known name is close to the word.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, otherwise: &str) -> String {
    const MOST: usize = 3;
    match nearest(word, known, MOST)[..] {
        [] => otherwise.into(),
        [only] => format!("did you mean {only}?"),
        [ref others @ .., last] => format!("did you mean {} or {last}?", others.join(", ")),
    }
}

fn plain(name: &str) -> String {
    name.to_lowercase().replace('_', "-")
}

/// Returns the letters of a name without the hyphens between its parts.
fn letters_of(name: &str) -> Vec<char> {
    name.chars().filter(|letter| *letter != '-').collect()
}

/// Returns true if one name is a sequence of whole parts, between hyphens, of another name.
fn is_part(part: &str, name: &str) -> bool {
    !part.is_empty() && format!("-{name}-").contains(&format!("-{part}-"))
}

/// Returns the number of letters to add, drop, change or swap with a neighbour (optimal string alignment).
fn edits(word: &[char], name: &[char]) -> usize {
    // Without one of the two, all letters of the other are added or dropped.
    let mut table: Vec<Vec<usize>> = (0..=word.len()).map(|row| (row..=row + name.len()).collect()).collect();
    for row in 1..=word.len() {
        for column in 1..=name.len() {
            let changed = table[row - 1][column - 1] + usize::from(word[row - 1] != name[column - 1]);
            let mut least = changed.min(table[row - 1][column] + 1).min(table[row][column - 1] + 1);
            let swapped =
                row > 1 && column > 1 && word[row - 1] == name[column - 2] && word[row - 2] == name[column - 1];
            if swapped {
                least = least.min(table[row - 2][column - 2] + 1);
            }
            table[row][column] = least;
        }
    }
    table[word.len()][name.len()]
}

/// Lower-case words with hyphens, then their answer after a colon.
const WISHES: [&str; 25] = [
    "mesh stl obj triangles facets polyhedron cad file: a wall of a CAD file is { kind = \"mesh\", file, scale }; grains of a CSV file are a [start]",
    "insert insertion inflow inlet feed factory source emitter pour: grains that come during a run are an [[insert]] with region, material, radius, and rate, mass_rate or total",
    "delete remove outflow outlet sink: grains leave in the region of a [[remove]]; grains outside the domain: watch.on_escape = \"ignore\"",
    "clump clumps multisphere superquadric ellipsoid polyhedra rod template: grains are spheres: rolling_friction of the material stands for their shape, or use YADE, LIGGGHTS or Chrono",
    "cube cuboid hexahedron: a container with flat faces is { kind = \"box\", min, max }; grains are spheres",
    "cone funnel hopper: a cone is { kind = \"frustum\", base, axis, radii, length }",
    "sheet plate parallelogram: a flat sheet is { kind = \"rectangle\", corner, edges }",
    "ball particle particles sphere grains: one grain is a [[grain]], many are a [[population]]; a ball as a wall is { kind = \"spheres\" }",
    "bond bonds bonded parallel-bond bpm: there are no bonds that break: the attraction between grains is `cohesion` of their material",
    "rpm: turns are given as rate in rad/s: rate = rpm * 0.10472 (2 pi / 60)",
    "omega angular-velocity: turns of a wall are given as rate in rad/s; turns of a grain as spin in rad/s",
    "diameter diameters d: sizes are given as radius in m, half the diameter",
    "young e-modulus stiffness kn: elasticity is youngs_modulus of the material in Pa, or solver.normal_law with a stiffness in N/m",
    "nu: Poisson's ratio is poisson_ratio of the material",
    "mu cof friction-angle: friction is the coefficient `friction` of the material: the tangent of the friction angle",
    "cor e en: the coefficient of restitution is `restitution` of the material",
    "dt timestep time-step: the time step is solver.step in s",
    "end-time t-end total-time runtime: the simulated time is duration in s",
    "servo load pressure stress: a wall under a load has motion = { kind = \"force-driven\", axis, force, mass }, with the force in N",
    "temperature heat fluid drag liquid charge: dry grains only: there is no heat, fluid, drag or electric charge",
    "density youngs-modulus poisson-ratio friction restitution rolling-friction cohesion: it is a key of a material: material.NAME, such as material.grain",
    "count region spacing agitation: it is a key of a [[population]]",
    "radius: it is a key of a [[population]], a [[grain]] or the shape of a wall",
    "step stop sweeps method normal-law: it is a key of [solver]",
    "units unit: units are SI: metres, seconds, kilograms, pascals, radians per second",
];

/// Returns the answer for a word that resembles no key; `None` for an unknown word.
pub fn wish(word: &str) -> Option<&'static str> {
    let word = plain(word);
    let mut wishes = WISHES.iter().filter_map(|wish| wish.split_once(": "));
    wishes.find(|(words, _)| words.split(' ').any(|own| own == word)).map(|(_, answer)| answer)
}

/// Returns the remedy for an unknown name: a close known name, or the answer of [`wish`]; `None` without either.
pub(super) fn remedy<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    match nearest(unknown, known, 1).first() {
        Some(name) => Some(format!("did you mean `{name}`?")),
        None => wish(unknown).map(String::from),
    }
}
