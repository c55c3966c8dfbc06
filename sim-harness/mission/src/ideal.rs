//! The ideal link: reports and orders get from one member to another without packets.
//!
//! Every report reaches each other member with the strength, the noise and the loss of the radio
//! model, and an order reaches the drone that it is for. Both take a time that is drawn from what
//! the exact link was measured to take ([`delays`]). There are no packets, turns, serial lines,
//! collisions, telemetry or keys: a mission flies several times as fast, and the same
//! `onboard::Drone` decides.

pub mod delays;

use std::collections::VecDeque;

use chain::neighbours::Heard;
use chain::report::Report;
use radio_model::{Draws, Reception};
use random::{Purpose, Stream};
use units::{Dbm, NodeId, Order, Role};
use world::Radio;

use super::Mission;
use super::member::{Member, Onboard};
use super::strengths::Strengths;
use delays::Delays;
use medium::directed_link::{LinkFades, streams};
use medium::{Loss, Tally, timing};
use recordings::recorded::PacketDeviations;
use scenario::Scenario;

/// Bits on the air of a report that names four nodes.
const REPORT_BITS: u64 = timing::air_bits(56);

/// A report or an order on its way.
#[derive(Clone, Copy, Debug)]
struct OnWay {
    arrives_us: u64,
    message: Message,
}

#[derive(Clone, Copy, Debug)]
enum Message {
    /// A report, for all members that receive it.
    Report(Report),
    /// An order, for one drone.
    Order { to: usize, order: Order, given_us: u64 },
}

/// The ideal link between the members of a mission.
pub(super) struct IdealLink {
    count: usize,
    reception: Reception,
    fades: LinkFades,
    delays: Delays,
    /// How long each member's reports take, µs.
    report_us: Vec<u64>,
    /// The random numbers for the delays of the base's orders.
    base: Stream,
    /// The random numbers of each link, by sender and receiver.
    links: Vec<Stream>,
    /// What recorded packets add to their strengths, where the channel is recorded.
    deviations: Option<PacketDeviations>,
    /// The strengths of the reports that have been heard and not named in a report of the receiver
    /// yet, sender-major.
    unnamed: Vec<Option<Dbm>>,
    /// The reports and orders on their way; the next to arrive is the first.
    on_way: VecDeque<OnWay>,
    /// The operator's last order.
    order: Option<Order>,
    /// When the last order was given that has reached each member.
    heeded_us: Vec<u64>,
    tally: Tally,
}

impl IdealLink {
    pub(super) fn new(scenario: &Scenario, count: usize, seed: u64) -> Self {
        let reception = scenario.radio.reception;
        let sender = |n: usize| Stream::new(seed, Purpose::Delay(n as u8));
        Self {
            count,
            reception,
            fades: LinkFades::new(scenario.radio.fades, count, seed),
            delays: Delays::of(reception.loss_rate, count - 1),
            report_us: (0..count).map(|n| Delays::report_us(sender(n).uniform())).collect(),
            base: sender(count),
            links: streams(count, seed),
            deviations: scenario
                .radio
                .trace
                .as_ref()
                .map(|channel| PacketDeviations::new(channel, count, seed)),
            unnamed: vec![None; count * count],
            on_way: VecDeque::new(),
            order: None,
            heeded_us: vec![0; count],
            tally: Tally::default(),
        }
    }

    /// The tally of all reports. They take no time on the air.
    pub(super) const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Sends a member's report.
    pub(super) fn report(&mut self, now_us: u64, report: Report) {
        let Some(delay_us) = self.report_us.get(usize::from(report.from.0)) else { return };
        let arrives_us = now_us + delay_us;
        self.tally.sent += 1;
        self.put(OnWay { arrives_us, message: Message::Report(report) });
    }

    /// Sends the base's order after its round. An order to explore goes to the head every time; a
    /// change of order goes to every drone.
    pub(super) fn order(&mut self, now_us: u64, order: Option<Order>) {
        let Some(order) = order else { return };
        let kind = |order: &Order| core::mem::discriminant(order);
        let is_other = self.order.as_ref().map(kind) != Some(kind(&order));
        self.order = Some(order);
        let base = self.count - 1;
        for to in 0..base {
            let steers = to == usize::from(NodeId::HEAD.0) && matches!(order, Order::Explore(..));
            if is_other || steers {
                let luck = self.base.uniform();
                let arrives_us = now_us + self.delays.order_us(base - to, luck);
                self.put(OnWay {
                    arrives_us,
                    message: Message::Order { to, order, given_us: now_us },
                });
            }
        }
    }

