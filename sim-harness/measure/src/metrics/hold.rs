//! Computes the metrics of a chain while the operator lets the head hover.
//!
//! The book's chapter "Metrics" defines each of them. All are taken over the *hold*, and those of
//! the steady chain over its end: the last half of the hold, but at most its last 60 s.

use std::fmt;

use units::NodeId;

use super::{ROUND_S, mean, quantile};
use scenario::Stretch;

/// The end of a hold is no longer than this, s.
const LONGEST_END_S: f32 = 60.0;
/// A link swings by as much as it changes within this time, s: longer than any limit cycle of the
/// movement policies, shorter than a relay creeps over by a decibel.
const SWING_WINDOW_S: f32 = 10.0;
/// A quantity has converged when this part of all later samples is within the threshold,
const SUSTAINED: f32 = 0.95;
/// and at least this much time is left to show it.
const LEAST_REST_S: f32 = 10.0;

/// The reason why a mission has no metrics of a hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoHold {
    /// The operator never lets the head stand still.
    NeverStill,
    /// The orders of the mission come from a client and not from the scenario.
    Live,
    /// The head was not part of the chain during the hold, or the drones were on their way home.
    NoChain,
}

impl NoHold {
    const ALL: [Self; 3] = [Self::NeverStill, Self::Live, Self::NoChain];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NeverStill => "never-still",
            Self::Live => "live",
            Self::NoChain => "no-chain",
        }
    }

    /// The reason of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

impl fmt::Display for NoHold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NeverStill => "the operator never orders \"explore\" at 0 m/s",
            Self::Live => "the mission follows its clients and no script",
            Self::NoChain => {
                "the head had left the chain, or came home, when it was to stand still"
            }
        })
    }
}

/// One sample of the chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// The time since the hold began, s.
    pub time: f32,
    /// D: the largest difference between adjacent links, dB.
    pub(super) difference: f32,
    /// The weakest link over the best chain's, dB.
    pub(super) gap: f32,
    /// Whether a link is weaker than the launch limit.
    pub(super) is_violated: bool,
    /// Relays that are links, less those that the best chain must have.
    pub(super) surplus: f32,
}

/// The loss of one link at one sample of the hold.
#[derive(Clone, Copy, Debug)]
struct LinkLoss {
    ends: (NodeId, NodeId),
    sample: usize,
    loss: f32,
}

/// The samples of a hold.
pub(super) struct HoldRecord {
    span: Stretch,
    /// When the last drone is lost that the scenario loses in the hold, s since it began.
    lost_s: Option<f32>,
    samples: Vec<Sample>,
    losses: Vec<LinkLoss>,
    /// The ways of all members, sample-major, m.
    ways: Vec<f32>,
    members: usize,
}

/// The figures of a hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldMetrics {
    /// The beginning of the hold, s since the start of the mission.
    pub from_s: f32,
    /// The end of the hold, s since the start of the mission.
    pub until_s: f32,
    /// The time at which the largest difference between adjacent links converged to 3 dB, s since
    /// the hold began; infinite if it did not converge.
    pub t3_s: f32,
    /// The time at which that difference converged to 1 dB, s since the hold began.
    pub t1_s: f32,
    /// The time at which the weakest link converged to within 1 dB of the best chain's, s since the
    /// hold began.
    pub t_gap1_s: f32,
    /// The time from the last loss of a drone in the hold to when the weakest link converged to
    /// within 1 dB of the best chain's; infinite if it did not converge, NaN where no drone was
    /// lost.
    pub t_repair_s: f32,
    /// The loss of the weakest link minus that of the best chain's, mean over the end of the hold.
    pub gap_db: f32,
    /// The largest difference between adjacent links, root mean square over the end of the hold.
    pub difference_db: f32,
    /// The largest difference between any two links, each averaged over the end of the hold; NaN
    /// where drones joined or left the chain in that time.
    pub spread_db: f32,
    /// The swing of a link within 10 s that 95 % of all links and moments of the end of the hold do
    /// not exceed.
    pub swing_p95_db: f32,
    /// The standard deviation of the relays' positions over the end of the hold.
    pub position_sd_m: f32,
    /// The distance that a relay flew during the hold, mean over the relays.
    pub path_m: f32,
    /// The part of the hold in which a link was over 0.5 dB weaker than the launch limit.
    pub violation: f32,
    /// The number of relays in the chain minus the number that the best chain needs, mean over the
    /// end of the hold.
    pub relays_beyond_need: f32,
}

impl HoldRecord {
    /// A record of a hold in which drones are lost at the times `losses`.
    pub(super) fn new(span: Stretch, members: usize, losses: impl Iterator<Item = u64>) -> Self {
        let within = losses.filter(|at_us| (span.from_us..span.until_us).contains(at_us));
        let lost_s = within.max().map(|at_us| since(span, at_us));
        Self { span, lost_s, samples: Vec::new(), losses: Vec::new(), ways: Vec::new(), members }
    }

