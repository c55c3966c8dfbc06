//! A channel that plays recorded packets back: the links of a mission scatter as those of a log did.
//!
//! Of each recorded packet counts its residual, by which it was stronger than the law that was fitted
//! to its log. Where the log knows the distances, the residual has two parts: the *level*, its mean
//! at the distance, and the *deviation* of the packet from it. A simulated link has the level of its
//! own length, the same in both directions, and each packet that is received has the deviation of the
//! next recorded one, separately in each direction. Where the log knows no distances, there is no
//! level, and a packet has the residual of the recorded packet that was the last at that time.
//!
//! Each link of a mission is given one of the log's links and a place to begin in it, both drawn from
//! the mission's seed. At its end a recording is played backwards, and forwards again, so that no
//! step comes into it.

use std::sync::Arc;

use random::{Purpose, Stream};
use units::{Db, Metres};

/// The lengths over which residuals are averaged for the level, m: eight wavelengths at 2.4 GHz, so
/// that the fades within them belong to the deviations.
const BIN: f32 = 1.0;

/// The least number of packets of a link that is played back.
const LEAST: usize = 20;

/// One packet of a log, as a channel needs it.
#[derive(Clone, Copy, Debug)]
pub struct Residual {
    /// When it was received, since the log began, µs. Where the log began anew, time goes on.
    pub at_us: u64,
    /// The distance between both ends.
    pub distance: Option<Metres>,
    /// By how much it was stronger than the law.
    pub residual: Db,
}

/// The residuals of all links of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedChannel {
    links: Vec<RecordedLink>,
}

/// The residuals of one link.
#[derive(Clone, Debug, PartialEq)]
struct RecordedLink {
    levels: Option<Levels>,
    /// The moments of the packets, µs since the first; empty where they are played in their order.
    times_us: Vec<u64>,
    deviations: Vec<f32>,
}

/// The mean residual by distance.
#[derive(Clone, Debug, PartialEq)]
struct Levels {
    /// In the middles of bins that follow each other; the first is at `nearest`, m.
    means: Vec<f32>,
    nearest: f32,
}

impl RecordedChannel {
    /// The channel of a log, whose links are given one after the other; `None` where no link has
    /// enough packets. The packets of a link have distances, or none has.
    #[must_use]
    pub fn of(links: impl Iterator<Item = Vec<Residual>>) -> Option<Self> {
        let links: Vec<_> = links
            .filter(|packets| packets.len() >= LEAST)
            .map(|link| RecordedLink::of(&link))
            .collect();
        (!links.is_empty()).then_some(Self { links })
    }

    /// Draws one of its links, and a place to begin in it as a part of the whole.
    fn draw(&self, mut stream: Stream) -> (usize, f64) {
        let link = stream.below(self.links.len() as u32) as usize;
        (link, f64::from(stream.uniform()))
    }
}

impl RecordedLink {
    fn of(packets: &[Residual]) -> Self {
        let levels = Levels::of(packets);
        let deviation = |packet: &Residual| {
            let distance = packet.distance.map_or(0.0, |distance| distance.0);
            packet.residual.0 - levels.as_ref().map_or(0.0, |levels| levels.at(distance))
        };
        let first_us = packets.first().map_or(0, |packet| packet.at_us);
        let times_us = packets.iter().map(|packet| packet.at_us.saturating_sub(first_us));
        Self {
            times_us: if levels.is_none() { times_us.collect() } else { Vec::new() },
            deviations: packets.iter().map(deviation).collect(),
            levels,
        }
    }
}

impl Levels {
    fn of(packets: &[Residual]) -> Option<Self> {
        let known: Vec<(f32, f32)> = packets
            .iter()
            .filter_map(|packet| Some((packet.distance?.0, packet.residual.0)))
            .collect();
        let nearest = known.iter().map(|(distance, _)| *distance).fold(f32::INFINITY, f32::min);
        let farthest = known.iter().map(|(distance, _)| *distance).fold(0.0, f32::max);
        if known.len() < packets.len() || known.is_empty() {
            return None;
        }
        let bins = ((farthest - nearest) / BIN) as usize + 1;
        let mut sums = vec![(0.0_f32, 0.0_f32); bins];
        for (distance, residual) in known {
            let bin = ((distance - nearest) / BIN) as usize;
            let (sum, count) = &mut sums[bin.min(bins - 1)];
            *sum += residual;
            *count += 1.0;
        }
        Some(Self { means: filled(&sums), nearest: nearest + 0.5 * BIN })
    }

