//! The turns of a chain without a common clock: packets do not overlap for long.

use crate::common;
use crate::common::net::{Net, Received, Sent, Setup};
use crate::common::unsealed::Unsealed;
use crate::common::{Rng, identity, seeded};
use airlink::{Airlink, Event, LinkConfig, Schedule, Standing};
use proptest::prelude::*;
use units::{Dbm, Duration, Instant, MetresPerSecond, Order};
use wire::p2p::{Epoch, Header, Kind, Membership, Wave};
use wire::radio::Datarate;

const SECOND: u64 = 1_000_000;
const FRAME: u64 = 100_000;

fn lossy() -> Setup {
    Setup { loss: 0.2, late: 150, ..Setup::default() }
}

/// Pairs of packets that were on the air at the same time, of senders up to `apart` places apart.
fn overlaps(net: &Net<Unsealed>, since: u64, apart: usize) -> usize {
    let mut sent: Vec<_> = net.sent.iter().filter(|sent| sent.start >= since).collect();
    sent.sort_by_key(|sent| sent.start);
    let near = |a: usize, b: usize| net.nodes[a].position.abs_diff(net.nodes[b].position) <= apart;
    let overlap = |pair: &&[&Sent]| pair[1].start < pair[0].end && near(pair[0].from, pair[1].from);
    sent.windows(2).filter(overlap).count()
}

/// The difference in µs between the frames of a packet's sender and of the base, at 2 Mbit/s. Up to
/// 1.1 ms of it are the packet's jitter and its time to the radio. The second packet of a turn comes
/// 1,362 µs after the first.
fn off_frame(sent: &Sent, base: &Sent) -> u64 {
    let frame = |sent: &Sent| {
        let header = Header::decode(&sent.bytes).unwrap().0;
        let owner = u64::from(header.owner.0);
        let slot = match header.wave {
            Wave::Outward => 2 * (15 - owner),
            Wave::Inward => 2 * owner + 1,
        };
        sent.start + FRAME - slot * 3_125 - u64::from(header.place) * 1_362
    };
    let ahead = (frame(sent) + 1_000 * FRAME - frame(base)) % FRAME;
    ahead.min(FRAME - ahead)
}

#[test]
fn in_a_settled_chain_no_two_packets_overlap_where_both_are_heard() {
    // Two packets meet at a receiver when their senders are two places apart at most; those six
    // places apart share their turns.
    let table = [
        (Datarate::Mbit2, 16, 5, 150),
        (Datarate::Mbit1, 16, 5, 50),
        (Datarate::Mbit1, 16, 4, 150),
        (Datarate::Mbit2, 9, 5, 150),
        (Datarate::Kbit250, 8, 5, 150),
    ];
    for (datarate, nodes, apart, late) in table {
        for seed in 0..4 {
            let mut net = Net::row(Setup { datarate, late, ..lossy() }, seed, nodes, |_| Unsealed);
            // The chain settles within 30 frames.
            net.run(30 * FRAME);
            let since = net.now;
            net.run(20 * SECOND);
            assert_eq!(overlaps(&net, since, apart), 0, "{datarate:?}, {nodes} nodes, seed {seed}");
            assert_eq!(net.cut, 0, "{datarate:?}, {nodes} nodes, seed {seed}");
        }
    }
}

#[test]
fn every_node_follows_its_neighbour_towards_the_base() {
    let mut net = Net::row(lossy(), 1, 9, |_| Unsealed);
    net.run(3 * SECOND);
    for (node, follows) in net.nodes.iter().zip(1..) {
        let follows = (follows < 9).then_some(units::NodeId(follows));
        assert_eq!(node.link.status().follows, follows);
        assert_eq!(node.link.status().standing, Standing::Member);
    }
}