    /// Whether a sample at this time belongs to the hold.
    pub(super) fn covers(&self, now_us: u64) -> bool {
        self.span.from_us < now_us && now_us <= self.span.until_us
    }

    /// The time since the hold began, s.
    pub(super) fn time(&self, now_us: u64) -> f32 {
        since(self.span, now_us)
    }

    /// Takes one sample of the chain, the losses of its links and the ways of all members.
    pub(super) fn take(
        &mut self,
        taken: Sample,
        links: impl Iterator<Item = ((NodeId, NodeId), f32)>,
        ways: impl Iterator<Item = f32>,
    ) {
        let sample = self.samples.len();
        self.samples.push(taken);
        self.losses.extend(links.map(|(ends, loss)| LinkLoss { ends, sample, loss }));
        self.ways.extend(ways);
    }

    /// The figures; the relays are members `relays`.
    pub(super) fn metrics(&self, relays: &[usize]) -> Result<HoldMetrics, NoHold> {
        if self.samples.is_empty() {
            return Err(NoHold::NoChain);
        }
        let seconds = |us: u64| (us as f64 * 1e-6) as f32;
        let converged = |value: fn(&Sample) -> f32, threshold| {
            converged_at(self.samples.iter().map(|sample| (sample.time, value(sample))), threshold)
        };
        let end = &self.samples[self.end()..];
        Ok(HoldMetrics {
            from_s: seconds(self.span.from_us),
            until_s: seconds(self.span.until_us),
            t3_s: converged(|s| s.difference, 3.0),
            t1_s: converged(|s| s.difference, 1.0),
            t_gap1_s: converged(|s| s.gap, 1.0),
            t_repair_s: self.repaired(),
            gap_db: mean(end.iter().map(|s| s.gap)),
            difference_db: mean(end.iter().map(|s| s.difference * s.difference)).sqrt(),
            spread_db: self.spread(),
            swing_p95_db: self.swing(),
            position_sd_m: self.position_sd(relays),
            path_m: self.path(relays),
            violation: mean(self.samples.iter().map(|s| f32::from(u8::from(s.is_violated)))),
            relays_beyond_need: mean(end.iter().map(|s| s.surplus)),
        })
    }

    /// The time from the last loss of a drone to the convergence of the gap, s.
    fn repaired(&self) -> f32 {
        let Some(lost) = self.lost_s else { return f32::NAN };
        let later = self.samples.iter().filter(|sample| sample.time > lost);
        converged_at(later.map(|sample| (sample.time - lost, sample.gap)), 1.0)
    }

    /// The first sample of the end of the hold.
    fn end(&self) -> usize {
        let count = self.samples.len();
        let longest = (LONGEST_END_S / ROUND_S) as usize;
        count - (count - count / 2).min(longest)
    }

    /// The links of the end of the hold, each with its losses in order of time.
    fn links(&self) -> Vec<Vec<LinkLoss>> {
        let end = self.end();
        let mut found: Vec<Vec<LinkLoss>> = Vec::new();
        for loss in self.losses.iter().filter(|loss| loss.sample >= end) {
            match found.iter_mut().find(|link| link.first().is_some_and(|l| l.ends == loss.ends)) {
                Some(link) => link.push(*loss),
                None => found.push(vec![*loss]),
            }
        }
        found
    }

    fn spread(&self) -> f32 {
        let links = self.links();
        let samples = self.samples.len() - self.end();
        if links.iter().any(|link| link.len() != samples) {
            return f32::NAN;
        }
        let means = links.iter().map(|link| mean(link.iter().map(|loss| loss.loss)));
        let (low, high) = bounds(means);
        high - low
    }

    fn swing(&self) -> f32 {
        let window = (SWING_WINDOW_S / ROUND_S) as usize;
        let mut swings = Vec::new();
        for link in self.links() {
            // A link that was interrupted is two.
            for piece in link.chunk_by(|a, b| a.sample + 1 == b.sample) {
                for within in piece.windows(window.min(piece.len())) {
                    let (low, high) = bounds(within.iter().map(|loss| loss.loss));
                    swings.push(high - low);
                }
            }
        }
        quantile(&mut swings, 0.95)
    }

    fn way(&self, sample: usize, member: usize) -> f32 {
        self.ways[sample * self.members + member]
    }

    /// Standard deviation of each relay's position about its own mean, pooled.
    fn position_sd(&self, relays: &[usize]) -> f32 {
        let samples = self.end()..self.samples.len();
        let variance = |&relay: &usize| {
            let middle = mean(samples.clone().map(|n| self.way(n, relay)));
            mean(samples.clone().map(|n| (self.way(n, relay) - middle).powi(2)))
        };
        mean(relays.iter().map(variance)).sqrt()
    }

