//! Starts the `uchain-ground` command, which is [`ground_station::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    ground_station::cli::main()
}
