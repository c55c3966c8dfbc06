//! Switching off: the button, the request to the flight processor, and the shutdown
//! (crazyflie2-nrf-firmware, `shutdown.c`, `pm.c`).

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
        /// The flight processor let it go; otherwise it did not answer in time.
        agreed: bool,
    },
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
