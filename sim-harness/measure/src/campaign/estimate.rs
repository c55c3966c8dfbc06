//! Figures with their intervals, of runs that are in memory or come one by one.

use serde_json::{Value, json};

/// A figure with its 95 % confidence interval. In JSON, a value that is not finite is `null`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The figure.
    pub value: f64,
    /// The limits of the 95 % confidence interval; `None` where there are too few runs.
    pub interval: Option<(f64, f64)>,
}

impl Estimate {
    pub(super) fn json(&self) -> Value {
        let (low, high) = self.interval.map_or((None, None), |(l, h)| (finite(l), finite(h)));
        json!({ "value": finite(self.value), "low": low, "high": high })
    }
}

pub(super) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The part of the runs for which `holds` is true, with its Wilson score interval, which is of use
/// also where that is none or all of them.
#[must_use]
pub fn fraction<R>(runs: &[R], holds: impl Fn(&R) -> bool) -> Estimate {
    share(runs.iter().filter(|run| holds(run)).count(), runs.len())
}

/// The part of `count` runs that `hits` are, with its Wilson score interval.
pub(super) fn share(hits: usize, count: usize) -> Estimate {
    let count = count.max(1) as f64;
    let value = hits as f64 / count;
    Estimate { value, interval: Some(wilson(value, count)) }
}

/// Wilson's score interval of a share that was seen in `count` trials.
fn wilson(share: f64, count: f64) -> (f64, f64) {
    let z2 = Z * Z;
    let middle = (share + z2 / (2.0 * count)) / (1.0 + z2 / count);
    let spread = Z * (share * (1.0 - share) / count + z2 / (4.0 * count * count)).sqrt();
    let half = spread / (1.0 + z2 / count);
    ((middle - half).max(0.0), (middle + half).min(1.0))
}

/// Standard deviations on each side of the middle that hold 95 % of a normal distribution.
const Z: f64 = 1.96;

/// The mean over the runs, with the normal interval of its standard error.
#[must_use]
pub fn mean<R>(runs: &[R], of: impl Fn(&R) -> f32) -> Estimate {
    let mut mean = Mean::default();
    runs.iter().for_each(|run| mean.add(of(run)));
    mean.estimate()
}

/// The mean of values that come one by one, and their squared deviations by Welford's method
/// (Technometrics 4:419, 1962), which loses no digits where the mean is far greater than they.
#[derive(Clone, Copy, Default)]
pub(super) struct Mean {
    count: usize,
    sum: f64,
    /// The mean so far.
    middle: f64,
    /// The sum of the squared deviations from it.
    squares: f64,
}

impl Mean {
    pub(super) fn add(&mut self, value: f32) {
        let value = f64::from(value);
        self.count += 1;
        self.sum += value;
        let deviation = value - self.middle;
        self.middle += deviation / self.count as f64;
        self.squares += deviation * (value - self.middle);
    }

    pub(super) fn estimate(&self) -> Estimate {
        let count = self.count.max(1) as f64;
        let middle = self.sum / count;
        let error = (self.squares / (count - 1.0).max(1.0) / count).sqrt();
        Estimate { value: middle, interval: Some((middle - Z * error, middle + Z * error)) }
    }
}

/// Returns the q-quantile over *all* runs; a run that never reached the event counts as infinite.
#[must_use]
pub fn quantile_of<R>(runs: &[R], q: f64, of: impl Fn(&R) -> f32) -> Estimate {
    let mut values: Vec<f32> = runs.iter().map(of).collect();
    values.sort_by(f32::total_cmp);
    Ranks::of(values.len(), q).estimate(|rank| values.get(rank).copied())
}

/// The places, in the sorted list of all values, of a quantile and of the limits of its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ranks {
    pub(super) value: usize,
    pub(super) interval: Option<(usize, usize)>,
}

impl Ranks {
    /// The places of the q-quantile among so many values.
    pub(super) fn of(count: usize, q: f64) -> Self {
        let value = ((count.max(1) - 1) as f64 * q).round() as usize;
        Self { value, interval: quantile_ranks(count, q) }
    }

    pub(super) fn all(self) -> impl Iterator<Item = usize> {
        let (low, high) = self.interval.unzip();
        [Some(self.value), low, high].into_iter().flatten()
    }

    /// The estimate, by the values at these places.
    pub(super) fn estimate(self, at: impl Fn(usize) -> Option<f32>) -> Estimate {
        let at = |rank| at(rank).map(f64::from);
        let value = at(self.value).unwrap_or(f64::NAN);
        let interval = self.interval.and_then(|(low, high)| Some((at(low)?, at(high)?)));
        Estimate { value, interval }
    }
}

/// Ranks of the sorted values between which the q-quantile lies, 19 times in 20: Wilson's interval
/// of the share q, as places in the list. Needs two values on either side of the quantile.
fn quantile_ranks(count: usize, q: f64) -> Option<(usize, usize)> {
    let below = (count as f64 * q).round() as usize;
    let above = count.checked_sub(below)?;
    if below < 2 || above < 2 {
        return None;
    }
    let (low, high) = wilson(below as f64 / count as f64, count as f64);
    let rank = |share: f64| ((share * count as f64) as usize).min(count - 1);
    Some((rank(low), rank(high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranks that the crate `stats-ci` gave.
    #[test]
    fn a_quantile_lies_between_these_ranks() {
        assert_eq!(quantile_ranks(15, 0.5), Some((4, 11)));
        assert_eq!(quantile_ranks(15, 0.4), Some((2, 9)));
        assert_eq!(quantile_ranks(3, 0.5), None);
        assert_eq!(quantile_ranks(20, 0.99), None);
    }

    #[test]
    fn a_mean_that_comes_value_by_value_has_the_interval_of_the_whole_list() {
        let values: Vec<f32> = (0..1000u16).map(|n| 1e4 + f32::from(n % 37) * 0.01).collect();
        let count = values.len() as f64;
        let middle = values.iter().map(|v| f64::from(*v)).sum::<f64>() / count;
        let squares = values.iter().map(|v| (f64::from(*v) - middle).powi(2)).sum::<f64>();
        let error = (squares / (count - 1.0) / count).sqrt();
        let estimate = mean(&values, |v| *v);
        assert_eq!(estimate.value, middle);
        let (low, high) = estimate.interval.unwrap();
        assert!(((high - low) / (2.0 * Z * error) - 1.0).abs() < 1e-9, "{estimate:?}");
        // Equal values have no spread at all.
        assert_eq!(mean(&[0.1f32; 7], |v| *v).interval.unwrap().0, f64::from(0.1f32));
        let infinite = mean(&[1.0, f32::INFINITY, 2.0], |v| *v);
        assert!(infinite.value.is_infinite() && infinite.interval.unwrap().0.is_nan());
    }
}
