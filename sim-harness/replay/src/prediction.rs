//! Measures how well six predictors foresee the RSSI of the next packet.
//!
//! All six predictors get the same packets, and all are the on-board [`LinkFilter`] with different
//! settings. Before each packet each predicts it from earlier packets and from the motion since;
//! then each is given the packet. The first packet of a link, and the first after a silence that on
//! board makes a link lost, are not predicted.

use chain::filter::{Kalman, LinkFilter, Slope, Smoothing};
use chain::policy::PolicyConfig;
use serde::Serialize;
use units::{Db, Dbm, Duration, Instant, MetresPerSecond};

use recordings::recording::{Recording, Sample};

/// The filter for a real 2.4 GHz link.
///
/// The slope is the on-board one. R and Q are those of the largest likelihood, of 7 values of R
/// from 9 to 24 dB² and 9 of Q from 0.5 to 10 dB²/s, each of three recordings weighing the same:
/// the TETAM tracks `straight_01` and `straight_03` and the robot. The other two tracks and the
/// links without motion were not used for the choice. The book's chapter "Replay" has the numbers.
pub const REAL_LINK: Kalman = Kalman {
    // The exponent is between air and one wall, the first metre is free space at 2.4 GHz. On the
    // two tracks a constant 1 dB/m does as well, 2 dB/m worse.
    slope: Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) },
    // Twelve times what the on-board filter allows for: real links fade slowly for more reasons
    // than their length.
    process_variance: 3.0,
    // Between 0 and 1 the likelihood changes by less than 0.0003: the data do not tell.
    motion_doubt: 0.5,
    // Six times the paper's 3 dB². The three advertising channels fade differently, and the
    // receiver does not say which one it heard.
    measurement_variance: 18.0,
};

/// One round of the chain's loop, 5 Hz: the on-board filter predicts at least this often.
const ROUND: Duration = Duration::from_millis(200);

/// The number of predictors.
const N: usize = 6;

/// The predictors: last sample, average, filter without velocity, filter with it, and the
/// filters of the policies `k-tuned` and `chain` with it.
#[derive(Clone, Copy)]
struct Predictor {
    smoothing: Smoothing,
    moves: bool,
}

fn predictors(kalman: Kalman) -> [Predictor; N] {
    let still = |smoothing| Predictor { smoothing, moves: false };
    [
        still(Smoothing::Raw),
        still(Smoothing::Average { weight: 0.27 }),
        still(Smoothing::Kalman(kalman)),
        Predictor { smoothing: Smoothing::Kalman(kalman), moves: true },
        Predictor { smoothing: PolicyConfig::K_TUNED.smoothing, moves: true },
        Predictor { smoothing: PolicyConfig::CHAIN.smoothing, moves: true },
    ]
}

/// The variance of a predictor's residuals on one link so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Residuals {
    count: u32,
    squares: f64,
}

impl Residuals {
    /// Before the first residual the variance is that of (5 dB)², as links in motion show it.
    const PRIOR: f64 = 25.0;
    /// The weight of that variance, in residuals.
    const PRIOR_WEIGHT: f64 = 4.0;

    pub(super) fn variance(&self) -> f64 {
        (Self::PRIOR_WEIGHT * Self::PRIOR + self.squares)
            / (Self::PRIOR_WEIGHT + f64::from(self.count))
    }

    pub(super) fn add(&mut self, residual: f64) {
        self.count = self.count.saturating_add(1);
        self.squares += residual * residual;
    }
}

/// The prediction of one packet by one predictor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foresight {
    pub(super) expected: Dbm,
    /// Received less expected, in dB.
    pub(super) residual: f64,
    own_variance: Option<f64>,
    seen_variance: f64,
}

/// The predictions of all of them; `None` for one that had nothing to predict from.
pub(super) type Foresights = [Option<Foresight>; N];

/// The state of all predictors for one link.
#[derive(Clone, Default)]
struct Link {
    filters: [LinkFilter; N],
    residuals: [Residuals; N],
    heard: Instant,
}

