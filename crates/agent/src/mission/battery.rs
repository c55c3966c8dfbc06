//! Reckons how long a battery still carries a drone.

use units::{Duration, Instant};

/// What a drone knows of its battery. The gauge goes by a voltage that hardly falls until shortly before
/// the end, and so the drone counts the seconds, too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Charge {
    /// When the drone first knew how long its battery carries it, and how long that was.
    first: Option<(Instant, Duration)>,
}

impl Charge {
    /// A battery of which nothing is known.
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { first: None }
    }

    /// How long it still carries the drone, s: by the gauge, which says `endurance`, and by the seconds
    /// since the gauge first spoke, whichever is less. Where the gauge falls silent the seconds go on.
    pub(crate) fn left(&mut self, now: Instant, endurance: Option<Duration>) -> Option<f32> {
        self.first = self.first.or_else(|| endurance.map(|left| (now, left)));
        let (since, at_first) = self.first?;
        let counted = at_first.as_secs_f32() - now.since(since).as_secs_f32();
        Some(endurance.map_or(counted, |left| left.as_secs_f32().min(counted)))
    }
}
