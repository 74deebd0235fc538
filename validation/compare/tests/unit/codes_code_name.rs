//! Unit tests of `src/codes/code_name.rs`.

use super::*;

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
