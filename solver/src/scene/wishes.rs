//! Words of other programs that no key of a scene is spelt like: the limit behind each, and what to do instead.

use super::nearest::nearest;

/// Words, small letters with hyphens, with the answer to all of them.
const WISHES: [(&[&str], &str); 24] = [
    (
        &["mesh", "stl", "obj", "triangles", "facets", "polyhedron", "cad", "file"],
        "walls have no meshes: compose the surface of planes, boxes, cylinders, discs and wall spheres, or use LIGGGHTS or YADE",
    ),
    (
        &["insert", "insertion", "inflow", "inlet", "feed", "factory", "source", "emitter", "pour"],
        "a scene has all its grains from the start: place them as a [[population]] above the bed, or insert grains from Python \
         (Simulation.insert)",
    ),
    (
        &["delete", "remove", "outflow", "outlet", "sink"],
        "a scene keeps its grains: let them fall out of the domain (watch.on_escape = \"ignore\"), or remove grains from Python \
         (Simulation.remove)",
    ),
    (
        &["clump", "clumps", "multisphere", "superquadric", "ellipsoid", "polyhedra", "rod", "template"],
        "grains are spheres: rolling_friction of the material stands for their shape, or use YADE, LIGGGHTS or Chrono",
    ),
    (
        &["cube", "cuboid", "rectangle", "hexahedron"],
        "a container with flat faces is { kind = \"box\", min, max }; grains are spheres",
    ),
    (
        &["cone", "funnel", "hopper"],
        "there are no cones: an outlet in a flat floor is a disc with a hole (`makadam new silo`), a steep wall can be composed of \
         wall spheres (kind = \"spheres\")",
    ),
    (
        &["ball", "particle", "particles", "sphere", "grains"],
        "one grain is a [[grain]], many are a [[population]]; a ball as a wall is { kind = \"spheres\" }",
    ),
    (
        &["bond", "bonds", "bonded", "parallel-bond", "bpm"],
        "there are no bonds that break: the attraction between grains is `cohesion` of their material",
    ),
    (&["rpm"], "turns are given as rate in rad/s: rate = rpm * 0.10472 (2 pi / 60)"),
    (&["omega", "angular-velocity"], "turns of a wall are given as rate in rad/s; turns of a grain as spin in rad/s"),
    (&["diameter", "diameters", "d"], "sizes are given as radius in m, half the diameter"),
    (
        &["young", "e-modulus", "stiffness", "kn"],
        "elasticity is youngs_modulus of the material in Pa, or solver.normal_law with a stiffness in N/m",
    ),
    (&["nu"], "Poisson's ratio is poisson_ratio of the material"),
    (
        &["mu", "cof", "friction-angle"],
        "friction is the coefficient `friction` of the material: the tangent of the friction angle",
    ),
    (&["cor", "e", "en"], "the coefficient of restitution is `restitution` of the material"),
    (&["dt", "timestep", "time-step"], "the time step is solver.step in s"),
    (&["end-time", "t-end", "total-time", "runtime"], "the simulated time is duration in s"),
    (
        &["servo", "load", "pressure", "stress"],
        "a wall under a load has motion = { kind = \"force-driven\", axis, force, mass }, with the force in N",
    ),
    (
        &["temperature", "heat", "fluid", "drag", "liquid", "charge"],
        "dry grains only: there is no heat, fluid, drag or electric charge",
    ),
    (
        &["density", "youngs-modulus", "poisson-ratio", "friction", "restitution", "rolling-friction", "cohesion"],
        "it is a key of a material: material.NAME, such as material.grain",
    ),
    (&["count", "region", "spacing", "agitation"], "it is a key of a [[population]]"),
    (&["radius"], "it is a key of a [[population]], a [[grain]] or the shape of a wall"),
    (&["step", "stop", "sweeps", "method", "normal-law"], "it is a key of [solver]"),
    (&["units", "unit"], "units are SI: metres, seconds, kilograms, pascals, radians per second"),
];

/// Answer to a word that no key is spelt like; `None` where nothing is known of it.
pub fn wish(word: &str) -> Option<&'static str> {
    let word = word.to_lowercase().replace('_', "-");
    WISHES.iter().find(|(words, _)| words.contains(&word.as_str())).map(|(_, answer)| *answer)
}

/// Remedy for an unknown name: the close one of those that are known, or the answer to a wish; `None` where there is neither.
pub(super) fn remedy<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    match nearest(unknown, known, 1).first() {
        Some(name) => Some(format!("did you mean `{name}`?")),
        None => wish(unknown).map(String::from),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes_are_answered_with_a_way() {
        for (word, way) in [
            ("mesh", "wall spheres"),
            ("Insert", "Simulation.insert"),
            ("time_step", "solver.step"),
            ("rpm", "0.10472"),
        ] {
            assert!(wish(word).is_some_and(|answer| answer.contains(way)), "{word}");
        }
        assert_eq!(wish("zzz"), None);
        assert_eq!(remedy("frcition", ["friction"]).unwrap(), "did you mean `friction`?");
    }

    #[test]
    fn no_word_is_listed_twice() {
        let mut words: Vec<&str> = WISHES.iter().flat_map(|(words, _)| words.iter().copied()).collect();
        let number = words.len();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), number);
    }
}
