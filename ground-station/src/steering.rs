//! Knows the open pages, which of them steers, and which of their requests are heeded.
//!
//! # Who steers
//! One page steers at a time; every page may stop. A page begins to steer in two cases only:
//! - **its person asks for it** ([`Pages::take_over`]), or
//! - it is the first page that is opened, and none has ever steered this station.
//!
//! So a page that looks on never becomes the pilot because another page goes. While the pilot's page
//! is closed or silent no page steers, with one page as with ten: the station says nothing to the
//! base, and the head hovers. The pilot's page itself may come back, over a new line too, and steers
//! again; no order is repeated by that. An order from a page that looks on is refused even while
//! no page steers: a key that was pressed on the wrong page must not make it the pilot.
//!
//! Programs that speak to the station by ROS 2 count as one page, [`PageId::PROGRAM`], which no person has
//! opened: they steer only once one of them has asked for it.
//!
//! # Who is there
//! A page is there from the stamp that it has echoed last ([`Echo::seen`]), not from the moment at
//! which its sign of life arrived: what has waited on a frozen line says nothing about now.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::Serialize;
use units::{Duration, Instant};

use crate::freshness::{Echo, LIMIT};

/// The time after which a page of which nothing was seen counts as gone. A page sends a sign of life
/// four times a second; a browser slows the timers of a hidden page down to one a second.
pub const GONE: Duration = Duration::from_millis(1_500);

/// The number of closed pages whose requests are still told from new ones.
const REMEMBERED: usize = 64;

/// The number of a page, which it keeps when it connects anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct PageId(pub u64);

impl PageId {
    /// The programs that speak to the station by ROS 2, which count as one page. No page has this number.
    pub const PROGRAM: Self = Self(0);
}

/// The number of a connection of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LineId(pub u64);

impl LineId {
    /// The way that programs speak by. Lines to pages count from 1.
    pub const PROGRAM: Self = Self(0);
}

/// What is known of a page.
#[derive(Clone, Debug, Default)]
struct KnownPage {
    lines: BTreeSet<LineId>,
    /// Whether the page was opened by a person, and did not come back by itself.
    is_new: bool,
    /// The latest stamp that it has echoed.
    seen: Option<Instant>,
    /// The highest number of its requests, of its orders, and of its stops.
    last: Option<u64>,
    order: Option<u64>,
    stop: Option<u64>,
}

/// What the station has heard of an open page, so that the page knows what has arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Receipt {
    page: PageId,
    /// The highest number of a request.
    last: Option<u64>,
    /// The highest number of a stop.
    stop: Option<u64>,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejected {
    /// The person's act may be so old.
    Old(Duration),
    /// Nothing bounds the age of the person's act.
    Undated,
    /// A later request of the same page has arrived before.
    Overtaken,
    /// Another page steers.
    AnotherSteers,
    /// No page steers.
    NobodySteers,
}

impl fmt::Display for Rejected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Old(age) => {
                write!(f, "it arrived {:.1} s late. Give it again.", age.as_secs_f32())
            }
            Self::Undated => f.write_str("it does not say when it was given. Load the page anew."),
            Self::Overtaken => f.write_str("a later one arrived before it."),
            Self::AnotherSteers => f.write_str("another page steers. Take over first."),
            Self::NobodySteers => f.write_str("nobody steers. Take over first."),
        }
    }
}

/// The pages.
#[derive(Clone, Debug, Default)]
pub struct Pages {
    pages: BTreeMap<PageId, KnownPage>,
    /// The last page that steered.
    steers: Option<PageId>,
}

impl Pages {
    /// Takes a new line to a page; `is_new` where a person has opened the page, and it is not one
    /// that has lost its line.
    pub fn open(&mut self, line: LineId, id: PageId, is_new: bool) {
        let page = self.pages.entry(id).or_default();
        page.is_new = is_new && page.lines.is_empty() && page.last.is_none();
        page.lines.insert(line);
    }

    /// Forgets a line that was closed. A page without a line is not there.
    pub fn close(&mut self, line: LineId) {
        for page in self.pages.values_mut() {
            if page.lines.remove(&line) && page.lines.is_empty() {
                page.seen = None;
            }
        }
        let closed = |page: &KnownPage| page.lines.is_empty();
        if self.pages.values().filter(|page| closed(page)).count() > REMEMBERED {
            self.pages.retain(|_, page| !closed(page));
        }
    }

