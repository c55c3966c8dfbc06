//! Bounds the age of what a page asks for, whatever the line between page and station does.
//!
//! # Why a stamp
//! A WebSocket keeps what is written to it. If the line stalls, or the station is suspended, what
//! the page wrote arrives when the line is back, be it after a minute. Page and station have two
//! clocks, which nothing sets to the same time, so the page's own time of an order says nothing.
//!
//! Each state that the station sends therefore carries a *stamp*, the time of the station's clock.
//! A page answers with the stamp of the last state that it has received (`stamp`), and with the
//! time by its own clock from the person's act until the request was written (`held`). Then
//!
//! ```text
//!   station   ──stamp──┐                        ┌── now
//!                       ╲                      ╱
//!   page       act ──────▶ state ──── written ──
//!               └───────── held ────────┘
//! ```
//! - the request was written after the state had come, and the state came after its stamp, so since
//!   the writing there has passed at most `now - stamp`, on the station's clock alone;
//! - the act lies `held` before the writing, on the page's clock alone.
//!
//! So the act is at most **`now - stamp + held`** old. No two clocks are compared, and a line that
//! freezes, delays, doubles or reorders makes the bound only greater, since the stamp is older then.
//! Two pages could make the bound too small: one whose clock runs slow by itself, which a browser's
//! monotonic clock does not do within seconds, and one that lies, which must have the session token
//! first. The price is that the way of the state to the page counts: on a line that takes 0.4 s there
//! and back, orders are refused, and the page says so.
//!
//! # What is refused
//! Everything that is older than [`LIMIT`] is refused, with two exceptions. **A stop is never
//! refused**: motors that are off hurt no person, and a late stop was still meant. A sign of life is
//! not refused, but counts from its stamp, not from its arrival.
//!
//! Each request also has a number, which grows from one request of a page to the next. A page that
//! connects anew has two lines for a moment, and what it wrote first may arrive last; an order whose
//! number is not higher than that of the page's last one is refused.

use serde::Deserialize;
use units::{Duration, Instant};

/// The greatest age of an order that is carried out.
pub const LIMIT: Duration = Duration::from_millis(500);

/// What a page says about the time of a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct Echo {
    /// The stamp of the last state that the page has received, in ms.
    pub stamp: Option<u64>,
    /// The time from the person's act until the request was written, in ms by the page's clock.
    pub held: u64,
    /// The number of the request.
    pub seq: Option<u64>,
}

/// The stamp of a state that is sent now, in ms. It is rounded down, so that it makes nothing
/// younger.
#[must_use]
pub const fn stamp(now: Instant) -> u64 {
    now.as_micros() / 1_000
}

impl Echo {
    /// The moment at which the page was surely alive: when the state was sent that it has since
    /// received. `None` without a stamp, or with one that the station cannot have sent yet.
    #[must_use]
    pub fn seen(self, now: Instant) -> Option<Instant> {
        let stamp = self.stamp.filter(|given| *given <= stamp(now))?;
        Some(Instant::from_millis(stamp))
    }

    /// The greatest age that the person's act can have; `None` where nothing bounds it.
    #[must_use]
    pub fn age(self, now: Instant) -> Option<Duration> {
        let on_the_way = now.since(self.seen(now)?).as_micros();
        let held = self.held.saturating_mul(1_000);
        Some(Duration::from_micros(on_the_way.saturating_add(held)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn echo(stamp: u64, held: u64) -> Echo {
        Echo { stamp: Some(stamp), held, seq: None }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 1_024, failure_persistence: None, ..ProptestConfig::default() })]

        /// Whatever each way takes, and however the page's clock is set, the bound is no less than
        /// the true age.
        #[test]
        fn an_act_is_never_older_than_its_bound(
            sent_us in 0_u64..10_000_000,
            to_page_us in 0_u64..5_000_000,
            // The person acts before or after the state has come.
            act_us in -3_000_000_i64..3_000_000,
            until_written_us in 0_i64..3_000_000,
            to_station_us in 0_u64..60_000_000,
            page_clock_us in 0_i64..1_000_000_000,
        ) {
            let came = (sent_us + to_page_us) as i64;
            let acted = came + act_us;
            let written = came.max(acted) + until_written_us;
            let arrived = written + to_station_us as i64;
            // The page reads its own clock, and rounds up to whole milliseconds.
            let held_us = (page_clock_us + written) - (page_clock_us + acted);
            let held = u64::try_from(held_us).unwrap().div_ceil(1_000);
            let of = echo(stamp(Instant::from_micros(sent_us)), held);
            let bound = of.age(Instant::from_micros(arrived as u64)).unwrap();
            prop_assert!(i128::from(bound.as_micros()) >= i128::from(arrived - acted));
        }
    }

    #[test]
    fn an_order_at_once_on_a_good_line_is_young() {
        let age = echo(10_000, 2).age(Instant::from_millis(10_130)).unwrap();
        assert_eq!(age, Duration::from_millis(132));
        assert!(age < LIMIT);
    }

    #[test]
    fn nothing_bounds_the_age_without_a_stamp_or_with_one_from_the_future() {
        let now = Instant::from_millis(10_000);
        assert_eq!(Echo::default().age(now), None);
        assert_eq!(echo(10_001, 0).age(now), None);
        assert_eq!(echo(u64::MAX, u64::MAX).age(now), None);
        assert!(echo(10_000, u64::MAX).age(now).unwrap() > LIMIT);
    }
}
