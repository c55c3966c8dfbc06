//! Carries the packets between the members of a mission.
//!
//! Links on the host ask for their turns; the radio chips of emulated drones send when their
//! firmware has told them to. With emulated drones, packets arrive at each receiver's antenna, and a
//! link on the host has its serial line behind that, as an emulated one has by itself.

use airlink::Opened;
use rayon::prelude::*;
use units::{Dbm, Role};
use wire::syslink::MAX_P2P;
use world::Radio;

use super::hosted::Hosted;
use super::intruders::Intruders;
use super::log::OrderLog;
use super::member::{Member, OnLine, Onboard};
use super::strengths::Strengths;
use super::{CRAFT_STEP_US, Mission, Part};
use medium::{Arrives, Ether, timing};

/// The next event on the air.
enum Next {
    /// Something happens in the medium: a packet may arrive.
    Medium,
    /// A packet that has arrived comes out of this member's serial line.
    Line(usize, usize),
    /// This member has a packet to send.
    Turn(usize),
}

impl Mission<'_> {
    /// Carries all packets that are on the air before `until_us`.
    pub(super) fn carry_packets(&mut self, until_us: u64) {
        if self.ideal.is_some() {
            return self.carry_messages(until_us);
        }
        let due_us = self.members.iter().map(|member| member.onboard.due_us());
        self.due_us.clear();
        self.due_us.extend(due_us);
        while let Some((at_us, next)) = self.next_on_air()
            && at_us < until_us
        {
            match next {
                Next::Medium => self.receive(),
                Next::Line(n, place) => self.take_from_line(n, place),
                Next::Turn(n) => self.transmit(n, at_us),
            }
        }
    }

    /// The next event. Of several at the same moment, arrivals are first.
    fn next_on_air(&self) -> Option<(u64, Next)> {
        let arrival = self.medium.next().map(|at_us| (at_us, Next::Medium));
        let line = match self.medium.arrives() {
            Arrives::AtProcessor => None,
            Arrives::AtAntenna => self.next_on_line(),
        };
        let turn = self.due_us.iter().enumerate().min_by_key(|(_, due_us)| **due_us);
        let turn = turn.map(|(n, &due_us)| (due_us, Next::Turn(n)));
        let first = earlier(arrival, line);
        earlier(first, turn)
    }

    /// The packet that comes out of a serial line next.
    fn next_on_line(&self) -> Option<(u64, Next)> {
        let lines = self.members.iter().enumerate().filter_map(|(n, member)| {
            let line = &member.onboard.hosted()?.line;
            let (place, first) = line.iter().enumerate().min_by_key(|(_, on)| on.at_us)?;
            Some((first.at_us, Next::Line(n, place)))
        });
        lines.min_by_key(|(at_us, _)| *at_us)
    }

    fn transmit(&mut self, n: usize, now_us: u64) {
        let mut packet = [0; MAX_P2P];
        let member = &mut self.members[n];
        let silenced = member.is_silenced();
        let Onboard::Hosted(hosted) = &mut member.onboard else { return };
        self.stopwatch.enter(Part::Links);
        let sent = hosted.transmit(now_us, &mut packet);
        self.due_us[n] = hosted.due_us();
        self.stopwatch.enter(Part::Medium);
        let Some(length) = sent else { return };
        if silenced {
            return;
        }
        let data = packet.get(..length).unwrap_or_default();
        if member.role == Role::Base {
            self.orders.sent(data);
        }
        self.medium.send(n, now_us, data);
    }

    /// Lets the medium go on, and hands a packet that arrives to all members that receive it.
    fn receive(&mut self) {
        let Self { medium, members, strengths, world, orders, intruders, due_us, .. } = self;
        let stopwatch = &mut self.stopwatch;
        let arrives = medium.arrives();
        let count = members.len();
        let mut ether = Tube { members, strengths, radio: &world.radio };
        let Some(arrival) = medium.advance(&mut ether) else { return };
        let now_us = arrival.at_us;
        let mut opened = None;
        stopwatch.enter(Part::Links);
        let jammed = arrival.from < count && intruders.as_ref().is_some_and(Intruders::jams);
        for receipt in arrival.heard.iter().filter(|receipt| !jammed || receipt.by >= count) {
            let Some(member) = members.get_mut(receipt.by) else {
                if let Some(intruders) = intruders.as_mut().filter(|_| receipt.by == count) {
                    intruders.overhear(now_us, arrival.data);
                }
                continue;
            };
            let role = member.role;
            let hosted = match &mut member.onboard {
                Onboard::Emulated(emulated) => {
                    emulated.hear(now_us, receipt.rssi, arrival.data);
                    continue;
                }
                Onboard::Hosted(hosted) => hosted,
            };
            if arrives == Arrives::AtAntenna {
                hosted.line.push(OnLine::new(now_us, receipt.rssi, arrival.data));
                continue;
            }
            if opened.is_none() {
                opened = hosted.open(arrival.data);
            }
            let Some(opened) = &opened else { continue };
            // Of an intruder's packets is counted how many are taken for the chain's.
            let of_intruder = intruders.as_mut().filter(|_| arrival.from >= count);
            let before = of_intruder.is_some().then(|| taken(hosted));
            deliver(hosted, role, (now_us, receipt.rssi, opened), orders);
            due_us[receipt.by] = hosted.due_us();
            if let Some(intruders) = of_intruder
                && before != Some(taken(hosted))
            {
                intruders.accept();
            }
        }
        stopwatch.enter(Part::Medium);
    }

    fn take_from_line(&mut self, n: usize, place: usize) {
        let Self { members, orders, due_us, .. } = self;
        let Some(Member { role, onboard: Onboard::Hosted(hosted), .. }) = members.get_mut(n) else {
            return;
        };
        let OnLine { at_us, rssi, length, data } = hosted.line.swap_remove(place);
        let Some(opened) = hosted.open(&data[..length]) else { return };
        deliver(hosted, *role, (at_us, rssi, &opened), orders);
        due_us[n] = hosted.due_us();
    }

    /// Lets the emulated drones run up to this moment, and takes what their radio chips send.
    pub(super) fn emulate(&mut self, until_us: u64) {
        let drones = self.members.iter_mut().filter_map(|member| member.onboard.emulated_mut());
        let mut drones: Vec<_> = drones.collect();
        let ran = match drones.as_mut_slice() {
            // One drone alone needs no second thread.
            [alone] => alone.run_until(until_us),
            several => several.par_iter_mut().try_for_each(|drone| drone.run_until(until_us)),
        };
        if let Err(halt) = ran {
            self.halted.get_or_insert(halt);
        }
        let mut sent = Vec::new();
        for (n, member) in self.members.iter_mut().enumerate() {
            let silenced = member.is_silenced();
            let role = member.role;
            let Onboard::Emulated(emulated) = &mut member.onboard else { continue };
            emulated.take_sent(|on_air_us, data| {
                if !silenced {
                    sent.push((on_air_us, n, data));
                }
            });
            // Looking is not cheap, and to the millisecond is near enough.
            if role == Role::Head
                && until_us.is_multiple_of(CRAFT_STEP_US)
                && let Some(counter) = emulated.newly_heeded()
            {
                self.orders.delivered(until_us, counter);
            }
        }
        sent.sort_by_key(|(on_air_us, n, _)| (*on_air_us, *n));
        for (on_air_us, n, data) in sent {
            self.medium.inject(n, on_air_us, &data);
        }
    }
}

