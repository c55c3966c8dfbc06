//! What happens at each step of a mission where the line of the pilot's page freezes, delays, breaks
//! in the middle of a frame and is reset, with one to three pages open.

use std::time::Duration;

use futures_util::future::join_all;
use serde_json::Value;
use sim_harness::serve::Event;
use tokio::time::sleep;
use units::{MetresPerSecond, Order};

use crate::browser::Browser;
use crate::page_client::session;
use crate::resilient_page::ResilientPage;
use crate::simulated_chain::SimulatedChain;
use crate::stalling_proxy::StallingProxy;
use crate::station_process::StationProcess;
use crate::steps::{
    EXPLORE, HOLD, Key, RECALL, RIGHT, SPEED, STEPS, STOP, Step, browse, has_taken, way,
};

/// An order of which it is seen whether it was carried out: no other has its speed.
const LATE: Key = Key("e", r#"{"do":"order","order":"explore","speed":0.3}"#);
const LATE_SPEED: MetresPerSecond = MetresPerSecond(0.3);

/// The page of the pilot, at the far end of the proxy.
enum Pilot {
    Line(ResilientPage),
    Browser(Box<Browser>),
}

impl Pilot {
    async fn press(&mut self, Key(key, request): Key) {
        match self {
            Self::Line(page) if key == STOP.0 => page.stop(),
            Self::Line(page) => page.ask(serde_json::from_str(request).unwrap()),
            Self::Browser(browser) => browser.press(key).await,
        }
    }

    /// Sets the speed of the next order to explore, which a request of a line has in itself.
    async fn set_speed(&mut self, speed: f32) {
        if let Self::Browser(browser) = self {
            browser.evaluate(&format!("at('speed').value = '{speed}'; true")).await;
        }
    }

    /// The last state that has come over the line.
    async fn state(&mut self) -> Value {
        match self {
            Self::Line(page) => page.seen().state.clone(),
            Self::Browser(browser) => {
                let text = browser.evaluate("JSON.stringify(line.state)").await;
                serde_json::from_str(text.as_str().unwrap()).unwrap()
            }
        }
    }

    /// Whether the page says that a stop has not arrived; a browser says so in large letters.
    async fn says_that_the_stop_has_not_arrived(&mut self) -> bool {
        match self {
            Self::Line(page) => page.seen().unheard.is_some(),
            Self::Browser(browser) => {
                let said = "document.getElementById('unheard').checkVisibility() && \
                            parseFloat(getComputedStyle(at('unheard')).fontSize) > 20 && \
                            at('unheard').innerText.includes('THE STOP HAS NOT ARRIVED')";
                browser.evaluate(said).await == true
            }
        }
    }

    /// Whether the page says that an order did not go out, was refused, or may be lost.
    async fn says_what_became_of_the_order(&mut self) -> bool {
        match self {
            Self::Line(page) => {
                let seen = page.seen();
                seen.not_sent > 0 || seen.state["refused"].is_object()
            }
            Self::Browser(browser) => {
                let said = "[at('warning'), at('refused')].some((e) => e.checkVisibility())";
                browser.evaluate(said).await == true
            }
        }
    }

    async fn wait_for(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) {
        let mut last = Value::Null;
        for _ in 0..1_200 {
            last = self.state().await;
            if !last.is_null() && is_it(&last) {
                return;
            }
            sleep(Duration::from_millis(50)).await;
        }
        panic!("within a minute there was no {what}: {last:#}");
    }
}

/// A mission whose pilot's line stalls, and the pages that look on over lines of their own.
struct Stalled {
    step: Step,
    chain: SimulatedChain,
    _station: StationProcess,
    proxy: StallingProxy,
    pilot: Pilot,
    lookers: Vec<ResilientPage>,
}

impl Stalled {
    async fn begin(step: Step, pages: usize, in_browser: bool) -> Self {
        let chain = SimulatedChain::at_speed(step.scenario(), SPEED);
        let station = StationProcess::start(&chain.address(), &[]);
        let proxy = StallingProxy::to(station.page);
        let token = session(station.page);
        let mut pilot = if in_browser {
            Pilot::Browser(Box::new(browse(&format!("stalled-{step:?}-{pages}"), proxy.at).await))
        } else {
            Pilot::Line(ResilientPage::open(proxy.at, &token, 1))
        };
        pilot.wait_for("pilot", |state| !state["steering"].is_null()).await;
        let open = |page| ResilientPage::open(station.page, &token, page as u64);
        let lookers = (2..=pages).map(open).collect();
        Self { step, chain, _station: station, proxy, pilot, lookers }
    }

    /// Flies up to the step.
    async fn reach(&mut self) {
        let drones = self.step.scenario().drones.flying();
        if self.step == Step::Connecting {
            return self.pilot.wait_for("base", |state| state["hears_base"] == true).await;
        }
        let all = |state: &Value| state["drones"].as_array().unwrap().len() == drones;
        self.pilot.wait_for("chain", all).await;
        match self.step {
            Step::Connecting | Step::Checklist => {}
            Step::Exploring => self.explore(0.5).await,
            Step::Choosing => {
                self.explore(0.5).await;
                self.pilot.press(RIGHT).await;
                self.pilot.wait_for("choice", has_taken("branch right")).await;
            }
            Step::RelayLost => {
                self.pilot.press(EXPLORE).await;
                self.pilot.wait_for("relay", |s| s["drones"][1]["airborne"] == true).await;
                self.pilot.press(HOLD).await;
                self.pilot.wait_for("silent relay", |s| s["drones"][1]["silent"] == true).await;
            }
            Step::Recalled => {
                self.explore(0.5).await;
                self.pilot.press(RECALL).await;
                self.pilot.wait_for("recall", has_taken("recall")).await;
            }
            Step::Returning => {
                self.explore(1.0).await;
                self.pilot.press(RECALL).await;
                self.pilot.wait_for("head on its way home", |s| way(s) < 0.9).await;
            }
            Step::Stopping => {
                self.explore(0.5).await;
                self.pilot.press(STOP).await;
                self.pilot.wait_for("stop", |s| s["stop"]["base_s"].is_number()).await;
            }
        }
    }

    async fn explore(&mut self, metres: f64) {
        self.pilot.press(EXPLORE).await;
        self.pilot.wait_for("head under way", |state| way(state) > metres).await;
    }

    /// The page connects again, and its states are those of now.
    async fn is_mended(&mut self) {
        self.proxy.flow();
        let before = self.pilot.state().await["stamp"].as_u64().unwrap();
        let is_new = |state: &Value| state["stamp"].as_u64().unwrap() > before + 1_000;
        self.pilot.wait_for("new state", is_new).await;
    }

    fn was_late_order_carried_out(&self) -> bool {
        self.chain.events().contains(&Event::Ordered(Order::explore(LATE_SPEED)))
    }

    /// An order is given in a freeze that lasts until the base takes its client for gone.
    async fn freezes(&mut self) {
        let before = self.chain.events().len();
        self.proxy.freeze();
        self.pilot.press(LATE).await;
        let is_gone = |event: &Event| matches!(event, Event::Gone(..));
        for _ in 0..1_200 {
            if self.chain.events()[before..].iter().any(is_gone) {
                break;
            }
            sleep(Duration::from_millis(50)).await;
        }
        assert!(self.chain.events()[before..].iter().any(is_gone), "{:?}", self.step);
        self.is_mended().await;
        assert!(self.pilot.says_what_became_of_the_order().await, "{:?}", self.step);
    }

    async fn delays(&mut self) {
        self.proxy.delay(Duration::from_millis(600));
        sleep(Duration::from_millis(700)).await;
        self.pilot.press(LATE).await;
        sleep(Duration::from_millis(700)).await;
        self.is_mended().await;
    }

    async fn breaks_in_the_middle(&mut self) {
        self.proxy.halve();
        self.is_mended().await;
    }

    /// A stop is given in a freeze, and what was written of it is lost by a reset.
    async fn loses_a_stop(&mut self) {
        self.proxy.freeze();
        self.pilot.press(STOP).await;
        sleep(Duration::from_millis(700)).await;
        assert!(self.pilot.says_that_the_stop_has_not_arrived().await, "{:?}", self.step);
        self.proxy.reset();
        sleep(Duration::from_millis(700)).await;
        assert!(self.pilot.says_that_the_stop_has_not_arrived().await, "{:?}", self.step);
        self.is_mended().await;
        let is_sent = |state: &Value| state["stop"].is_object();
        self.pilot.wait_for("stop", is_sent).await;
        let is_stop = |event: &Event| *event == Event::Ordered(Order::Stop);
        self.chain.wait_for("stop", is_stop).await;
        for _ in 0..1_200 {
            if !self.pilot.says_that_the_stop_has_not_arrived().await {
                return;
            }
            sleep(Duration::from_millis(50)).await;
        }
        panic!("{:?}: the stop has arrived, and the page does not know it", self.step);
    }

    async fn pilots_number(&mut self) -> Option<u64> {
        match &mut self.pilot {
            Pilot::Line(page) => Some(page.page),
            Pilot::Browser(browser) => browser.evaluate("PAGE").await.as_u64(),
        }
    }

    async fn try_all(mut self) {
        self.reach().await;
        self.pilot.set_speed(LATE_SPEED.0).await;
        self.freezes().await;
        self.delays().await;
        assert!(!self.was_late_order_carried_out(), "{:?}: {:?}", self.step, self.chain.events());
        self.breaks_in_the_middle().await;
        self.loses_a_stop().await;
        let pilot = self.pilots_number().await;
        for looker in &self.lookers {
            let seen = looker.seen();
            let is_pilots = |steers: &Option<u64>| steers.is_none() || *steers == pilot;
            assert!(seen.steered.iter().all(is_pilots), "{:?}: {:?}", self.step, seen.steered);
        }
    }
}

#[tokio::test]
async fn lines_stall_at_each_step_with_one_to_three_pages() {
    let flights = STEPS.into_iter().enumerate().map(|(n, step)| async move {
        Stalled::begin(step, 1 + n % 3, false).await.try_all().await;
    });
    join_all(flights).await;
}

#[tokio::test]
#[ignore = "needs chromium, and six minutes; UCHAIN_LONG=1 .ci/run test runs it"]
async fn lines_stall_at_each_step_with_one_to_three_pages_in_chromium() {
    for pages in 1..=3 {
        for step in STEPS {
            Stalled::begin(step, pages, true).await.try_all().await;
        }
    }
}
