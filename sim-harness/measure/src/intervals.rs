//! Intervals of a share, of a median, and for the difference between two policies that flew the same
//! seeds.
//!
//! None of them assumes a distribution of what is measured, and all of them bear runs that never
//! came to the measured event, whose time is infinite. Their limits are functions of the runs alone,
//! so that the same runs give the same interval on every machine. Those of a share and of a median are
//! exact: they hold the true value at least as often as they say. That of a difference of shares is
//! Tango's and that of a mean is the bootstrap's, which do so nearly.

use random::{Purpose, Stream};

/// The confidence of each interval. A claim is looked at in three places and with many seeds; at
/// 95 %, one place in twenty would be judged wrongly.
pub const CONFIDENCE: f64 = 0.99;

/// Standard deviations on each side of the middle that hold 99 % of a normal distribution.
const Z: f64 = 2.575_829_303_548_901;

/// The least values of which a mean has limits: with fewer, a median has none either.
const FEWEST: usize = 8;

/// How often the values of a mean are drawn again: 10 draws lie outside each limit.
const DRAWS: usize = 2_000;

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

impl Interval {
    /// The interval of a value that nothing bounds.
    pub const UNBOUNDED: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// The interval of the function's value, where the function never falls.
    #[must_use]
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self { low: of(self.low), high: of(self.high) }
    }

    /// The interval of the distance from a value.
    #[must_use]
    pub fn distance_from(self, value: f64) -> Self {
        let (low, high) = (self.low - value, self.high - value);
        let nearest = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
        Self { low: nearest, high: low.abs().max(high.abs()) }
    }

    /// The interval of the least of several values, or unbounded where there are none.
    #[must_use]
    pub fn of_least(all: impl IntoIterator<Item = Self>) -> Self {
        let least = |one: Self, other: Self| Self {
            low: one.low.min(other.low),
            high: one.high.min(other.high),
        };
        all.into_iter().reduce(least).unwrap_or(Self::UNBOUNDED)
    }

    /// The interval of the greatest of several values, or unbounded where there are none.
    #[must_use]
    pub fn of_greatest(all: impl IntoIterator<Item = Self>) -> Self {
        let greatest = |one: Self, other: Self| Self {
            low: one.low.max(other.low),
            high: one.high.max(other.high),
        };
        all.into_iter().reduce(greatest).unwrap_or(Self::UNBOUNDED)
    }
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
        None => Interval::UNBOUNDED,
    }
}

/// The interval for the mean of what `values` are a sample of, by the studentised bootstrap (Efron and
/// Tibshirani 1993, chapter 12.5), which follows a skewed distribution. The values are drawn again with
/// the same random numbers each time. Where all values are 0, as numbers of rare events may be, the mean is
/// at most that of a Poisson distribution that so seldom has any; other values that are all equal say
/// nothing of how much others vary, and bound nothing.
#[must_use]
pub fn mean(values: &[f64]) -> Interval {
    let runs = values.len();
    if runs < FEWEST {
        return Interval::UNBOUNDED;
    }
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let (middle, error) = mean_and_error(values.iter().copied());
    if error == 0.0 {
        let most = if middle == 0.0 { -libm::log(tail) / runs as f64 } else { f64::INFINITY };
        return Interval { low: if middle == 0.0 { 0.0 } else { f64::NEG_INFINITY }, high: most };
    }
    let mut random = Stream::new(0, Purpose::Fit);
    let mut drawn = Vec::with_capacity(runs);
    let mut scores: Vec<f64> = (0..DRAWS)
        .map(|_| {
            drawn.clear();
            let pick =
                |_| values.get(random.below(runs as u32) as usize).copied().unwrap_or(middle);
            drawn.extend((0..runs).map(pick));
            let (again, its_error) = mean_and_error(drawn.iter().copied());
            if again == middle { 0.0 } else { (again - middle) / its_error }
        })
        .collect();
    scores.sort_by(f64::total_cmp);
    let outside = (tail * DRAWS as f64) as usize;
    let at = |rank: usize| scores.get(rank).copied().unwrap_or(f64::NAN);
    Interval { low: middle - at(DRAWS - 1 - outside) * error, high: middle - at(outside) * error }
}