/// The number of frames until the neighbours of `newcomer`, which is switched on last, hear it.
fn frames_until_heard(newcomer: usize, seed: u64) -> u64 {
    let setup = Setup { range: 15, ..lossy() };
    let mut net = Net::new(setup, seed, |_| Unsealed);
    let others: Vec<_> = (0..9).filter(|node| *node != newcomer).collect();
    for node in others {
        net.add(identity(node, 9), node, 1);
    }
    let settles = 4 * SECOND + net.rng.below(SECOND);
    net.run(settles);
    let (came_at, before) = (net.now, net.collisions);
    net.add(identity(newcomer, 9), newcomer, 1);
    net.run(3 * SECOND);
    assert_eq!(net.collisions, before, "a newcomer fits in");
    let is_heard = |to: usize| {
        net.received.iter().find(|received| {
            received.to == to
                && matches!(&received.event, Event::Report { from, .. } if usize::from(from.0) == newcomer)
        })
    };
    let last = (0..8)
        .filter(|to| net.nodes[*to].position.abs_diff(newcomer) == 1)
        .map(|to| is_heard(to).map_or(u64::MAX, |received| received.at));
    last.max().unwrap().saturating_sub(came_at) / FRAME
}

#[test]
fn a_newcomer_is_heard_within_fifteen_frames() {
    let mut all: Vec<u64> = [0, 4, 8]
        .into_iter()
        .flat_map(|node| (0..6).map(move |seed| frames_until_heard(node, seed)))
        .collect();
    println!(
        "frames until heard: p50 {}, most {}",
        common::quantile(&mut all, 0.5),
        all[all.len() - 1]
    );
    assert!(common::quantile(&mut all, 0.95) <= 15, "{all:?}");
}

fn standing(net: &Net<Unsealed>, node: usize) -> Standing {
    net.nodes[node].link.status().standing
}

#[test]
fn of_two_nodes_with_one_number_the_newcomer_falls_silent() {
    // The newcomer's epoch is the earlier or the later one.
    for (epoch, seed) in [(1, 1), (9, 2), (1, 3), (9, 4)] {
        let mut net = Net::new(Setup { range: 2, ..lossy() }, seed, |_| Unsealed);
        for node in 0..5 {
            net.add(identity(node, 5), node, 5);
        }
        net.run(4 * SECOND);
        let twin = net.add(identity(2, 5), 2, epoch);
        net.run(4 * SECOND);
        assert_eq!(standing(&net, twin), Standing::Refused, "epoch {epoch}");
        assert_eq!(standing(&net, 2), Standing::Member);
        let (since, seen) = (net.sent.len(), net.received.len());
        net.run(3 * SECOND);
        assert!(net.sent[since..].iter().all(|sent| sent.from != twin));
        // The first node is heard as before: 12 times of 15, give or take 1.5.
        let heard = net.received[seen..].iter().filter(|received| {
            received.to == 1 && matches!(&received.event, Event::Report { from, .. } if from.0 == 2)
        });
        assert!(heard.count() > 6);
    }
}

#[test]
fn of_two_settled_nodes_with_one_number_that_meet_one_goes_on() {
    for (a, b) in [(3, 7), (7, 3)] {
        let mut net = Net::new(Setup { loss: 0.2, ..Setup::default() }, 5, |_| Unsealed);
        for (node, place) in [(1, 0), (2, 1), (1, 10), (2, 11)] {
            let epoch = if place < 5 { a } else { b };
            net.add(identity(node, 4), place, epoch);
        }
        net.run(4 * SECOND);
        assert!((0..4).all(|node| standing(&net, node) == Standing::Member));
        for node in [2, 3] {
            net.nodes[node].position -= 9;
        }
        net.run(5 * SECOND);
        let goes_on = [standing(&net, 1), standing(&net, 3)].map(|s| s == Standing::Member);
        assert_eq!(goes_on, [a < b, b < a], "the earlier epoch stays");
    }
}

#[test]
fn a_node_that_is_switched_off_and_on_is_heard_again() {
    let mut net = Net::row(lossy(), 3, 6, |_| Unsealed);
    net.run(4 * SECOND);
    net.nodes[3].on = false;
    net.run(1_200_000);
    net.reboot(3);
    let seen = net.received.len();
    net.run(2 * SECOND);
    for to in [2, 4] {
        let heard = net.received[seen..].iter().any(|received| {
            received.to == to
                && matches!(&received.event, Event::Report { from, .. } if from.0 == 3)
        });
        assert!(heard, "node {to} does not hear it again");
    }
    let joined = |received: &Received| {
        matches!(&received.event, Event::Membership { membership: Membership::Join, .. })
    };
    assert!(net.received[seen..].iter().any(joined));
}

