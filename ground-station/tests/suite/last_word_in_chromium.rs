//! The operator's last word in a real browser: three pages in three browsers, each behind a proxy
//! that freezes, delays, breaks and resets its line between keys and reloads.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use tokio::time::sleep;

use crate::browser::Browser;
use crate::last_word::{Ended, Numbers, speed};
use crate::local_station::{LocalStation, Told};
use crate::stalling_proxy::StallingProxy;

const EVENTS: usize = 1_000;
const PAGES: usize = 3;
/// The page whose person never asks to steer.
const LOOKS_ON: usize = 2;

/// Notes in the page which page steered, one after the other.
const NOTE: &str = "globalThis.steered = []; globalThis.shown = line.onState; \
                    line.onState = (state) => { \
                        if (steered.at(-1) !== state.steering) steered.push(state.steering); \
                        shown(state); }; true";

/// A browser with one page, behind a proxy.
struct Tab {
    browser: Browser,
    proxy: StallingProxy,
    /// When the proxy carries everything again.
    until: Option<Instant>,
    /// Whether a stop was ordered since the page was last seen to know of all its stops.
    has_stopped: bool,
}

impl Tab {
    async fn open(station: &LocalStation, name: &str) -> Self {
        let profile = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_dir_all(&profile);
        std::fs::create_dir_all(&profile).unwrap();
        let proxy = StallingProxy::to(station.at);
        let browser = Browser::open(&profile, &format!("http://{}/", proxy.at)).await;
        let mut tab = Self { browser, proxy, until: None, has_stopped: false };
        tab.is_loaded().await;
        tab
    }

    async fn is_loaded(&mut self) {
        let loaded = "typeof line !== 'undefined' && typeof steers !== 'undefined' && \
                      line.state !== null";
        self.browser.wait_for(loaded).await;
        self.browser.evaluate(NOTE).await;
    }

    async fn number(&mut self) -> u64 {
        self.browser.evaluate("PAGE").await.as_u64().unwrap()
    }

    async fn steered(&mut self) -> Vec<Option<u64>> {
        let steered = self.browser.evaluate("steered").await;
        steered.as_array().unwrap().iter().map(serde_json::Value::as_u64).collect()
    }

    /// As long as a stop has not arrived, the page says so.
    async fn tells_of_its_stop(&mut self) {
        let is_silent = "line.stop !== null && !at('unheard').checkVisibility()";
        if self.browser.evaluate(is_silent).await == true {
            // The page looks four times a second.
            sleep(Duration::from_millis(500)).await;
            assert_eq!(self.browser.evaluate(is_silent).await, false);
        }
    }
}

struct BrowserScript {
    numbers: Numbers,
    station: LocalStation,
    tabs: Vec<Tab>,
    ended: Ended,
}

impl BrowserScript {
    async fn begin() -> Self {
        let station = LocalStation::start().await;
        let mut tabs = Vec::new();
        for n in 0..PAGES {
            tabs.push(Tab::open(&station, &format!("last-word-{n}")).await);
            // The first is the pilot's before the next is opened.
            tabs[0].browser.wait_for("steers").await;
        }
        let first = tabs[0].number().await;
        let (orders, told, seen, steered, asked) = Default::default();
        let ended = Ended { orders, told, seen, steered, asked, first };
        Self { numbers: Numbers(32), station, tabs, ended }
    }

    async fn step(&mut self) {
        let place = self.numbers.below(PAGES as u64) as usize;
        let event = self.numbers.below(20);
        let stall = Duration::from_millis(50 + self.numbers.below(3_000));
        let delay = Duration::from_millis(self.numbers.below(900));
        let tab = &mut self.tabs[place];
        match event {
            0..=6 => {
                let speed = speed(self.ended.orders.len());
                let give =
                    format!("order('explore', {{ speed: {speed} }}, performance.now()); true");
                tab.browser.evaluate(&give).await;
                // The act lies before this moment, so that its age is no less.
                self.ended.orders.push(Instant::now());
            }
            7..=8 => {
                tab.browser.press("Escape").await;
                tab.has_stopped = true;
            }
            9..=10 if place != LOOKS_ON => {
                *self.ended.asked.entry(tab.number().await).or_default() += 1;
                tab.browser.evaluate("at('steer').click(); true").await;
            }
            9..=11 if tab.until.is_none() => {
                self.ended.steered.push(tab.steered().await);
                tab.browser.evaluate("globalThis.isOld = true").await;
                tab.browser.call("Page.reload", serde_json::json!({})).await;
                tab.browser.wait_for("typeof isOld === 'undefined'").await;
                tab.is_loaded().await;
            }
            17 => {
                tab.proxy.delay(delay);
                tab.until = Some(Instant::now() + stall);
            }
            18 => tab.proxy.reset(),
            19 => tab.proxy.halve(),
            _ => {
                tab.proxy.freeze();
                tab.until = Some(Instant::now() + stall);
            }
        }
        sleep(Duration::from_millis(self.numbers.below(500))).await;
        for tab in &mut self.tabs {
            if tab.until.take_if(|until| *until <= Instant::now()).is_some() {
                tab.proxy.flow();
            }
            tab.tells_of_its_stop().await;
        }
    }

    async fn end(mut self) -> Ended {
        for tab in &mut self.tabs {
            tab.proxy.flow();
            tab.browser.wait_for("line.stop === null && !at('unheard').checkVisibility()").await;
            self.ended.steered.push(tab.steered().await);
        }
        let is_stopped = self.tabs.iter().any(|tab| tab.has_stopped);
        self.ended.told.clone_from(&self.station.log.lock().unwrap());
        let is_told = self.ended.told.iter().any(|(_, told)| *told == Told::Stop);
        assert_eq!(is_stopped, is_told);
        self.ended
    }
}

#[tokio::test]
#[ignore = "needs chromium, and five minutes; UCHAIN_LONG=1 .ci/run test runs it"]
async fn freezes_reloads_and_keys_do_not_take_the_operators_last_word_in_chromium() {
    let mut script = BrowserScript::begin().await;
    for _ in 0..EVENTS {
        script.step().await;
    }
    let ended = script.end().await;
    let orders = ended.no_order_was_late();
    ended.no_page_was_a_pilot_by_accident();
    let stops = ended.told.iter().filter(|(_, told)| *told == Told::Stop).count();
    let given = ended.orders.len();
    println!("{orders} of {given} orders were carried out, and {stops} stops came to the base");
    assert!(orders > 5, "{orders} orders have arrived");
}
