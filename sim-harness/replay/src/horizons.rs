//! Compares how well filters predict a packet with the motion of the link's ends and without it,
//! from the packet before and from packets one and two seconds old.
//!
//! A filter predicts a packet as if all packets within the horizon had been lost: its state after
//! the last packet that is old enough is moved on over the motion since. The motion is known on
//! board without any packet, so a horizon of a second is what a fade of a second leaves a drone with.
//!
//! The gain of the motion is that of one filter over the same filter whose rate of separation is
//! zero, on the same packets. Its interval comes from a bootstrap over blocks of each link's time,
//! since packets near each other are not independent.

mod bootstrap;
mod table;

use std::collections::VecDeque;
use std::path::Path;

use chain::filter::{LinkFilter, Smoothing};
use chain::policy::PolicyConfig;
use serde::Serialize;
use units::{Duration, Instant, MetresPerSecond};

use self::bootstrap::Block;
use super::prediction::{REAL_LINK, Residuals, log_density, move_on};
use recordings::recording::{Recording, Sample};

/// The least ages of the packets from which a packet is predicted. With zero it is the packet before.
const HORIZONS: [Duration; 3] = [Duration::ZERO, Duration::from_secs(1), Duration::from_secs(2)];

/// The number of predictors.
const N: usize = 8;

/// Name and smoothing of each predictor, and whether the log's motion moves it. The last six are
/// three pairs of one filter without its motion and with it.
const PREDICTORS: [(&str, Smoothing, bool); N] = [
    ("last sample", Smoothing::Raw, false),
    ("average 0.27", Smoothing::Average { weight: 0.27 }, false),
    ("paper, still", PolicyConfig::K.smoothing, false),
    ("paper", PolicyConfig::K.smoothing, true),
    ("fitted, still", Smoothing::Kalman(REAL_LINK), false),
    ("fitted", Smoothing::Kalman(REAL_LINK), true),
    ("chain, still", PolicyConfig::CHAIN.smoothing, false),
    ("chain", PolicyConfig::CHAIN.smoothing, true),
];

/// The filters whose gain by the motion is reported, with the places of their predictors without the
/// motion and with it.
const PAIRS: [(&str, usize, usize); 3] = [("paper", 2, 3), ("fitted", 4, 5), ("chain", 6, 7)];

/// The place of the predictor whose law says what the motion should change, and of the same without
/// the motion.
const LAW: usize = 5;
const STILL: usize = 4;

/// The blocks of the bootstrap, s: as long as those of the fit.
const BLOCK_S: f64 = 20.0;

/// A rate of separation from which on a log has motion: half of the noise at which the authors'
/// relays are taken to hover.
const MOVES: MetresPerSecond = MetresPerSecond(0.03);

/// The comparison over all logs with motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Horizons {
    /// One entry for each log with motion, in the order given.
    pub logs: Vec<LogHorizons>,
    /// The files that were left out, as no link's length changes in them or none is known.
    pub without_motion: Vec<String>,
    /// The gain over the packets of all logs with motion together; empty where there are fewer than two.
    pub all: Vec<Horizon>,
}

/// The comparison over one log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogHorizons {
    /// The file, as it was named.
    pub file: String,
    /// One entry for each horizon.
    pub horizons: Vec<Horizon>,
    /// The links, in the order of the log.
    pub links: Vec<LinkHorizons>,
}

/// The comparison over one link.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkHorizons {
    /// The link's name in the log.
    pub link: String,
    /// One entry for each horizon.
    pub horizons: Vec<Horizon>,
}

/// The comparison at one horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// The least age of the packet that is predicted from, s; zero for the packet before.
    pub horizon_s: f32,
    /// The number of packets that were predicted.
    pub samples: usize,
    /// The root mean square of what the motion should change until the packet, by the log-distance
    /// law of the fitted filter, dB.
    pub motion_db: f64,
    /// The part of that change that came, by regression of what the filter without motion did not
    /// foresee: one where the law holds. Below a half, motion makes a prediction worse.
    pub came: Interval,
    /// The scores of each predictor.
    pub predictors: Vec<PredictorScore>,
    /// The gain by the motion of each filter.
    pub gains: Vec<Gain>,
}

