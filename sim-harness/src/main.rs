//! The `uchain` command: see [`sim_harness::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    sim_harness::cli::main()
}
