//! `uchain bench firmware`: how much of the processor and the memory the firmware uses.

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
pub(crate) struct FirmwareBench {
    /// The firmware's ELF file
    #[arg(long, value_name = "FILE", default_value = Firmware::DEFAULT)]
    elf: PathBuf,
    /// The radio chip's own firmware; where left out, the radio chip is a model
    #[arg(long, value_name = "FILE")]
    radio_elf: Option<PathBuf>,
}

impl Benchmark for FirmwareBench {
    const NAME: &'static str = "firmware";
    const ABOUT: &'static str =
        "How much of the processor and the memory the firmware uses, on the emulated chip";
    const PAGE: &'static str = "virtual.md";
    const NEEDS: Needs = Needs::Firmware;

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        table::outcome(session, (self.elf.as_path(), self.radio_elf.as_deref()))
    }
}
