//! The station as a node of ROS 2, beside a peer with another maker's DDS, Eclipse Cyclone DDS.

use futures_util::StreamExt;
use serde_json::Value;
use tokio_tungstenite::connect_async;

use crate::page_client::session;
use crate::station_process::{StationProcess, command};

/// No base listens there.
const NO_BASE: &str = "udp://127.0.0.1:9";

fn refused(options: &[&str]) -> String {
    let output = command().arg(NO_BASE).args(options).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    error
}

#[test]
fn steering_by_ros2_without_a_domain_is_refused() {
    assert!(refused(&["--ros2-steer"]).contains("--ros2"));
}

/// Who asks for the number under which programs steer is given another.
#[tokio::test]
async fn no_page_has_the_number_of_programs() {
    let station = StationProcess::start(NO_BASE, &[]);
    let url = format!("ws://{}/live?session={}&page=0", station.page, session(station.page));
    let (mut socket, _) = connect_async(url).await.unwrap();
    let welcome = socket.next().await.unwrap().unwrap();
    let welcome: Value = serde_json::from_str(welcome.to_text().unwrap()).unwrap();
    assert!(welcome["page"].as_u64().is_some_and(|page| page != 0), "{welcome}");
}

#[cfg(not(feature = "ros2"))]
#[test]
fn a_station_without_ros2_says_how_to_build_one_with_it() {
    let error = refused(&["--ros2"]);
    assert!(error.contains("cargo ground-ros2") && error.lines().count() == 1, "{error}");
}

#[cfg(feature = "ros2")]
mod node {
    use std::process::{Child, Command, Stdio};

    use sim_harness::serve::Event;
    use units::{MetresPerSecond, Order};

    use super::*;
    use crate::page_client::PageClient;
    use crate::simulated_chain::SimulatedChain;

    /// A peer, which hears the station or steers by it; it is killed when it is dropped.
    struct Peer(Child);

    impl Peer {
        fn start(domain: &str, does: &str) -> Self {
            let python = std::env::var_os("UCHAIN_CYCLONEDDS_PYTHON").expect(
                "UCHAIN_CYCLONEDDS_PYTHON does not name a Python that has the package cyclonedds",
            );
            let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/ros2_peer.py");
            let mut command = Command::new(python);
            Self(command.args([script, domain, does]).stderr(Stdio::piped()).spawn().unwrap())
        }

        /// Waits for the end of the peer, which ends by itself.
        fn end(mut self) {
            let mut error = String::new();
            let mut stderr = self.0.stderr.take().unwrap();
            std::io::Read::read_to_string(&mut stderr, &mut error).unwrap();
            assert!(self.0.wait().unwrap().success(), "{error}");
        }
    }

    impl Drop for Peer {
        fn drop(&mut self) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    fn is_ordered(wanted: Order) -> impl Fn(&Event) -> bool {
        move |event| *event == Event::Ordered(wanted)
    }

    #[test]
    fn what_is_no_domain_is_refused_and_records_nothing() {
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-domain");
        let error = refused(&["--ros2=233", "--record", folder.to_str().unwrap()]);
        assert!(error.contains("--ros2=233") && error.lines().count() == 1, "{error}");
        assert!(!folder.exists());
    }

    /// The peer takes over from the page, flies the head by Twists, stops them, and recalls the chain.
    #[tokio::test]
    #[ignore = "needs the Python package cyclonedds; UCHAIN_CYCLONEDDS_PYTHON names the Python"]
    async fn cyclone_dds_hears_the_topics_and_steers_the_head() {
        let chain = SimulatedChain::demo();
        let station = StationProcess::start(&chain.address(), &["--ros2=214", "--ros2-steer"]);
        let mut page = PageClient::open(station.page).await;
        page.wait_for_chain().await;
        let peer = Peer::start("214", "steer");
        page.wait_for("program that steers", |status| status["steering"] == 0).await;
        let explore = |speed| Order::explore(MetresPerSecond(speed));
        chain.wait_for("order to explore", is_ordered(explore(0.25))).await;
        chain.wait_for("head that hovers", is_ordered(explore(0.0))).await;
        chain.wait_for("order to return", is_ordered(Order::Return)).await;
        peer.end();
        // A person takes over from the program as from another page.
        page.steer().await;
    }

    #[tokio::test]
    #[ignore = "needs the Python package cyclonedds; UCHAIN_CYCLONEDDS_PYTHON names the Python"]
    async fn a_station_that_only_publishes_follows_nothing() {
        let chain = SimulatedChain::demo();
        let station = StationProcess::start(&chain.address(), &["--ros2=215"]);
        let mut page = PageClient::open(station.page).await;
        page.wait_for_chain().await;
        // The station asks the base only while its page shows signs of life.
        let peer = tokio::task::spawn_blocking(|| Peer::start("215", "look").end());
        while !peer.is_finished() {
            page.wait_for("state", |_| true).await;
        }
        peer.await.unwrap();
    }
}
