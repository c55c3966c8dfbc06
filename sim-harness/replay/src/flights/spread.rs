//! The distribution of a measure.

use serde::Serialize;

/// Percentiles of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The least value.
    pub min: f32,
    /// The median.
    pub p50: f32,
    /// 95 % of the values are no larger.
    pub p95: f32,
    /// 99 % of the values are no larger.
    pub p99: f32,
    /// 99.9 % of the values are no larger.
    pub p999: f32,
    /// The largest value.
    pub max: f32,
}

impl Spread {
    /// The distribution of these values; `None` without any. A value that is no number is left out.
    pub(super) fn of(values: impl IntoIterator<Item = f32>) -> Option<Self> {
        let mut values: Vec<f32> = values.into_iter().filter(|value| value.is_finite()).collect();
        values.sort_unstable_by(f32::total_cmp);
        let last = values.len().checked_sub(1)?;
        let quantile = |part: f64| values.get((part * last as f64).round() as usize).copied();
        Some(Self {
            min: quantile(0.0)?,
            p50: quantile(0.5)?,
            p95: quantile(0.95)?,
            p99: quantile(0.99)?,
            p999: quantile(0.999)?,
            max: quantile(1.0)?,
        })
    }
}