/// The mean of values, and its standard error.
fn mean_and_error(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let runs = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / runs;
    let squares: f64 = values.map(|value| (value - mean) * (value - mean)).sum();
    (mean, (squares / (runs - 1.0) / runs).sqrt())
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
        let unbounded = Interval::UNBOUNDED;
        assert_eq!(median(&values[..7]), unbounded, "2 · 0.5⁷ is more than 1 %");
        assert_eq!(median(&[]), unbounded);
        let never = [f64::INFINITY; 12];
        assert_eq!(median(&never), Interval { low: f64::INFINITY, high: f64::INFINITY });
    }

    #[test]
    fn a_mean_has_limits_where_its_values_say_how_much_they_vary() {
        assert_eq!(mean(&[1.0, 2.0, 3.0]), Interval::UNBOUNDED, "too few");
        assert_eq!(mean(&[2.0; 30]), Interval::UNBOUNDED, "all are equal");
        // No event in 100 runs: a Poisson mean of 0.053 has none in 0.5 % of all hundreds.
        is_near(mean(&[0.0; 100]), (0.0, 0.052_983));
        // The limits of Student's distribution with 99 degrees of freedom: 2.626 errors on each side; ten
        // of 2,000 draws give them to a tenth of an error or so.
        let spread: Vec<f64> = (0..100).map(|n| f64::from(n % 10)).collect();
        let found = mean(&spread);
        let (middle, error) = mean_and_error(spread.iter().copied());
        assert!((found.low - (middle - 2.626 * error)).abs() < 0.4 * error, "{found:?}");
        assert!((found.high - (middle + 2.626 * error)).abs() < 0.4 * error, "{found:?}");
    }

    #[test]
    fn intervals_of_a_distance_and_of_the_least_and_greatest_value() {
        let one = Interval { low: -1.0, high: 3.0 };
        let other = Interval { low: 2.0, high: 2.5 };
        assert_eq!(one.distance_from(0.0), Interval { low: 0.0, high: 3.0 });
        assert_eq!(one.distance_from(4.0), Interval { low: 1.0, high: 5.0 });
        assert_eq!(Interval::of_least([one, other]), Interval { low: -1.0, high: 2.5 });
        assert_eq!(Interval::of_greatest([one, other]), Interval { low: 2.0, high: 3.0 });
        assert_eq!(Interval::of_least([]), Interval::UNBOUNDED);
    }

    /// Of 1,000 samples whose true value is known, at most as many miss it as the confidence says.
    #[test]
    fn intervals_hold_the_true_value_as_often_as_they_say() {
        let mut random = Stream::new(1, Purpose::Fit);
        let mut missed = [0; 4];
        for _ in 0..1_000 {
            let draws: Vec<f64> = (0..40).map(|_| f64::from(random.uniform())).collect();
            let count = |of: &dyn Fn(f64) -> bool| draws.iter().filter(|draw| of(**draw)).count();
            let seen = share(count(&|draw| draw < 0.2), 40);
            let (one, other) = (count(&|draw| draw < 0.3), count(&|draw| draw > 0.8));
            let difference = difference_of_shares(one, other, 40);
            let middle = median(&draws);
            // A skewed quantity, whose mean is 1.
            let skewed: Vec<f64> = draws.iter().map(|draw| -libm::log(1.0 - draw)).collect();
            let all = [(seen, 0.2), (difference, 0.1), (middle, 0.5), (mean(&skewed), 1.0)];
            for (missed, (interval, truth)) in missed.iter_mut().zip(all) {
                *missed += u32::from(truth < interval.low || interval.high < truth);
            }
        }
        assert!(missed.iter().all(|missed| *missed <= 20), "{missed:?} of 1000");
    }
}
