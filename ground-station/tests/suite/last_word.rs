//! The operator's last word: whatever the lines between pages and station do, no order that is older
//! than half a second is carried out, no stop is lost without being told, and no page becomes the
//! pilot by accident.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use futures_util::future::join_all;
use serde_json::json;
use tokio::time::sleep;

use crate::local_station::{LocalStation, Told};
use crate::resilient_page::{ResilientPage, Seen};
use crate::stalling_proxy::StallingProxy;

/// The greatest age of an order that the base may be told, and what a busy machine may take between
/// the station's look at its clock and its writing.
const LIMIT: Duration = Duration::from_millis(500 + 100);

/// The number of scripts, and of the events of each.
const SCRIPTS: u64 = 20;
const EVENTS: u64 = 50;

/// A stream of numbers that follow from a seed (SplitMix64, Steele et al. 2014).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }
}

/// The pages of the persons in a script: the first is opened first and steers, the second asks to
/// steer now and then, the third only looks on.
const PAGES: usize = 3;
const LOOKS_ON: usize = 2;

/// A script: a station, and pages each behind a proxy of its own.
struct Script {
    numbers: Numbers,
    station: LocalStation,
    proxies: Vec<StallingProxy>,
    pages: Vec<ResilientPage>,
    /// When each proxy carries everything again.
    until: Vec<Option<Instant>>,
    /// When each order was given; its speed is its number in ten thousandths of a m/s, from
    /// [`SLOWEST`] on.
    orders: Vec<Instant>,
    /// The number of times that each page has asked to steer, by the page's number.
    asked: Vec<(u64, usize)>,
    /// What was seen at pages that were closed, and the stops of which they said that they had not
    /// arrived.
    closed: Vec<Seen>,
    opened: u64,
}

const SLOWEST: f32 = 0.05;

pub(crate) fn speed(order: usize) -> f32 {
    SLOWEST + order as f32 * 1e-4
}

impl Script {
    async fn begin(seed: u64) -> Self {
        let station = LocalStation::start().await;
        let proxies: Vec<_> = (0..PAGES).map(|_| StallingProxy::to(station.at)).collect();
        let mut script = Self {
            numbers: Numbers(seed),
            station,
            proxies,
            pages: Vec::new(),
            until: vec![None; PAGES],
            orders: Vec::new(),
            asked: Vec::new(),
            closed: Vec::new(),
            opened: 0,
        };
        for place in 0..PAGES {
            let page = script.open(place);
            page.wait_for("pilot", |seen| !seen.state["steering"].is_null()).await;
            script.pages.push(page);
        }
        script
    }

    fn open(&mut self, place: usize) -> ResilientPage {
        self.opened += 1;
        self.asked.push((self.opened, 0));
        ResilientPage::open(self.proxies[place].at, &self.station.session, self.opened)
    }

    /// One event, at any of the pages, and a short wait after it.
    async fn step(&mut self) {
        let place = self.numbers.below(PAGES as u64) as usize;
        match self.numbers.below(20) {
            0..=6 => self.explore(place),
            7..=8 => self.pages[place].stop(),
            9..=10 if place != LOOKS_ON => self.steer(place),
            9..=11 => self.close_and_open(place),
            12..=15 => self.stall(place, StallingProxy::freeze),
            16 => self.stall(place, StallingProxy::freeze_up),
            17 => {
                let delay = Duration::from_millis(self.numbers.below(900));
                self.stall(place, |proxy| proxy.delay(delay));
            }
            18 => self.proxies[place].reset(),
            _ => self.proxies[place].halve(),
        }
        sleep(Duration::from_millis(self.numbers.below(600))).await;
        self.mend(|until| until <= Instant::now());
    }

    fn explore(&mut self, place: usize) {
        let request =
            json!({ "do": "order", "order": "explore", "speed": speed(self.orders.len()) });
        self.orders.push(Instant::now());
        self.pages[place].ask(request);
    }

    fn steer(&mut self, place: usize) {
        let page = self.pages[place].page;
        self.asked[page as usize - 1].1 += 1;
        self.pages[place].ask(json!({ "do": "steer" }));
    }

    fn close_and_open(&mut self, place: usize) {
        let page = self.open(place);
        let closed = std::mem::replace(&mut self.pages[place], page);
        self.closed.push(closed.seen().clone());
    }

    fn stall(&mut self, place: usize, how: impl FnOnce(&StallingProxy)) {
        how(&self.proxies[place]);
        let time = Duration::from_millis(50 + self.numbers.below(3_000));
        self.until[place] = Some(Instant::now() + time);
    }

