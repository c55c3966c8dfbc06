//! The session with the CRTP server that the drones run.

use std::collections::VecDeque;

use crtp::{Access, Event, Node, Outcome, Parameters, Server, Snapshot};
use proptest::prelude::*;
use units::Metres;
use wire::crtp::{SupervisorCommand, Value};
use wire::p2p::Telemetry;

use super::*;
use crate::order::Way;

/// A base of the drones' own CRTP server, which hears one drone.
struct Base {
    server: Server,
    parameters: Parameters,
    snapshot: Snapshot,
    stops: usize,
    /// Whether the base gives the stop, whatever it is asked for.
    is_stopped: bool,
    /// Whether packets to the base are lost.
    is_deaf: bool,
    /// The time of an answer on its way, ms.
    delay: u64,
    on_the_way: VecDeque<(u64, Packet)>,
}

impl Base {
    fn new() -> Self {
        let mut parameters = Parameters::DEFAULT;
        (parameters.about.node, parameters.about.role) = (NodeId(4), Role::Base);
        Self {
            server: Server::new(),
            parameters,
            snapshot: Snapshot::DEFAULT,
            stops: 0,
            is_stopped: false,
            is_deaf: false,
            delay: 0,
            on_the_way: VecDeque::new(),
        }
    }

    fn hears(&mut self, now: Instant, state: u8) {
        let telemetry = Telemetry {
            state,
            fault: 0,
            battery: None,
            endurance: None,
            front: None,
            back: None,
            odometer: Metres::ZERO,
            velocity: units::MetresPerSecond::ZERO,
            height: None,
            heeded: 0,
        };
        self.snapshot.nodes[2] = Some(Node { telemetry, heard: now });
    }

    /// Carries packets both ways for a while, in steps of 10 ms; returns those of the session.
    fn talk(
        &mut self,
        session: &mut Session,
        ms: std::ops::Range<u64>,
        speech: Speech,
    ) -> Vec<Packet> {
        let mut sent = Vec::new();
        for now in ms.step_by(10).map(Instant::from_millis) {
            self.snapshot.taken = now;
            while let Some(packet) = session.poll(now, speech) {
                sent.push(packet);
                if self.is_deaf {
                    continue;
                }
                let Self { server, parameters, stops, is_stopped, .. } = self;
                server.receive(
                    now,
                    packet.bytes(),
                    Access::Full,
                    parameters,
                    |event, parameters| {
                        *stops += usize::from(event == Event::EmergencyStop);
                        if *is_stopped {
                            parameters.show(units::Order::Stop);
                        }
                        Outcome::Done
                    },
                );
                self.answer(session, now);
            }
            self.answer(session, now);
        }
        sent
    }

    fn answer(&mut self, session: &mut Session, now: Instant) {
        let ms = now.as_micros() / 1_000;
        while let Some(packet) = self.server.poll(now, &self.snapshot, &self.parameters) {
            self.on_the_way.push_back((ms + self.delay, packet));
        }
        while let Some((_, packet)) = self.on_the_way.pop_front_if(|(at, _)| *at <= ms) {
            session.receive(now, &packet);
        }
    }
}

fn connected() -> (Base, Session) {
    let (mut base, mut session) = (Base::new(), Session::default());
    base.hears(Instant::ZERO, 3);
    base.talk(&mut session, 0..5_000, Speech::Steered);
    assert!(matches!(session.stage, Stage::Ready(_)), "{:?}", session.stage);
    (base, session)
}

fn is_stop(packet: &Packet) -> bool {
    *packet == Request::Command(SupervisorCommand::EmergencyStop).packet()
}

#[test]
fn a_session_learns_the_base_and_hears_its_drones() {
    let (_, mut session) = connected();
    let news = session.take_news();
    assert!(news.iter().any(|news| matches!(news, News::Ready(facts) if facts.node == NodeId(4))));
    let is_drone = |news: &News| matches!(news, News::Block(Block::Drone(NodeId(2), _)));
    assert!(news.iter().any(is_drone), "{news:?}");
    assert!(news.contains(&News::Task(0)));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    /// While no page steers, nothing is sent but a stop, whatever was ordered before.
    #[test]
    fn without_a_page_only_a_stop_is_sent(
        order_at in 0_u64..100,
        stop in any::<bool>(),
        silence in 1_u64..20,
    ) {
        let (mut base, mut session) = connected();
        base.talk(&mut session, 5_000..5_000 + order_at, Speech::Steered);
        let is_given = session.order(Order::Explore { speed: 0.3 }, Instant::from_millis(30_000));
        prop_assert!(is_given);
        let from = 6_000;
        if stop {
            session.stopping.order(Instant::from_millis(from), [NodeId(2)].into_iter());
        }
        let sent = base.talk(&mut session, from..from + 1_000 * silence, Speech::StopOnly);
        prop_assert!(sent.iter().all(is_stop), "{sent:?}");
        prop_assert_eq!(sent.len() as u64, if stop { 5 * silence } else { 0 });
        prop_assert_eq!(base.stops, sent.len());
    }
}

#[test]
fn a_stop_is_sent_before_the_base_is_known_and_ends_with_the_last_answer() {
    let (mut base, mut session) = (Base::new(), Session::default());
    session.stopping.order(Instant::ZERO, std::iter::empty());
    let sent = base.talk(&mut session, 0..10, Speech::Steered);
    assert!(is_stop(&sent[0]), "{sent:?}");
    let (mut base, mut session) = connected();
    session.stopping.order(Instant::from_millis(6_000), [NodeId(2)].into_iter());
    base.talk(&mut session, 6_000..7_000, Speech::Steered);
    assert!(session.stopping.is_sending());
    base.hears(Instant::from_millis(7_000), 9);
    base.talk(&mut session, 7_000..8_000, Speech::Steered);
    assert!(!session.stopping.is_sending());
}

