//! The catalogue of effects against the scene language, the files of the effects, and the page that shows it.

use crate::common::parse;
use makadam::effects::catalogue::{Absent, CATALOGUE, Coefficient, Effect, coefficients};
use makadam::scene::Scene;
use makadam::{EffectSet, Simulation};
use std::path::Path;

/// Material of the scenes here, unless a test states otherwise.
const MATERIAL: [(&str, &str); 5] = [
    ("density", "2500.0"),
    ("youngs_modulus", "1e7"),
    ("poisson_ratio", "0.3"),
    ("friction", "0.5"),
    ("restitution", "0.5"),
];

/// Two grains that fall on a floor, of a material that says this besides, with a rule of pairs that says that.
fn text(material: &[(&str, String)], rule: &str) -> String {
    let said = |key: &str| material.iter().find(|(other, _)| *other == key);
    let mut lines: String = MATERIAL
        .iter()
        .filter(|(key, _)| said(key).is_none())
        .map(|(key, value)| format!("{key} = {value}\n"))
        .collect();
    lines.extend(material.iter().filter(|(_, line)| !line.is_empty()).map(|(_, line)| format!("{line}\n")));
    let rule =
        if rule.is_empty() { String::new() } else { format!("[[pair]]\nbetween = ['grain', 'grain']\n{rule}\n") };
    format!(
        "name = 'test'\ndescription = 'test'\nduration = 1.0\ngravity = [0.0, 0.0, -9.81]\n\
         domain = {{ min = [-1, -1, -1], max = [1, 1, 1] }}\n[material.grain]\n{lines}{rule}\
         [solver]\nstep = 5e-4\nnormal_law = {{ kind = 'rigid' }}\nstop = {{ kind = 'sweeps', sweeps = 10 }}\n\
         [[wall]]\nname = 'floor'\nmaterial = 'grain'\nshape = {{ kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }}\n\
         [[grain]]\nmaterial = 'grain'\nradius = 0.01\nposition = [0.0, 0.0, 0.011]\nvelocity = [0.3, 0.1, -0.2]\nspin = [5.0, 3.0, 9.0]\n\
         [[grain]]\nmaterial = 'grain'\nradius = 0.008\nposition = [0.004, 0.0, 0.031]\n"
    )
}

/// The line of a scene that gives a coefficient a value; the pull of cohesion that has a range is one newton.
fn line(coefficient: &Coefficient, value: f64) -> String {
    match coefficient.key.split_once('.') {
        None => format!("{} = {value:?}", coefficient.key),
        Some(("cohesion", "force")) => format!("cohesion = {{ kind = 'constant', force = {value:?} }}"),
        Some(("cohesion", "range")) => format!("cohesion = {{ kind = 'constant', force = 1.0, range = {value:?} }}"),
        Some(("cohesion", "work")) => format!("cohesion = {{ kind = 'surface-energy', work = {value:?} }}"),
        Some(_) => panic!("how does a scene say {}?", coefficient.key),
    }
}

/// A scene whose material gives a coefficient a value.
fn with(coefficient: &Coefficient, value: f64) -> Result<Scene, String> {
    parse(&text(&[(coefficient.key, line(coefficient, value))], ""))
}

fn effect_of(coefficient: &Coefficient) -> &'static Effect {
    let of = |effect: &&&Effect| effect.coefficients.iter().any(|one| one.key == coefficient.key);
    CATALOGUE.iter().find(of).unwrap()
}

fn effects(scene: &Scene) -> EffectSet {
    Simulation::new(scene, 1).unwrap().effects()
}

fn hash_after(scene: &Scene, steps: u32) -> u64 {
    let mut simulation = Simulation::new(scene, 1).unwrap();
    (0..steps).for_each(|_| _ = simulation.step());
    simulation.state_hash()
}

/// As the page writes a number.
fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e5).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

