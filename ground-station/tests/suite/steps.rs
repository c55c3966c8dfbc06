//! What the drones do where the connection is cut, the page is closed or the browser is killed, at
//! each step of a mission.

use std::net::SocketAddr;
use std::path::PathBuf;

use futures_util::future::join_all;
use serde_json::Value;
use sim_harness::scenario::Scenario;
use sim_harness::scenario::{Loss, LossKind};
use sim_harness::serve::Event;
use units::{Course, Dbm, NodeId, Order};

use crate::browser::Browser;
use crate::page_client::PageClient;
use crate::severed_line::Line;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::StationProcess;

/// A step of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// The station reads the base's tables.
    Connecting,
    /// The page shows the checklist; all drones stand on the ground.
    Checklist,
    /// The head is on its way.
    Exploring,
    /// The head is on its way to a fork, and the operator has chosen the branch.
    Choosing,
    /// The head hovers, and a relay behind it is gone.
    RelayLost,
    /// The base has taken the recall.
    Recalled,
    /// The head is on its way home.
    Returning,
    /// The operator has ordered the stop.
    Stopping,
}

/// All of them, in the order of a mission.
pub(crate) const STEPS: [Step; 8] = [
    Step::Connecting,
    Step::Checklist,
    Step::Exploring,
    Step::Choosing,
    Step::RelayLost,
    Step::Recalled,
    Step::Returning,
    Step::Stopping,
];

/// What is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lost {
    Connection,
    Page,
    Browser,
}

/// Simulated seconds per second.
pub(crate) const SPEED: f64 = 2.0;

impl Step {
    /// The scenario in which the step is flown.
    pub(crate) fn scenario(self) -> Scenario {
        match self {
            Self::Choosing => Scenario::open("three-forks").unwrap(),
            // Links of a short chain are already weak, so that relay 1 is in the air when it is lost.
            Self::RelayLost => {
                let mut scenario = Scenario::open("demo").unwrap();
                scenario.agent.launch.limit = Dbm(-50.0);
                scenario.losses = vec![Loss { at_us: 20_000_000, drone: 1, how: LossKind::Gone }];
                scenario
            }
            _ => Scenario::open("demo").unwrap(),
        }
    }
}

/// An order of the operator: the key in the browser, and the request of a page.
pub(crate) struct Key(pub(crate) &'static str, pub(crate) &'static str);