impl OnLine {
    fn new(on_air_until_us: u64, rssi: Dbm, bytes: &[u8]) -> Self {
        let length = bytes.len().min(MAX_P2P);
        let mut data = [0; MAX_P2P];
        data[..length].copy_from_slice(&bytes[..length]);
        // The chip's main loop passes it on in its next round, which is half a round away in the mean.
        let at_us = on_air_until_us + timing::ROUND_NS / 2_000 + timing::received_us(length);
        Self { at_us, rssi, length, data }
    }
}

/// The earlier of two events, or the first where they are at the same moment.
fn earlier(a: Option<(u64, Next)>, b: Option<(u64, Next)>) -> Option<(u64, Next)> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.0 < a.0 { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// Packets that a drone on the host has taken.
fn taken(hosted: &Hosted) -> u32 {
    hosted.drone().link_counters().map_or(0, |counters| counters.taken.total())
}

/// Hands a packet to the processor of a member on the host.
fn deliver(
    hosted: &mut Hosted,
    role: Role,
    (now_us, rssi, packet): (u64, Dbm, &Opened),
    orders: &mut OrderLog,
) {
    if let Some(counter) = hosted.receive(now_us, rssi, packet)
        && role == Role::Head
    {
        orders.delivered(now_us, counter);
    }
}

/// The tunnel as the air sees it.
struct Tube<'a> {
    members: &'a [Member],
    strengths: &'a mut Strengths,
    radio: &'a Radio,
}

impl Ether for Tube<'_> {
    fn strength(&mut self, from: usize, to: usize) -> Option<Dbm> {
        // What a silenced sender sends never comes here.
        let silenced = self.members.get(to).is_some_and(Member::is_silenced);
        (!silenced).then(|| self.strengths.between(self.radio, from, to))
    }
}
