//! The drone's own estimate of how fast it flies along the tunnel.
//!
//! The optic flow's velocity is noisy, 0.02 m/s from round to round at point level (the studies
//! behind the book's chapter "Policies"). Summed up, that noise is a random walk of the odometer,
//! which a link of 30 dB/m turns into decibels, and the filter takes a hovering drone for one that
//! flies. So the drone starts from what it was told to fly at, through the lag of its velocity
//! loop, and corrects that by the mean difference from what it measures, as far as that is more
//! than noise.

use units::{Duration, MetresPerSecond};

/// The estimate of the velocity along the tunnel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// The velocity that the drone was last told to fly at.
    commanded: MetresPerSecond,
    /// The velocity that the drone would have by its commands alone.
    modelled: MetresPerSecond,
    /// How much faster than that the drone has been measured to fly, on average.
    drift: MetresPerSecond,
}

impl Motion {
    /// The time constant of the velocity loop, s: the lag of the vehicle in the studies behind the
    /// book's chapter "Policies".
    const LAG_S: f32 = 0.3;
    /// The time constant over which the measured velocity corrects the modelled one, s.
    const CORRECTION_S: f32 = 1.0;
    /// A mean difference that is smaller is noise: twice its standard deviation at a noise of
    /// 0.02 m/s, 0.02 · √(0.2 s / 2 · 1 s).
    const NOISE: MetresPerSecond = MetresPerSecond(0.015);

    /// A drone that does not move.
    pub(crate) const STILL: Self = Self {
        commanded: MetresPerSecond::ZERO,
        modelled: MetresPerSecond::ZERO,
        drift: MetresPerSecond::ZERO,
    };

    /// Notes the velocity that the drone is told to fly at from now on.
    pub(crate) const fn command(&mut self, forward: MetresPerSecond) {
        self.commanded = forward;
    }

    /// The mean velocity over the last round of `dt`, in which `measured` was the mean velocity by
    /// the optic flow, or `None` where the flow was blind.
    pub(crate) fn step(
        &mut self,
        measured: Option<MetresPerSecond>,
        dt: Duration,
    ) -> MetresPerSecond {
        let dt = dt.as_secs_f32();
        if dt <= 0.0 {
            return self.modelled;
        }
        // A first-order lag, solved over the round.
        let left = decay(dt / Self::LAG_S);
        let away = self.modelled - self.commanded;
        let mean = self.commanded + away * ((1.0 - left) * Self::LAG_S / dt);
        self.modelled = self.commanded + away * left;
        // A difference that is no longer measured does not last.
        let drift = measured.map_or(MetresPerSecond::ZERO, |measured| measured - mean);
        self.drift += (drift - self.drift) * (dt / (dt + Self::CORRECTION_S));
        mean + (self.drift - self.drift.limited_to(Self::NOISE))
    }
}

/// exp(−x) to 1 %, for x up to 3: five rounds that were missed.
fn decay(x: f32) -> f32 {
    1.0 / (1.0 + x * (1.0 + x * (0.5 + x / 6.0)))
}