#[test]
fn what_is_out_of_range_is_refused_with_key_range_and_unit_in_materials_and_rules() {
    for one in coefficients() {
        let [least, most] = one.range;
        let most = one.ceiling.as_ref().map_or(most, |_| 0.5);
        for wrong in [least - 1e-3 * most, 1.001 * most, f64::NAN] {
            let wrong_line = line(one, wrong).replace("NaN", "nan");
            let in_material = text(&[(one.key, wrong_line.clone())], "");
            for (table, text) in [("material.grain", in_material), ("pair[0]", text(&[], &wrong_line))] {
                let message = parse(&text).expect_err(one.key);
                let range = format!("from {least} to {most} {}", one.unit);
                for word in [&format!("{table}.{}: ", one.key), "is out of range", &*range] {
                    assert!(message.contains(word), "no '{word}' in: {message}");
                }
            }
        }
        for right in [least, most] {
            // The smallest steps of a restitution that falls are for a solver to bear, and rigid contacts do.
            with(one, right).unwrap_or_else(|error| panic!("{}: {error}", one.key));
        }
    }
}

#[test]
fn a_coefficient_calls_for_its_effect_and_for_no_other_one() {
    for one in coefficients() {
        let effect = effect_of(one);
        let rest = parse(&text(&[("friction", "friction = 0.5".into()), (one.key, String::new())], ""));
        // Where the key must be given, materials are without effect and the rule alone has it.
        let bare = if one.absent == Absent::Refused { vec![(one.key, line(one, 0.0))] } else { Vec::new() };
        for called in [with(one, 0.1).unwrap(), parse(&text(&bare, &line(one, 0.1))).unwrap()] {
            let call = effect.called_by(&called).unwrap_or_else(|without| panic!("{}: {without}", one.key));
            assert!(call.why.contains(&format!("{} = 0.1", one.key)), "{}", call.why);
            let set = effects(&called);
            assert_ne!(set.has(effect), Some(false), "{}", one.key);
            let before = rest.as_ref().map_or_else(|_| set, effects);
            for other in CATALOGUE.iter().filter(|other| other.name != effect.name) {
                assert_eq!(set.has(other), before.has(other), "{} changes {}", one.key, other.name);
            }
        }
    }
}

#[test]
fn the_line_that_calls_for_an_effect_is_told() {
    for one in coefficients() {
        for text in [text(&[(one.key, line(one, 0.1))], ""), text(&[], &line(one, 0.1))] {
            let scene = parse(&text).unwrap();
            let call = effect_of(one).called_by(&scene).unwrap();
            // Materials have friction and restitution, so these are where a scene first says so.
            let key = one.key.split('.').next().unwrap();
            let first = text.lines().position(|line| line.starts_with(key)).unwrap();
            assert_eq!(call.place.line(&text), Some(first + 1), "{}", one.key);
        }
    }
}

#[test]
fn the_value_without_effect_and_the_absent_key_are_the_same() {
    for one in coefficients() {
        let effect = effect_of(one);
        // A range goes with a force, which has the effect by itself.
        let accompanies = one.absent == Absent::Value(0.0) && one.off.is_none();
        let rest = if accompanies { line(one, 0.0).replace(", range = 0.0", "") } else { String::new() };
        let absent = parse(&text(&[(one.key, rest)], ""));
        if one.absent == Absent::Refused {
            let message = absent.expect_err(one.key);
            assert!(message.contains(&format!("missing field `{}`", one.key)), "{message}");
        } else {
            let absent = absent.unwrap();
            assert_eq!(effect.called_by(&absent).is_ok(), accompanies, "{} is not said", one.key);
            assert_eq!(effects(&absent).has(effect).unwrap_or(accompanies), accompanies, "{}", one.key);
            if let Absent::SameAs(other) = one.absent {
                let same = absent.material["grain"].clone();
                let value = coefficients().find(|one| one.key == other).and_then(|one| (one.of_material)(&same));
                let said = with(one, value.unwrap()).unwrap();
                assert!(effect.called_by(&said).is_err(), "{} as {other}", one.key);
                assert_eq!(hash_after(&said, 200), hash_after(&absent, 200), "{}", one.key);
            }
            if let Some(off) = one.off {
                let said = with(one, off).unwrap();
                assert_eq!(hash_after(&said, 200), hash_after(&absent, 200), "{}", one.key);
            }
            if let Absent::Value(value) = one.absent {
                assert_eq!(with(one, value).unwrap(), absent, "{}: another scene is another hash", one.key);
                assert!(!toml::to_string(&absent).unwrap().contains(one.key), "{} is written", one.key);
            }
        }
        if let Some(off) = one.off {
            let said = with(one, off).unwrap();
            assert!(effect.called_by(&said).is_err(), "{} = {off}", one.key);
            assert_ne!(effects(&said).has(effect), Some(true), "{} = {off}", one.key);
        }
    }
}

