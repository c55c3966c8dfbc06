//! Turns the operator's orders into parameters of the base, and sets them one after the other.

use std::collections::VecDeque;

use crtp::OperatorTask;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use units::{Branch, Duration, Instant, MetresPerSecond};
use wire::crtp::{LinkRequest, Packet, ParamRequest, Port, Request};

use crate::table::Rows;

/// The time after which a parameter whose setting was not answered is set again: an order has half a
/// second ([`freshness`](crate::freshness)), in which a parameter is set up to ten times.
const AGAIN: Duration = Duration::from_millis(50);

/// The fastest that the base lets a head fly (`crtp`, `Parameters::MAX_SPEED`).
pub const MAX_SPEED: MetresPerSecond = MetresPerSecond(0.4);

/// An order of the operator to the whole mission, except the stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "order")]
pub enum Order {
    /// The drones wait on the ground; drones that have landed may fly again.
    Wait,
    /// The head takes off, or stops where it is in the air, and the chain holds.
    Hold,
    /// The head flies along the tunnel.
    Explore {
        /// The speed in m/s, negative to fly back.
        #[serde(deserialize_with = "number")]
        speed: f32,
    },
    /// The head takes this way at the junctions that it comes to.
    Branch {
        /// The way.
        way: Way,
    },
    /// All drones fly home.
    Recall,
    /// Each drone lands where it is.
    Land,
    /// The drones of the chain land at their places and relay from the ground.
    Perch,
}

/// Reads a number also where another program of the workspace has `serde_json` keep numbers as text
/// (its feature `arbitrary_precision`): then a plain `f32` of a tagged enum is refused.
pub(crate) fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f32, D::Error> {
    let number = serde_json::Number::deserialize(from)?;
    number.as_f64().map(|number| number as f32).ok_or_else(|| D::Error::custom("no number"))
}

/// A choice for junctions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    /// No choice: the head waits at a junction.
    None,
    /// The left one.
    Left,
    /// The right one.
    Right,
    /// The one ahead.
    Straight,
}

impl Way {
    /// The name in the page's messages and in recordings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Left => "left",
            Self::Right => "right",
            Self::Straight => "straight",
        }
    }

    const fn code(self) -> u8 {
        Branch::code(match self {
            Self::None => None,
            Self::Left => Some(Branch::Left),
            Self::Right => Some(Branch::Right),
            Self::Straight => Some(Branch::Straight),
        })
    }
}

impl Order {
    /// The name in the page's messages and in recordings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wait => "wait",
            Self::Hold => "hold",
            Self::Explore { .. } => "explore",
            Self::Branch { .. } => "branch",
            Self::Recall => "recall",
            Self::Land => "land",
            Self::Perch => "perch",
        }
    }

    /// The parameters to be set, in this order, with their values as bytes. The speed comes before
    /// the task, so that a head never starts at an old speed.
    fn parameters(self) -> Vec<(&'static str, Vec<u8>)> {
        let task = |task: OperatorTask| ("uchain.task", vec![task as u8]);
        let speed = |speed: f32| ("uchain.speed", speed.to_le_bytes().to_vec());
        match self {
            Self::Wait => vec![task(OperatorTask::Wait)],
            Self::Hold => vec![speed(0.0), task(OperatorTask::Explore)],
            Self::Explore { speed: forward } => {
                let forward = MetresPerSecond(forward).limited_to(MAX_SPEED);
                vec![speed(forward.0), task(OperatorTask::Explore)]
            }
            Self::Branch { way } => vec![("uchain.branch", vec![way.code()])],
            Self::Recall => vec![task(OperatorTask::Return)],
            Self::Land => vec![task(OperatorTask::Land)],
            Self::Perch => vec![task(OperatorTask::Perch)],
        }
    }
}

/// What became of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// The base has taken the order.
    Taken,
    /// The base has answered with another value: it does not follow the order.
    Refused,
    /// The base has not answered.
    NotAnswered,
    /// The operator has given another order first.
    Replaced,
    /// No page steers any more.
    Dropped,
}

impl Fate {
    /// The name in recordings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Taken => "taken",
            Self::Refused => "refused",
            Self::NotAnswered => "not-answered",
            Self::Replaced => "replaced",
            Self::Dropped => "dropped",
        }
    }
}

