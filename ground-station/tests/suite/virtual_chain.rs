//! The station beside virtual drones: head, relay and base run the ELF that `cargo fw` makes, or the one
//! that `UCHAIN_ELF` names, and the station reaches the base's firmware through its radio chip, as
//! through a Crazyradio.

use std::path::PathBuf;

use sim_harness::bodies::emulated::Firmware;
use sim_harness::serve::Event;
use units::NodeId;

use crate::fleet::{check, fleet};
use crate::page_client::PageClient;
use crate::simulated_chain::{LAUNCH, RETREAT, SimulatedChain};
use crate::station_process::StationProcess;

fn firmware() -> Firmware {
    let built = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join("../thumbv7em-none-eabihf/firmware/uchain-firmware");
    let path = std::env::var_os("UCHAIN_ELF").map_or(built, PathBuf::from);
    Firmware::open(&path).unwrap_or_else(|why| panic!("{why}"))
}

#[tokio::test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
async fn virtual_drones_are_checked_take_off_and_stop() {
    let chain = SimulatedChain::of_virtual_drones(firmware());
    let limits = format!(
        "[limits]\nlaunch_limit_dbm = {:?}\nretreat_limit_dbm = {:?}\n[firmware]\nradio = \"2025.02\"",
        LAUNCH.0, RETREAT.0
    );
    let (text, status) = check(&fleet("virtual", &chain, &limits));
    assert_eq!(status, Some(0), "{text}");
    let station = StationProcess::start(&chain.address(), &[]);
    let mut page = PageClient::open(station.page).await;
    let status = page
        .wait_for("checklist with nothing wrong", |status| {
            let checks = status["checks"].as_array();
            checks.is_some_and(|checks| {
                !checks.is_empty() && checks.iter().all(|check| check["good"] == true)
            })
        })
        .await;
    assert_eq!(status["drones"].as_array().map(Vec::len), Some(2), "{status:#}");
    page.send(r#"{"do":"order","order":"explore","speed":0.2}"#).await;
    page.wait_for_flight().await;
    page.send(r#"{"do":"stop"}"#).await;
    page.wait_for("answer of every drone", |status| status["stop"]["sending"] == "answered").await;
    for node in [0, 1].map(NodeId) {
        let stops = |event: &Event| matches!(event, Event::Stopped(other) if other.id == node);
        chain.wait_for("stop of every drone", stops).await;
    }
    chain.end();
}
