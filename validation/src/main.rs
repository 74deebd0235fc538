//! The `makadam` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    makadam_validation::commands::main()
}
