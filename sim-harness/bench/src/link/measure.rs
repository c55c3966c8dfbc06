//! Measures the radio link by itself: chains of 2 to 15 drones and a base that stand still, in
//! which each node hears its two neighbours only, so that no other node can replace a lost packet.
//!
//! Each node reports five times a second and sends its telemetry to the base; the operator's stick
//! is read five times a second and has a new value each time. At the end the operator stops all. A
//! dongle polls the base a thousand times a second ([`Polling`]), outside of the schedule, as cflib
//! drives it; the longest chain is also measured with one that polls a hundred times a second, which
//! is the rate limit that the vendor asks users of P2P to set, and in fades.

use airlink::{Event, LinkConfig};
use heapless::Vec as Few;
use radio_model::{Fades, Reception};
use random::{Purpose, Stream};
use rayon::prelude::*;
use serde_json::{Value, json};
use units::{Course, Duration, LinkSum, Metres, MetresPerSecond, NodeId, Order, Phase};
use wire::p2p::{Report, Telemetry};

use crate::net::{End, Fleet, Net, next_only};
use medium::{Medium, MediumConfig, Polling};

/// The numbers of drones in the chains.
pub const DRONES: std::ops::RangeInclusive<u8> = 2..=15;
/// The part of all packets that is lost on each link.
pub const LOSSES: [f32; 4] = [0.0, 0.2, 0.5, 0.7];
/// A pilot's order is to reach the head within this, s, 95 of 100 times, through
/// [`AIM_HOPS`] hops at a loss of 20 %: what the pilot of a vehicle takes for immediate enough to
/// steer by at walking pace.
pub const AIM_S: f32 = 0.5;
/// See [`AIM_S`].
pub const AIM_HOPS: u8 = 8;
const AIM_LOSS: f32 = 0.2;

/// An aim for the longest chain.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// The figure that is to be reached.
    pub figure: &'static str,
    /// The part of all packets that is lost on each link.
    pub loss: f32,
    /// The figure is to be no greater than this, s.
    pub aim_s: f32,
    of: fn(&Row) -> Option<f32>,
}

/// The number of drones in the longest chain.
pub const LONGEST: u8 = 15;

/// The aims for the longest chain: a pilot steers a vehicle at walking pace by what is a quarter of
/// a second old, and by jerks by what is most of one; an operator waits for telemetry for a few
/// seconds; and a drone that flies 0.5 m/s stops within a quarter of a metre.
pub const AIMS: [Aim; 4] = [
    Aim { figure: "pilot", loss: 0.2, aim_s: 0.25, of: |row| row.pilot_delay_p95_s },
    Aim { figure: "pilot", loss: 0.7, aim_s: 0.8, of: |row| row.pilot_delay_p95_s },
    Aim { figure: "telemetry", loss: 0.7, aim_s: 4.0, of: |row| row.telemetry_delay_p95_s },
    Aim { figure: "stop to all", loss: 0.2, aim_s: 0.5, of: |row| row.stop_p95_s },
];

impl Aim {
    /// The figure as it was measured with so many polls a second, without fades.
    #[must_use]
    pub fn measured(&self, rows: &[Row], polls_per_s: u32) -> Option<f32> {
        let is_meant = |row: &&Row| {
            let is_longest = row.drones == LONGEST && row.loss == self.loss;
            is_longest && row.polls_per_s == polls_per_s && !row.fades
        };
        rows.iter().find(is_meant).and_then(self.of)
    }
}

/// How often a second a dongle polls that cflib drives without a rate limit.
pub const POLLS_PER_S: u32 = 1_000;
/// How often a second a dongle with the rate limit that the vendor asks for polls.
pub const POLLS_PER_S_LIMITED: u32 = 100;
/// The fades of the rows that have any: the part of all packets that such a row loses is lost in
/// fades of this mean length alone. A drone at 0.5 m/s crosses half a wavelength, 6 cm, in this time.
const FADE: Duration = Duration::from_millis(120);

/// A round of each node's agent, µs.
const ROUND_US: u64 = 200_000;
/// Packets before this, µs, do not count: the nodes join.
const SETTLE_US: u64 = 10_000_000;
/// The time that is measured after that, µs.
const SPAN_US: u64 = 60_000_000;
/// Messages of the last moments may still be on their way, and do not count.
const TAIL_US: u64 = 5_000_000;
/// The operator's stop has this long to reach all drones, µs.
const STOP_US: u64 = 5_000_000;

