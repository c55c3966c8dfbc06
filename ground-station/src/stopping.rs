//! Keeps an emergency stop going: it is sent again and again until every drone has answered, or the
//! operator gives up.

use std::collections::BTreeMap;

use crtp::OperatorTask;
use units::{Duration, Instant, NodeId};
use wire::crtp::{Packet, Port, Request, SupervisorCommand};

/// The time between two stops, as often as the base spreads orders to its chain (`airlink`,
/// `schedule.rs`: a node has five turns a second).
const AGAIN: Duration = Duration::from_millis(200);

/// The code of the state in which a drone has its motors off (`agent`, `State::Stopped`).
const STOPPED: u8 = 9;
/// The code of the fault that a drone with stopped motors reports (`onboard`, `air::fault`).
const MOTORS_OFF: u8 = 2;

/// Whether this state and fault say that the drone's motors are stopped.
#[must_use]
pub const fn is_stopped(state: u8, fault: u8) -> bool {
    state == STOPPED || fault == MOTORS_OFF
}

/// The emergency stop.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Stopping {
    /// The operator has not ordered a stop.
    #[default]
    NotOrdered,
    /// The operator has ordered a stop.
    Ordered(Stop),
}

/// An emergency stop that was ordered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stop {
    /// When the operator ordered the stop.
    pub since: Instant,
    /// When the stop was sent last.
    sent: Option<Instant>,
    /// The time from the order to the base's answer.
    pub base: Option<Duration>,
    /// For each drone that the base has ever heard, the time from the order to the drone's answer.
    pub drones: BTreeMap<NodeId, Option<Duration>>,
    /// Whether the stop is still being sent.
    pub sending: Sending,
}

/// Whether a stop is still being sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sending {
    /// The stop is sent until the base and every drone have answered.
    Repeating,
    /// The base and every drone have answered.
    Answered,
    /// The operator no longer waits for the answers that are missing.
    GivenUp,
}

impl Stopping {
    /// Orders the stop. A stop that is already being sent goes on, one that was given up or
    /// answered begins anew.
    pub fn order(&mut self, now: Instant, drones: impl Iterator<Item = NodeId>) {
        if let Self::Ordered(Stop { sending: Sending::Repeating, .. }) = self {
            return;
        }
        *self = Self::Ordered(Stop {
            since: now,
            sent: None,
            base: None,
            drones: drones.map(|drone| (drone, None)).collect(),
            sending: Sending::Repeating,
        });
    }

    /// Ends the repetition: the operator no longer waits. The base keeps the stop that it has.
    pub const fn give_up(&mut self) {
        if let Self::Ordered(stop) = self
            && matches!(stop.sending, Sending::Repeating)
        {
            stop.sending = Sending::GivenUp;
        }
    }

    /// The stop, if it is to be sent now.
    pub fn poll(&mut self, now: Instant) -> Option<Packet> {
        let Self::Ordered(stop) = self else { return None };
        let is_due = stop.sent.is_none_or(|sent| now.since(sent) >= AGAIN);
        if stop.sending != Sending::Repeating || !is_due {
            return None;
        }
        stop.sent = Some(now);
        Some(Request::Command(SupervisorCommand::EmergencyStop).packet())
    }

    /// Begins anew with a drone at another address, which has neither heard nor answered the stop.
    pub fn begin_anew(&mut self) {
        let Self::Ordered(stop) = self else { return };
        (stop.sent, stop.base) = (None, None);
        stop.conclude();
    }

    /// Takes a packet of the base: its answer to the stop counts.
    ///
    /// The answer has no number. One to an earlier stop counts too once this one was sent, which is right:
    /// a base keeps a stop until it is restarted.
    pub fn receive(&mut self, now: Instant, packet: &Packet) {
        const ANSWER: u8 = 0x80;
        let wanted = ANSWER | SupervisorCommand::EmergencyStop.code();
        let Self::Ordered(stop) = self else { return };
        if let (Ok(Port::Supervisor), 1, [code, done, ..]) =
            (packet.port(), packet.channel(), packet.data())
            && *code == wanted
            && *done != 0
            && stop.sent.is_some()
        {
            stop.base.get_or_insert(now.since(stop.since));
            stop.conclude();
        }
    }

    /// Takes what a drone said at `said`: only what it said after the order counts as an answer.
    pub fn hear(&mut self, drone: NodeId, said: Instant, state: u8, fault: u8) {
        let Self::Ordered(stop) = self else { return };
        let answer = stop.drones.entry(drone).or_default();
        if is_stopped(state, fault) && said >= stop.since {
            answer.get_or_insert(said.since(stop.since));
        }
        stop.conclude();
    }

