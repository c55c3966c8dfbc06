//! One signal of a log over time.

/// A gap between two values, in s, over which nothing is known in between.
const LONGEST_GAP: f64 = 0.1;

/// A signal, in SI units.
#[derive(Clone, Debug, Default)]
pub(super) struct Track {
    points: Vec<(f64, f32)>,
}

impl Track {
    /// The values of a variable times `unit`. Values that are no number are left out; `None` where
    /// none is left.
    pub(super) fn of((times, values): (&[f64], &[f64]), unit: f64) -> Option<Self> {
        let points: Vec<(f64, f32)> = times
            .iter()
            .zip(values)
            .map(|(time, value)| (*time, (value * unit) as f32))
            .filter(|(_, value)| value.is_finite())
            .collect();
        (!points.is_empty()).then_some(Self { points })
    }

    /// The value at a time, on the straight line between its neighbours; `None` in a gap and outside
    /// of the signal.
    pub(super) fn at(&self, time: f64) -> Option<f32> {
        let next = self.points.partition_point(|(at, _)| *at < time);
        let &(after, to) = self.points.get(next)?;
        if after == time {
            return Some(to);
        }
        let &(before, from) = self.points.get(next.checked_sub(1)?)?;
        let within = after - before <= LONGEST_GAP;
        within.then(|| from + ((time - before) / (after - before)) as f32 * (to - from))
    }

    /// The last value after `from` and not after `to`: what a sensor has said in between.
    pub(super) fn news(&self, from: f64, to: f64) -> Option<f32> {
        let next = self.points.partition_point(|(at, _)| *at <= to);
        let &(at, value) = self.points.get(next.checked_sub(1)?)?;
        (at > from).then_some(value)
    }

    /// The mean between two times; `None` without a value there.
    pub(super) fn mean(&self, from: f64, to: f64) -> Option<f32> {
        let first = self.points.partition_point(|(at, _)| *at < from);
        let end = self.points.partition_point(|(at, _)| *at <= to);
        let part = self.points.get(first..end).filter(|part| !part.is_empty())?;
        Some(part.iter().map(|(_, value)| value).sum::<f32>() / part.len() as f32)
    }

    pub(super) fn times(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|(at, _)| *at)
    }

    /// The median time between two values, s.
    pub(super) fn period(&self) -> f64 {
        let mut gaps: Vec<f64> = self.points.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        gaps.sort_unstable_by(f64::total_cmp);
        gaps.get(gaps.len() / 2).copied().unwrap_or(f64::INFINITY)
    }

    /// The same signal with every value changed.
    pub(super) fn map(mut self, change: impl Fn(f32) -> f32) -> Self {
        for (_, value) in &mut self.points {
            *value = change(*value);
        }
        self
    }
}