/// One chain at one loss.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The number of drones without the base, which is the number of hops from base to head.
    pub drones: u8,
    /// The part of all packets that is lost on each link.
    pub loss: f32,
    /// How often a second the operator's dongle polls the base.
    pub polls_per_s: u32,
    /// Whether packets are lost in fades, not one by one.
    pub fades: bool,
    /// Messages a second that are to go through the chain: orders to the head, telemetry of all.
    pub offered_per_s: f64,
    /// The part of them that arrived.
    pub delivered: f64,
    /// The delay from the stick to the head's agent, or until a later order got there, s: the 95th
    /// percentile. `None` where more than 5 % never arrived.
    pub pilot_delay_p95_s: Option<f32>,
    /// The delay from a drone's agent to the base, s, of the telemetry that arrived.
    pub telemetry_delay_p95_s: Option<f32>,
    /// The time from the operator's stop until the last drone has it, s: the 95th percentile. `None`
    /// where more than 5 % of the chains never stopped.
    pub stop_p95_s: Option<f32>,
    /// The part of the time that the chain's packets are on the air.
    pub air_time_fraction: f64,
    /// The part of all reports between two drones that arrived.
    pub reports_delivered: f64,
    /// From the sender's mind to the receiver's, s, of the reports that arrived.
    pub report_delay_s: Deciles,
    /// From the stick to the head's mind, s, of the orders that arrived themselves.
    pub order_delay_s: Deciles,
}

/// The least value, those that each further tenth of all does not exceed, and the greatest.
pub type Deciles = [f32; 11];

impl Row {
    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let round = |value: f64| (value * 1e4).round() / 1e4;
        let seconds = |value: Option<f32>| value.map(|value| round(f64::from(value)));
        json!({
            "drones": self.drones,
            "loss": round(f64::from(self.loss)),
            "polls_per_s": self.polls_per_s,
            "fades": self.fades,
            "offered_per_s": round(self.offered_per_s),
            "delivered": round(self.delivered),
            "pilot_delay_p95_s": seconds(self.pilot_delay_p95_s),
            "telemetry_delay_p95_s": seconds(self.telemetry_delay_p95_s),
            "stop_p95_s": seconds(self.stop_p95_s),
            "air_time_fraction": round(self.air_time_fraction),
            "reports_delivered": round(self.reports_delivered),
            "report_delay_s": self.report_delay_s.map(|value| round(f64::from(value))),
            "order_delay_s": self.order_delay_s.map(|value| round(f64::from(value))),
        })
    }
}

/// All chains at all losses, each with `runs` seeds from `seed` on.
#[must_use]
pub fn run(runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Vec<Row> {
    cases().into_par_iter().map(|case| row(case, runs, seed, &after_each)).collect()
}

/// The chain of a row, and its air.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The number of drones that fly.
    pub drones: u8,
    /// The part of all packets that each link loses.
    pub loss: f32,
    /// How often a second the operator's dongle polls the base; zero for no dongle.
    pub polls_per_s: u32,
    /// Whether links fade.
    pub fades: bool,
}

impl Case {
    /// A chain as most rows have it.
    pub const fn of(drones: u8, loss: f32) -> Self {
        Self { drones, loss, polls_per_s: POLLS_PER_S, fades: false }
    }
}

fn cases() -> Vec<Case> {
    let all = DRONES.flat_map(|drones| LOSSES.map(|loss| Case::of(drones, loss)));
    let longest = LOSSES.map(|loss| Case::of(LONGEST, loss));
    let limited = longest.map(|case| Case { polls_per_s: POLLS_PER_S_LIMITED, ..case });
    let fades = longest.into_iter().skip(1).map(|case| Case { fades: true, ..case });
    all.chain(limited).chain(fades).collect()
}

/// The number of rows.
#[must_use]
pub fn count() -> usize {
    cases().len()
}

/// One chain at one loss, with `runs` seeds from `seed` on.
pub fn row(case: Case, runs: usize, seed: u64, after_each: impl Fn()) -> Row {
    let mut sum = Seen::default();
    for n in 0..runs as u64 {
        sum.add(chain(case, seed.wrapping_add(n)));
        after_each();
    }
    sum.row(case)
}

