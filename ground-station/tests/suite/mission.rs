//! Missions by the page: orders reach the drones, a stop is answered, and where the page, the
//! browser or the station goes away, the drones do what their own time-outs say.

use std::collections::BTreeSet;
use std::path::PathBuf;

use sim_harness::replay::{ReplayOptions, replay};
use sim_harness::serve::Event;
use units::{MetresPerSecond, NodeId, Order};

use crate::page_client::PageClient;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::StationProcess;

const EXPLORE: &str = r#"{"do":"order","order":"explore","speed":0.25}"#;
const STOP: &str = r#"{"do":"stop"}"#;

fn is_ordered(wanted: Order) -> impl Fn(&Event) -> bool {
    move |event| *event == Event::Ordered(wanted)
}

/// A folder of its own for a test's recording, which does not exist yet.
fn folder(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

#[tokio::test]
async fn a_mission_from_take_off_to_the_answered_stop() {
    let chain = SimulatedChain::demo();
    let recording = folder("mission");
    let station =
        StationProcess::start(&chain.address(), &["--record", recording.to_str().unwrap()]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(EXPLORE).await;
    chain.wait_for("order to explore", is_ordered(Order::explore(MetresPerSecond(0.25)))).await;
    page.wait_for_flight().await;
    page.send(r#"{"do":"order","order":"branch","way":"left"}"#).await;
    let is_taken = |notice: &serde_json::Value| {
        notice.as_str().unwrap().contains("taken the order to branch left")
    };
    page.wait_for("choice of a branch", |status| {
        status["notices"].as_array().unwrap().iter().any(is_taken)
    })
    .await;
    page.send(r#"{"do":"order","order":"recall"}"#).await;
    chain.wait_for("order to return", is_ordered(Order::Return)).await;
    page.wait_for("order in the page", |status| status["task"] == "return").await;
    page.send(STOP).await;
    let status = page
        .wait_for("answer of every drone", |status| status["stop"]["sending"] == "answered")
        .await;
    let answers = status["stop"]["drones"].as_array().unwrap();
    assert_eq!(answers.len(), 4);
    assert!(answers.iter().all(|answer| answer["answered_s"].is_number()), "{status:#}");
    let is_stopped =
        |event: &Event, wanted| matches!(event, Event::Stopped(node) if node.id == wanted);
    for node in (0..4).map(NodeId) {
        assert!(chain.events().iter().any(|event| is_stopped(event, node)), "node {node}");
    }
    let packets = recording.join("packets.csv");
    while !std::fs::read_to_string(&packets).unwrap().contains(",stopped,") {
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
    }
    station.kill();
    let summary = replay(&[packets], &ReplayOptions::default()).unwrap();
    let links: BTreeSet<_> = summary.files[0].links.iter().map(|link| link.link.as_str()).collect();
    assert_eq!(links, BTreeSet::from(["0 from 4", "1 from 4", "2 from 4", "3 from 4"]));
}

/// The first address that `uchain serve` prints is the head's, the last one the base's.
#[tokio::test]
async fn a_station_that_is_given_the_heads_address_finds_the_base() {
    let chain = SimulatedChain::demo_in_a_row();
    let station = StationProcess::start(&chain.head_address(), &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(EXPLORE).await;
    chain.wait_for("order to explore", is_ordered(Order::explore(MetresPerSecond(0.25)))).await;
}

/// The head hovers, as the base says two seconds after the last packet of its client.
async fn the_head_hovers(chain: &SimulatedChain) {
    chain.wait_for("head that hovers", is_ordered(Order::explore(MetresPerSecond(0.0)))).await;
}

#[tokio::test]
async fn the_head_hovers_when_the_page_hangs() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(EXPLORE).await;
    page.wait_for_flight().await;
    // The page is open and says nothing more.
    the_head_hovers(&chain).await;
    drop(page);
}

#[tokio::test]
async fn the_head_hovers_when_the_station_is_killed() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(EXPLORE).await;
    page.wait_for_flight().await;
    station.kill();
    the_head_hovers(&chain).await;
}

#[tokio::test]
async fn one_page_steers_and_both_may_stop() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut first = PageClient::open(station.page).await;
    first.wait_for_chain().await;
    let mut second = PageClient::open(station.page).await;
    let steering = first.page;
    let status = second.wait_for("page that steers", |status| status["steering"] == steering).await;
    assert_ne!(status["steering"], second.page);
    second.send(r#"{"do":"order","order":"land"}"#).await;
    second
        .wait_for("refusal", |status| status["notices"].to_string().contains("another page steers"))
        .await;
    assert!(!chain.events().iter().any(is_ordered(Order::Land)));
    second.send(STOP).await;
    chain.wait_for("stop", is_ordered(Order::Stop)).await;
}

#[tokio::test]
async fn a_base_that_is_gone_is_said_to_be_gone() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    drop(chain);
    let status = page.wait_for("silent base", |status| status["hears_base"] == false).await;
    assert_eq!(status["advice"]["urgent"], true);
    page.send(STOP).await;
    page.wait_for("stop that is repeated", |status| {
        status["stop"]["sending"] == "repeating" && status["stop"]["base_s"].is_null()
    })
    .await;
    page.send(r#"{"do":"give-up"}"#).await;
    page.wait_for("end of waiting", |status| status["stop"]["sending"] == "given up").await;
}
