//! cfclient offers to fly only where it is told of a flow deck and of a drone that can fly
//! (`ui/tabs/FlightTab.py` of cfclient 2026.8.1). A base has neither; it gives the orders for
//! those that have.

use crtp::Snapshot;
use flight::{Mode, NotReady};
use onboard::{Config, Drone, Keys, Sensed, Setup};
use units::{Instant, NodeId, Role};

use crate::common::{Clear, drone, packets};

const NOW: Instant = Instant::from_micros(1_000_000);
const ARMED_AND_CAN_FLY: u16 = 1 << 1 | 1 << 3;

/// A node without decks whose motors are not ready: `deck.bcFlow2`, and `supervisor.info`'s bits
/// "armed" and "can fly".
fn seen(mut node: Drone<Clear>) -> (u8, u16) {
    node.note_decks(false, false);
    node.step(NOW, &Sensed::NONE);
    let mode = Some(Mode::Grounded { waits_for: Some(NotReady::NoFlow) });
    let measured = Snapshot { mode, ..Snapshot::DEFAULT };
    let mut ask = |packet: &[u8]| {
        node.client(NOW, packet);
        let snapshot = node.snapshot(NOW, &measured);
        // The console's greeting is no answer.
        let mut answers = std::iter::from_fn(|| node.poll_client(NOW, &snapshot)).take(100);
        answers.find(|packet| packet.bytes()[0] >> 4 != 0).unwrap().bytes().to_vec()
    };
    let row = crtp::parameters().position(|row| (row.group, row.name) == ("deck", "bcFlow2"));
    let deck = ask(&packets::read(row.unwrap() as u16))[4];
    let info = ask(&packets::SUPERVISOR_INFO);
    (deck, u16::from_le_bytes([info[2], info[3]]) & ARMED_AND_CAN_FLY)
}

#[test]
fn a_base_that_takes_orders_has_a_flow_deck_and_can_fly_to_its_clients() {
    assert_eq!(seen(drone(NodeId(4), Role::Base)), (1, ARMED_AND_CAN_FLY));
}

#[test]
fn any_other_drone_says_what_it_has_itself() {
    assert_eq!(seen(drone(NodeId(1), Role::Relay)), (0, 0));
    let without_keys = Drone::new(Config::DEFAULT, &Setup::new(NodeId(4), Role::Base));
    assert_eq!(seen(without_keys), (0, 0));
    let mut refused = Drone::new(Config::DEFAULT, &Setup::new(NodeId(4), Role::Base));
    refused.open_link(NOW, Keys::Unusable);
    assert_eq!(seen(refused), (0, 0));
}
