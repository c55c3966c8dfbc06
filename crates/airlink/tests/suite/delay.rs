//! How long an order takes, what it costs, and whom it reaches. `-- --nocapture` prints the figures.

use crate::common::clear::Clear;
use crate::common::net::{Net, ROUND, Setup};
use crate::common::quantile;
use airlink::Event;
use units::{MetresPerSecond, Order};
use wire::radio::Datarate;

struct Figures {
    p50: u64,
    p95: u64,
    /// Of all senders together, of the time.
    air: f64,
}

/// From the moment that the operator says something new to the moment that the head has it or
/// something newer, in ms. `before` is done to a chain that has been flying for 4 s.
fn delays(setup: &Setup, hops: usize, seeds: u64, before: fn(&mut Net<Clear>)) -> Figures {
    let mut all = Vec::new();
    let mut air = 0.0;
    for seed in 0..seeds {
        let mut net = Net::row(setup.clone(), seed, hops + 1, |_| Clear);
        net.run(4_000_000);
        before(&mut net);
        let (begin, first) = (net.now, net.sent.len());
        for word in 1..40 {
            let speed = word as f32 * 0.001;
            let task = Order::Explore(MetresPerSecond(speed));
            // The operator's stick, whenever it moves, and then in every round of the base.
            let said_at = net.now;
            net.stick = Some(task);
            net.order(hops, task);
            let seen = net.said.len();
            let pause = 700_000 + net.chance.below(200_000);
            net.run(pause);
            let got = net.said[seen..].iter().find(|said| {
                said.to == 0
                    && matches!(said.event, Event::Order { task: Order::Explore(got), .. } if got.0 >= speed - 1e-4)
            });
            all.push(got.map_or(1_000, |said| (said.at - said_at) / 1000));
        }
        let on_air: u64 = net.sent[first..].iter().map(|sent| sent.end - sent.start).sum();
        air += on_air as f64 / (net.now - begin) as f64 / seeds as f64;
    }
    let [p50, p95] = [0.5, 0.95].map(|p| quantile(&mut all, p));
    Figures { p50, p95, air }
}

/// Chains of each length and loss; `LinkConfig::DEFAULT` has the figures of 40.
const SEEDS: u64 = 3;

/// A chain that flies for a minute, the operator's stick saying something else in every round.
#[derive(Default)]
struct Flight {
    /// From the stick to the head, or until a later word of it got there, ms.
    pilot: Vec<u64>,
    /// How old telemetry is that comes to the base, ms.
    telemetry: Vec<u64>,
    /// Of the drone that the base hears least of, how often in a second.
    rarest: f64,
    /// Until the head has the first word, from the first one of all, ms.
    first: u64,
    air: f64,
}