const ORDERS: [Order; 7] = [
    Order::Wait,
    Order::Hold,
    Order::Explore { speed: 0.2 },
    Order::Branch { way: Way::Left },
    Order::Recall,
    Order::Land,
    Order::Perch,
];

/// Gives two orders, 60 ms apart, to a base whose answers take `delay` ms; returns the base's parameters
/// and what became of the second order.
fn in_turn(stops: bool, delay: u64, orders: [Order; 2]) -> (Parameters, Fate) {
    let (mut base, mut session) = connected();
    (base.delay, base.is_stopped) = (delay, stops);
    session.take_news();
    for (order, at) in orders.into_iter().zip([5_000, 5_060]) {
        assert!(session.order(order, Instant::from_millis(at + 500)));
        base.talk(&mut session, at..at + 60, Speech::Steered);
    }
    base.talk(&mut session, 5_120..6_000, Speech::Steered);
    let mut fates = session.take_news().into_iter().filter_map(|news| match news {
        News::Order(order, fate) => Some((order, fate)),
        _ => None,
    });
    let (order, fate) = fates.next_back().unwrap();
    assert_eq!(order, orders[1]);
    (base.parameters, fate)
}

/// The answers to an earlier order, which come while the next one is given, say nothing about it: it used
/// to be called refused, and its second parameter was never set.
#[test]
fn an_order_that_is_followed_is_never_called_refused() {
    for delay in [0, 70, 110, 200] {
        for before in ORDERS {
            for order in ORDERS {
                let (parameters, fate) = in_turn(false, delay, [before, order]);
                assert_eq!(fate, Fate::Taken, "{before:?}, then {order:?}, {delay} ms");
                let (at_once, _) = in_turn(false, 0, [before, order]);
                match order {
                    Order::Branch { .. } => assert_eq!(parameters.branch, at_once.branch),
                    _ => assert_eq!(parameters.order(), at_once.order(), "{before:?}, {order:?}"),
                }
            }
        }
    }
}

/// The answer to an earlier order with the same value comes while the base no longer hears the station: it
/// used to be taken for the answer to the next order, which never arrived.
#[test]
fn an_order_that_the_base_has_not_heard_is_never_called_taken() {
    for delay in [70, 110, 150, 200, 400] {
        for order in ORDERS {
            let (mut base, mut session) = connected();
            base.delay = delay;
            session.take_news();
            let other = if order == Order::Wait { Order::Recall } else { Order::Wait };
            for (order, at) in [(order, 5_000), (other, 5_060), (order, 5_120)] {
                base.is_deaf = at == 5_120;
                assert!(session.order(order, Instant::from_millis(at + 500)));
                base.talk(&mut session, at..at + 60, Speech::Steered);
            }
            base.talk(&mut session, 5_180..6_000, Speech::Steered);
            let news = session.take_news();
            let last = news.iter().rfind(|news| matches!(news, News::Order(..)));
            assert_eq!(last, Some(&News::Order(order, Fate::NotAnswered)), "{order:?}, {delay} ms");
        }
    }
}

#[test]
fn a_base_that_is_stopped_refuses_every_task() {
    for delay in [0, 70, 200] {
        for order in ORDERS.into_iter().filter(|order| !matches!(order, Order::Branch { .. })) {
            let (_, fate) = in_turn(true, delay, [Order::Land, order]);
            assert_eq!(fate, Fate::Refused, "{order:?}, {delay} ms");
        }
    }
}

#[test]
fn a_base_that_was_restarted_sends_its_blocks_again() {
    let (_, mut session) = connected();
    let mut base = Base::new();
    base.hears(Instant::from_millis(9_000), 8);
    session.take_news();
    base.talk(&mut session, 9_000..14_000, Speech::Steered);
    let is_landed = |news: &News| matches!(news, News::Block(Block::Drone(NodeId(2), report)) if report.state == 8);
    assert!(session.take_news().iter().any(is_landed));
}

#[test]
fn a_relay_is_no_base() {
    let (mut base, mut session) = (Base::new(), Session::default());
    (base.parameters.about.node, base.parameters.about.role) = (NodeId(1), Role::Relay);
    base.talk(&mut session, 0..5_000, Speech::Steered);
    assert_eq!(session.take_news(), [News::NotBase(NodeId(1))]);
    session.begin_anew();
    let mut base = Base::new();
    base.talk(&mut session, 5_000..9_000, Speech::Steered);
    let is_ready = |news: &News| matches!(news, News::Ready(facts) if facts.node == NodeId(4));
    assert!(session.take_news().iter().any(is_ready));
}

#[test]
fn an_order_sets_the_parameters_of_the_base() {
    let (mut base, mut session) = connected();
    session.take_news();
    let order = Order::Explore { speed: 0.25 };
    assert!(session.order(order, Instant::from_millis(6_500)));
    base.talk(&mut session, 6_000..6_500, Speech::Steered);
    assert_eq!(base.parameters.task as u8, 1);
    assert_eq!(Value::F32(base.parameters.speed.0), Value::F32(0.25));
    assert!(session.take_news().contains(&News::Order(order, Fate::Taken)));
}
