//! The map of the page: the chain on a plan, and along the way flown where there is none.

use crate::page_client::PageClient;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::{StationProcess, command};

#[tokio::test]
async fn drones_are_shown_on_the_plan_as_far_as_they_have_flown() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &["--map", "demo"]);
    let mut page = PageClient::open(station.page).await;
    assert!(!page.plan["outlines"].as_array().unwrap().is_empty());
    page.wait_for_chain().await;
    let status = page.wait_for("chain at the mouth", |_| true).await;
    let way = |drone: usize| status["drones"][drone]["way_m"].as_f64().unwrap();
    assert!(way(0) > way(1) && way(1) > way(2), "the head stands in front: {status:#}");
    assert!(status["map"]["end"].is_null());
    let before = status["drones"][0]["at"].clone();
    page.send(r#"{"do":"order","order":"explore","speed":0.25}"#).await;
    page.wait_for("head elsewhere on the map", |status| status["drones"][0]["at"] != before).await;
}

#[tokio::test]
async fn without_a_map_the_line_is_the_way_flown() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    assert!(page.plan.is_null());
    page.wait_for_chain().await;
    let status = page.wait_for("straight line", |status| status["map"]["end"].is_array()).await;
    assert_eq!(status["map"]["end"][1], 0.0);
    assert_eq!(status["drones"][0]["at"][1], 0.0);
}

#[test]
fn a_map_that_is_none_ends_with_one_line() {
    let output =
        command().args(["udp://127.0.0.1:9", "--map", "no-such-cave.svx"]).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("no-such-cave.svx") && error.lines().count() == 1, "{error}");
}