impl Link {
    fn hear(&mut self, sample: &Sample, predictors: &[Predictor; N]) -> Foresights {
        let span = sample.time.since(self.heard);
        self.heard = sample.time;
        let each = self.filters.iter_mut().zip(&mut self.residuals).zip(predictors);
        let mut foresights = [None; N];
        for (foresight, ((filter, residuals), predictor)) in foresights.iter_mut().zip(each) {
            if sample.restarts {
                filter.reset();
            }
            let speed = sample.separating.filter(|_| predictor.moves);
            let speed = speed.unwrap_or(MetresPerSecond::ZERO);
            move_on(filter, &predictor.smoothing, speed, span);
            *foresight = foresee(filter, &predictor.smoothing, residuals, sample.rssi);
            filter.update(&predictor.smoothing, sample.rssi);
        }
        foresights
    }
}

/// Moves a filter on over a time in which the ends separated at this speed, in pieces no longer than
/// a round of the chain's loop.
pub(super) fn move_on(
    filter: &mut LinkFilter,
    smoothing: &Smoothing,
    speed: MetresPerSecond,
    mut span: Duration,
) {
    // A reset filter has nothing to move, and no other waits longer than a link may be silent.
    while filter.rssi().is_some() && span > Duration::ZERO {
        let round = span.min(ROUND);
        filter.predict(smoothing, speed, round);
        span = Duration::from_micros(span.as_micros() - round.as_micros());
    }
}

fn foresee(
    filter: &LinkFilter,
    smoothing: &Smoothing,
    residuals: &mut Residuals,
    rssi: Dbm,
) -> Option<Foresight> {
    let expectation = filter.expectation(smoothing)?;
    let residual = f64::from((rssi - expectation.rssi).0);
    let foresight = Foresight {
        expected: expectation.rssi,
        residual,
        own_variance: expectation.variance.map(f64::from),
        seen_variance: residuals.variance(),
    };
    residuals.add(residual);
    Some(foresight)
}

/// Predicts each sample of a recording with all predictors.
pub(super) fn foresee_all(recording: &Recording, kalman: Kalman) -> Vec<Foresights> {
    let predictors = predictors(kalman);
    let mut links = vec![Link::default(); recording.links.len()];
    recording
        .samples
        .iter()
        .map(|sample| {
            links.get_mut(sample.link).map_or([None; N], |link| link.hear(sample, &predictors))
        })
        .collect()
}

/// The natural logarithm of the normal density of an error about zero.
pub(super) fn log_density(error: f64, variance: f64) -> f64 {
    -0.5 * (libm::log(core::f64::consts::TAU * variance) + error * error / variance)
}

/// Sums over one predictor's foresights.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: u64,
    squares: f64,
    own: f64,
    seen: f64,
}

impl Sums {
    fn add(&mut self, foresight: &Foresight) {
        let squared = foresight.residual * foresight.residual;
        let likelihood = |variance: f64| log_density(foresight.residual, variance);
        let seen = likelihood(foresight.seen_variance);
        self.count += 1;
        self.squares += squared;
        self.own += foresight.own_variance.map_or(seen, likelihood);
        self.seen += seen;
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.squares += other.squares;
        self.own += other.own;
        self.seen += other.seen;
    }

    fn score(&self) -> Option<Score> {
        let count = (self.count > 0).then_some(self.count as f64)?;
        Some(Score {
            rmse_db: libm::sqrt(self.squares / count),
            log_likelihood: self.own / count,
            log_likelihood_seen: self.seen / count,
        })
    }
}

/// The scores of one predictor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// The root of the mean squared difference between the received and the expected strength.
    pub rmse_db: f64,
    /// The mean natural logarithm of the density that the predictor gave to the received strength:
    /// a normal one, with the variance that the filter predicts, or, for the last sample and the
    /// average, which predict none, with that of their residuals so far.
    pub log_likelihood: f64,
    /// The log-likelihood with the variance of the residuals so far, for all predictors alike.
    pub log_likelihood_seen: f64,
}

