//! What the page shows and the drones do where the connection is cut and mended, the station is killed
//! or a relay is lost; the module `steps` looks at each step of a mission.

use sim_harness::scenario::Scenario;
use sim_harness::scenario::{Loss, LossKind};
use sim_harness::serve::Event;
use units::{Dbm, MetresPerSecond, NodeId, Order};

use crate::page_client::PageClient;
use crate::severed_line::Line;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::StationProcess;

const EXPLORE: &str = r#"{"do":"order","order":"explore","speed":0.25}"#;
const HOLD: &str = r#"{"do":"order","order":"hold"}"#;
const RECALL: &str = r#"{"do":"order","order":"recall"}"#;
const STOP: &str = r#"{"do":"stop"}"#;

/// A chain, a station behind a line that can be cut, and its page.
struct Mission {
    chain: SimulatedChain,
    line: Line,
    station: StationProcess,
    page: PageClient,
}

impl Mission {
    /// Connects to a chain on the ground.
    async fn begin() -> Self {
        let chain = SimulatedChain::demo();
        let line = Line::to(&chain.address());
        let station = StationProcess::start(&line.address(), &[]);
        let mut page = PageClient::open(station.page).await;
        page.wait_for_chain().await;
        Self { chain, line, station, page }
    }

    /// Has the head explore until it is on its way.
    async fn explore(&mut self) {
        self.page.send(EXPLORE).await;
        self.page
            .wait_for("head under way", |status| {
                status["drones"][0]["odometer_m"].as_f64().is_some_and(|metres| metres > 0.5)
            })
            .await;
    }

    /// Gives an order, and waits until the page shows it as the base's.
    async fn order(&mut self, order: &str, task: &str) {
        self.page.send(order).await;
        self.page.wait_for(task, |status| status["task"] == task).await;
    }

    async fn hovers(&self) {
        let hover = Order::explore(MetresPerSecond(0.0));
        self.chain.wait_for("head that hovers", |event| *event == Event::Ordered(hover)).await;
    }
}

/// The head stands on the ground again.
async fn comes_home(chain: &SimulatedChain) {
    let is_head = |event: &Event| matches!(event, Event::Landed(node) if node.id == NodeId(0));
    chain.wait_for("head at home", is_head).await;
}

/// Goes on showing signs of life, so that the station gives the page's orders, until an event.
async fn steer_until(
    page: &mut PageClient,
    chain: &SimulatedChain,
    is_it: impl Fn(&Event) -> bool,
) {
    page.wait_for("event of the chain", |_| chain.events().iter().any(&is_it)).await;
}

/// All four drones have stopped.
async fn stops(chain: &SimulatedChain) {
    for node in (0..4).map(NodeId) {
        let is_it = |event: &Event| matches!(event, Event::Stopped(other) if other.id == node);
        chain.wait_for("stop of every drone", is_it).await;
    }
}

#[tokio::test]
async fn connection_cut_on_the_ground_no_order_arrives_and_the_page_says_so() {
    let mut mission = Mission::begin().await;
    mission.line.cut();
    mission.page.wait_for("silent base", |status| status["hears_base"] == false).await;
    mission.page.send(EXPLORE).await;
    mission
        .page
        .wait_for("order without an answer", |status| {
            status["notices"].to_string().contains("has not answered the order to explore")
        })
        .await;
    let flies = |event: &Event| matches!(event, Event::TakesOff(_) | Event::Ordered(_));
    assert!(!mission.chain.events().iter().any(flies), "{:?}", mission.chain.events());
    mission.line.mend();
    mission.page.wait_for("base that answers", |status| status["hears_base"] == true).await;
}

#[tokio::test]
async fn connection_cut_while_the_head_explores_it_hovers_and_flies_on_when_it_is_mended() {
    let mut mission = Mission::begin().await;
    mission.explore().await;
    mission.line.cut();
    mission.hovers().await;
    mission.line.mend();
    mission.page.wait_for("base that answers", |status| status["hears_base"] == true).await;
    let before = mission.chain.events().len();
    mission.order(EXPLORE, "explore").await;
    let flies_on = Event::Ordered(Order::explore(MetresPerSecond(0.25)));
    let goes = |_: &serde_json::Value| mission.chain.events()[before..].contains(&flies_on);
    mission.page.wait_for("head that flies on", goes).await;
}

