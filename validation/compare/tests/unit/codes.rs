//! Unit tests of `src/codes/mod.rs`.

use super::*;
use crate::scenes::{find, load};

/// Effects that reference codes have, and those that they are refused for.
const REFUSED: [(&str, &[&Effect], &[&str]); 3] = [
    (
        "YADE",
        &yade::HAS,
        &[
            "changing gravity",
            "inflow",
            "outflow",
            "periodic axes",
            "falling restitution",
            "kinetic friction",
            "twisting resistance",
        ],
    ),
    (
        "LIGGGHTS and LAMMPS",
        &deck::HAS,
        &[
            "changing gravity",
            "surface velocity",
            "inflow",
            "outflow",
            "driven walls",
            "periodic axes",
            "falling restitution",
            "kinetic friction",
            "cohesion",
            "twisting resistance",
        ],
    ),
    (
        "MigFlow",
        &migflow::HAS,
        &[
            "changing gravity",
            "surface velocity",
            "driven walls",
            "inflow",
            "outflow",
            "periodic axes",
            "elastic compliance",
            "contact viscosity",
            "restitution",
            "falling restitution",
            "kinetic friction",
            "tangential spring",
            "cohesion",
            "rolling resistance",
            "twisting resistance",
        ],
    ),
];

#[test]
fn every_effect_is_had_or_refused() {
    for (code, has, refused) in REFUSED {
        for effect in CATALOGUE {
            let listed = has.iter().filter(|one| one.name == effect.name).count();
            let refused = refused.iter().filter(|name| **name == effect.name).count();
            assert_eq!(listed + refused, 1, "{code}: {} stands in one list", effect.name);
        }
        assert_eq!(has.len() + refused.len(), CATALOGUE.len(), "{code} lists an effect that is none");
    }
}

#[test]
fn an_unlisted_effect_is_refused() {
    let scene = load(&find("packing-100", &[]).unwrap()).unwrap();
    let grains = ::makadam::scene::populate(&scene, 1).unwrap();
    let refusal = |has: &[&'static Effect]| refuse_effects("YADE", has, &scene, &grains).err().map(|e| e.to_string());
    assert_eq!(refusal(&yade::HAS), None);
    for left_out in yade::HAS.iter().filter(|effect| effect.called_by(&scene).is_ok()) {
        let has: Vec<_> = yade::HAS.into_iter().filter(|effect| effect.name != left_out.name).collect();
        let said = refusal(&has).expect(left_out.name);
        assert!(said.contains(&format!("it has no {}", left_out.name)), "{said}");
    }
}

#[test]
fn each_code_is_found_by_its_own_name_and_listed_once() {
    let all = CodeName::value_variants();
    for name in all {
        assert_eq!(CodeName::of(name.code().name()), Ok(*name));
    }
    let unknown = CodeName::of("edem").unwrap_err().to_string();
    assert!(unknown.contains("no code 'edem'"), "{unknown}");
    for name in all {
        assert!(unknown.contains(&name.code().name().to_lowercase()), "{unknown}");
    }
    let listed = codes_of(&[CodeName::Lammps, CodeName::Makadam, CodeName::Lammps]);
    assert_eq!(listed.iter().map(|code| code.name()).collect::<Vec<_>>(), ["Makadam", "LAMMPS"]);
    let referees = CodeName::REFEREES.iter().chain(&CodeName::FURTHER_REFEREES);
    assert_eq!(referees.count() + 1, all.len());
}
