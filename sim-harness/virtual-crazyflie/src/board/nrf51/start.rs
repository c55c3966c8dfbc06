//! When the chip's parts begin to work, as measured with the vendor's program on an emulated chip
//! (`nrf51-chip`).

use crate::soc::Nanos;

/// The moments of a start of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Start {
    /// Its line to the flight processor is open from then on.
    pub(super) opens: Nanos,
    /// Its radio listens from then on even if the flight processor never enabled it.
    pub(super) listens: Nanos,
    /// It reports battery and signal no earlier (`SYSLINK_STARTUP_DELAY_TIME_MS`).
    pub(super) reports: Nanos,
}

impl Start {
    /// From the chip's own start until it opens the line.
    const OPENS: Nanos = 354_400_000;
    /// Until the flight processor runs: its reset is released 6 ms after its supply is on.
    const RELEASES: Nanos = 357_400_000;
    /// Until the radio listens: 3 s after the main loop's first round
    /// (`SYSLINK_RADIO_DISABLED_TIMEOUT_MS`).
    const LISTENS: Nanos = 3_120_800_000;
    /// Until the first report.
    const REPORTS: Nanos = 1_010_400_000;

    /// The start at which the chip gives the flight processor its power, which runs from zero on.
    pub(super) const WITH_PROCESSOR: Self = Self {
        opens: 0,
        listens: Self::LISTENS - Self::RELEASES,
        reports: Self::REPORTS - Self::RELEASES,
    };

    /// A start beside a flight processor that runs.
    pub(super) const fn at(now: Nanos) -> Self {
        Self {
            opens: now + Self::OPENS,
            listens: now + Self::LISTENS,
            reports: now + Self::REPORTS,
        }
    }
}
