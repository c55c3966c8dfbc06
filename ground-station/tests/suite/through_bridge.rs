//! The station over a Crazyradio: `uchain bridge` with a scripted dongle that loses packets, and the
//! CRTP server that the drones run behind it.

use std::net::Ipv4Addr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;

use bridge::{self, Ports, Radio, RadioLost, Rate};
use crtp::{Access, Event, Node, OperatorTask, Outcome, Parameters, Server, Snapshot};
use units::{Dbm, Instant, Metres, MetresPerSecond, NodeId, Role};
use wire::crtp::Packet;
use wire::p2p::Telemetry;

use crate::page_client::PageClient;
use crate::station_process::StationProcess;

const RELAY: NodeId = NodeId(2);
const LEADING: u8 = 3;
const STOPPED: u8 = 9;

/// A base within reach of a Crazyradio that loses every fifth packet and every seventh answer.
struct BaseOnTheAir {
    server: Server,
    parameters: Arc<Mutex<Parameters>>,
    is_stopped: Arc<AtomicBool>,
    began: std::time::Instant,
    exchanges: u64,
    safelink: Safelink,
}

/// The radio chip's side of the safelink, which drops the second copy of a packet whose
/// acknowledgement was lost (crazyflie2-nrf-firmware, `src/esb.c`).
#[derive(Default)]
struct Safelink {
    up: u8,
    down: u8,
    offered: Vec<u8>,
}

const ASK_SAFELINK: [u8; 3] = [0xFF, 0x05, 0x01];
const UP: u8 = 1 << 3;
const DOWN: u8 = 1 << 2;

impl BaseOnTheAir {
    /// What the base knows: one relay, which flies until the stop.
    fn snapshot(&self, now: Instant) -> Snapshot {
        let state = if self.is_stopped.load(Ordering::Relaxed) { STOPPED } else { LEADING };
        let telemetry = Telemetry {
            state,
            fault: 0,
            battery: None,
            endurance: None,
            front: None,
            back: Some((NodeId(4), Dbm(-60.0))),
            odometer: Metres(3.0),
            velocity: MetresPerSecond::ZERO,
            height: None,
            heeded: 0,
        };
        let mut snapshot = Snapshot { taken: now, ..Snapshot::DEFAULT };
        snapshot.nodes[usize::from(RELAY.0)] = Some(Node { telemetry, heard: now });
        snapshot
    }
}

impl Radio for BaseOnTheAir {
    fn exchange(&mut self, packet: &[u8]) -> Result<Option<Vec<u8>>, RadioLost> {
        self.exchanges += 1;
        if self.exchanges.is_multiple_of(5) {
            return Ok(None);
        }
        let answer = self.answer(packet);
        Ok((!self.exchanges.is_multiple_of(7)).then_some(answer))
    }
}

impl BaseOnTheAir {
    /// The acknowledgement of a packet that has arrived.
    fn answer(&mut self, packet: &[u8]) -> Vec<u8> {
        if packet == ASK_SAFELINK {
            self.safelink = Safelink::default();
            return packet.to_vec();
        }
        let now = Instant::from_micros(self.began.elapsed().as_micros() as u64);
        let snapshot = self.snapshot(now);
        let mut parameters = self.parameters.lock().unwrap();
        let Safelink { up, down, offered } = &mut self.safelink;
        if packet[0] & UP == *up {
            *up ^= UP;
            let is_stopped = &self.is_stopped;
            self.server.receive(now, packet, Access::Full, &mut parameters, |event, parameters| {
                if event == Event::EmergencyStop {
                    parameters.task = OperatorTask::Stop;
                    is_stopped.store(true, Ordering::Relaxed);
                }
                Outcome::Done
            });
        }
        if packet[0] & DOWN != *down || offered.is_empty() {
            *down = packet[0] & DOWN;
            let next = self.server.poll(now, &snapshot, &parameters).unwrap_or(Packet::NULL);
            *offered = next.bytes().to_vec();
        }
        let mut answer = offered.clone();
        answer[0] = answer[0] & !(UP | DOWN) | *down;
        answer
    }
}

#[tokio::test]
async fn orders_and_the_stop_go_through_a_crazyradio_that_loses_packets() {
    let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, 1).unwrap();
    let address = format!("udp://{}", ports.addresses()[0]);
    let mut parameters = Parameters::DEFAULT;
    (parameters.about.node, parameters.about.role) = (NodeId(4), Role::Base);
    let parameters = Arc::new(Mutex::new(parameters));
    let is_stopped = Arc::new(AtomicBool::new(false));
    let mut base = BaseOnTheAir {
        server: Server::new(),
        parameters: Arc::clone(&parameters),
        is_stopped: Arc::clone(&is_stopped),
        began: std::time::Instant::now(),
        exchanges: 0,
        safelink: Safelink::default(),
    };
    let ending = Arc::new(AtomicBool::new(false));
    let end = Arc::clone(&ending);
    let bridge =
        thread::spawn(move || bridge::run(&mut base, ports, Rate::DEFAULT, &end, |_, _| {}));
    let station = StationProcess::start(&address, &[]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for("relay", |status| status["drones"][0]["node"] == RELAY.0).await;
    page.send(r#"{"do":"order","order":"explore","speed":0.25}"#).await;
    page.wait_for("order to explore", |status| status["task"] == "explore").await;
    assert_eq!(parameters.lock().unwrap().speed, MetresPerSecond(0.25));
    page.send(r#"{"do":"stop"}"#).await;
    page.wait_for("answer to the stop", |status| status["stop"]["sending"] == "answered").await;
    assert!(is_stopped.load(Ordering::Relaxed));
    ending.store(true, Ordering::Relaxed);
    bridge.join().unwrap().unwrap();
}
