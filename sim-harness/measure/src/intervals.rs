//! Intervals of a share, of a median, and for the difference between two policies that flew the same
//! seeds.
//!
//! None of them assumes a distribution of what is measured, and all of them bear runs that never
//! came to the measured event, whose time is infinite. Their limits are functions of the runs alone,
//! so that the same runs give the same interval on every machine. Those of a share and of a median are
//! exact: they hold the true value at least as often as they say. That of a difference of shares is
//! Tango's, which does so nearly.

/// The confidence of each interval. A claim is looked at in three places and with many seeds; at
/// 95 %, one place in twenty would be judged wrongly.
pub const CONFIDENCE: f64 = 0.99;

/// Standard deviations on each side of the middle that hold 99 % of a normal distribution.
const Z: f64 = 2.575_829_303_548_901;

/// Halvings of an interval of length 1 or 2 after which less than 10⁻¹⁵ of it is left.
const HALVINGS: usize = 52;

/// An interval that holds the true value with the probability [`CONFIDENCE`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The lower limit; −∞ where nothing bounds the value from below.
    pub low: f64,
    /// The upper limit.
    pub high: f64,
}

/// The exact interval of Clopper and Pearson for the share of all runs of which `hits` of `runs` are
/// a sample. It is of use also where that is none or all of them.
#[must_use]
pub fn share(hits: usize, runs: usize) -> Interval {
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let at_least = |p: f64| 1.0 - at_most(hits.saturating_sub(1), runs, p);
    let low = if hits == 0 { 0.0 } else { crossing((0.0, 1.0), |p| at_least(p) < tail) };
    let is_likely = |p: f64| at_most(hits, runs, p) >= tail;
    let high = if hits >= runs { 1.0 } else { crossing((0.0, 1.0), is_likely) };
    Interval { low, high }
}

/// Tango's score interval for the difference of two shares of the same runs (Statistics in Medicine
/// 17:891, 1998): `only_one` runs of `runs` have the one property alone, `only_other` the other one.
#[must_use]
pub fn difference_of_shares(only_one: usize, only_other: usize, runs: usize) -> Interval {
    if runs == 0 {
        return Interval { low: -1.0, high: 1.0 };
    }
    let (b, c, n) = (only_one as f64, only_other as f64, runs as f64);
    let score = |difference: f64| {
        let linear = (2.0 * n - b + c) * difference - b - c;
        let constant = -c * difference * (1.0 - difference);
        let root = (linear * linear - 8.0 * n * constant).max(0.0).sqrt();
        let share = (root - linear) / (4.0 * n);
        let variance = n * (2.0 * share + difference * (1.0 - difference));
        (b - c - n * difference) / variance.max(f64::MIN_POSITIVE).sqrt()
    };
    let middle = (b - c) / n;
    Interval {
        low: crossing((-1.0, middle), |difference| score(difference) > Z),
        high: crossing((middle, 1.0), |difference| score(difference) > -Z),
    }
}

/// The exact interval for the median of what `values` are a sample of: two of the values, chosen by
/// the binomial distribution of the number of values below the median. A value may be infinite; NaN
/// is none.
#[must_use]
pub fn median(values: &[f64]) -> Interval {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let runs = sorted.len();
    let left_out = (0..runs / 2).take_while(|below| at_most(*below, runs, 0.5) <= tail).last();
    match left_out {
        Some(rank) => {
            let at = |rank: usize| sorted.get(rank).copied().unwrap_or(f64::NAN);
            Interval { low: at(rank), high: at(runs - 1 - rank) }
        }
        None => Interval { low: f64::NEG_INFINITY, high: f64::INFINITY },
    }
}

