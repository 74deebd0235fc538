//! Program `makadam`.

use std::process::ExitCode;

fn main() -> ExitCode {
    makadam_validation::commands::main()
}