    fn mend(&mut self, is_due: impl Fn(Instant) -> bool) {
        for (proxy, until) in self.proxies.iter().zip(&mut self.until) {
            if until.take_if(|until| is_due(*until)).is_some() {
                proxy.flow();
            }
        }
    }

    /// With all lines mended, every page that is open learns of its stop.
    async fn end(mut self) -> Ended {
        self.mend(|_| true);
        for page in &self.pages {
            page.wait_for("answer to its stop", |seen| seen.unheard.is_none()).await;
        }
        let mut seen = self.closed;
        seen.extend(self.pages.iter().map(|page| page.seen().clone()));
        let told = self.station.log.lock().unwrap().clone();
        let steered = seen.iter().map(|seen| seen.steered.clone()).collect();
        let asked = self.asked.into_iter().collect();
        Ended { orders: self.orders, told, seen, steered, asked, first: 1 }
    }
}

/// What a script leaves behind.
pub(crate) struct Ended {
    /// When each order was given.
    pub(crate) orders: Vec<Instant>,
    pub(crate) told: Vec<(Instant, Told)>,
    /// What was seen at each page.
    pub(crate) seen: Vec<Seen>,
    /// The pages that steered, one after the other, as each page has seen it.
    pub(crate) steered: Vec<Vec<Option<u64>>>,
    /// How often each page has asked to steer, by its number.
    pub(crate) asked: BTreeMap<u64, usize>,
    /// The number of the page that was opened first.
    pub(crate) first: u64,
}

impl Ended {
    /// No order that is older than half a second was carried out. Returns how many were.
    pub(crate) fn no_order_was_late(&self) -> usize {
        let told = self.told.iter().filter_map(|(at, told)| match told {
            Told::Speed(told) => Some((*at, *told)),
            Told::Stop => None,
        });
        let mut carried_out = 0;
        for (at, told) in told {
            let order = ((told - SLOWEST) / 1e-4).round() as usize;
            let age = at.saturating_duration_since(self.orders[order]);
            assert!(age <= LIMIT, "order {order} was carried out {age:?} after it was given");
            carried_out += 1;
        }
        carried_out
    }

    /// A page that no longer says that its stop has not arrived has seen a state with the stop, and
    /// the base was told. Returns the number of stops that were answered so.
    fn no_stop_was_lost(&self) -> usize {
        let heard: Vec<_> = self.seen.iter().flat_map(|seen| &seen.heard_stops).collect();
        assert!(heard.iter().all(|stop| stop.is_object()), "{heard:#?}");
        let is_told = self.told.iter().any(|(_, told)| *told == Told::Stop);
        assert!(is_told || heard.is_empty());
        for seen in &self.seen {
            let known = seen.heard_stops.len() + usize::from(seen.unheard.is_some());
            assert!(seen.stops == 0 || known > 0, "a stop is neither heard nor told: {seen:#?}");
        }
        heard.len()
    }

    /// A page steers because it was the first, or once for each time that its person has asked.
    pub(crate) fn no_page_was_a_pilot_by_accident(&self) {
        for steered in &self.steered {
            let mut pilot = None;
            let mut became: BTreeMap<u64, usize> = BTreeMap::new();
            for steers in steered.iter().flatten() {
                if pilot != Some(*steers) {
                    *became.entry(*steers).or_default() += 1;
                }
                pilot = Some(*steers);
            }
            for (page, became) in became {
                let asked = self.asked.get(&page).copied().unwrap_or_default();
                let may = asked + usize::from(page == self.first);
                assert!(
                    became <= may,
                    "page {page} steered {became} times, and asked {asked} times"
                );
            }
        }
    }
}

async fn play(seed: u64) -> Ended {
    let mut script = Script::begin(seed).await;
    for _ in 0..EVENTS {
        script.step().await;
    }
    script.end().await
}

#[tokio::test]
async fn of_1000_freezes_closings_and_keys_none_takes_the_operators_last_word() {
    let ended = join_all((1..=SCRIPTS).map(play)).await;
    let (mut orders, mut stops) = (0, 0);
    for ended in &ended {
        orders += ended.no_order_was_late();
        stops += ended.no_stop_was_lost();
        ended.no_page_was_a_pilot_by_accident();
    }
    let given: usize = ended.iter().map(|ended| ended.orders.len()).sum();
    println!("{orders} of {given} orders were carried out, and {stops} stops were answered");
    // The scripts would show nothing if nothing arrived.
    assert!(orders > 20 && stops > 20, "{orders} orders and {stops} stops have arrived");
}