/// The aims that are missed.
#[must_use]
pub fn missed(rows: &[Row]) -> Vec<String> {
    let aimed = rows.iter().find(|row| row.drones == AIM_HOPS && row.loss == AIM_LOSS);
    let delay_s = aimed.map_or(0.0, |row| row.pilot_delay_p95_s.unwrap_or(f32::INFINITY));
    let steered = (delay_s > AIM_S).then(|| {
        format!(
            "orders take {delay_s} s through {AIM_HOPS} hops at a loss of {AIM_LOSS}, not {AIM_S} s"
        )
    });
    let rates = [POLLS_PER_S, POLLS_PER_S_LIMITED];
    let aims = AIMS.iter().flat_map(|aim| rates.map(|polls| (aim, polls)));
    let longest = aims.filter_map(|(aim, polls)| {
        let measured = aim.measured(rows, polls).unwrap_or(f32::INFINITY);
        let Aim { figure, loss, aim_s, .. } = aim;
        (measured > *aim_s).then(|| {
            format!(
                "{figure} takes {measured} s in a chain of {LONGEST} at a loss of {loss} and {polls} \
                 polls a second, not {aim_s} s"
            )
        })
    });
    steered.into_iter().chain(longest).collect()
}

/// The delays of one or more runs.
#[derive(Default)]
struct Seen {
    runs: u32,
    orders: u32,
    orders_heeded: u32,
    telemetry_offered: f64,
    telemetry: u32,
    /// Delays in µs; `u64::MAX` for messages that never arrived.
    pilot_us: Vec<u64>,
    telemetry_us: Vec<u64>,
    air_us: u64,
    reports_offered: u64,
    report_us: Vec<u64>,
    order_us: Vec<u64>,
    stop_us: Vec<u64>,
}

impl Seen {
    fn add(&mut self, other: Self) {
        self.runs += 1;
        self.orders += other.orders;
        self.orders_heeded += other.orders_heeded;
        self.telemetry_offered += other.telemetry_offered;
        self.telemetry += other.telemetry;
        self.pilot_us.extend(other.pilot_us);
        self.telemetry_us.extend(other.telemetry_us);
        self.air_us += other.air_us;
        self.reports_offered += other.reports_offered;
        self.report_us.extend(other.report_us);
        self.order_us.extend(other.order_us);
        self.stop_us.extend(other.stop_us);
    }

    fn row(mut self, Case { drones, loss, polls_per_s, fades }: Case) -> Row {
        let seconds = f64::from(self.runs) * SPAN_US as f64 * 1e-6;
        let offered = f64::from(self.orders) + self.telemetry_offered;
        Row {
            drones,
            loss,
            polls_per_s,
            fades,
            offered_per_s: offered / seconds,
            delivered: f64::from(self.orders_heeded + self.telemetry) / offered,
            pilot_delay_p95_s: p95(&mut self.pilot_us),
            telemetry_delay_p95_s: p95(&mut self.telemetry_us),
            stop_p95_s: p95(&mut self.stop_us),
            air_time_fraction: self.air_us as f64 * 1e-6 / seconds,
            reports_delivered: self.report_us.len() as f64 / self.reports_offered as f64,
            report_delay_s: deciles(&mut self.report_us),
            order_delay_s: deciles(&mut self.order_us),
        }
    }
}

/// The deciles of these times, s; NaN where there are none.
fn deciles(all_us: &mut [u64]) -> Deciles {
    all_us.sort_unstable();
    let last = all_us.len().saturating_sub(1) as f64;
    std::array::from_fn(|tenth| {
        let at = (last * tenth as f64 * 0.1).round() as usize;
        all_us.get(at).map_or(f32::NAN, |value| *value as f32 * 1e-6)
    })
}

/// The 95th percentile, s.
fn p95(all_us: &mut [u64]) -> Option<f32> {
    all_us.sort_unstable();
    let at = (0.95 * all_us.len() as f64).ceil() as usize;
    let value = *all_us.get(at.checked_sub(1)?)?;
    (value < u64::MAX).then_some(value as f32 * 1e-6)
}

/// The speed of the stick in round `n`: another one in each of a thousand rounds.
fn stick(n: u64) -> MetresPerSecond {
    MetresPerSecond((n % 1_000) as f32 * 1e-3)
}