/// The scores of one predictor at one horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictorScore {
    /// The predictor's name.
    pub name: &'static str,
    /// The root of the mean squared error, dB.
    pub rmse_db: f64,
    /// The mean error, received less expected, dB.
    pub mean_db: f64,
    /// The median of the errors without their signs, dB.
    pub median_db: f64,
    /// The mean natural logarithm of the density that the predictor gave to the received strength.
    pub log_likelihood: f64,
}

/// By how much the motion makes one filter better.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// The filter's name.
    pub filter: &'static str,
    /// By which part of a hundred the root mean squared error is smaller with the motion; negative
    /// where it is larger.
    pub rmse_percent: Interval,
    /// By how much the mean log-likelihood is larger with the motion.
    pub log_likelihood: Interval,
}

/// A value with the bounds between which 95 % of the bootstrap's samples lie.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The value.
    pub value: f64,
    /// The lower bound.
    pub low: f64,
    /// The upper bound.
    pub high: f64,
}

impl Interval {
    /// Whether zero lies outside of the interval.
    #[must_use]
    pub fn excludes_zero(&self) -> bool {
        self.low > 0.0 || self.high < 0.0
    }
}

/// A packet that all predictors have predicted.
#[derive(Clone, Debug)]
struct Predicted {
    link: usize,
    /// The number of its block within its link.
    block: u64,
    errors: [f64; N],
    log_likelihoods: [f64; N],
    /// What the motion should have changed, dB.
    motion: f64,
}

/// The filters after one packet, and the motion that led to it.
struct Past {
    time: Instant,
    span: Duration,
    separating: Option<MetresPerSecond>,
    filters: [LinkFilter; N],
}

/// The predictors of one link.
#[derive(Default)]
struct Link {
    past: VecDeque<Past>,
    residuals: [[Residuals; N]; HORIZONS.len()],
}

impl Link {
    fn hear(&mut self, sample: &Sample, block: u64) -> [Option<Predicted>; HORIZONS.len()] {
        if sample.restarts {
            self.past.clear();
        }
        let span = self.past.back().map_or(Duration::ZERO, |last| sample.time.since(last.time));
        let mut predicted = [const { None }; HORIZONS.len()];
        for (n, horizon) in HORIZONS.into_iter().enumerate() {
            predicted[n] = self.predict(n, horizon, sample, span, block);
        }
        self.learn(sample, span);
        predicted
    }

    /// Moves the filters after packet `from` on to this packet.
    fn moved(&self, from: usize, sample: &Sample, span: Duration) -> [LinkFilter; N] {
        let mut filters = self.past[from].filters;
        let since = self.past.iter().skip(from + 1).map(|past| (past.span, past.separating));
        for (span, separating) in since.chain([(span, sample.separating)]) {
            for (filter, (_, smoothing, moves)) in filters.iter_mut().zip(&PREDICTORS) {
                let speed = separating.filter(|_| *moves).unwrap_or(MetresPerSecond::ZERO);
                move_on(filter, smoothing, speed, span);
            }
        }
        filters
    }

    fn predict(
        &mut self,
        at: usize,
        horizon: Duration,
        sample: &Sample,
        span: Duration,
        block: u64,
    ) -> Option<Predicted> {
        let is_old = |past: &Past| sample.time.since(past.time) >= horizon;
        let from = self.past.iter().rposition(is_old)?;
        let filters = self.moved(from, sample, span);
        let strength = |filter: &LinkFilter| filter.rssi().map(|rssi| f64::from(rssi.0));
        let before = strength(&self.past[from].filters[LAW])?;
        let motion = strength(&filters[LAW])? - before;
        let [mut errors, mut log_likelihoods] = [[0.0; N]; 2];
        for (n, (filter, (_, smoothing, _))) in filters.iter().zip(&PREDICTORS).enumerate() {
            let expected = filter.expectation(smoothing)?;
            let residuals = &mut self.residuals[at][n];
            let variance = expected.variance.map_or_else(|| residuals.variance(), f64::from);
            errors[n] = f64::from((sample.rssi - expected.rssi).0);
            log_likelihoods[n] = log_density(errors[n], variance);
            residuals.add(errors[n]);
        }
        Some(Predicted { link: sample.link, block, errors, log_likelihoods, motion })
    }

