//! Axes with round numbers, linear or logarithmic.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// Room beyond the outermost values, as a share of what they span.
const MARGIN: f64 = 0.04;

/// One axis: what it spans, and where its grid lines are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) ticks: Vec<f64>,
    decimals: usize,
    /// Whether equal lengths are equal factors.
    is_logarithmic: bool,
}

/// The decades that a logarithmic axis has at most, so that a value near zero does not squash all
/// others.
const MOST_DECADES: i32 = 7;

impl Axis {
    /// Spans exactly `from` to `to`, with about `wanted` ticks.
    pub(super) fn exact(from: f64, to: f64, wanted: usize) -> Self {
        let to = if to - from > 1e-9 { to } else { from + 1.0 };
        let (step, decimals) = round_step((to - from) / wanted.max(1) as f64);
        let first = (from / step - 1e-6).ceil() as i64;
        let last = (to / step + 1e-6).floor() as i64;
        let ticks = (first..=last.min(first + 100)).map(|n| n as f64 * step).collect();
        Self { from, to, ticks, decimals, is_logarithmic: false }
    }

    /// Spans all of `values` and a little more; NaN and infinities do not count.
    pub(super) fn covering(values: impl IntoIterator<Item = f64>, wanted: usize) -> Self {
        let (low, high) = extent(values).unwrap_or((0.0, 1.0));
        let high = if high - low > 1e-9 { high } else { low + 1.0 };
        let margin = (high - low) * MARGIN;
        Self::exact(low - margin, high + margin, wanted)
    }

    /// Spans from zero to all of `values`, which are not negative, and a little more.
    pub(super) fn from_zero(values: impl IntoIterator<Item = f64>, wanted: usize) -> Self {
        let high = extent(values).map_or(1.0, |(_, high)| high);
        Self::exact(0.0, high * (1.0 + MARGIN), wanted)
    }

    /// Spans the decades of all positive values, with a tick at each; values that are smaller than
    /// the first lie at its beginning.
    pub(super) fn logarithmic(values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = extent(values.into_iter().filter(|v| *v > 0.0)).unwrap_or((0.1, 1.0));
        let last = decade(high).ceil() as i32;
        let first = (decade(low).floor() as i32).clamp(last - MOST_DECADES, last - 1);
        let power = |n: i32| libm::exp10(f64::from(n));
        let ticks: Vec<f64> = (first..=last).map(power).collect();
        Self { from: power(first), to: power(last), ticks, decimals: 0, is_logarithmic: true }
    }

    /// How far along the axis a value lies: 0 at its beginning, 1 at its end.
    pub(super) fn share(&self, value: f64) -> f64 {
        if self.is_logarithmic {
            let (from, to) = (decade(self.from), decade(self.to));
            return (decade(value.max(self.from)) - from) / (to - from);
        }
        (value - self.from) / (self.to - self.from)
    }

    /// A tick's label, with a real minus sign.
    pub(super) fn label(&self, value: f64) -> String {
        let decimals = if self.is_logarithmic {
            (-decade(value)).ceil().max(0.0) as usize
        } else {
            self.decimals
        };
        let text = format!("{value:.decimals$}");
        match text.strip_prefix('-') {
            Some(zero) if zero.bytes().all(|c| c == b'0' || c == b'.') => zero.to_owned(),
            Some(rest) => format!("\u{2212}{rest}"),
            None => text,
        }
    }
}

/// As plotters asks for it. Its own axes choose their ticks through a logarithm.
impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        (f64::from(first) + self.share(*value) * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(value: &f64) -> String {
        value.to_string()
    }

    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

/// The logarithm to base 10, to the nearest whole number where that is meant.
fn decade(value: f64) -> f64 {
    let decade = libm::log10(value);
    if (decade - decade.round()).abs() < 1e-9 { decade.round() } else { decade }
}

/// Least and greatest of the finite values; `None` where there are none.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|v| v.is_finite()).fold(None, |extent, v| match extent {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

/// The least of 1, 2 and 5 times a power of ten that is at least `step`, and its decimals.
///
/// Counted up and down rather than by logarithm, so that every machine agrees.
pub(super) fn round_step(step: f64) -> (f64, usize) {
    let mut power = 1.0;
    let mut decimals: usize = 0;
    while power > step && decimals < 9 {
        decimals += 1;
        power = 1.0 / 10_f64.powi(i32::try_from(decimals).unwrap_or(9));
    }
    while power * 10.0 <= step && power < 1e12 {
        power *= 10.0;
    }
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|round| *round >= step * (1.0 - 1e-9))
        .map_or((power * 10.0, decimals.saturating_sub(1)), |round| (round, decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (step, round, decimals) in [
            (0.7, 1.0, 0),
            (1.0, 1.0, 0),
            (1.1, 2.0, 0),
            (4.2, 5.0, 0),
            (6.0, 10.0, 0),
            (60.0, 100.0, 0),
            (0.03, 0.05, 2),
        ] {
            let (found, places) = round_step(step);
            assert!((found - round).abs() < 1e-9, "{step}: {found}");
            assert_eq!(places, decimals, "{step}");
        }
    }

    #[test]
    fn an_axis_covers_its_values_and_nothing_endless() {
        let axis = Axis::covering([-71.3, f64::NAN, -48.2, f64::INFINITY], 5);
        assert!(axis.from < -71.3 && axis.to > -48.2 && axis.to - axis.from < 26.0);
        assert_eq!(axis.ticks, [-70.0, -65.0, -60.0, -55.0, -50.0]);
        assert_eq!(axis.label(-70.0), "\u{2212}70");
    }

    #[test]
    fn a_logarithmic_axis_has_whole_decades() {
        let axis = Axis::logarithmic([0.03, 4.0, 0.0, f64::INFINITY]);
        assert_eq!(axis.ticks.len(), 4);
        let labels: Vec<_> = axis.ticks.iter().map(|tick| axis.label(*tick)).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10"]);
        assert!((axis.share(1.0) - 2.0 / 3.0).abs() < 1e-9);
        assert_eq!(axis.share(0.0), 0.0, "what is smaller lies at the beginning");
        assert_eq!(Axis::logarithmic([1.0, 1e-30]).ticks.len(), 8);
        assert_eq!(Axis::logarithmic([]).ticks.len(), 2);
    }

    #[test]
    fn an_axis_without_values_is_still_an_axis() {
        let axis = Axis::covering([], 4);
        assert!(axis.to > axis.from);
        assert!(!axis.ticks.is_empty());
        let point = Axis::covering([3.0, 3.0], 4);
        assert!(point.to > point.from);
    }
}
