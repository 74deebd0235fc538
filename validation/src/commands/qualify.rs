use super::arguments::QualifyArguments;
use super::{Console, Failure};
use std::process::ExitCode;
pub(super) fn qualify(_: &QualifyArguments, _: &Console) -> Result<ExitCode, Failure> { Ok(ExitCode::SUCCESS) }
