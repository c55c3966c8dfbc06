//! A Stop, once ordered, stands: no later order of the operator replaces it, and every drone hears
//! of it, however often it reboots.

use airlink::Event;
use proptest::prelude::*;
use units::{MetresPerSecond, Order};

use crate::common::clear::Clear;
use crate::common::net::{Net, Setup};
use crate::common::seeded;

const SECOND: u64 = 1_000_000;
const EXPLORE: Order = Order::Explore(MetresPerSecond(0.3));

/// The orders that `node` has heard since `since`, in µs.
fn orders(net: &Net<Clear>, node: usize, since: u64) -> Vec<Order> {
    let heard = net.said.iter().filter(|said| said.to == node && said.at >= since);
    heard
        .filter_map(|said| match said.event {
            Event::Order { task, .. } => Some(task),
            _ => None,
        })
        .collect()
}

/// A client that goes on sending hover set-points after the operator has pressed the red button.
#[test]
fn a_stick_does_not_replace_a_stop() {
    let mut net = Net::row(Setup::default(), 1, 4, |_| Clear);
    net.stick = Some(EXPLORE);
    net.run(5 * SECOND);
    assert!(net.order(3, Order::Stop));
    let since = net.now;
    net.run(100_000);
    assert!(!net.order(3, EXPLORE), "the base answers that the order does not stand");
    net.run(10 * SECOND);
    for drone in 0..3 {
        let heard = orders(&net, drone, since);
        let first = heard.iter().position(|order| *order == Order::Stop);
        let first = first.unwrap_or_else(|| panic!("drone {drone} has heard {heard:?}"));
        assert!(heard[first..].iter().all(|order| *order == Order::Stop), "{drone}: {heard:?}");
    }
}

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
    fn every_drone_hears_of_a_stop_and_of_nothing_after_it(
        seed in any::<u64>(),
        loss in 0.0..0.6_f64,
        before in 0..4 * SECOND,
        mishaps in mishaps(4),
    ) {
        let (drones, base) = (4, 4);
        let mut net = Net::row(Setup { loss, ..Setup::default() }, seed, drones + 1, |_| Clear);
        net.stick = Some(EXPLORE);
        net.run(before);
        net.order(base, Order::Stop);
        let mut born = vec![net.now; drones];
        for mishap in mishaps {
            match mishap {
                Mishap::Reboot(drone) => {
                    net.reboot(drone);
                    born[drone] = net.now;
                }
                Mishap::Order(order) => {
                    net.order(base, order);
                }
                Mishap::Wait(span) => net.run(span),
            }
        }
        net.run(60 * SECOND);
        for (drone, &since) in born.iter().enumerate() {
            let heard = orders(&net, drone, since);
            let first = heard.iter().position(|order| *order == Order::Stop);
            prop_assert!(first.is_some(), "drone {} has heard {:?}", drone, heard);
            let after = &heard[first.unwrap_or_default()..];
            prop_assert!(after.iter().all(|order| *order == Order::Stop), "{}: {:?}", drone, heard);
        }
    }
}
