//! Delay, air time and reach of orders and telemetry. `-- --nocapture` prints the figures.

use crate::common::net::{Net, ROUND, Setup};
use crate::common::quantile;
use crate::common::unsealed::Unsealed;
use airlink::Event;
use units::{MetresPerSecond, Order};
use wire::radio::Datarate;

/// Delay of an order to the head in ms, and the load of the air.
struct Figures {
    p50: u64,
    p95: u64,
    /// The part of the time that the packets of all senders together take.
    air: f64,
}

/// The delay in ms from a new order of the operator until the head has it or a newer one. `before`
/// is applied to the chain after it has run for 4 s.
fn delays(setup: &Setup, hops: usize, seeds: u64, before: fn(&mut Net<Unsealed>)) -> Figures {
    let mut all = Vec::new();
    let mut air = 0.0;
    for seed in 0..seeds {
        let mut net = Net::row(setup.clone(), seed, hops + 1, |_| Unsealed);
        net.run(4_000_000);
        before(&mut net);
        let (begin, first) = (net.now, net.sent.len());
        for index in 1..40 {
            let speed = index as f32 * 0.001;
            let order = Order::explore(MetresPerSecond(speed));
            // The operator gives the order at any moment, and repeats it in every round of the
            // base.
            let given_at = net.now;
            net.stick = Some(order);
            net.order(hops, order);
            let seen = net.received.len();
            let pause = 700_000 + net.rng.below(200_000);
            net.run(pause);
            let got = net.received[seen..].iter().find(|received| {
                received.to == 0
                    && matches!(received.event, Event::Order { task: Order::Explore(got), .. } if got.speed.0 >= speed - 1e-4)
            });
            all.push(got.map_or(1_000, |received| (received.at - given_at) / 1000));
        }
        let on_air: u64 = net.sent[first..].iter().map(|sent| sent.end - sent.start).sum();
        air += on_air as f64 / (net.now - begin) as f64 / seeds as f64;
    }
    let [p50, p95] = [0.5, 0.95].map(|p| quantile(&mut all, p));
    Figures { p50, p95, air }
}

/// Number of flights for each length and loss; the figures at `LinkConfig::DEFAULT` are from 40.
const SEEDS: u64 = 3;

/// Figures of a flight of a minute in which the operator gives a new order in every round.
#[derive(Default)]
struct Flight {
    /// Delay of each order to the head, or until the head has a later one, in ms.
    pilot: Vec<u64>,
    /// Age of each telemetry packet when the base has it, in ms.
    telemetry: Vec<u64>,
    /// Telemetry packets a second from the drone of which the base receives the fewest.
    rarest: f64,
    /// Time from the first order of the flight until the head has one, in ms.
    first: u64,
    /// The part of the time that packets take.
    air: f64,
}

fn flight(setup: &Setup, nodes: usize, seed: u64) -> Flight {
    const SETTLING: u64 = 10_000_000;
    const ORDERS: usize = 350;
    const MEASURED: f64 = 60.0;
    let mut net = Net::row(setup.clone(), seed, nodes, |_| Unsealed);
    let began = net.now;
    let (mut given, mut heard, mut air) = (Vec::new(), vec![u64::MAX; ORDERS + 1], 0);
    for index in 0..ORDERS {
        given.push(net.now);
        net.order(nodes - 1, Order::explore(MetresPerSecond(index as f32 * 0.001)));
        net.run(ROUND);
    }
    net.run(5_000_000);
    let (from, until) = (began + SETTLING, given[ORDERS - 1]);
    let mut flight = Flight::default();
    let mut telemetry_count = vec![0; nodes - 1];
    for received in &net.received {
        match received.event {
            Event::Order { task: Order::Explore(course), .. } if received.to == 0 => {
                let index = (course.speed.0 * 1000.0).round() as usize;
                heard[index] = heard[index].min(received.at);
            }
            Event::Telemetry { from: node, telemetry, .. }
                if (from..until).contains(&received.at) =>
            {
                telemetry_count[usize::from(node.0)] += 1;
                let taken = (f64::from(telemetry.odometer.0) * 1000.0).round() as u64;
                flight.telemetry.push((received.at / 1000).saturating_sub(taken));
            }
            _ => {}
        }
    }
    for index in (0..ORDERS).rev() {
        heard[index] = heard[index].min(heard[index + 1]);
        if given[index] >= from {
            flight.pilot.push((heard[index].min(99_999_000 + given[index]) - given[index]) / 1000);
        }
    }
    flight.first = (heard[0].min(99_999_000 + began) - began) / 1000;
    flight.rarest =
        telemetry_count.into_iter().min().map_or(0.0, |least| f64::from(least) / MEASURED);
    for sent in net.sent.iter().filter(|sent| (from..until).contains(&sent.start)) {
        air += sent.end - sent.start;
    }
    flight.air = air as f64 / (until - from) as f64;
    flight
}