    /// Takes a request of a page as a sign of life, whatever it is.
    pub fn hear(&mut self, now: Instant, id: PageId, echo: Echo) {
        let page = self.pages.entry(id).or_default();
        page.last = page.last.max(echo.seq);
        let Some(seen) = echo.seen(now) else { return };
        page.seen = page.seen.max(Some(seen));
        if self.steers.is_none() && page.is_new && now.since(seen) < GONE {
            self.steers = Some(id);
        }
    }

    /// Whether this stop of a page is one that the station has not had yet. A page sends a stop again
    /// until it knows that it has arrived.
    pub fn take_stop(&mut self, id: PageId, echo: Echo) -> bool {
        let page = self.pages.entry(id).or_default();
        if echo.seq.is_some() && echo.seq <= page.stop {
            return false;
        }
        page.stop = page.stop.max(echo.seq);
        true
    }

    /// Decides on a request that must be fresh. Returns until when it may be carried out.
    ///
    /// # Errors
    /// Why it is refused.
    pub fn judge(&mut self, now: Instant, id: PageId, echo: Echo) -> Result<Instant, Rejected> {
        let page = self.pages.entry(id).or_default();
        if echo.seq.is_some() && echo.seq <= page.order {
            return Err(Rejected::Overtaken);
        }
        page.order = page.order.max(echo.seq);
        let age = echo.age(now).ok_or(Rejected::Undated)?;
        if age >= LIMIT {
            return Err(Rejected::Old(age));
        }
        Ok(Instant::from_micros(now.as_micros() + LIMIT.as_micros() - age.as_micros()))
    }

    /// Decides on a request of which also only the pilot's page may make one.
    ///
    /// # Errors
    /// Why it is refused.
    pub fn judge_order(
        &mut self,
        now: Instant,
        id: PageId,
        echo: Echo,
    ) -> Result<Instant, Rejected> {
        let until = self.judge(now, id, echo)?;
        match self.steering(now) {
            Some(pilot) if pilot == id => Ok(until),
            Some(_) => Err(Rejected::AnotherSteers),
            None => Err(Rejected::NobodySteers),
        }
    }

    /// Lets a page steer from now on, because its person asks for it.
    pub const fn take_over(&mut self, page: PageId) {
        self.steers = Some(page);
    }

    /// The page that steers; `None` where it is closed or silent.
    #[must_use]
    pub fn steering(&self, now: Instant) -> Option<PageId> {
        let id = self.steers?;
        let seen = self.pages.get(&id)?.seen?;
        (now.since(seen) < GONE).then_some(id)
    }

