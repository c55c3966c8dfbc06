//! `uchain replay --on virtual`: recorded RSSI on an emulated Crazyflie.

use std::path::{Path, PathBuf};

use bodies::emulated::Firmware;
use replay::chip::emulated::EmulatedTarget;
use replay::chip::{self, ChipOptions, ChipSummary};

/// Replays all logs.
pub(in crate::cli) fn run(
    logs: &[PathBuf],
    options: &ChipOptions,
    elf: Option<&Path>,
    stepped: impl FnMut(),
) -> Result<ChipSummary, chip::Error> {
    let target =
        || EmulatedTarget::new(&Firmware::open(elf.unwrap_or(Path::new(Firmware::DEFAULT)))?);
    chip::replay(logs, options, target, stepped)
}