fn flights(setup: &Setup, nodes: usize, seeds: u64) -> Flight {
    let mut sum = Flight { rarest: f64::MAX, ..Flight::default() };
    for seed in 0..seeds {
        let one = flight(setup, nodes, seed);
        sum.pilot.extend(one.pilot);
        sum.telemetry.extend(one.telemetry);
        sum.rarest = sum.rarest.min(one.rarest);
        sum.first = sum.first.max(one.first);
        sum.air += one.air / seeds as f64;
    }
    sum
}

/// At 50 and 70 % loss a hop takes two and three tries, and there are eight or fifteen hops.
#[test]
fn a_chain_that_loses_most_packets_is_still_steered() {
    println!("nodes  loss  pilot p50  p95 ms  first  telemetry p50  p95 ms  rarest/s    air");
    let table = [
        (9, 0.2, 200, 2_000, 0.8, 0.08),
        (9, 0.5, 350, 5_000, 0.6, 0.12),
        (9, 0.7, 850, 12_000, 0.3, 0.15),
        (16, 0.2, 270, 2_500, 0.8, 0.17),
        (16, 0.5, 520, 6_000, 0.4, 0.28),
        (16, 0.7, 950, 20_000, 0.1, 0.32),
    ];
    for (nodes, loss, limit, first, rarest, most) in table {
        let setup = Setup { loss, late: 100, ..Setup::default() };
        let mut sum = flights(&setup, nodes, SEEDS);
        let [pilot, p95] = [0.5, 0.95].map(|p| quantile(&mut sum.pilot, p));
        let [telemetry, telemetry_p95] = [0.5, 0.95].map(|p| quantile(&mut sum.telemetry, p));
        println!(
            "{nodes:5}  {loss:4}  {pilot:9}  {p95:6}  {:5}  {telemetry:13}  {telemetry_p95:6}  {:8.2}  {:5.3}",
            sum.first, sum.rarest, sum.air
        );
        let setting = format!("{nodes} nodes at {loss}");
        assert!(p95 <= limit && sum.first <= first, "{setting}: {p95} ms, first {} ms", sum.first);
        assert!(
            sum.rarest >= rarest,
            "{setting}: telemetry of one drone comes {} times a second",
            sum.rarest
        );
        assert!(sum.air <= most, "{setting}: {} of the air", sum.air);
    }
}

/// The bounds are a quarter above what was measured.
#[test]
fn an_order_reaches_the_head_within_half_a_second() {
    println!("rate     hops  loss  range  p50 ms  p95 ms  air time");
    let table = [
        (Datarate::Mbit2, 3, 0.2, 1, 120, 0.03),
        (Datarate::Mbit2, 8, 0.0, 1, 150, 0.06),
        (Datarate::Mbit2, 8, 0.2, 1, 200, 0.08),
        (Datarate::Mbit2, 8, 0.3, 1, 250, 0.09),
        (Datarate::Mbit2, 8, 0.2, 2, 180, 0.08),
        (Datarate::Mbit2, 15, 0.2, 1, 300, 0.17),
        (Datarate::Mbit1, 8, 0.2, 1, 250, 0.14),
        (Datarate::Kbit250, 7, 0.2, 1, 1000, 0.4),
    ];
    for (datarate, hops, loss, range, limit, most) in table {
        let setup = Setup { datarate, loss, range, late: 100, ..Setup::default() };
        let Figures { p50, p95, air } = delays(&setup, hops, 4, |_| {});
        println!(
            "{:8} {hops:4}  {loss:4}  {range:5}  {p50:6}  {p95:6}  {air:8.3}",
            format!("{datarate:?}")
        );
        assert!(p95 <= limit && air <= most, "{hops} hops at {loss}: {p95} ms, {air}");
    }
}

