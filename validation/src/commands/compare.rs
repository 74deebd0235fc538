use super::arguments::CompareArguments;
use super::{Console, Failure};
use std::process::ExitCode;
pub(super) fn compare(_: &CompareArguments, _: &Console) -> Result<ExitCode, Failure> { Ok(ExitCode::SUCCESS) }