#[tokio::test]
async fn connection_cut_before_the_stop_is_sent_until_it_is_answered() {
    let mut mission = Mission::begin().await;
    mission.explore().await;
    mission.line.cut();
    mission.page.send(STOP).await;
    mission
        .page
        .wait_for("stop that is repeated", |status| status["stop"]["sending"] == "repeating")
        .await;
    mission.hovers().await;
    mission.line.mend();
    stops(&mission.chain).await;
    mission
        .page
        .wait_for("answer of every drone", |status| status["stop"]["sending"] == "answered")
        .await;
}

#[tokio::test]
async fn page_closed_while_the_chain_holds_it_goes_on_holding() {
    let mut mission = Mission::begin().await;
    mission.explore().await;
    mission.order(HOLD, "explore").await;
    mission.hovers().await;
    drop(mission.page);
    let gone = |event: &Event| matches!(event, Event::Gone(..));
    mission.chain.wait_for("client that is gone", gone).await;
    let mut page = PageClient::open(mission.station.page).await;
    page.steer().await;
    let status = page
        .wait_for("head in the air", |status| {
            status["hears_base"] == true && status["drones"][0]["silent"] == false
        })
        .await;
    assert_eq!(status["drones"][0]["airborne"], true);
    let down = |event: &Event| matches!(event, Event::Lands(..) | Event::Stopped(_));
    assert!(!mission.chain.events().iter().any(down), "{:?}", mission.chain.events());
}

#[tokio::test]
async fn station_killed_after_the_recall_the_chain_comes_home() {
    let mut mission = Mission::begin().await;
    mission.explore().await;
    mission.order(RECALL, "return").await;
    mission.station.kill();
    comes_home(&mission.chain).await;
}

/// Links of a short chain that are already weak, so that relay 1 is in the air when its radio and
/// its motors fail.
#[tokio::test]
async fn a_relay_is_lost_in_flight_the_page_names_it_and_the_head_comes_home() {
    let mut scenario = Scenario::open("demo").unwrap();
    scenario.agent.launch.limit = Dbm(-46.0);
    scenario.losses = vec![Loss { at_us: 40_000_000, drone: 1, how: LossKind::Gone }];
    let chain = SimulatedChain::at_speed(scenario, 2.0);
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(EXPLORE).await;
    let takes_off = |event: &Event| matches!(event, Event::TakesOff(node) if node.id == NodeId(1));
    steer_until(&mut page, &chain, takes_off).await;
    page.send(HOLD).await;
    let status =
        page.wait_for("silent relay", |status| status["drones"][1]["silent"] == true).await;
    assert_eq!(status["advice"]["urgent"], true, "{status:#}");
    let advice = status["advice"]["text"].as_str().unwrap();
    assert!(advice.starts_with("Relay 1 has been silent"), "{advice}");
    page.send(RECALL).await;
    let is_head = |event: &Event| matches!(event, Event::Landed(node) if node.id == NodeId(0));
    steer_until(&mut page, &chain, is_head).await;
}

/// The first fork lies 8 m in, with galleries to the left and to the right.
#[tokio::test]
async fn the_head_takes_the_branch_that_the_operator_chooses() {
    let chain = SimulatedChain::at_speed(Scenario::open("three-forks").unwrap(), 2.0);
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for("chain of six drones", |status| {
        status["drones"].as_array().is_some_and(|drones| drones.len() == 6)
    })
    .await;
    page.send(r#"{"do":"order","order":"branch","way":"right"}"#).await;
    page.send(EXPLORE).await;
    page.wait_for("head in a branch", |status| {
        status["drones"][0]["way_m"].as_f64().is_some_and(|metres| metres > 11.5)
    })
    .await;
    let trace = chain.end();
    let head = trace.frames.last().unwrap().drones[0];
    assert_eq!(trace.floor_plan.edge_name(head.place), "first-right");
}
