//! Knows the open pages, and which of them steers. One page steers at a time; every page may stop.

use std::collections::BTreeMap;

use units::{Duration, Instant};

/// The time after which a page that has sent nothing counts as gone. A page sends a sign of life
/// four times a second; a browser slows the timers of a hidden page down to one a second.
pub const GONE: Duration = Duration::from_millis(1_500);

/// The number of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub struct PageId(pub u64);

/// The open pages.
#[derive(Clone, Debug, Default)]
pub struct Pages {
    heard: BTreeMap<PageId, Instant>,
    steers: Option<PageId>,
}

impl Pages {
    /// Takes a sign of life of a page. Where no page steers, this one does from now on.
    pub fn hear(&mut self, now: Instant, page: PageId) {
        self.heard.insert(page, now);
        if self.steering(now).is_none() {
            self.steers = Some(page);
        }
    }

    /// Forgets a page that was closed.
    pub fn close(&mut self, page: PageId) {
        self.heard.remove(&page);
    }

    /// Lets a page steer from now on, in place of another.
    pub const fn take_over(&mut self, page: PageId) {
        self.steers = Some(page);
    }

    /// The page that steers; `None` where it is closed or silent.
    #[must_use]
    pub fn steering(&self, now: Instant) -> Option<PageId> {
        let page = self.steers?;
        let heard = self.heard.get(&page)?;
        (now.since(*heard) < GONE).then_some(page)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: PageId = PageId(1);
    const TWO: PageId = PageId(2);

    fn at(ms: u64) -> Instant {
        Instant::from_millis(ms)
    }

    #[test]
    fn the_first_page_steers_until_it_is_closed_or_another_takes_over() {
        let mut pages = Pages::default();
        pages.hear(at(0), ONE);
        pages.hear(at(10), TWO);
        assert_eq!(pages.steering(at(20)), Some(ONE));
        pages.take_over(TWO);
        assert_eq!(pages.steering(at(30)), Some(TWO));
        pages.close(TWO);
        assert_eq!(pages.steering(at(40)), None);
    }

    #[test]
    fn a_page_that_hangs_steers_no_more() {
        let mut pages = Pages::default();
        pages.hear(at(0), ONE);
        assert_eq!(pages.steering(at(1_499)), Some(ONE));
        assert_eq!(pages.steering(at(1_500)), None);
    }
}