/// Two materials of two grains, and a wall of the second: what a contact has follows from the rule of combination.
#[test]
fn grains_take_the_smaller_value_and_walls_their_own_unless_a_pair_has_one() {
    // A pull of an energy and one of a range do not compare; that of a range is the other's companion.
    for one in coefficients().filter(|one| one.key != "cohesion.range") {
        let scene = |rule: &str| {
            let second = text(&[(one.key, line(one, 0.2))], "").replace("'grain'", "'second'");
            let table = &second[second.find("[material.grain]").unwrap()..second.find("[solver]").unwrap()];
            let rule = if rule.is_empty() {
                String::new()
            } else {
                format!("[[pair]]\nbetween = ['second', 'grain']\n{rule}\n")
            };
            let first = text(&[(one.key, line(one, 0.1))], "");
            parse(&first.replacen(
                "[solver]",
                &(table.replace("material.grain", "material.second") + &rule + "[solver]"),
                1,
            ))
        };
        let alike = |value: f64| with(one, value).unwrap().contact_coefficients("grain", "grain", false);
        let (bare, ruled) = (scene("").unwrap(), scene(&line(one, 0.3)).unwrap());
        for (a, b, wall, expected) in [
            ("grain", "second", false, 0.1),
            ("second", "grain", false, 0.1),
            ("grain", "second", true, 0.2),
            ("second", "grain", true, 0.1),
        ] {
            assert_eq!(bare.contact_coefficients(a, b, wall), alike(expected), "{} of {a}, {b}, {wall}", one.key);
            let mut ruled = ruled.contact_coefficients(a, b, wall);
            if one.key == "friction" {
                // A rule's friction alone is that of what slides, too.
                assert_eq!((ruled.friction, ruled.kinetic_friction), (0.3, 0.3));
                ruled.kinetic_friction = alike(0.3).kinetic_friction;
            }
            assert_eq!(ruled, alike(0.3), "{} of {a}, {b} by a rule", one.key);
        }
    }
}

/// A scene that calls for all effects.
fn all() -> Scene {
    let lines = "kinetic_friction = 0.4\nrestitution_speed = 0.1\nrolling_friction = 0.1\ntwisting_friction = 0.1\n\
                 cohesion = { kind = 'constant', force = 1.0 }";
    let lid = "[[wall]]\nname = 'lid'\nmaterial = 'grain'\n\
               shape = { kind = 'plane', point = [0.0, 0.0, 0.1], normal = [0.0, 0.0, -1.0] }\n\
               motion = { kind = 'force-driven', axis = [0, 0, 1], force = 0.1, mass = 0.1 }\n[[grain]]";
    let flow = "[[insert]]\nmaterial = 'grain'\nradius = { kind = 'fixed', value = 0.01 }\nrate = 1\n\
                region = { kind = 'box', min = [0, 0, 0.1], max = [0.1, 0.1, 0.2] }\n\
                [[remove]]\nregion = { kind = 'box', min = [0, 0, -1], max = [1, 1, -0.9] }\n";
    let text = text(&[("", lines.into())], "")
        .replacen("gravity =", "gravity_changes = [{ time = 0.1, gravity = [0.0, 0.0, -9.0] }]\ngravity =", 1)
        .replacen("max = [1, 1, 1]", "max = [1, 1, 1], periodic = ['x']", 1)
        .replacen(
            "[[grain]]",
            &format!("motion = {{ kind = 'translating', velocity = [1, 0, 0] }}\nsurface_velocity = [0, 1, 0]\n{lid}"),
            1,
        )
        .replacen("[[grain]]", &format!("{flow}[[grain]]"), 1);
    let mut scene = parse(&text).unwrap();
    // A fall of restitution goes with rigid contacts, viscosity with the others; nothing is simulated here.
    scene.solver.normal_law = makadam::NormalLaw::Hertz;
    scene.solver.tangential_law = makadam::scene::TangentialLaw::Spring { stiffness_ratio: None };
    scene
}

