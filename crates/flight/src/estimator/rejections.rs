//! Counts for how long rejected readings agree with each other. After a while the estimate must be
//! wrong, and is reset to the readings.

/// A run of rejected readings that agree with each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rejections {
    last: Option<Streak>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Streak {
    innovation: [f32; 2],
    lasted: f32,
}

impl Rejections {
    pub(super) const fn none() -> Self {
        Self { last: None }
    }

    /// Adds a rejected reading that came `elapsed` seconds after the one before. Returns for how
    /// many seconds the innovations have now stayed the same, to within `agreement`.
    pub(super) fn add(&mut self, innovation: [f32; 2], elapsed: f32, agreement: f32) -> f32 {
        let [x, y] = innovation;
        let lasted = match self.last {
            Some(Streak { innovation: [was_x, was_y], lasted })
                if (x - was_x).abs() <= agreement && (y - was_y).abs() <= agreement =>
            {
                lasted + elapsed
            }
            _ => 0.0,
        };
        self.last = Some(Streak { innovation, lasted });
        lasted
    }
}
