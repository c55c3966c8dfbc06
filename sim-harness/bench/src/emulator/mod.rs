//! `uchain bench emulator`: how fast the emulator is, and whether it computes what another
//! emulator does.

#[cfg(feature = "virtual")]
pub mod measure;
#[cfg(feature = "virtual")]
mod table;

use std::path::PathBuf;

use clap::Args;
use input::InputError;

#[cfg(not(feature = "virtual"))]
use super::absent as table;
use super::{Benchmark, Needs, Outcome, Session};
use bodies::emulated::Firmware;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct EmulatorBench {
    /// The firmware's ELF file
    #[arg(long, value_name = "FILE", default_value = Firmware::DEFAULT)]
    elf: PathBuf,
    /// The radio chip's own firmware; where left out, the radio chip is a model
    #[arg(long, value_name = "FILE")]
    radio_elf: Option<PathBuf>,
}

impl Benchmark for EmulatorBench {
    const NAME: &'static str = "emulator";
    const ABOUT: &'static str =
        "How fast the emulator is, and whether it computes what another emulator does";
    const PAGE: &'static str = "virtual.md";
    const NEEDS: Needs = Needs::Firmware;

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        table::outcome(session, (self.elf.as_path(), self.radio_elf.as_deref()))
    }
}
