//! The codes that this program drives, in one table: by which word each is asked for, and when it counts.

use super::{Code, Lammps, Liggghts, Makadam, Yade};
use clap::ValueEnum;

/// A name that this program gives to no code.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no code '{0}': give makadam, yade, liggghts or lammps")]
pub struct UnknownCode(String);

/// A code that this program drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CodeName {
    /// Makadam.
    Makadam,
    /// YADE.
    Yade,
    /// LIGGGHTS.
    Liggghts,
    /// LAMMPS.
    Lammps,
}

impl CodeName {
    /// The codes that Makadam is held against, live or recorded.
    pub const REFEREES: [CodeName; 2] = [CodeName::Yade, CodeName::Liggghts];

    /// The codes that count where their numbers are on record, and are not asked to run.
    pub const FURTHER_REFEREES: [CodeName; 1] = [CodeName::Lammps];

    /// The code of a name, in capitals or not.
    ///
    /// # Errors
    /// [`UnknownCode`] for a name that this program gives to no code.
    pub fn of(name: &str) -> Result<CodeName, UnknownCode> {
        CodeName::from_str(name, true).map_err(|_| UnknownCode(name.into()))
    }

    /// The code.
    pub fn code(self) -> Box<dyn Code + Send> {
        match self {
            CodeName::Makadam => Box::new(Makadam),
            CodeName::Yade => Box::new(Yade::default()),
            CodeName::Liggghts => Box::new(Liggghts::default()),
            CodeName::Lammps => Box::new(Lammps::default()),
        }
    }
}

/// The codes of these names, each once, Makadam first.
pub fn codes_of(names: &[CodeName]) -> Vec<Box<dyn Code>> {
    let asked = CodeName::value_variants().iter().filter(|name| names.contains(name));
    asked.map(|name| -> Box<dyn Code> { name.code() }).collect()
}

#[cfg(test)]
mod tests {
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
}