/// One chain, once.
fn chain(case: Case, seed: u64) -> Seen {
    let Case { drones, loss, polls_per_s, fades } = case;
    let fleet = Fleet::of(seed);
    let mut random = Stream::new(seed, Purpose::Start);
    let stations = usize::from(drones) + 1;
    let base = usize::from(drones);
    let config = MediumConfig {
        polling: Some(Polling::at(base, polls_per_s as f32)),
        fades: Fades { share: if fades { loss } else { 0.0 }, mean: FADE },
        ..MediumConfig::of(Reception {
            loss_rate: if fades { 0.0 } else { loss },
            ..Reception::PAPER
        })
    };
    let mut net = Net {
        ends: (0..=drones).map(|n| End::new(&fleet, n, drones, &mut random)).collect(),
        medium: Medium::new(config, stations, seed),
    };
    let turns: Vec<u64> =
        (0..stations).map(|_| (random.uniform() * ROUND_US as f32) as u64).collect();
    let mut log = Log::new(stations);
    let mut air_before = 0;
    let (counts_from, counts_until) = (SETTLE_US, SETTLE_US + SPAN_US);
    let mut order: Vec<usize> = (0..stations).collect();
    order.sort_by_key(|&n| turns[n]);
    for round in 0..(counts_until + TAIL_US) / ROUND_US {
        for &n in &order {
            let now_us = round * ROUND_US + turns[n];
            net.run(now_us, &mut next_only, |by, at_us, event| log.took(by, at_us, event));
            think(&mut net.ends[n], n, base, now_us, round);
            log.thought(n, base, now_us);
        }
        if (round + 1) * ROUND_US == counts_from {
            air_before = net.medium.tally().air_us;
        }
        if (round + 1) * ROUND_US == counts_until {
            log.air_us = net.medium.tally().air_us - air_before;
        }
    }
    // The stop is given in a round of the base, at any moment of the frame.
    let stop_us = counts_until + TAIL_US + turns[base];
    net.run(stop_us, &mut next_only, |by, at_us, event| log.took(by, at_us, event));
    let at = net.ends[base].clock(stop_us);
    net.ends[base].link.order(at, Order::Stop);
    net.ends[base].look(stop_us);
    for round in 0..STOP_US / ROUND_US {
        for &n in &order {
            let now_us = counts_until + TAIL_US + ROUND_US + round * ROUND_US + turns[n];
            net.run(now_us, &mut next_only, |by, at_us, event| log.took(by, at_us, event));
            think(&mut net.ends[n], n, base, now_us, 0);
        }
    }
    let mut seen = log.seen(drones, counts_from, counts_until);
    let last_us = (0..base).map(|n| log.stopped_us[n]).max().unwrap_or_default();
    let stopped = last_us != u64::MAX;
    seen.stop_us.push(if stopped { last_us.saturating_sub(stop_us) } else { u64::MAX });
    seen
}

/// Hands each link the report, the telemetry and the order of a round.
fn think(end: &mut End, n: usize, base: usize, now_us: u64, round: u64) {
    let now = end.clock(now_us);
    end.link.report(Report {
        phase: if n == base { Phase::Base } else { Phase::Linked },
        recall: false,
        calls: false,
        is_uneven: false,
        velocity: MetresPerSecond::ZERO,
        odometer: round_of_report(round),
        links: None,
        sums: [LinkSum::NONE; 2],
        waiting: 0,
        head_velocity: MetresPerSecond::ZERO,
        signpost: None,
        heard: Few::new(),
    });
    if n == base {
        end.link.order(now, Order::explore(stick(round)));
    } else {
        end.link.telemeter(Telemetry {
            state: 0,
            fault: 0,
            battery: None,
            endurance: None,
            front: None,
            back: None,
            // The odometer of the telemetry identifies the round.
            odometer: Metres(round as f32 * 0.1),
            velocity: MetresPerSecond::ZERO,
            height: None,
            heeded: 0,
        });
    }
    end.look(now_us);
}

/// The odometer by which a report's round is known: whole steps of a report's odometer.
fn round_of_report(round: u64) -> Metres {
    Metres(round as f32 * 0.125)
}

