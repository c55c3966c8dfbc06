//! `uchain bench stock`: how far the vendor's own firmware flies the emulated drone.

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

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct StockBench {
    /// The vendor's cf2.elf
    #[arg(long, value_name = "FILE")]
    elf: PathBuf,
    /// The radio chip's own firmware; where left out, the radio chip is a model
    #[arg(long, value_name = "FILE")]
    radio_elf: Option<PathBuf>,
    /// A Python that has cflib, by which it is flown a second time
    #[arg(long, value_name = "FILE")]
    python: Option<PathBuf>,
}

impl Benchmark for StockBench {
    const NAME: &'static str = "stock";
    const ABOUT: &'static str =
        "How far the vendor's own firmware flies the emulated drone; --elf names its cf2.elf";
    const PAGE: &'static str = "virtual.md";
    const NEEDS: Needs = Needs::VendorsFirmware;

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let radio = self.radio_elf.as_deref();
        table::outcome(session, (self.elf.as_path(), radio, self.python.as_deref()))
    }
}