    fn path(&self, relays: &[usize]) -> f32 {
        let flown = |&relay: &usize| -> f32 {
            let step = |n: usize| (self.way(n, relay) - self.way(n - 1, relay)).abs();
            (1..self.samples.len()).map(step).sum()
        };
        mean(relays.iter().map(flown))
    }
}

/// A moment of the hold, s since it began.
fn since(span: Stretch, now_us: u64) -> f32 {
    ((now_us - span.from_us) as f64 * 1e-6) as f32
}

fn bounds(values: impl Iterator<Item = f32>) -> (f32, f32) {
    values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The first moment from which on 95 % of all samples are within the threshold; infinite if there
/// is none with at least 10 s to follow. Samples are pairs of a time and a value.
pub(crate) fn converged_at(
    samples: impl DoubleEndedIterator<Item = (f32, f32)>,
    threshold: f32,
) -> f32 {
    let least = (LEAST_REST_S / ROUND_S) as usize;
    let (mut within, mut seen) = (0_usize, 0_usize);
    let mut first = f32::INFINITY;
    for (time, value) in samples.rev() {
        seen += 1;
        let is_within = value <= threshold;
        within += usize::from(is_within);
        if is_within && seen >= least && within as f32 >= SUSTAINED * seen as f32 {
            first = time;
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hold of 100 s of a chain of two links, whose losses are `loss(link, time)`; a third link
    /// went at 30 s.
    fn held(loss: impl Fn(u8, f32) -> f32) -> HoldMetrics {
        let span = Stretch { from_us: 50_000_000, until_us: 150_000_000 };
        let mut record = HoldRecord::new(span, 3, [80_000_000, 200_000_000].into_iter());
        for n in 1..=500_u64 {
            let now_us = span.from_us + n * 200_000;
            let time = record.time(now_us);
            let (near, far) = (loss(0, time), loss(1, time));
            let links = [((NodeId(2), NodeId(1)), near), ((NodeId(1), NodeId(0)), far)];
            let weakest = near.max(far);
            let sample = Sample {
                time,
                difference: (near - far).abs(),
                gap: weakest - 60.0,
                is_violated: weakest > 65.0,
                surplus: 1.0,
            };
            record.take(sample, links.into_iter(), [9.0, 4.0, 0.0].into_iter());
        }
        record.metrics(&[1]).unwrap()
    }

    /// Both links swing by 20 dB together: every mean is that of a chain at rest.
    #[test]
    fn a_limit_cycle_whose_means_are_equal_is_seen_in_the_swing() {
        let swinging = held(|_, time| 60.0 + 10.0 * libm::sinf(time));
        assert!(swinging.spread_db < 0.5 && swinging.gap_db.abs() < 0.5, "{swinging:?}");
        assert!((19.0..=20.0).contains(&swinging.swing_p95_db), "{swinging:?}");
        let opposed = held(|link, time| {
            60.0 + 10.0 * libm::sinf(time + f32::from(link) * core::f32::consts::PI)
        });
        assert!(opposed.spread_db < 0.5, "{opposed:?}");
        assert!((19.0..=20.0).contains(&opposed.swing_p95_db), "{opposed:?}");
        let still = held(|_, _| 60.0);
        assert_eq!((still.spread_db, still.swing_p95_db, still.gap_db), (0.0, 0.0, 0.0));
    }

    /// A link that creeps by a tenth of a decibel a second does not swing by ten.
    #[test]
    fn slow_creeping_is_little_swing() {
        let creeping = held(|_, time| 60.0 + 0.02 * time);
        assert!(creeping.swing_p95_db < 0.21, "{creeping:?}");
    }

    #[test]
    fn times_count_from_the_beginning_of_the_hold() {
        let settling = held(|link, time| if link == 0 && time < 20.0 { 70.0 } else { 60.0 });
        assert!((19.0..=20.5).contains(&settling.t3_s), "{settling:?}");
        assert_eq!((settling.from_s, settling.until_s), (50.0, 150.0));
    }

    #[test]
    fn a_repair_counts_from_the_loss() {
        let repaired = held(|_, time| if (30.0..42.0).contains(&time) { 70.0 } else { 60.0 });
        assert!((11.5..=12.5).contains(&repaired.t_repair_s), "{repaired:?}");
        assert!((0.11..=0.13).contains(&repaired.violation), "{repaired:?}");
        assert_eq!(repaired.relays_beyond_need, 1.0);
        let never = held(|_, time| if time < 30.0 { 60.0 } else { 62.0 });
        assert!(never.t_repair_s.is_infinite(), "{never:?}");
    }

    #[test]
    fn a_hold_without_a_chain_has_no_figures() {
        let record = HoldRecord::new(Stretch { from_us: 0, until_us: 1 }, 3, std::iter::empty());
        assert_eq!(record.metrics(&[1]), Err(NoHold::NoChain));
    }
}