/// The order that is being given, parameter by parameter.
///
/// # Which order an answer belongs to
/// The answer to a setting has the parameter's row and the value that holds, and no number. A parameter
/// is set several times, so answers to an earlier order come while the next one is given; one that has
/// the same value by chance says nothing about whether the base has heard the new one. So before the
/// first setting of an order the base is sent a *mark*, a number of the order's own that it echoes. A
/// base answers in the order in which it was asked, and the line keeps that order, so that what comes
/// behind the mark answers this order, and what comes before it answers an earlier one.
#[derive(Clone, Debug, Default)]
pub struct Giving {
    setting: Option<Setting>,
    /// The mark of the order that was begun last.
    mark: u32,
}

/// The parameters of an order are being set.
#[derive(Clone, Debug)]
struct Setting {
    order: Order,
    /// The parameters that are not set yet, by row, with their values.
    left: VecDeque<(u16, Vec<u8>)>,
    /// When the first of them was set last.
    sent: Option<Instant>,
    marking: Marking,
    /// When the order is too old to be given.
    until: Instant,
}

/// How far the mark of an order has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Marking {
    /// The mark is to be sent before the parameter is set next.
    Due,
    /// The mark is on its way.
    Sent,
    /// The base has echoed the mark.
    Echoed,
}

impl Giving {
    /// Begins to give an order, of which nothing is sent from `until` on. Returns whether the base
    /// has such parameters; where it has not, nothing changes.
    pub fn begin(&mut self, order: Order, until: Instant, rows: &Rows) -> bool {
        let row = |(name, value): (&str, Vec<u8>)| Some((*rows.get(name)?, value));
        let left: Option<_> = order.parameters().into_iter().map(row).collect();
        let Some(left) = left else { return false };
        self.mark = self.mark.wrapping_add(1);
        self.setting = Some(Setting { order, left, sent: None, marking: Marking::Due, until });
        true
    }

    /// The order that is being given.
    #[must_use]
    pub const fn order(&self) -> Option<Order> {
        match &self.setting {
            None => None,
            Some(setting) => Some(setting.order),
        }
    }

    /// Gives up the order that is being given, and returns it.
    pub fn take_order(&mut self) -> Option<Order> {
        self.setting.take().map(|setting| setting.order)
    }

    /// Returns the packet to be sent now, if one is due, or the order that was not answered in time.
    ///
    /// The station may have been suspended since the last call: no part of an order that has become
    /// too old meanwhile is sent.
    pub fn poll(&mut self, now: Instant) -> Result<Option<Packet>, Order> {
        let Some(Setting { order, left, sent, marking, until }) = &mut self.setting else {
            return Ok(None);
        };
        if now >= *until {
            let order = *order;
            self.setting = None;
            return Err(order);
        }
        if sent.is_some_and(|at| now.since(at) < AGAIN) {
            return Ok(None);
        }
        let Some((id, value)) = left.front() else { return Ok(None) };
        match marking {
            Marking::Due => {
                *marking = Marking::Sent;
                return Ok(Some(mark(self.mark)));
            }
            // The mark may be lost: it is sent again with the setting.
            Marking::Sent => *marking = Marking::Due,
            Marking::Echoed => {}
        }
        *sent = Some(now);
        Ok(Some(Request::Param(ParamRequest::Write { id: *id, value }).packet()))
    }

    /// Takes a packet of the base. Returns the order and what became of it, once that is known.
    ///
    /// A base answers with the value that holds: one with another value than the order's refuses it.
    pub fn receive(&mut self, packet: &Packet) -> Option<(Order, Fate)> {
        let Setting { order, left, sent, marking, .. } = self.setting.as_mut()?;
        let is_echo = packet.port() == Ok(Port::Link) && packet.channel() == 0;
        if is_echo && packet.data() == self.mark.to_le_bytes() {
            *marking = Marking::Echoed;
        }
        if *marking != Marking::Echoed || packet.port() != Ok(Port::Param) || packet.channel() != 2
        {
            return None;
        }
        let (row, value) = left.front()?;
        let (id, holds) = packet.data().split_first_chunk::<2>()?;
        if u16::from_le_bytes(*id) != *row {
            return None;
        }
        let order = *order;
        if holds != value.as_slice() {
            self.setting = None;
            return Some((order, Fate::Refused));
        }
        left.pop_front();
        *sent = None;
        if !left.is_empty() {
            return None;
        }
        self.setting = None;
        Some((order, Fate::Taken))
    }
}

