//! Tells the time since the station's beginning; the time that the machine slept counts.
//!
//! The age of an order is read from this clock. The monotonic clock of the machine stands still
//! while the machine sleeps (Linux: `CLOCK_MONOTONIC`), so that an order from before the sleep would
//! look young after it. The wall clock goes on, but a person or a time server may set it. The clock
//! therefore follows the monotonic one, and where the wall clock has gone on by `SLEEP` more, it
//! takes the machine to have slept that long. A wall clock that is set forward makes what waits
//! look older than it is, and an older order is refused; one that is set back changes nothing.

use std::time::{Duration, SystemTime};

/// The least difference of the two clocks between two readings that counts as sleep. The station
/// reads the clock a hundred times a second; two readings of two clocks differ by far less.
const SLEEP: Duration = Duration::from_millis(50);

/// The clock of a station.
#[derive(Debug)]
pub struct Clock {
    read: (std::time::Instant, SystemTime),
    now: Duration,
}

impl Clock {
    /// A clock that begins now.
    #[must_use]
    pub fn begin() -> Self {
        Self { read: (std::time::Instant::now(), SystemTime::now()), now: Duration::ZERO }
    }

    /// The time since the beginning.
    pub fn now(&mut self) -> units::Instant {
        let (monotonic, wall) = (std::time::Instant::now(), SystemTime::now());
        let gone_by = monotonic.saturating_duration_since(self.read.0);
        // An error says that the wall clock was set back.
        self.now += step(gone_by, wall.duration_since(self.read.1).ok());
        self.read = (monotonic, wall);
        units::Instant::from_micros(u64::try_from(self.now.as_micros()).unwrap_or(u64::MAX))
    }
}

/// The time between two readings, by what each of the two clocks says.
fn step(monotonic: Duration, wall: Option<Duration>) -> Duration {
    match wall {
        Some(wall) if wall.saturating_sub(monotonic) >= SLEEP => wall,
        _ => monotonic,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sleep_of_the_machine_counts() {
        let ms = Duration::from_millis;
        assert_eq!(step(ms(10), Some(ms(10))), ms(10));
        assert_eq!(step(ms(10), Some(ms(3_600_000))), ms(3_600_000));
        assert_eq!(step(ms(10), Some(ms(59))), ms(10), "not yet a sleep");
        assert_eq!(step(ms(10), Some(ms(2))), ms(10), "the wall clock was slowed down");
        assert_eq!(step(ms(10), None), ms(10), "the wall clock was set back");
    }

    #[test]
    fn the_clock_never_goes_back() {
        let mut clock = Clock::begin();
        let readings: Vec<_> = (0..100).map(|_| clock.now()).collect();
        assert!(readings.is_sorted());
    }
}
