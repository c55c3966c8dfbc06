//! Time, as the crates count it.

use units::Instant;

/// Since boot, by TIM5.
pub(crate) fn now() -> Instant {
    Instant::from_micros(embassy_time::Instant::now().as_micros())
}