fn is_leave(received: &Received) -> bool {
    matches!(received.event, Event::Membership { membership: Membership::Leave, .. })
}

#[test]
fn a_node_that_leaves_is_forgotten_at_once_and_silent_for_good() {
    let mut net = Net::row(Setup { late: 150, ..Setup::default() }, 4, 6, |_| Unsealed);
    net.run(4 * SECOND);
    assert_eq!(net.nodes[2].link.status().follows, Some(units::NodeId(3)));
    let (since, seen) = (net.sent.len(), net.received.len());
    net.leave(3);
    net.run(FRAME);
    let own: Vec<_> = net.sent[since..].iter().filter(|sent| sent.from == 3).collect();
    assert!(
        own.len() == 2
            && own.iter().all(|sent| Net::<Unsealed>::kind(&sent.bytes) == Kind::Membership)
    );
    assert_eq!(standing(&net, 3), Standing::Left);
    let heard: Vec<_> = net.received[seen..]
        .iter()
        .filter(|received| is_leave(received))
        .map(|received| received.to)
        .collect();
    assert!(heard == [2, 4] || heard == [4, 2], "each neighbour hears it once: {heard:?}");
    assert_eq!(net.nodes[2].link.status().follows, None);
    let (since, seen) = (net.sent.len(), net.received.len());
    net.run(5 * SECOND);
    assert!(net.sent[since..].iter().all(|sent| sent.from != 3));
    let named = net.received[seen..].iter().any(|received| {
        matches!(&received.event, Event::Report { report, .. } if report.heard.iter().any(|heard| heard.node.0 == 3))
    });
    assert!(!named);
}

/// A node that has left does not wait until its number is free, as one does that was switched off.
#[test]
fn a_node_that_has_left_and_comes_back_is_soon_heard() {
    for seed in 0..4 {
        let mut net = Net::row(lossy(), seed, 6, |_| Unsealed);
        net.run(4 * SECOND);
        net.leave(3);
        net.run(FRAME);
        net.reboot(3);
        let (back_at, seen) = (net.now, net.received.len());
        net.run(2 * SECOND);
        for to in [2, 4] {
            let taken = |received: &&Received| {
                received.to == to
                    && matches!(&received.event, Event::Report { from, .. } if from.0 == 3)
            };
            let first = net.received[seen..].iter().find(taken).unwrap();
            assert!(first.at - back_at < 12 * FRAME, "{} frames", (first.at - back_at) / FRAME);
        }
        assert_eq!(net.nodes[3].link.counters().refused.twin, 0);
    }
}

#[test]
fn a_node_that_leaves_before_it_has_sent_sends_nothing() {
    let mut net = Net::row(lossy(), 1, 3, |_| Unsealed);
    let newcomer = net.add(identity(3, 5), 3, 1);
    net.leave(newcomer);
    assert_eq!(net.nodes[newcomer].link.due(), None);
    net.run(2 * SECOND);
    assert!(net.sent.iter().all(|sent| sent.from != newcomer));
}

/// Two halves of a chain that have settled out of range of each other meet.
#[test]
fn two_halves_that_meet_agree_on_one_frame() {
    let mut worst = 0;
    for seed in 0..8 {
        let mut net = Net::new(lossy(), seed, |_| Unsealed);
        for node in 0..10 {
            net.add(identity(node, 10), if node < 5 { node } else { node + 20 }, 1);
        }
        net.run(4 * SECOND);
        for node in 0..5 {
            net.nodes[node].position += 20;
        }
        let met_at = net.now;
        net.run(8 * SECOND);
        let base = net.sent.iter().rev().find(|sent| sent.from == 9).unwrap();
        let off = |sent: &&Sent| sent.start >= met_at && off_frame(sent, base) > 2_000;
        let last = net.sent.iter().rev().find(off);
        let frames = last.map_or(0, |sent| (sent.start - met_at) / FRAME);
        worst = worst.max(frames);
        let follows: Vec<_> = net.nodes.iter().map(|node| node.link.status().follows).collect();
        assert!(follows[..9].iter().all(Option::is_some), "{follows:?}");
    }
    println!("two halves agree after {worst} frames at most");
    assert!(worst <= 30, "{worst} frames");
}

