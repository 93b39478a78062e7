//! The `aether` renderer; see [`integrators::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    integrators::cli::main()
}