#[test]
fn a_change_turns_its_effect_off_or_on() {
    let scene = all();
    for effect in CATALOGUE {
        effect.called_by(&scene).unwrap_or_else(|without| panic!("{}: {without}", effect.name));
        let apply = |scene: &Scene, change: fn(&mut Scene)| {
            let mut changed = scene.clone();
            change(&mut changed);
            changed
        };
        let Some(off) = &effect.off else {
            assert!(effect.tried.is_none());
            continue;
        };
        // Size spread goes with populations: grains placed one by one keep their radii.
        let without = apply(&scene, off.apply);
        let off = effect.called_by(&without).is_err();
        assert!(off || effect.name == "size spread", "{}", effect.name);
        if let Some(tried) = &effect.tried {
            assert!(effect.called_by(&apply(&without, tried.apply)).is_ok(), "{}", effect.name);
        }
    }
}

#[test]
fn every_file_of_an_effect_has_descriptors_and_all_are_listed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/effects");
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let catalogue = read(&folder.join("mod.rs"));
    let list = catalogue.split_once("pub static CATALOGUE").and_then(|(_, rest)| rest.split_once("\n];")).unwrap().0;
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        // The law of impacts is that of restitution, whose descriptor stands with its coefficients.
        if ["mod.rs", "catalogue.rs", "term.rs", "impact.rs"].iter().any(|name| path.ends_with(name)) {
            continue;
        }
        let text = read(&path);
        let names: Vec<&str> = text
            .lines()
            .filter_map(|line| Some(line.strip_prefix("pub static ")?.split_once(": Effect =")?.0))
            .collect();
        assert!(!names.is_empty(), "{} has no descriptor", path.display());
        for name in &names {
            assert!(list.contains(&format!("    &{name},")), "{name} of {} is not listed", path.display());
        }
        count += names.len();
    }
    assert_eq!(count, CATALOGUE.len());
    let mut names: Vec<&str> = CATALOGUE.iter().map(|effect| effect.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), CATALOGUE.len(), "no two effects have one name");
}

#[test]
fn the_page_shows_the_catalogue() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/effects.md")).unwrap();
    let mut table = String::new();
    for effect in CATALOGUE {
        for one in effect.coefficients {
            let [least, most] = one.range.map(number);
            let ceiling = one.ceiling.as_ref().map_or(String::new(), |ceiling| format!(", at most {}", ceiling.words));
            let absent = match one.absent {
                Absent::Refused => "must be given".into(),
                Absent::Value(value) => number(value),
                Absent::SameAs(other) => format!("`{other}`"),
                Absent::Off => "off".into(),
            };
            let (unit, words) = (one.unit.trim_matches(['(', ')']), effect.combination.as_ref().unwrap().words);
            let columns =
                [effect.name, &format!("`{}`", one.key), unit, &format!("{least} to {most}{ceiling}"), &absent, words];
            table += &format!("| {} |\n", columns.join(" | "));
        }
    }
    assert!(page.contains(&table), "docs/effects.md has another table than this one:\n{table}");
    for effect in CATALOGUE {
        assert!(page.contains(&format!("| {} |", effect.name)), "docs/effects.md does not name {}", effect.name);
    }
}