/// The packet that the base echoes.
fn mark(mark: u32) -> Packet {
    Request::Link(LinkRequest::Echo(&mark.to_le_bytes())).packet()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Rows {
        [("uchain.task", 0), ("uchain.speed", 1), ("uchain.branch", 2)]
            .into_iter()
            .map(|(name, row)| (name.to_owned(), row))
            .collect()
    }

    const UNTIL: Instant = Instant::from_millis(500);

    fn begun(order: Order) -> Giving {
        let mut giving = Giving::default();
        assert!(giving.begin(order, UNTIL, &rows()));
        giving
    }

    /// An order whose mark the base has echoed, while the first setting is on its way.
    fn marked(order: Order) -> Giving {
        let mut giving = begun(order);
        let mark = giving.poll(Instant::ZERO).unwrap().unwrap();
        assert_eq!(mark.port(), Ok(Port::Link));
        assert!(giving.poll(Instant::ZERO).unwrap().is_some());
        assert_eq!(giving.receive(&mark), None);
        giving
    }

    fn answer(row: u16, value: &[u8]) -> Packet {
        Packet::new(Port::Param, 2, &[&row.to_le_bytes()[..], value].concat()).unwrap()
    }

    #[test]
    fn the_speed_is_set_before_the_task() {
        let order = Order::Explore { speed: 0.25 };
        let mut giving = begun(order);
        let mark = giving.poll(Instant::ZERO).unwrap().unwrap();
        let speed = giving.poll(Instant::ZERO).unwrap().unwrap();
        assert_eq!(giving.receive(&mark), None);
        assert_eq!(speed.data(), [&[1, 0][..], &0.25_f32.to_le_bytes()].concat());
        assert_eq!(giving.receive(&answer(1, &0.25_f32.to_le_bytes())), None);
        let task = giving.poll(Instant::ZERO).unwrap().unwrap();
        assert_eq!(task.data(), [0, 0, 1]);
        assert_eq!(giving.receive(&answer(0, &[1])), Some((order, Fate::Taken)));
    }

    #[test]
    fn an_order_that_is_answered_with_another_value_was_refused() {
        let mut giving = marked(Order::Wait);
        assert_eq!(giving.receive(&answer(0, &[4])), Some((Order::Wait, Fate::Refused)));
    }

    /// What comes before the mark is the answer to an earlier order.
    #[test]
    fn an_answer_before_the_mark_says_nothing() {
        for value in [1, 4] {
            let mut giving = begun(Order::Land);
            assert!(giving.poll(Instant::ZERO).unwrap().is_some());
            assert!(giving.poll(Instant::ZERO).unwrap().is_some());
            assert_eq!(giving.receive(&answer(0, &[value])), None);
            assert_eq!(giving.order(), Some(Order::Land));
        }
    }

    #[test]
    fn an_order_without_an_answer_is_repeated_until_it_is_too_old() {
        let mut giving = begun(Order::Land);
        let at = |ms| Instant::from_millis(ms);
        let mut sent = [0, 0];
        for n in 0..=49 {
            while let Some(packet) = giving.poll(at(10 * n)).unwrap() {
                sent[usize::from(packet.port() == Ok(Port::Param))] += 1;
            }
        }
        assert_eq!(sent, [10, 10]);
        assert_eq!(giving.poll(at(500)), Err(Order::Land));
        assert_eq!(giving.poll(at(600)), Ok(None));
    }

    /// The station is suspended after the speed was set and before the task is.
    #[test]
    fn half_an_order_that_has_become_too_old_is_not_finished() {
        let order = Order::Explore { speed: 0.25 };
        let mut giving = marked(order);
        assert_eq!(giving.receive(&answer(1, &0.25_f32.to_le_bytes())), None);
        assert_eq!(giving.poll(Instant::from_millis(20_000)), Err(order));
        assert_eq!(giving.poll(Instant::from_millis(20_010)), Ok(None));
    }
}