    fn learn(&mut self, sample: &Sample, span: Duration) {
        let mut filters = match self.past.len().checked_sub(1) {
            Some(last) => self.moved(last, sample, span),
            None => [LinkFilter::new(); N],
        };
        for (filter, (_, smoothing, _)) in filters.iter_mut().zip(&PREDICTORS) {
            filter.update(smoothing, sample.rssi);
        }
        self.past.push_back(Past {
            time: sample.time,
            span,
            separating: sample.separating,
            filters,
        });
        // The second is the oldest that any later packet needs, once it is older than all horizons.
        let [.., longest] = HORIZONS;
        while self.past.get(1).is_some_and(|past| sample.time.since(past.time) >= longest) {
            self.past.pop_front();
        }
    }
}

/// The packets of a log that were predicted, by horizon.
type ByHorizon = [Vec<Predicted>; HORIZONS.len()];

fn predicted(recording: &Recording) -> ByHorizon {
    let mut links: Vec<Link> = recording.links.iter().map(|_| Link::default()).collect();
    let mut by_horizon = ByHorizon::default();
    for sample in &recording.samples {
        let Some(link) = links.get_mut(sample.link) else { continue };
        let block = (sample.time.as_micros() as f64 * 1e-6 / BLOCK_S) as u64;
        for (into, one) in by_horizon.iter_mut().zip(link.hear(sample, block)) {
            into.extend(one);
        }
    }
    by_horizon
}

/// Compares the filters over every log in which the length of a link changes.
pub(super) fn compare(logs: &[(&Path, Recording)]) -> Horizons {
    let mut compared = Horizons { logs: Vec::new(), without_motion: Vec::new(), all: Vec::new() };
    let mut pooled = ByHorizon::default();
    let mut links_before = 0;
    for (file, recording) in logs {
        let file = file.display().to_string();
        let moves =
            |sample: &Sample| sample.separating.is_some_and(|speed| speed.0.abs() > MOVES.0);
        if !recording.samples.iter().any(moves) {
            compared.without_motion.push(file);
            continue;
        }
        let packets = predicted(recording);
        compared.logs.push(log_horizons(file, recording, &packets));
        for (into, packets) in pooled.iter_mut().zip(packets) {
            into.extend(packets.into_iter().map(|one| {
                let link = links_before + one.link;
                Predicted { link, ..one }
            }));
        }
        links_before += recording.links.len();
    }
    if compared.logs.len() > 1 {
        compared.all = horizons(&pooled, |_| true);
    }
    compared
}

fn log_horizons(file: String, recording: &Recording, packets: &ByHorizon) -> LogHorizons {
    let of_link = |(number, link): (usize, &String)| LinkHorizons {
        link: link.clone(),
        horizons: horizons(packets, |one| one.link == number),
    };
    LogHorizons {
        file,
        horizons: horizons(packets, |_| true),
        links: recording.links.iter().enumerate().map(of_link).collect(),
    }
}

/// The comparison over some packets, at each horizon at which any were predicted.
fn horizons(packets: &ByHorizon, counts: impl Fn(&Predicted) -> bool) -> Vec<Horizon> {
    let each = HORIZONS.into_iter().zip(packets);
    each.filter_map(|(horizon, packets)| {
        let packets: Vec<&Predicted> = packets.iter().filter(|one| counts(one)).collect();
        at_horizon(horizon, &packets)
    })
    .collect()
}

fn at_horizon(horizon: Duration, packets: &[&Predicted]) -> Option<Horizon> {
    let count = (!packets.is_empty()).then_some(packets.len() as f64)?;
    let blocks = Block::of(packets);
    let whole = Block::sum(blocks.iter());
    let scores = PREDICTORS.iter().enumerate().map(|(n, (name, ..))| PredictorScore {
        name,
        rmse_db: (whole.squares[n] / count).sqrt(),
        mean_db: packets.iter().map(|one| one.errors[n]).sum::<f64>() / count,
        median_db: median(packets.iter().map(|one| one.errors[n].abs()).collect()),
        log_likelihood: whole.log_likelihoods[n] / count,
    });
    Some(Horizon {
        horizon_s: horizon.as_secs_f32(),
        samples: packets.len(),
        motion_db: (whole.motion_squares / count).sqrt(),
        came: bootstrap::interval(&blocks, Block::came),
        predictors: scores.collect(),
        gains: bootstrap::gains(&blocks),
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