    /// What was heard of each open page.
    #[must_use]
    pub fn heard(&self) -> Vec<Receipt> {
        let open = self.pages.iter().filter(|(_, page)| !page.lines.is_empty());
        open.map(|(id, page)| Receipt { page: *id, last: page.last, stop: page.stop }).collect()
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

    fn echo(stamp: u64) -> Echo {
        Echo { stamp: Some(stamp), held: 0, seq: None }
    }

    fn numbered(stamp: u64, seq: u64) -> Echo {
        Echo { seq: Some(seq), ..echo(stamp) }
    }

    /// Two pages, of which the first steers.
    fn two() -> Pages {
        let mut pages = Pages::default();
        pages.open(LineId(1), ONE, true);
        pages.open(LineId(2), TWO, true);
        pages.hear(at(0), ONE, echo(0));
        pages.hear(at(10), TWO, echo(10));
        assert_eq!(pages.steering(at(20)), Some(ONE));
        pages
    }

    #[test]
    fn the_first_page_steers_until_it_is_closed_or_another_takes_over() {
        let mut pages = two();
        pages.take_over(TWO);
        assert_eq!(pages.steering(at(30)), Some(TWO));
        pages.close(LineId(2));
        assert_eq!(pages.steering(at(40)), None);
    }

    #[test]
    fn a_page_that_hangs_steers_no_more() {
        let pages = two();
        assert_eq!(pages.steering(at(1_499)), Some(ONE));
        assert_eq!(pages.steering(at(1_500)), None);
    }

    #[test]
    fn a_page_that_looks_on_never_steers_because_the_pilots_page_is_gone() {
        let mut pages = two();
        pages.close(LineId(1));
        for ms in (20..10_000).step_by(250) {
            pages.hear(at(ms), TWO, echo(ms));
            assert_eq!(pages.steering(at(ms)), None);
        }
        assert_eq!(pages.judge_order(at(9_770), TWO, echo(9_770)), Err(Rejected::NobodySteers));
        // A page that is opened then looks on as well.
        pages.open(LineId(3), PageId(3), true);
        pages.hear(at(10_000), PageId(3), echo(10_000));
        assert_eq!(pages.steering(at(10_000)), None);
        pages.take_over(TWO);
        assert_eq!(pages.steering(at(10_000)), Some(TWO));
    }

    #[test]
    fn the_pilots_page_steers_again_when_it_comes_back_over_a_new_line() {
        let mut pages = two();
        pages.open(LineId(3), ONE, false);
        pages.close(LineId(1));
        assert_eq!(pages.steering(at(100)), Some(ONE), "its other line is open");
        pages.close(LineId(3));
        assert_eq!(pages.steering(at(100)), None);
        pages.open(LineId(4), ONE, false);
        assert_eq!(pages.steering(at(100)), None, "nothing was seen of it yet");
        pages.hear(at(5_000), ONE, echo(4_990));
        assert_eq!(pages.steering(at(5_000)), Some(ONE));
    }

    /// A station that was restarted knows none of the pages that come back to it.
    #[test]
    fn a_page_that_comes_back_to_a_station_that_does_not_know_it_looks_on() {
        let mut pages = Pages::default();
        pages.open(LineId(1), TWO, false);
        pages.hear(at(100), TWO, echo(100));
        assert_eq!(pages.steering(at(100)), None);
    }

    #[test]
    fn signs_of_life_that_have_waited_say_nothing_about_now() {
        let mut pages = two();
        pages.hear(at(20_000), ONE, echo(400));
        assert_eq!(pages.steering(at(20_000)), None);
        let mut pages = Pages::default();
        pages.open(LineId(1), ONE, true);
        pages.hear(at(20_000), ONE, Echo::default());
        pages.hear(at(20_000), ONE, echo(400));
        assert_eq!(pages.steering(at(20_000)), None);
    }

    #[test]
    fn an_order_is_refused_from_half_a_second_on() {
        let mut pages = two();
        assert_eq!(pages.judge_order(at(499), ONE, echo(0)), Ok(at(500)));
        let old = Duration::from_millis(500);
        assert_eq!(pages.judge_order(at(500), ONE, echo(0)), Err(Rejected::Old(old)));
        let held = Echo { held: 400, ..echo(200) };
        assert_eq!(pages.judge_order(at(300), ONE, held), Err(Rejected::Old(old)));
        let undated = pages.judge_order(at(300), ONE, Echo::default());
        assert_eq!(undated, Err(Rejected::Undated));
        assert_eq!(pages.judge_order(at(300), TWO, echo(290)), Err(Rejected::AnotherSteers));
    }

    #[test]
    fn an_order_that_a_later_one_has_overtaken_is_refused() {
        let mut pages = two();
        assert!(pages.judge_order(at(300), ONE, numbered(250, 7)).is_ok());
        for late in [6, 7] {
            let judged = pages.judge_order(at(310), ONE, numbered(250, late));
            assert_eq!(judged, Err(Rejected::Overtaken));
        }
        assert!(pages.judge_order(at(310), ONE, numbered(250, 8)).is_ok());
    }

    #[test]
    fn a_stop_of_any_age_is_taken_once() {
        let mut pages = two();
        assert!(pages.take_stop(ONE, numbered(0, 9)));
        assert!(!pages.take_stop(ONE, numbered(0, 9)), "it was sent again");
        assert!(pages.take_stop(ONE, numbered(0, 10)));
        assert!(pages.take_stop(ONE, Echo::default()), "a stop without a number always counts");
        assert!(pages.take_stop(TWO, numbered(0, 1)));
    }

    #[test]
    fn a_page_is_told_what_was_heard_of_it() {
        let mut pages = two();
        pages.hear(at(20), ONE, numbered(10, 3));
        pages.take_stop(ONE, numbered(10, 3));
        pages.close(LineId(2));
        let heard = pages.heard();
        assert_eq!(heard, [Receipt { page: ONE, last: Some(3), stop: Some(3) }]);
    }

    #[test]
    fn closed_pages_are_not_kept_without_end() {
        let mut pages = two();
        for n in 10..1_000 {
            pages.open(LineId(n), PageId(n), true);
            pages.close(LineId(n));
        }
        assert!(pages.pages.len() <= REMEMBERED + 2);
        assert_eq!(pages.steering(at(20)), Some(ONE));
    }
}
