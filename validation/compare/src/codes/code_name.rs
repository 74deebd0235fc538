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
#[path = "../../tests/unit/codes_code_name.rs"]
mod tests;
