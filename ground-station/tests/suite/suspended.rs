//! A station that is suspended and goes on: what waited in its sockets is not carried out, but for
//! a stop.

#![cfg(unix)]

use std::time::Duration;

use sim_harness::serve::Event;
use units::{MetresPerSecond, Order};

use crate::page_client::PageClient;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::StationProcess;

const EXPLORE: &str = r#"{"do":"order","order":"explore","speed":0.25}"#;

/// Twice what the age of an order may be.
const SUSPENSION: Duration = Duration::from_secs(1);

async fn begin() -> (SimulatedChain, StationProcess, PageClient) {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    (chain, station, page)
}

#[tokio::test]
async fn an_order_that_waited_for_a_suspended_station_is_refused_and_the_page_told() {
    let (chain, station, mut page) = begin().await;
    station.signal("-STOP");
    for _ in 0..5 {
        page.send_now(EXPLORE).await;
    }
    page.send_now(r#"{"do":"order","order":"land"}"#).await;
    tokio::time::sleep(SUSPENSION).await;
    station.signal("-CONT");
    let state = page.wait_for("refusal", |status| status["refused"].is_object()).await;
    let told = state["refused"]["text"].as_str().unwrap();
    assert!(told.starts_with("Not ordered to ") && told.contains("s late"), "{told}");
    assert!(state["notices"].to_string().contains("Not ordered to explore at 0.25 m/s"), "{state}");
    let ordered = |event: &Event| matches!(event, Event::Ordered(_) | Event::TakesOff(_));
    // The page steers on, and its next order is taken.
    let page_number = page.page;
    page.wait_for("pilot", |status| status["steering"] == page_number).await;
    assert!(!chain.events().iter().any(ordered), "{:?}", chain.events());
    page.send(EXPLORE).await;
    let explore = Event::Ordered(Order::explore(MetresPerSecond(0.25)));
    page.wait_for("order that is taken", |_| chain.events().contains(&explore)).await;
}

#[tokio::test]
async fn a_stop_that_waited_for_a_suspended_station_is_carried_out() {
    let (chain, station, mut page) = begin().await;
    station.signal("-STOP");
    page.send_now(r#"{"do":"stop"}"#).await;
    page.send_now(r#"{"do":"give-up"}"#).await;
    tokio::time::sleep(SUSPENSION).await;
    station.signal("-CONT");
    page.wait_for("answered stop", |status| status["stop"]["sending"] == "answered").await;
    assert!(chain.events().contains(&Event::Ordered(Order::Stop)));
}