    fn put(&mut self, on_way: OnWay) {
        let earlier = |other: &OnWay| other.arrives_us <= on_way.arrives_us;
        let place = self.on_way.iter().rposition(earlier).map_or(0, |last| last + 1);
        self.on_way.insert(place, on_way);
    }

    fn next_before(&mut self, until_us: u64) -> Option<OnWay> {
        self.on_way.pop_front_if(|next| next.arrives_us < until_us)
    }

    /// The strength with which a report is heard, if it is. Luck is drawn before anything else, as
    /// a report that is lost needs no strength.
    #[inline]
    fn receive(
        &mut self,
        now_us: u64,
        (from, to): (usize, usize),
        strength: impl FnOnce() -> Dbm,
    ) -> Option<Dbm> {
        let is_faded = self.fades.is_faded(from, to, now_us);
        let stream = &mut self.links[from * self.count + to];
        let luck = stream.uniform();
        if is_faded || luck < self.reception.loss_rate {
            self.tally.lose(Loss::Chance);
            return None;
        }
        let deviation = self.deviations.as_mut().map(|all| all.next(from, to, now_us));
        let draws =
            Draws { luck, normal: stream.gauss(), deviation: deviation.unwrap_or_default() };
        let heard = self.reception.receive(strength(), REPORT_BITS, draws);
        match heard {
            Some(_) => self.tally.heard += 1,
            None => self.tally.lose(Loss::Weak),
        }
        heard
    }

    /// Whether most packets of a link of this strength get through.
    fn is_link(&self, strength: Dbm) -> bool {
        self.reception.packet_error_rate(strength, REPORT_BITS) < 0.5
    }

    /// Whether an order of the base can get to a member, passed on by those between them that are
    /// not `silent`.
    fn is_in_reach(
        &self,
        member: usize,
        silent: &[bool],
        strengths: &mut Strengths,
        radio: &Radio,
    ) -> bool {
        let hears_nothing = |n: usize| silent.get(n).copied().unwrap_or(true);
        if hears_nothing(member) || !self.reception.sensitivity.0.is_finite() {
            return !hears_nothing(member);
        }
        let mut reached = vec![self.count - 1];
        let mut next = 0;
        while let Some(&from) = reached.get(next) {
            for to in 0..self.count {
                let mut hears =
                    || !hears_nothing(to) && self.is_link(strengths.between(radio, from, to));
                if !reached.contains(&to) && hears() {
                    reached.push(to);
                }
            }
            if reached.contains(&member) {
                return true;
            }
            next += 1;
        }
        false
    }
}

impl Mission<'_> {
    /// Hands over all reports and orders that arrive before `until_us` by the ideal link.
    pub(super) fn carry_messages(&mut self, until_us: u64) {
        while let Some(OnWay { arrives_us, message }) =
            self.ideal.as_mut().and_then(|ideal| ideal.next_before(until_us))
        {
            match message {
                Message::Report(report) => self.carry_report(arrives_us, report),
                Message::Order { to, order, given_us } => {
                    self.carry_order(arrives_us, to, order, given_us);
                }
            }
        }
    }

    fn carry_report(&mut self, now_us: u64, report: Report) {
        let Self { ideal: Some(ideal), members, strengths, world, .. } = self else { return };
        let from = usize::from(report.from.0);
        if members.get(from).is_none_or(Member::is_silenced) {
            return;
        }
        let others = members.iter_mut().enumerate().filter(|(to, _)| *to != from);
        for (to, member) in others.filter(|(_, member)| !member.is_silenced()) {
            let heard =
                ideal.receive(now_us, (from, to), || strengths.between(&world.radio, from, to));
            let reverse = ideal.unnamed[to * ideal.count + from].take();
            if let (Some(rssi), Onboard::Hosted(hosted)) = (heard, &mut member.onboard) {
                ideal.unnamed[from * ideal.count + to] = Some(rssi);
                hosted.hear(now_us, Heard { report, rssi: Some(rssi), reverse });
            }
        }
    }

    /// An order that a later one has overtaken is dropped.
    fn carry_order(&mut self, now_us: u64, to: usize, order: Order, given_us: u64) {
        let Self { ideal: Some(ideal), members, strengths, world, orders, .. } = self else {
            return;
        };
        let overtaken = ideal.heeded_us[to] > given_us;
        let silent: Vec<_> = members.iter().map(Member::is_silenced).collect();
        if overtaken || !ideal.is_in_reach(to, &silent, strengths, &world.radio) {
            return;
        }
        ideal.heeded_us[to] = given_us;
        let Some(member) = members.get_mut(to) else { return };
        if let Onboard::Hosted(hosted) = &mut member.onboard {
            hosted.heed(now_us, order);
            if member.role == Role::Head {
                orders.delivered_after(now_us - given_us);
            }
        }
    }
}
