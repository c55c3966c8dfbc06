//! The fleet file: the station names the drones by it, finds the base, and checks every drone.

use std::path::PathBuf;

use crate::page_client::PageClient;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::{StationProcess, command};

/// Writes the fleet file of a simulated chain, whose drones are named A, B, C and so on.
pub(crate) fn fleet(test: &str, chain: &SimulatedChain, limits: &str) -> String {
    let addresses = chain.addresses();
    let base = addresses.len() - 1;
    let drone = |(number, address): (usize, &String)| {
        let role = if number == base { "role = \"base\"\n" } else { "" };
        let name = char::from(b'A' + number as u8);
        format!("[[drone]]\nnumber = {number}\nname = \"{name}\"\naddress = \"{address}\"\n{role}")
    };
    let drones: String = addresses.iter().enumerate().map(drone).collect();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("fleet.toml");
    std::fs::write(&file, format!("{limits}\n{drones}")).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Checks the drones of a fleet file. Returns what was printed, and the exit status.
pub(crate) fn check(file: &str) -> (String, Option<i32>) {
    let output = command().args(["--check", "--fleet", file]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    (text, output.status.code())
}

#[test]
fn a_simulated_fleet_is_checked_drone_by_drone() {
    let chain = SimulatedChain::demo();
    let (text, status) = check(&fleet("checked", &chain, ""));
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("0 of 5 drones are not as"), "{text}");
    assert!(text.contains("1 B, relay, udp://") && text.contains("Flow deck"), "{text}");

    let limits = "[limits]\nlaunch_limit_dbm = -33.0\n[firmware]\nrevision = \"f00d\"";
    let (text, status) = check(&fleet("deviating", &chain, limits));
    assert_eq!(status, Some(1), "{text}");
    assert!(text.contains("5 of 5 drones are not as"), "{text}");
    assert!(text.contains("the file's -33 dBm") && text.contains("the file's f00d"), "{text}");
}

#[tokio::test]
async fn the_page_names_the_drones_by_the_fleet_file_and_finds_the_base_in_it() {
    let chain = SimulatedChain::demo();
    let file = fleet("named", &chain, "");
    let station = StationProcess::start_with(&["--fleet", &file]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    let status = page.wait_for("checks", |status| status["checks"][1]["good"] == true).await;
    assert_eq!(status["drones"][0]["name"], "the head (A)");
    assert_eq!(status["drones"][2]["name"], "relay 2 (C)");
    assert_eq!(status["checks"][1]["text"], "Every drone of the fleet file is heard.");
}

#[test]
fn a_fleet_file_that_is_none_ends_with_one_line() {
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("no-fleet.toml");
    std::fs::write(&file, "[[drone]]\nnumber = 20\naddress = \"udp://a:1\"").unwrap();
    let output = command().args(["--check", "--fleet", file.to_str().unwrap()]).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("no such number") && error.lines().count() == 1, "{error}");
}
