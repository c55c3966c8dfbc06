//! Fits the log-distance law by least squares.

use std::collections::BTreeMap;

use random::Stream;
use units::{Dbm, Metres};

use super::{Point, log_distance, points};
use crate::recording::Recording;

/// A log-distance law with a gain for each link.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    pub(super) loss_at_1m: f64,
    pub(super) exponent: f64,
    /// The gain of each link, dB, with the number of its packets.
    pub(super) gains: BTreeMap<usize, (f64, usize)>,
    /// The variance of what is left of a packet, dB².
    variance: f64,
}

/// Sums over the packets of one link.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: usize,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

/// The least spread of a link's log-distances for a slope, as a standard deviation over all links:
/// 0.02 is 5 % of the distance.
const LEAST_SPREAD: f64 = 0.02;

impl Law {
    /// The law that fits these packets best; `None` where no link's distance changes.
    pub(super) fn of<'a>(points: impl Iterator<Item = &'a Point>) -> Option<Self> {
        let mut links: BTreeMap<usize, Sums> = BTreeMap::new();
        for point in points {
            let sums = links.entry(point.link).or_default();
            let (x, y) = (point.log_distance, point.rssi);
            sums.count += 1;
            sums.x += x;
            sums.y += y;
            sums.xx += x * x;
            sums.xy += x * y;
            sums.yy += y * y;
        }
        let total: usize = links.values().map(|sums| sums.count).sum();
        let within = |f: fn(&Sums) -> f64| links.values().map(f).sum::<f64>();
        let spread = within(|s| s.xx - s.x * s.x / s.count as f64);
        let product = within(|s| s.xy - s.x * s.y / s.count as f64);
        let left = within(|s| s.yy - s.y * s.y / s.count as f64);
        if total == 0 || spread < LEAST_SPREAD * LEAST_SPREAD * total as f64 {
            return None;
        }
        let slope = product / spread;
        let mean = |f: fn(&Sums) -> f64| links.values().map(f).sum::<f64>() / total as f64;
        let intercept = mean(|s| s.y) - slope * mean(|s| s.x);
        let gain = |s: &Sums| (s.y - slope * s.x) / s.count as f64 - intercept;
        Some(Self {
            loss_at_1m: -intercept,
            exponent: -slope / 10.0,
            gains: links.iter().map(|(&link, sums)| (link, (gain(sums), sums.count))).collect(),
            variance: (left - slope * product) / total as f64,
        })
    }

    /// The law that fits one recording best; `None` where it knows no distances, or where they do not
    /// change.
    pub(crate) fn of_recording(recording: &Recording) -> Option<Self> {
        Self::of(points([recording].into_iter()).iter())
    }

    /// By how much a packet of a link is stronger than the law with the link's gain, dB.
    pub(crate) fn residual(&self, link: usize, distance: Metres, rssi: Dbm) -> f32 {
        let gain = self.gains.get(&link).map_or(0.0, |(gain, _)| *gain);
        let expected = self.expected(log_distance(distance)) + gain;
        (f64::from(rssi.0) - expected) as f32
    }

    /// The strength at the distance of this logarithm, dBm.
    pub(super) fn expected(&self, log_distance: f64) -> f64 {
        -self.loss_at_1m - 10.0 * self.exponent * log_distance
    }

    /// What is left of each packet, dB.
    pub(super) fn residuals(&self, points: &[Point]) -> Vec<f64> {
        let gain = |point: &Point| self.gains.get(&point.link).map_or(0.0, |(gain, _)| *gain);
        points
            .iter()
            .map(|point| point.rssi - self.expected(point.log_distance) - gain(point))
            .collect()
    }

    /// The standard deviation of the links' gains, without what the packets' own scatter makes of
    /// it, dB.
    pub(super) fn gain_error(&self) -> f64 {
        let links = self.gains.len() as f64;
        let squares: f64 = self.gains.values().map(|(gain, _)| gain * gain).sum();
        let scatter: f64 = self.gains.values().map(|(_, n)| self.variance / *n as f64).sum();
        ((squares - scatter) / links).max(0.0).sqrt()
    }
}

/// The laws of packets drawn again, in blocks of time, with replacement.
pub(super) fn resampled(
    points: &[Point],
    block: f64,
    count: usize,
    random: &mut Stream,
) -> Vec<Law> {
    let mut blocks: BTreeMap<(usize, u64), Vec<usize>> = BTreeMap::new();
    for (n, point) in points.iter().enumerate() {
        blocks.entry((point.link, (point.time / block) as u64)).or_default().push(n);
    }
    let blocks: Vec<Vec<usize>> = blocks.into_values().collect();
    let draw = |_| {
        let chosen: Vec<&Point> = (0..blocks.len())
            .flat_map(|_| &blocks[random.below(blocks.len() as u32) as usize])
            .map(|&n| &points[n])
            .collect();
        Law::of(chosen.into_iter())
    };
    (0..count).filter_map(draw).collect()
}
