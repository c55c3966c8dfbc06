//! Measures how long the operator's order takes from the base's agent to the head's, and counts the
//! packets by what became of them.

use std::collections::VecDeque;

use wire::p2p::{Counter, Header, Kind};

use medium::Tally;

/// Delays are counted by the millisecond, up to this many.
const LONGEST_MS: usize = 5_000;
/// The most commands of the base of which one may still arrive at some node.
const REMEMBERED: usize = 256;

/// The operator's orders on their way to the head.
#[derive(Debug)]
pub(super) struct OrderLog {
    /// When the operator's stick was last read.
    given_us: u64,
    /// The numbers of the base's packets, and when the stick was read whose order they carry.
    sent: VecDeque<(Counter, u64)>,
    /// The number of orders that took so many milliseconds; the last entry counts all that took longer.
    delays: Vec<u32>,
    delivered: u32,
}

impl Default for OrderLog {
    fn default() -> Self {
        let sent = VecDeque::with_capacity(REMEMBERED);
        Self { given_us: 0, sent, delays: vec![0; LONGEST_MS + 1], delivered: 0 }
    }
}

impl OrderLog {
    /// Notes that the stick is read.
    pub(super) fn given(&mut self, now_us: u64) {
        self.given_us = now_us;
    }

    /// Notes that the base sends a packet.
    pub(super) fn sent(&mut self, data: &[u8]) {
        let Ok((header, _)) = Header::decode(data) else { return };
        if header.kind != Kind::Command {
            return;
        }
        if self.sent.len() == REMEMBERED {
            self.sent.pop_front();
        }
        self.sent.push_back((header.counter, self.given_us));
    }

    /// Notes that an order that was sealed under this number has reached the head: the first packet with
    /// that number or a later one brought it out.
    pub(super) fn delivered(&mut self, now_us: u64, sealed: Counter) {
        let at = self.sent.partition_point(|(counter, _)| *counter < sealed);
        if let Some((_, given_us)) = self.sent.get(at) {
            self.delivered_after(now_us.saturating_sub(*given_us));
        }
    }

    /// Notes that an order has reached the head so long after the stick was read.
    pub(super) fn delivered_after(&mut self, delay_us: u64) {
        let ms = (delay_us / 1_000) as usize;
        self.delays[ms.min(LONGEST_MS)] += 1;
        self.delivered += 1;
    }

    /// The delay in seconds that this part of all orders did not exceed.
    fn quantile_s(&self, part: f64) -> f32 {
        let wanted = (part * f64::from(self.delivered)).ceil() as u32;
        let mut seen = 0;
        let at = self.delays.iter().position(|count| {
            seen += count;
            seen >= wanted
        });
        match at {
            Some(ms) if self.delivered > 0 => (ms + 1) as f32 * 1e-3,
            _ => f32::NAN,
        }
    }
}

/// The figures of the radio over a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadioMetrics {
    /// Whether packets were sealed, as they are at flight level.
    pub sealed: bool,
    /// The part of the time that the air was in use.
    pub air_time: f32,
    /// The tally of all packets.
    pub packets: Tally,
    /// Orders that reached the head.
    pub orders: u32,
    /// From the base's turn that read the pilot's stick to the head's radio link, s: the median,
    pub pilot_delay_p50_s: f32,
    /// and what one in twenty exceeded.
    pub pilot_delay_p95_s: f32,
}

impl RadioMetrics {
    /// The figures of a radio of which nothing is known.
    pub const NONE: Self = Self {
        sealed: false,
        air_time: f32::NAN,
        packets: Tally::NONE,
        orders: 0,
        pilot_delay_p50_s: f32::NAN,
        pilot_delay_p95_s: f32::NAN,
    };

    pub(super) fn of(sealed: bool, tally: &Tally, elapsed_us: u64, orders: &OrderLog) -> Self {
        Self {
            sealed,
            air_time: tally.air_time(elapsed_us) as f32,
            packets: *tally,
            orders: orders.delivered,
            pilot_delay_p50_s: orders.quantile_s(0.5),
            pilot_delay_p95_s: orders.quantile_s(0.95),
        }
    }
}
