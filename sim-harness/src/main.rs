//! Starts the `uchain` command, which is [`sim_harness::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    sim_harness::cli::main()
}
