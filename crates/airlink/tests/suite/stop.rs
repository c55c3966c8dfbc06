//! A Stop, once ordered, stands: no later order of the operator replaces it, and every drone
//! receives it, however often the drone reboots.

use airlink::Event;
use proptest::prelude::*;
use units::{MetresPerSecond, NodeId, Order};
use wire::p2p::{Commands, Header, Message, TAG};

use crate::common::net::{Net, Setup};
use crate::common::seeded;
use crate::common::unsealed::Unsealed;

const SECOND: u64 = 1_000_000;
const EXPLORE: Order = Order::explore(MetresPerSecond(0.3));

/// The orders that `node` has received since the time `since`, in µs.
fn orders(net: &Net<Unsealed>, node: usize, since: u64) -> Vec<Order> {
    let received =
        net.received.iter().filter(|received| received.to == node && received.at >= since);
    received
        .filter_map(|received| match received.event {
            Event::Order { task, .. } => Some(task),
            _ => None,
        })
        .collect()
}

/// A client goes on sending hover set-points after the operator has pressed the red button.
#[test]
fn later_set_points_do_not_replace_a_stop() {
    let mut net = Net::row(Setup::default(), 1, 4, |_| Unsealed);
    net.stick = Some(EXPLORE);
    net.run(5 * SECOND);
    assert!(net.order(3, Order::Stop));
    let since = net.now;
    net.run(100_000);
    assert!(!net.order(3, EXPLORE), "the base answers that the order does not stand");
    net.run(10 * SECOND);
    for drone in 0..3 {
        let received = orders(&net, drone, since);
        let first = received.iter().position(|order| *order == Order::Stop);
        let first = first.unwrap_or_else(|| panic!("drone {drone} has received {received:?}"));
        assert!(
            received[first..].iter().all(|order| *order == Order::Stop),
            "{drone}: {received:?}"
        );
    }
}

/// The base sends its order to eight drones in its next two turns, two orders to a packet.
#[test]
fn a_stop_goes_out_two_to_a_packet() {
    let (drones, base) = (8, 8);
    let mut net = Net::row(Setup::default(), 1, drones + 1, |_| Unsealed);
    net.run(10 * SECOND);
    net.order(base, Order::Stop);
    let before = net.sent.len();
    net.run(300_000);
    let mut nodes = Vec::new();
    for sent in &net.sent[before..] {
        let (header, rest) = Header::decode(&sent.bytes).unwrap();
        let body = &rest[..rest.len() - TAG];
        let Ok(Message::Command(Commands { first, second })) = Message::decode(header.kind, body)
        else {
            continue;
        };
        assert_ne!(second.map(|second| second.node), Some(first.node));
        if header.from == NodeId(8) && nodes.len() < drones {
            nodes.extend([first.node].into_iter().chain(second.map(|second| second.node)));
        }
    }
    assert_eq!(nodes, (0..8).map(NodeId).collect::<Vec<_>>(), "in four packets, the head first");
    for drone in 0..drones {
        assert_eq!(orders(&net, drone, 10 * SECOND), [Order::Stop], "{drone}");
    }
}

/// An event between the Stop and the end of the test.
#[derive(Clone, Copy, Debug)]
enum Mishap {
    Reboot(usize),
    Order(Order),
    Wait(u64),
}

fn mishaps(drones: usize) -> impl Strategy<Value = Vec<Mishap>> {
    let orders =
        prop::sample::select(vec![EXPLORE, Order::Wait, Order::Return, Order::Land, Order::Stop]);
    let mishap = prop_oneof![
        (0..drones).prop_map(Mishap::Reboot),
        orders.prop_map(Mishap::Order),
        (1..3_000_000_u64).prop_map(Mishap::Wait),
    ];
    prop::collection::vec(mishap, 0..12)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..seeded() })]

    #[test]
    fn every_drone_receives_a_stop_and_nothing_else_after_it(
        seed in any::<u64>(),
        loss in 0.0..0.6_f64,
        before in 0..4 * SECOND,
        mishaps in mishaps(4),
    ) {
        let (drones, base) = (4, 4);
        let mut net = Net::row(Setup { loss, ..Setup::default() }, seed, drones + 1, |_| Unsealed);
        net.stick = Some(EXPLORE);
        net.run(before);
        net.order(base, Order::Stop);
        let mut booted_at = vec![net.now; drones];
        for mishap in mishaps {
            match mishap {
                Mishap::Reboot(drone) => {
                    net.reboot(drone);
                    booted_at[drone] = net.now;
                }
                Mishap::Order(order) => {
                    net.order(base, order);
                }
                Mishap::Wait(span) => net.run(span),
            }
        }
        net.run(60 * SECOND);
        for (drone, &since) in booted_at.iter().enumerate() {
            let received = orders(&net, drone, since);
            let first = received.iter().position(|order| *order == Order::Stop);
            prop_assert!(first.is_some(), "drone {} has received {:?}", drone, received);
            let after = &received[first.unwrap_or_default()..];
            prop_assert!(after.iter().all(|order| *order == Order::Stop), "{}: {:?}", drone, received);
        }
    }
}