/// When each message was given and when it arrived.
struct Log {
    /// When the stick of each round was read.
    given_us: Vec<u64>,
    /// When the order of each round came to the head, if it did.
    heeded_us: Vec<Option<u64>>,
    /// When each drone handed over the telemetry of each round.
    told_us: Vec<Vec<u64>>,
    /// When telemetry was handed over and how long it took.
    arrived: Vec<(u64, u64)>,
    /// The same of reports from one drone to another.
    reports: Vec<(u64, u64)>,
    /// When each drone had the operator's stop; `u64::MAX` before it has.
    stopped_us: Vec<u64>,
    air_us: u64,
}

impl Log {
    fn new(stations: usize) -> Self {
        Self {
            given_us: Vec::new(),
            heeded_us: Vec::new(),
            told_us: vec![Vec::new(); stations],
            arrived: Vec::new(),
            reports: Vec::new(),
            stopped_us: vec![u64::MAX; stations],
            air_us: 0,
        }
    }

    fn thought(&mut self, n: usize, base: usize, now_us: u64) {
        if n == base {
            self.given_us.push(now_us);
            self.heeded_us.push(None);
        } else {
            self.told_us[n].push(now_us);
        }
    }

    fn took(&mut self, by: usize, at_us: u64, event: Event) {
        match event {
            Event::Order { task: Order::Stop, .. } => {
                self.stopped_us[by] = self.stopped_us[by].min(at_us);
            }
            Event::Order { task: Order::Explore(Course { speed, .. }), .. } if by == 0 => {
                let said = (0..self.given_us.len())
                    .rev()
                    .find(|&n| (stick(n as u64).0 - speed.0).abs() < 0.5e-3);
                if let Some(n) = said {
                    self.heeded_us[n].get_or_insert(at_us);
                }
            }
            Event::Report { from: NodeId(from), report, .. } => {
                let base = self.told_us.len() - 1;
                let round = (report.odometer.0 * 8.0).round() as usize;
                let told = self.told_us[usize::from(from)].get(round).filter(|_| by != base);
                self.reports.extend(told.map(|&told_us| (told_us, at_us - told_us)));
            }
            Event::Telemetry { from: NodeId(from), telemetry, .. } => {
                let round = (telemetry.odometer.0 * 10.0).round() as usize;
                let told = self.told_us[usize::from(from)].get(round);
                if let Some(&told_us) = told {
                    self.arrived.push((told_us, at_us - told_us));
                }
            }
            _ => {}
        }
    }

    fn seen(&self, drones: u8, from_us: u64, until_us: u64) -> Seen {
        let counts = |at_us: u64| (from_us..until_us).contains(&at_us);
        let config = LinkConfig::DEFAULT;
        let a_second = 1.0 / f64::from(config.telemetry_every.as_secs_f32());
        let head_a_second = 1.0 / f64::from(config.head_telemetry_every.as_secs_f32());
        let offered = a_second * f64::from(drones - 1) + head_a_second;
        // Each drone has a neighbour on each side, but the base does not count as one.
        let drone_links = 2 * u64::from(drones) - 2;
        let mut seen = Seen {
            reports_offered: drone_links * (SPAN_US / ROUND_US),
            telemetry_offered: offered * SPAN_US as f64 * 1e-6,
            air_us: self.air_us,
            ..Seen::default()
        };
        // From the last to the first: an order is also answered by any later one.
        let mut next_us = u64::MAX;
        for (given_us, heeded_us) in self.given_us.iter().zip(&self.heeded_us).rev() {
            next_us = heeded_us.map_or(next_us, |at_us| at_us.min(next_us));
            if counts(*given_us) {
                seen.orders += 1;
                seen.orders_heeded += u32::from(heeded_us.is_some());
                seen.pilot_us.push(if next_us == u64::MAX { next_us } else { next_us - given_us });
            }
        }
        let delays = |arrived: &[(u64, u64)]| {
            let counted = arrived.iter().filter(|(told_us, _)| counts(*told_us));
            counted.map(|(_, delay_us)| *delay_us).collect::<Vec<_>>()
        };
        let heeded = self.given_us.iter().zip(&self.heeded_us);
        let heeded = heeded.filter_map(|(given_us, heeded_us)| Some((*given_us, (*heeded_us)?)));
        let heeded: Vec<_> = heeded.map(|(given_us, at_us)| (given_us, at_us - given_us)).collect();
        seen.order_us = delays(&heeded);
        seen.report_us = delays(&self.reports);
        seen.telemetry_us = delays(&self.arrived);
        seen.telemetry = seen.telemetry_us.len() as u32;
        seen
    }
}
