//! What the station records: it survives the station's end, and opens in `uchain replay` and in the
//! report.

use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::MessageStream;
use mcap::read::Options;
use sim_harness::mission::trace::order_words;
use sim_harness::replay::{ReplayOptions, replay, station_record};
use sim_harness::report::report;

use crate::page_client::PageClient;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::StationProcess;

/// A folder of its own for a test's recording, which does not exist yet.
fn folder(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// Flies the head for a while, gives the last order, and kills the station a second after the
/// page has shown that the base has taken it.
async fn fly_and_kill(recording: &Path) {
    let chain = SimulatedChain::demo();
    let folder = recording.to_str().unwrap();
    let options = ["--record", folder, "--map", "demo"];
    let station = StationProcess::start(&chain.address(), &options);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(r#"{"do":"order","order":"explore","speed":0.25}"#).await;
    page.wait_for("head under way", |status| {
        status["drones"][0]["odometer_m"].as_f64().is_some_and(|metres| metres > 0.5)
    })
    .await;
    page.send(r#"{"do":"order","order":"recall"}"#).await;
    page.wait_for("answer to the recall", |status| {
        status["notices"].to_string().contains("taken the order to recall")
    })
    .await;
    tokio::time::sleep(Duration::from_secs(1)).await;
    station.kill();
}

/// The topics and the texts of the messages that can be read.
fn messages(file: &Path) -> Vec<(String, String)> {
    let bytes = std::fs::read(file).unwrap();
    MessageStream::new_with_options(&bytes, Options::IgnoreEndMagic.into())
        .unwrap()
        .map_while(Result::ok)
        .map(|message| {
            let text = String::from_utf8(message.data.to_vec()).unwrap();
            (message.channel.topic.clone(), text)
        })
        .collect()
}

#[tokio::test]
async fn the_recording_of_a_killed_station_opens_in_replay_and_in_the_report() {
    let recording = folder("killed-recording");
    fly_and_kill(&recording).await;
    let file = recording.join("station.mcap");
    let all = messages(&file);
    let has = |topic: &str, text: &str| {
        all.iter().any(|(other, message)| other == topic && message.contains(text))
    };
    assert!(has("/notice", "taken the order to recall"), "{all:#?}");
    assert!(has("/map", "outlines") && has("/limits", "launch_limit_dbm"));

    let files = [file.clone(), recording.join("packets.csv")];
    let summary = replay(&files, &ReplayOptions::default()).unwrap();
    let packets = |file: usize| -> Vec<(String, usize)> {
        summary.files[file].links.iter().map(|link| (link.link.clone(), link.packets)).collect()
    };
    assert_eq!(packets(0).len(), 4);
    // Each file is flushed by itself: at its end one may have a row more.
    for ((link, in_mcap), (_, in_csv)) in packets(0).iter().zip(packets(1)) {
        assert!(in_mcap.abs_diff(in_csv) <= 1, "{link}: {in_mcap} {in_csv}");
    }

    let record = station_record(&file).unwrap().unwrap();
    let orders: Vec<String> =
        record.trace.frames.iter().map(|frame| order_words(frame.order)).collect();
    for order in ["wait", "explore at 0.25 m/s", "return"] {
        assert!(orders.iter().any(|other| other == order), "{order}");
    }
    let head = record.trace.frames.last().unwrap().drones[0];
    assert!(head.way > 1.0 && head.back.is_some(), "{head:?}");
    let page = report::html(&record.trace, &record.summary).unwrap();
    for text in ["\"leading\"", "\"return\"", "recorded", "A flight that the station recorded"] {
        assert!(page.contains(text), "{text}");
    }
}

/// A chain that stays on the ground is surveyed where it stands: its relay does not move, but the
/// marks say so.
#[tokio::test]
async fn a_range_survey_proposes_limits_and_is_written_as_a_table_for_a_fit() {
    let chain = SimulatedChain::demo();
    let recording = folder("surveyed");
    let options = ["--record", recording.to_str().unwrap()];
    let station = StationProcess::start(&chain.address(), &options);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(r#"{"do":"survey","step":"begin","node":2}"#).await;
    let status = page.wait_for("survey", |status| status["survey"].is_object()).await;
    assert_eq!(status["survey"]["name"], "relay 2");
    let mut metres = 0.0;
    while page.wait_for("next state", |_| true).await["survey"]["proposal"].is_null() {
        metres += 0.05;
        page.send(&format!(r#"{{"do":"survey","step":"mark","metres":{metres}}}"#)).await;
    }
    let status = page.wait_for("proposal", |status| status["survey"]["proposal"].is_object()).await;
    let proposal = &status["survey"]["proposal"];
    assert_eq!(proposal["retreat_dbm"], -72.0);
    assert_eq!(proposal["reached_limit"], false, "{proposal}");
    page.send(r#"{"do":"survey","step":"end"}"#).await;
    let file = recording.join("survey-1.csv");
    page.wait_for("table", |status| {
        status["notices"].to_string().contains("The range survey has") && file.exists()
    })
    .await;
    drop(page);
    let table = loop {
        let table = std::fs::read_to_string(&file).unwrap();
        if table.lines().count() > 30 {
            break table;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    };
    assert!(table.starts_with("time_s,link,rssi_dbm,distance_m\n"), "{table}");
    let summary = replay(&[file], &ReplayOptions::default()).unwrap();
    assert_eq!(summary.files[0].links.len(), 1);
}

#[test]
fn what_is_no_recording_of_a_station_has_no_report() {
    assert!(
        station_record(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")))
            .unwrap()
            .is_none()
    );
}
