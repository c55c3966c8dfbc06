//! The clock, in the units of the crates.

use units::Instant;

/// The time since boot, by TIM5.
pub(crate) fn now() -> Instant {
    Instant::from_micros(embassy_time::Instant::now().as_micros())
}
