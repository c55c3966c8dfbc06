//! Switching off: the button, the request to the flight processor, and the shutdown
//! (crazyflie2-nrf-firmware, `shutdown.c`, `pm.c`).

use std::fmt;

use crate::soc::Nanos;

/// The chip's tick.
pub(super) const TICK: Nanos = 1_000_000;
/// The flight processor has so many ticks to answer (`TIMEOUT_TICKS`); power goes when more have
/// passed.
const PATIENCE: Nanos = 1_001 * TICK;

/// Whether the flight processor has power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// It has.
    On,
    /// It has not, since then: the chip pulls its reset line first, and then takes the supply.
    Off {
        /// Since when.
        since: Nanos,
        /// Why.
        cause: OffCause,
    },
}

/// Why the flight processor has no power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OffCause {
    /// It let its power go.
    Agreed,
    /// It did not answer the power button in time.
    Unanswered,
    /// The ground ordered it over the air.
    Ordered,
    /// The chip faulted, since a setting of the radio came in Bluetooth mode.
    Bluetooth,
    /// The chip's own firmware has taken the supply.
    Firmware,
}

impl fmt::Display for OffCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Agreed => "the flight processor let its power go",
            Self::Unanswered => "the flight processor did not answer the power button",
            Self::Ordered => "the ground switched it off",
            Self::Firmware => "the radio chip's firmware took the supply",
            Self::Bluetooth => "the radio chip faulted: a setting came in Bluetooth mode",
        })
    }
}

/// The state of affairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shutdown {
    Idle,
    /// The button was pressed, and the flight processor has not yet been asked.
    Pressed,
    /// The flight processor has been asked.
    Asked {
        until: Nanos,
    },
}

impl Shutdown {
    /// When there is something to do; at once is zero.
    pub(super) const fn due(self) -> Nanos {
        match self {
            Self::Idle => Nanos::MAX,
            Self::Pressed => 0,
            Self::Asked { until } => until,
        }
    }

    pub(super) const fn asked(now: Nanos) -> Self {
        Self::Asked { until: tick(now) + PATIENCE }
    }
}

/// The latest tick.
pub(super) const fn tick(now: Nanos) -> Nanos {
    now / TICK * TICK
}