/// The scores of the predictors on the same packets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// The number of packets that were predicted.
    pub samples: u64,
    /// The prediction by the packet before.
    pub last: Score,
    /// The prediction by the authors' average, of weight 0.27.
    pub average: Score,
    /// The prediction by the filter that takes both ends to stand still.
    pub kalman_still: Score,
    /// The prediction by the filter with the rate of separation; `None` where the log has none.
    pub kalman: Option<Score>,
    /// The prediction by the filter of the policy `k-tuned`, with the rate of separation where the
    /// log has one.
    pub k_tuned: Score,
    /// The prediction by the filter of the policy `chain`, with the rate of separation where the
    /// log has one.
    pub chain: Score,
}

/// Sums over all predictors, which can be pooled before they become a [`Prediction`].
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    sums: [Sums; N],
    /// Whether somewhere in it no speed was known at all.
    motionless: bool,
}

impl Tally {
    pub(super) fn of<'a>(
        foresights: impl IntoIterator<Item = &'a Foresights>,
        knows_motion: bool,
    ) -> Self {
        let mut tally = Self { motionless: !knows_motion, ..Self::default() };
        for foresight in foresights {
            for (sums, foresight) in tally.sums.iter_mut().zip(foresight) {
                if let Some(foresight) = foresight {
                    sums.add(foresight);
                }
            }
        }
        tally
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.motionless |= other.motionless;
        for (sums, other) in self.sums.iter_mut().zip(&other.sums) {
            sums.merge(other);
        }
    }

    pub(super) fn prediction(&self) -> Option<Prediction> {
        let [last, average, still, moving, k_tuned, chain] = &self.sums;
        Some(Prediction {
            samples: last.count,
            last: last.score()?,
            average: average.score()?,
            kalman_still: still.score()?,
            kalman: moving.score().filter(|_| !self.motionless),
            k_tuned: k_tuned.score()?,
            chain: chain.score()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(packets: &[(u64, f32, f32)]) -> Recording {
        let sample = |(index, &(ms, rssi, speed)): (usize, &(u64, f32, f32))| Sample {
            line: index + 1,
            time: Instant::from_millis(ms),
            link: 0,
            rssi: Dbm(rssi),
            ends: None,
            separating: Some(MetresPerSecond(speed)),
            restarts: index == 0,
        };
        let samples = packets.iter().enumerate().map(sample).collect();
        Recording { links: vec!["a".into()], samples, ..Recording::default() }
    }

    #[test]
    fn scores_are_those_of_a_calculation_by_hand() {
        let packets = [(0, -50.0, 0.0), (200, -54.0, 0.0), (400, -52.0, 0.0)];
        let foresights = foresee_all(&recording(&packets), REAL_LINK);
        assert_eq!(foresights[0], [None; N]);
        let prediction = Tally::of(&foresights, true).prediction().unwrap();
        assert_eq!(prediction.samples, 2);
        // −50 for −54, −54 for −52.
        assert!((prediction.last.rmse_db - f64::sqrt((16.0 + 4.0) / 2.0)).abs() < 1e-6);
        // −50 for −54, −51.08 for −52.
        assert!((prediction.average.rmse_db - f64::sqrt((16.0 + 0.92 * 0.92) / 2.0)).abs() < 1e-5);
        // The variance is 25 at first, (4·25 + 16) / 5 = 23.2 after one residual of 4 dB.
        let density = |squared: f64, variance: f64| {
            -0.5 * ((core::f64::consts::TAU * variance).ln() + squared / variance)
        };
        let by_hand = f64::midpoint(density(16.0, 25.0), density(4.0, 23.2));
        assert!((prediction.last.log_likelihood - by_hand).abs() < 1e-9);
        // P = R after one packet, + Q·dt; the claimed variance is P + R.
        let own = foresights[1][2].unwrap().own_variance.unwrap();
        assert!((own - (18.0 + 3.0 * 0.2 + 18.0)).abs() < 1e-4, "{own}");
    }

    #[test]
    fn the_filter_moves_with_the_ends_between_packets() {
        let foresights = foresee_all(&recording(&[(0, -50.0, 0.0), (900, -53.0, 0.5)]), REAL_LINK);
        let expected = |index: usize| foresights[1][index].unwrap().expected;
        assert_eq!(expected(2), Dbm(-50.0));
        assert!(expected(3) < Dbm(-51.0), "{}", expected(3));
    }
}
