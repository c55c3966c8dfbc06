//! `uchain bench mishaps`: what the firmware does when its chip, its buses or its code fail.

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
pub(crate) struct MishapsBench {
    /// The firmware's ELF file
    #[arg(long, value_name = "FILE", default_value = Firmware::DEFAULT)]
    elf: PathBuf,
    /// Run only the mishaps that have this text in their names
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
}

impl Benchmark for MishapsBench {
    const NAME: &'static str = "mishaps";
    const ABOUT: &'static str =
        "What the firmware does when its chip, its buses or its code fail, in the emulator";
    const PAGE: &'static str = "virtual.md";
    const NEEDS: Needs = Needs::Firmware;

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        table::outcome(session, (self.elf.as_path(), self.only.as_str()))
    }
}