/// The probability of at most `hits` in `runs` trials with the probability `p` each.
fn at_most(hits: usize, runs: usize, p: f64) -> f64 {
    if p <= 0.0 || hits >= runs {
        return 1.0;
    }
    if p >= 1.0 {
        return 0.0;
    }
    let (log_p, log_q) = (libm::log(p), libm::log(1.0 - p));
    let ways = |k: f64| {
        let n = runs as f64;
        libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0)
    };
    let each = (0..=hits).map(|hits| {
        let k = hits as f64;
        libm::exp(ways(k) + k * log_p + (runs as f64 - k) * log_q)
    });
    each.sum::<f64>().min(1.0)
}

/// The place in the range up to which `holds`, which holds from its beginning on.
fn crossing((mut low, mut high): (f64, f64), holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::{Purpose, Stream};

    fn is_near(found: Interval, (low, high): (f64, f64)) {
        let off = (found.low - low).abs().max((found.high - high).abs());
        assert!(off < 1e-4, "{found:?} is not {low} to {high}");
    }

    /// What `scipy.stats.binomtest(k, n).proportion_ci(0.99)` says; none and all have the limits
    /// `0.005 ** (1 / n)` by hand.
    #[test]
    fn a_share_has_the_limits_of_clopper_and_pearson() {
        is_near(share(0, 30), (0.0, 1.0 - 0.005_f64.powf(1.0 / 30.0)));
        is_near(share(30, 30), (0.005_f64.powf(1.0 / 30.0), 1.0));
        is_near(share(1, 2), (0.002_503, 0.997_497));
    }

    /// The limits are those at which Tango's score is the quantile: put in by hand.
    #[test]
    fn no_difference_has_an_interval_about_zero() {
        let none = difference_of_shares(0, 0, 100);
        assert!(none.low < 0.0 && none.high > 0.0 && none.high + none.low < 1e-9, "{none:?}");
        // With no run that differs the score is n·d / sqrt(n·d·(1 − d)).
        let limit = Z * Z / (100.0 + Z * Z);
        is_near(none, (-limit, limit));
        let (one, other) = (difference_of_shares(20, 5, 100), difference_of_shares(5, 20, 100));
        is_near(one, (-other.high, -other.low));
        assert!(one.low > 0.0 && one.low < 0.15 && one.high > 0.15, "{one:?}");
    }

    #[test]
    fn the_median_of_ten_values_lies_between_the_first_and_the_last() {
        let values: Vec<f64> = (1..=10).map(f64::from).collect();
        // 2 · 0.5¹⁰ is less than 1 %, and 2 · 11 · 0.5¹⁰ more.
        assert_eq!(median(&values), Interval { low: 1.0, high: 10.0 });
        let unbounded = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
        assert_eq!(median(&values[..7]), unbounded, "2 · 0.5⁷ is more than 1 %");
        assert_eq!(median(&[]), unbounded);
        let never = [f64::INFINITY; 12];
        assert_eq!(median(&never), Interval { low: f64::INFINITY, high: f64::INFINITY });
    }

    /// Of 1,000 samples whose true value is known, at most as many miss it as the confidence says.
    #[test]
    fn intervals_hold_the_true_value_as_often_as_they_say() {
        let mut random = Stream::new(1, Purpose::Fit);
        let mut missed = [0; 3];
        for _ in 0..1_000 {
            let draws: Vec<f64> = (0..40).map(|_| f64::from(random.uniform())).collect();
            let count = |of: &dyn Fn(f64) -> bool| draws.iter().filter(|draw| of(**draw)).count();
            let seen = share(count(&|draw| draw < 0.2), 40);
            let (one, other) = (count(&|draw| draw < 0.3), count(&|draw| draw > 0.8));
            let difference = difference_of_shares(one, other, 40);
            let middle = median(&draws);
            let all = [(seen, 0.2), (difference, 0.1), (middle, 0.5)];
            for (missed, (interval, truth)) in missed.iter_mut().zip(all) {
                *missed += u32::from(truth < interval.low || interval.high < truth);
            }
        }
        assert!(missed.iter().all(|missed| *missed <= 20), "{missed:?} of 1000");
    }
}