fn flight(setup: &Setup, nodes: usize, seed: u64) -> Flight {
    const SETTLES: u64 = 10_000_000;
    const WORDS: usize = 350;
    const FLIES: f64 = 60.0;
    let mut net = Net::row(setup.clone(), seed, nodes, |_| Clear);
    let began = net.now;
    let (mut given, mut heard, mut air) = (Vec::new(), vec![u64::MAX; WORDS + 1], 0);
    for word in 0..WORDS {
        given.push(net.now);
        net.order(nodes - 1, Order::Explore(MetresPerSecond(word as f32 * 0.001)));
        net.run(ROUND);
    }
    net.run(5_000_000);
    let (from, until) = (began + SETTLES, given[WORDS - 1]);
    let mut flight = Flight::default();
    let mut told = vec![0; nodes - 1];
    for said in &net.said {
        match said.event {
            Event::Order { task: Order::Explore(speed), .. } if said.to == 0 => {
                let word = (speed.0 * 1000.0).round() as usize;
                heard[word] = heard[word].min(said.at);
            }
            Event::Telemetry { from: node, telemetry, .. } if (from..until).contains(&said.at) => {
                told[usize::from(node.0)] += 1;
                let taken = (f64::from(telemetry.odometer.0) * 1000.0).round() as u64;
                flight.telemetry.push((said.at / 1000).saturating_sub(taken));
            }
            _ => {}
        }
    }
    for word in (0..WORDS).rev() {
        heard[word] = heard[word].min(heard[word + 1]);
        if given[word] >= from {
            flight.pilot.push((heard[word].min(99_999_000 + given[word]) - given[word]) / 1000);
        }
    }
    flight.first = (heard[0].min(99_999_000 + began) - began) / 1000;
    flight.rarest = told.into_iter().min().map_or(0.0, |least| f64::from(least) / FLIES);
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

/// At 50 and 70 % a hop takes two and three tries, and there are eight or fifteen of them.
#[test]
fn a_chain_that_loses_most_packets_is_still_steered() {
    println!("nodes  loss  pilot p50  p95 ms  first  telemetry p50  p95 ms  rarest/s    air");
    let table = [
        (9, 0.2, 330, 2_000, 0.8, 0.06),
        (9, 0.5, 850, 5_000, 0.3, 0.08),
        (9, 0.7, 2_000, 12_000, 0.08, 0.08),
        (16, 0.2, 480, 2_500, 0.6, 0.13),
        (16, 0.5, 1_400, 6_000, 0.1, 0.15),
        (16, 0.7, 4_000, 20_000, 0.0, 0.15),
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
        let what = format!("{nodes} nodes at {loss}");
        assert!(p95 <= limit && sum.first <= first, "{what}: {p95} ms, first {} ms", sum.first);
        assert!(
            sum.rarest >= rarest,
            "{what}: telemetry of one comes {} times a second",
            sum.rarest
        );
        assert!(sum.air <= most, "{what}: {} of the air", sum.air);
    }
}

/// The bounds are a quarter above what was measured.
#[test]
fn an_order_reaches_the_head_within_half_a_second() {
    println!("rate     hops  loss  earshot  p50 ms  p95 ms  air time");
    let table = [
        (Datarate::Mbit2, 3, 0.2, 1, 230, 0.03),
        (Datarate::Mbit2, 8, 0.0, 1, 180, 0.06),
        (Datarate::Mbit2, 8, 0.2, 1, 300, 0.06),
        (Datarate::Mbit2, 8, 0.3, 1, 500, 0.07),
        (Datarate::Mbit2, 8, 0.2, 2, 180, 0.06),
        (Datarate::Mbit2, 15, 0.2, 1, 650, 0.13),
        (Datarate::Mbit1, 8, 0.2, 1, 350, 0.12),
        (Datarate::Kbit250, 7, 0.2, 1, 1000, 0.4),
    ];
    for (datarate, hops, loss, earshot, limit, most) in table {
        let setup = Setup { datarate, loss, earshot, late: 100, ..Setup::default() };
        let Figures { p50, p95, air } = delays(&setup, hops, 4, |_| {});
        println!(
            "{:8} {hops:4}  {loss:4}  {earshot:7}  {p50:6}  {p95:6}  {air:8.3}",
            format!("{datarate:?}")
        );
        assert!(p95 <= limit && air <= most, "{hops} hops at {loss}: {p95} ms, {air}");
    }
}

/// One dies in the middle, and the next can be heard: the chain closes by itself.
#[test]
fn an_order_gets_round_a_dead_node() {
    let setup = Setup { loss: 0.2, earshot: 2, late: 100, ..Setup::default() };
    let Figures { p50, p95, .. } = delays(&setup, 8, 4, |net| net.nodes[4].on = false);
    println!("8 hops, one dead: p50 {p50} ms, p95 {p95} ms");
    assert!(p95 <= 350, "{p95} ms");
}

/// When the last of `nodes` but the base has the order to stop, in ms.
fn stops(nodes: usize, seed: u64) -> u64 {
    let setup = Setup { loss: 0.2, late: 100, ..Setup::default() };
    let mut net = Net::row(setup, seed, nodes, |_| Clear);
    net.stick = Some(Order::Explore(MetresPerSecond(0.3)));
    // A busy chain of 16 takes some seconds until the base has heard everybody, and whom it has not
    // heard it can tell nothing.
    let settles = 10_000_000 + net.chance.below(1_000_000);
    net.run(settles);
    let (said_at, seen) = (net.now, net.said.len());
    net.stick = Some(Order::Stop);
    net.order(nodes - 1, Order::Stop);
    net.run(3_000_000);
    let stopped = |node: usize| {
        net.said[seen..].iter().find(|said| {
            said.to == node && matches!(said.event, Event::Order { task: Order::Stop, .. })
        })
    };
    let times =
        (0..nodes - 1).map(|node| stopped(node).map_or(9_000, |said| (said.at - said_at) / 1000));
    times.max().unwrap()
}

/// Up to 9 within one, 16 within two, mostly: each order is for one node alone, and a turn carries
/// two.
#[test]
fn everybody_stops_within_a_second_or_two() {
    for (nodes, limit) in [(5, 1_000), (9, 1_000), (16, 2_000)] {
        let mut all: Vec<u64> = (0..20).map(|seed| stops(nodes, seed)).collect();
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
    let setup = Setup { loss: 0.2, earshot: 2, late: 100, ..Setup::default() };
    let mut net = Net::row(setup, 7, 9, |_| Clear);
    for word in 0..50 {
        net.stick =
            Some(if word % 9 == 8 { Order::Wait } else { Order::Explore(MetresPerSecond(0.1)) });
        net.run(300_000);
    }
    for node in 0..8 {
        let counters: Vec<_> = net
            .said
            .iter()
            .filter(|said| said.to == node)
            .filter_map(|said| match said.event {
                Event::Order { counter, .. } => Some(counter),
                _ => None,
            })
            .collect();
        assert!(counters.len() > 5, "node {node} has been told {} times", counters.len());
        assert!(counters.is_sorted_by(|a, b| a < b));
    }
}

#[test]
fn the_base_hears_everybodys_telemetry() {
    for (nodes, loss) in [(9, 0.2), (16, 0.2)] {
        let setup = Setup { loss, late: 100, ..Setup::default() };
        let mut net = Net::row(setup, 3, nodes, |_| Clear);
        net.stick = Some(Order::Explore(MetresPerSecond(0.1)));
        net.run(20_000_000);
        for node in 0..nodes - 1 {
            let heard = net
                .said
                .iter()
                .filter(|said| said.to == nodes - 1)
                .filter(|said| matches!(said.event, Event::Telemetry { from, .. } if usize::from(from.0) == node))
                .count();
            println!("{nodes} nodes: {heard} of node {node} in 20 s");
            assert!(heard >= 8, "{heard} of node {node}");
        }
    }
}

/// The pilot lets go of the stick: nobody may fly on for ever by a word of the base's.
#[test]
fn a_silent_operator_is_not_repeated() {
    let mut net = Net::row(Setup::default(), 1, 4, |_| Clear);
    net.run(3_000_000);
    net.order(3, Order::Explore(MetresPerSecond(0.3)));
    net.run(2_000_000);
    let seen = net.said.len();
    net.run(5_000_000);
    let to_head = net.said[seen..]
        .iter()
        .filter(|said| said.to == 0 && matches!(said.event, Event::Order { .. }));
    assert_eq!(to_head.count(), 0);
}