pub(crate) const EXPLORE: Key = Key("e", r#"{"do":"order","order":"explore","speed":0.2}"#);
pub(crate) const RIGHT: Key = Key("3", r#"{"do":"order","order":"branch","way":"right"}"#);
pub(crate) const HOLD: Key = Key("t", r#"{"do":"order","order":"hold"}"#);
pub(crate) const RECALL: Key = Key("r", r#"{"do":"order","order":"recall"}"#);
pub(crate) const STOP: Key = Key("Escape", r#"{"do":"stop"}"#);

/// A chain, a station behind a line that can be cut, and the operator's page: in a browser that
/// steers, with another page that looks on, or without a browser.
struct Mission {
    step: Step,
    chain: SimulatedChain,
    line: Line,
    station: StationProcess,
    browser: Option<Browser>,
    page: PageClient,
}

impl Mission {
    async fn begin(step: Step, lost: Lost) -> Self {
        let chain = SimulatedChain::at_speed(step.scenario(), SPEED);
        let line = Line::to(&chain.address());
        let station = StationProcess::start(&line.address(), &[]);
        let browser = match lost {
            Lost::Connection | Lost::Page => None,
            Lost::Browser => Some(browse(&format!("step-{step:?}"), station.page).await),
        };
        let page = PageClient::open(station.page).await;
        Self { step, chain, line, station, browser, page }
    }

    async fn press(&mut self, Key(key, request): Key) {
        match &mut self.browser {
            Some(browser) => browser.press(key).await,
            None => self.page.send(request).await,
        }
    }

    async fn wait_for(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) {
        let what = format!("{what}, while {:?}", self.step);
        self.page.wait_for(&what, is_it).await;
    }

    /// Flies up to the step.
    async fn reach(&mut self) {
        if self.step == Step::Connecting {
            return self.wait_for("base that answers", |status| status["hears_base"] == true).await;
        }
        let drones = self.step.scenario().drones.flying();
        self.wait_for("checklist", |status| {
            let checks = status["checks"].as_array().unwrap();
            checks.len() > 1 && status["drones"].as_array().unwrap().len() == drones
        })
        .await;
        match self.step {
            Step::Connecting | Step::Checklist => {}
            Step::Exploring => self.explore(0.5).await,
            Step::Choosing => {
                self.explore(0.5).await;
                self.press(RIGHT).await;
                self.wait_for("choice", has_taken("branch right")).await;
            }
            Step::RelayLost => {
                self.press(EXPLORE).await;
                self.wait_for("relay in the air", |s| s["drones"][1]["airborne"] == true).await;
                self.press(HOLD).await;
                self.wait_for("silent relay", |s| s["drones"][1]["silent"] == true).await;
            }
            Step::Recalled => {
                self.explore(0.5).await;
                self.press(RECALL).await;
                self.wait_for("recall", has_taken("recall")).await;
            }
            Step::Returning => {
                self.explore(1.0).await;
                self.press(RECALL).await;
                self.wait_for("head on its way home", |s| way(s) < 0.9).await;
            }
            Step::Stopping => {
                self.explore(0.5).await;
                self.press(STOP).await;
                self.wait_for("stop that is sent", |s| s["stop"]["base_s"].is_number()).await;
            }
        }
    }

    /// Explores until the head has flown so many metres.
    async fn explore(&mut self, metres: f64) {
        self.press(EXPLORE).await;
        self.wait_for("head under way", |status| way(status) > metres).await;
    }

    /// Loses what is to be lost. The station goes on.
    fn lose(self, lost: Lost) -> After {
        let Self { step, chain, line, station, browser, page } = self;
        let before = chain.events().len();
        let page = match lost {
            Lost::Connection => {
                line.cut();
                Some(page)
            }
            Lost::Page => None,
            // The page that looks on stays open.
            Lost::Browser => {
                browser.unwrap().kill();
                Some(page)
            }
        };
        After { step, chain, line, station, page, before }
    }
}

/// The head's way in metres.
pub(crate) fn way(status: &Value) -> f64 {
    status["drones"][0]["odometer_m"].as_f64().unwrap()
}

pub(crate) fn has_taken(order: &'static str) -> impl Fn(&Value) -> bool {
    move |status| {
        let taken = format!("taken the order to {order}");
        status["notices"].to_string().contains(&taken)
    }
}

/// Opens the page at this address in a browser, and waits until it steers.
pub(crate) async fn browse(profile: &str, page: SocketAddr) -> Browser {
    let profile = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(profile);
    let _ = std::fs::remove_dir_all(&profile);
    std::fs::create_dir_all(&profile).unwrap();
    let mut browser = Browser::open(&profile, &format!("http://{page}/")).await;
    // The station has heard a sign of life of it.
    browser.wait_for("typeof steers !== 'undefined' && steers && document.getElementById('not-steering').hidden").await;
    browser
}

/// A mission after something was lost.
struct After {
    step: Step,
    chain: SimulatedChain,
    line: Line,
    station: StationProcess,
    /// The page, where it is still open.
    page: Option<PageClient>,
    /// The number of events of the chain before the loss.
    before: usize,
}

impl After {
    /// What has happened since the loss.
    fn events(&self) -> Vec<Event> {
        self.chain.events()[self.before..].to_vec()
    }

    /// Waits for an event of the chain, with signs of life of the page where it is still open.
    async fn wait_for(&mut self, what: &str, is_it: impl Fn(&Event) -> bool) {
        let what = format!("{what}, after {:?}", self.step);
        let chain = &self.chain;
        let has_it = || chain.events()[self.before..].iter().any(&is_it);
        match &mut self.page {
            Some(page) => drop(page.wait_for(&what, |_| has_it()).await),
            None => self.chain.wait_for(&what, is_it).await,
        }
    }

    /// The base hears nothing of the station any more.
    async fn falls_silent(&mut self) {
        self.wait_for("client that is gone", |event| matches!(event, Event::Gone(..))).await;
    }

    /// The drones do what the step asks for.
    async fn hold(mut self) {
        match self.step {
            Step::Connecting | Step::Checklist => {
                self.falls_silent().await;
                let flies = |event: &Event| !matches!(event, Event::Gone(..));
                assert!(!self.events().iter().any(flies), "{:?}: {:?}", self.step, self.events());
                self.goes_on().await;
            }
            Step::Exploring | Step::Choosing => {
                self.wait_for("head that hovers", is_hover).await;
                self.falls_silent().await;
                self.stays_in_the_air();
                self.stands_still();
            }
            Step::RelayLost => {
                self.falls_silent().await;
                self.stays_in_the_air();
                self.stands_still();
            }
            Step::Recalled | Step::Returning => {
                let is_head =
                    |event: &Event| matches!(event, Event::Landed(node) if node.id == NodeId(0));
                self.wait_for("head at home", is_head).await;
                assert!(!self.events().iter().any(|e| matches!(e, Event::Stopped(_))));
            }
            Step::Stopping => {
                for node in (0..4).map(NodeId) {
                    let stops = |event: &Event| matches!(event, Event::Stopped(n) if n.id == node);
                    self.chain.wait_for("stop of every drone", stops).await;
                }
            }
        }
    }

    /// With the line mended and a page that steers, the station goes on where it was.
    async fn goes_on(&mut self) {
        self.line.mend();
        let mut page = match self.page.take() {
            Some(page) => page,
            None => PageClient::open(self.station.page).await,
        };
        page.steer().await;
        page.wait_for_chain().await;
    }

    /// No drone has landed, and none was stopped.
    fn stays_in_the_air(&self) {
        let is_down = |event: &Event| {
            matches!(event, Event::Lands(..) | Event::Landed(_) | Event::Stopped(_))
        };
        assert!(!self.events().iter().any(is_down), "{:?}: {:?}", self.step, self.events());
    }

    /// The head has not moved within the last simulated second.
    fn stands_still(self) {
        let step = self.step;
        let trace = self.chain.end();
        let mut last = trace.frames.iter().rev().step_by(5).map(|frame| frame.drones[0].place);
        let (now, before) = (last.next().unwrap(), last.next().unwrap());
        assert_eq!(now.edge, before.edge, "{step:?}");
        let moved = (now.along - before.along).abs();
        assert!(moved < 0.1, "{step:?}: {moved} m within a second");
    }
}

fn is_hover(event: &Event) -> bool {
    matches!(event, Event::Ordered(Order::Explore(Course { speed, .. })) if speed.0 == 0.0)
}

async fn try_step(step: Step, lost: Lost) {
    let mut mission = Mission::begin(step, lost).await;
    mission.reach().await;
    mission.lose(lost).hold().await;
}

#[tokio::test]
async fn connection_cut_at_each_step() {
    join_all(STEPS.map(|step| try_step(step, Lost::Connection))).await;
}

#[tokio::test]
async fn page_closed_at_each_step() {
    join_all(STEPS.map(|step| try_step(step, Lost::Page))).await;
}

#[tokio::test]
#[ignore = "needs chromium"]
async fn browser_killed_at_each_step_in_chromium() {
    for step in STEPS {
        try_step(step, Lost::Browser).await;
    }
}