    /// The length over which there are levels, m.
    fn span(&self) -> f32 {
        BIN * (self.means.len().saturating_sub(1)) as f32
    }

    /// The level at a distance, between the middles of two bins by a straight line.
    fn at(&self, distance: f32) -> f32 {
        let place = ((distance - self.nearest) / BIN).clamp(0.0, self.span() / BIN);
        let before = place as usize;
        let mean = |n: usize| self.means.get(n).or(self.means.last()).copied().unwrap_or(0.0);
        mean(before) + (place - place.floor()) * (mean(before + 1) - mean(before))
    }
}

/// The means of bins; one without packets has the mean of the bin before, or else of the next.
fn filled(sums: &[(f32, f32)]) -> Vec<f32> {
    let first = sums.iter().find(|(_, count)| *count > 0.0).map_or(0.0, |(sum, count)| sum / count);
    let mut last = first;
    sums.iter()
        .map(|(sum, count)| {
            if *count > 0.0 {
                last = sum / count;
            }
            last
        })
        .collect()
}

/// The place of a mirrored recording that is this far from where it began, both in parts of its
/// length.
fn mirrored(place: f64) -> f64 {
    let within = place.rem_euclid(2.0);
    if within <= 1.0 { within } else { 2.0 - within }
}

/// The levels of the links of a mission, each the same in both directions.
#[derive(Clone, Debug)]
pub struct LinkLevels {
    channel: Arc<RecordedChannel>,
    stations: usize,
    /// By the smaller and the larger number of both stations: the recorded link, and where it
    /// begins, as a part of the recorded distances.
    links: Vec<(usize, f64)>,
}

impl LinkLevels {
    /// The levels between so many stations.
    pub fn new(channel: &Arc<RecordedChannel>, stations: usize, seed: u64) -> Self {
        let between = |n: usize| Purpose::Level((n / stations) as u8, (n % stations) as u8);
        let link = |n| channel.draw(Stream::new(seed, between(n)));
        let links = (0..stations * stations).map(link).collect();
        Self { channel: Arc::clone(channel), stations, links }
    }

    /// By how much the link of this length between two stations is stronger than the law.
    pub fn at(&self, one: usize, other: usize, length: Metres) -> Db {
        let (link, offset) = self.links[one.min(other) * self.stations + one.max(other)];
        let levels = self.channel.links[link].levels.as_ref();
        let Some(levels) = levels.filter(|levels| levels.span() > 0.0) else { return Db(0.0) };
        let part = mirrored(offset + f64::from(length.0 / levels.span()));
        Db(levels.at(levels.nearest + part as f32 * levels.span()))
    }
}

/// The deviations of the packets of a mission, separately in each direction.
#[derive(Clone, Debug)]
pub struct PacketDeviations {
    channel: Arc<RecordedChannel>,
    stations: usize,
    /// By sender and receiver.
    links: Vec<Playback>,
}

/// The playback of the packets from one station to another.
#[derive(Clone, Copy, Debug)]
struct Playback {
    link: usize,
    /// Where it begins, as a part of the recorded time or of the recorded packets.
    offset: f64,
    /// The number of packets that have come.
    packets: u64,
}

impl PacketDeviations {
    /// The deviations between so many stations.
    pub fn new(channel: &Arc<RecordedChannel>, stations: usize, seed: u64) -> Self {
        let between = |n: usize| Purpose::Deviation((n / stations) as u8, (n % stations) as u8);
        let playback = |n| {
            let (link, offset) = channel.draw(Stream::new(seed, between(n)));
            Playback { link, offset, packets: 0 }
        };
        let links = (0..stations * stations).map(playback).collect();
        Self { channel: Arc::clone(channel), stations, links }
    }

    /// The deviation of a packet that comes to a receiver now.
    pub fn next(&mut self, from: usize, to: usize, now_us: u64) -> Db {
        let Playback { link, offset, packets } = &mut self.links[from * self.stations + to];
        let link = &self.channel.links[*link];
        let at = match link.times_us.last() {
            Some(&last_us) if last_us > 0 => {
                let part = mirrored(*offset + now_us as f64 / last_us as f64);
                let then_us = (part * last_us as f64) as u64;
                link.times_us.partition_point(|&at_us| at_us <= then_us).saturating_sub(1)
            }
            _ => {
                let count = link.deviations.len() as u64;
                // There and back again, each packet once on either way.
                let place = ((*offset * count as f64) as u64 + *packets) % (2 * count);
                (if place < count { place } else { 2 * count - 1 - place }) as usize
            }
        };
        *packets += 1;
        Db(link.deviations[at])
    }
}