#[test]
fn when_the_base_dies_the_chain_keeps_its_turns() {
    let mut net = Net::row(lossy(), 2, 9, |_| Unsealed);
    net.run(4 * SECOND);
    net.nodes[8].on = false;
    let since = net.now;
    net.run(60 * SECOND);
    assert_eq!(overlaps(&net, since, 5), 0);
}

/// `due` is `None` or in the future while there is nothing to send, so that few calls are in vain.
#[test]
fn transmit_is_called_a_few_times_for_each_packet_at_most() {
    let identity = identity(1, 3);
    let schedule = Schedule::new(Datarate::Mbit2, identity.node).unwrap();
    let config = LinkConfig::DEFAULT;
    let mut now = Instant::from_millis(1_234);
    let mut link = Airlink::new(config, identity, Unsealed, Epoch::FIRST, schedule, now);
    let (mut calls, mut rng) = (0, Rng(1));
    let mut out = [0; 60];
    while now < Instant::from_millis(101_234) {
        // A report comes at any moment, also in the middle of a turn.
        let pause = Duration::from_micros(rng.below(400_000));
        let until = now + pause;
        link.report(common::report());
        while let Some(due) = link.due()
            && due <= until
        {
            now = now.max(due);
            calls += 1;
            let _ = link.transmit(now, &mut out);
        }
        now = until;
    }
    let sent = link.counters().sent.total();
    assert!(calls < 4 * sent, "{calls} calls for {sent} packets");
}

/// Whether the link, called when it was due, sends a packet. If it does not, its next due time must
/// be later, even if the call was late or the frame has moved; the simulated channel asserts it,
/// too.
fn sends_or_is_due_later(
    link: &mut Airlink<Unsealed>,
    now: Instant,
) -> Result<bool, TestCaseError> {
    let mut out = [0; 60];
    if link.transmit(now, &mut out).is_some() {
        return Ok(true);
    }
    let due = link.due();
    prop_assert!(due.is_none_or(|due| due > now), "due {due:?} at {now:?}");
    Ok(false)
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn a_node_that_had_nothing_to_send_is_due_later_or_never(
        node in 0_usize..16,
        steps in prop::collection::vec((0..4, 0_u64..30_000, 0_u64..4_000), 1..200),
    ) {
        let at = Instant::from_millis(1_234);
        let with = |node: usize| {
            let schedule = Schedule::new(Datarate::Mbit2, identity(node, 16).node).unwrap();
            let identity = identity(node, 16);
            Airlink::new(LinkConfig::DEFAULT, identity, Unsealed, Epoch::FIRST, schedule, at)
        };
        let (mut link, mut other) = (with(node), with((node + 1) % 16));
        let mut now = at;
        for (action, pause, late) in steps {
            now = now + Duration::from_micros(pause);
            match action {
                0 => link.report(common::report()),
                1 => {
                    // The other node's frame may have any phase.
                    let mut out = [0; 60];
                    other.report(common::report());
                    let due = other.due().unwrap();
                    if let Some(length) = other.transmit(due, &mut out) {
                        let _ = link.receive(now, Dbm(-60.0), &out[..length]);
                    }
                }
                2 => {
                    link.order(now, Order::explore(MetresPerSecond(0.1)));
                }
                _ => link.telemeter(common::telemetry()),
            }
            if let Some(due) = link.due() {
                now = now.max(due) + Duration::from_micros(late);
                while sends_or_is_due_later(&mut link, now)? {}
            }
        }
    }
}