    /// Takes the order that the base gives: once a stop is no longer sent and the base gives
    /// another order, the base was switched off and on, and the stop is over.
    pub fn hear_task(&mut self, task: u8) {
        if task != OperatorTask::Stop as u8 && !self.is_sending() {
            *self = Self::NotOrdered;
        }
    }

    /// Whether the stop is being sent.
    #[must_use]
    pub const fn is_sending(&self) -> bool {
        matches!(self, Self::Ordered(Stop { sending: Sending::Repeating, .. }))
    }
}

impl Stop {
    fn conclude(&mut self) {
        let all = self.base.is_some() && self.drones.values().all(Option::is_some);
        match (self.sending, all) {
            (_, true) => self.sending = Sending::Answered,
            // A drone that was heard for the first time after all others had answered.
            (Sending::Answered, false) => self.sending = Sending::Repeating,
            (Sending::Repeating | Sending::GivenUp, false) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use wire::crtp::Reply;

    use super::*;

    fn at(ms: u64) -> Instant {
        Instant::from_millis(ms)
    }

    fn ordered(drones: u8) -> Stopping {
        let mut stopping = Stopping::default();
        stopping.order(at(1_000), (0..drones).map(NodeId));
        assert!(stopping.poll(at(1_000)).is_some());
        stopping
    }

    fn base_answer() -> Packet {
        let command = SupervisorCommand::EmergencyStop;
        Reply::Commanded { command, done: true, holds: false }.packet()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

        /// As long as one drone, or the base, has not answered, a stop is sent in every 200 ms.
        #[test]
        fn a_stop_is_sent_until_all_have_answered(
            drones in 1_u8..15,
            missing in 0_u8..15,
            base_answers in any::<bool>(),
        ) {
            let mut stopping = ordered(drones);
            if base_answers {
                stopping.receive(at(1_010), &base_answer());
            }
            for drone in (0..drones).filter(|drone| *drone != missing) {
                stopping.hear(NodeId(drone), at(1_500), STOPPED, 0);
            }
            let all = base_answers && missing >= drones;
            for step in 0_u64..50 {
                let sent = stopping.poll(at(2_000 + 200 * step)).is_some();
                prop_assert_eq!(sent, !all, "{:?}", stopping);
            }
        }
    }

    #[test]
    fn what_a_drone_said_before_the_order_is_no_answer() {
        let mut stopping = ordered(1);
        stopping.receive(at(1_010), &base_answer());
        stopping.hear(NodeId(0), at(999), STOPPED, 0);
        assert!(stopping.is_sending());
        stopping.hear(NodeId(0), at(1_000), 3, MOTORS_OFF);
        assert!(!stopping.is_sending());
    }

    #[test]
    fn a_drone_that_appears_late_is_waited_for() {
        let mut stopping = ordered(1);
        stopping.receive(at(1_010), &base_answer());
        stopping.hear(NodeId(0), at(1_500), STOPPED, 0);
        stopping.hear(NodeId(1), at(1_600), 3, 0);
        assert!(stopping.is_sending());
    }

    #[test]
    fn a_stop_is_over_when_the_base_was_switched_off_and_on() {
        let mut stopping = ordered(1);
        stopping.hear_task(1);
        assert!(stopping.is_sending(), "a stop that is not answered goes on");
        stopping.receive(at(1_010), &base_answer());
        stopping.hear(NodeId(0), at(1_500), STOPPED, 0);
        stopping.hear_task(4);
        assert!(matches!(stopping, Stopping::Ordered(_)));
        stopping.hear_task(0);
        assert_eq!(stopping, Stopping::NotOrdered);
    }

    /// A drone that is not the base answers the stop as well: the stop used to count as answered by the base,
    /// which had not heard it.
    #[test]
    fn the_answer_of_another_address_is_not_the_bases() {
        let base = |stopping: &Stopping| match stopping {
            Stopping::Ordered(stop) => stop.base,
            Stopping::NotOrdered => None,
        };
        let mut stopping = ordered(0);
        stopping.receive(at(1_010), &base_answer());
        assert!(!stopping.is_sending());
        stopping.begin_anew();
        assert!(stopping.is_sending());
        stopping.receive(at(1_020), &base_answer());
        assert_eq!(base(&stopping), None, "what the other drone has still said");
        assert!(stopping.poll(at(1_030)).is_some(), "at once");
        stopping.receive(at(1_040), &base_answer());
        assert_eq!(base(&stopping), Some(Duration::from_millis(40)));
    }

    #[test]
    fn the_operator_gives_up_and_orders_again() {
        let mut stopping = ordered(2);
        stopping.give_up();
        assert_eq!(stopping.poll(at(5_000)), None);
        stopping.order(at(6_000), [NodeId(0)].into_iter());
        assert!(stopping.poll(at(6_000)).is_some());
    }
}