/// A node in the middle dies, and its two neighbours hear each other.
#[test]
fn an_order_gets_round_a_dead_node() {
    let setup = Setup { loss: 0.2, range: 2, late: 100, ..Setup::default() };
    let Figures { p50, p95, .. } = delays(&setup, 8, 4, |net| net.nodes[4].on = false);
    println!("8 hops, one dead: p50 {p50} ms, p95 {p95} ms");
    assert!(p95 <= 350, "{p95} ms");
}

/// The time until all of `nodes` but the base have the order to stop, in ms.
fn time_to_stop(nodes: usize, seed: u64) -> u64 {
    let setup = Setup { loss: 0.2, late: 100, ..Setup::default() };
    let mut net = Net::row(setup, seed, nodes, |_| Unsealed);
    net.stick = Some(Order::explore(MetresPerSecond(0.3)));
    // In a busy chain of 16 it takes some seconds until the base has telemetry of all nodes, and it
    // can order only those.
    let settles = 10_000_000 + net.rng.below(1_000_000);
    net.run(settles);
    let (ordered_at, seen) = (net.now, net.received.len());
    net.stick = Some(Order::Stop);
    net.order(nodes - 1, Order::Stop);
    net.run(3_000_000);
    let stopped = |node: usize| {
        net.received[seen..].iter().find(|received| {
            received.to == node && matches!(received.event, Event::Order { task: Order::Stop, .. })
        })
    };
    let times = (0..nodes - 1)
        .map(|node| stopped(node).map_or(9_000, |received| (received.at - ordered_at) / 1000));
    times.max().unwrap()
}

/// Each order is for one node alone, and a turn carries two.
#[test]
fn all_nodes_stop_within_half_a_second() {
    for (nodes, limit) in [(5, 200), (9, 400), (16, 600)] {
        let mut all: Vec<u64> = (0..20).map(|seed| time_to_stop(nodes, seed)).collect();
        let [p50, p95] = [0.5, 0.95].map(|p| quantile(&mut all, p));
        println!(
            "{nodes} nodes, all stopped: p50 {p50} ms, p95 {p95} ms, worst {:?} ms",
            all.last()
        );
        assert!(p95 <= limit, "{nodes} nodes: {p95} ms");
    }
}

#[test]
fn every_order_comes_at_most_once_and_in_order() {
    let setup = Setup { loss: 0.2, range: 2, late: 100, ..Setup::default() };
    let mut net = Net::row(setup, 7, 9, |_| Unsealed);
    for index in 0..50 {
        net.stick =
            Some(if index % 9 == 8 { Order::Wait } else { Order::explore(MetresPerSecond(0.1)) });
        net.run(300_000);
    }
    for node in 0..8 {
        let counters: Vec<_> = net
            .received
            .iter()
            .filter(|received| received.to == node)
            .filter_map(|received| match received.event {
                Event::Order { counter, .. } => Some(counter),
                _ => None,
            })
            .collect();
        assert!(counters.len() > 5, "node {node} has received {} orders", counters.len());
        assert!(counters.is_sorted_by(|a, b| a < b));
    }
}

#[test]
fn the_base_receives_telemetry_of_every_drone() {
    for (nodes, loss) in [(9, 0.2), (16, 0.2)] {
        let setup = Setup { loss, late: 100, ..Setup::default() };
        let mut net = Net::row(setup, 3, nodes, |_| Unsealed);
        net.stick = Some(Order::explore(MetresPerSecond(0.1)));
        net.run(20_000_000);
        for node in 0..nodes - 1 {
            let heard = net
                .received
                .iter()
                .filter(|received| received.to == nodes - 1)
                .filter(|received| matches!(received.event, Event::Telemetry { from, .. } if usize::from(from.0) == node))
                .count();
            println!("{nodes} nodes: {heard} of node {node} in 20 s");
            assert!(heard >= 8, "{heard} of node {node}");
        }
    }
}

/// When the operator lets go of the stick, the base must not keep the head flying.
#[test]
fn the_base_does_not_repeat_the_order_of_a_silent_operator() {
    let mut net = Net::row(Setup::default(), 1, 4, |_| Unsealed);
    net.run(3_000_000);
    net.order(3, Order::explore(MetresPerSecond(0.3)));
    net.run(2_000_000);
    let seen = net.received.len();
    net.run(5_000_000);
    let to_head = net.received[seen..]
        .iter()
        .filter(|received| received.to == 0 && matches!(received.event, Event::Order { .. }));
    assert_eq!(to_head.count(), 0);
}
