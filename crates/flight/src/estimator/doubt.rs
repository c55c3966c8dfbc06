//! When to stop believing oneself: readings that are rejected one after the other, and all in the
//! same way.

/// A row of rejected readings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Doubt {
    last: Option<Contradiction>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Contradiction {
    innovation: [f32; 2],
    lasted: f32,
}

impl Doubt {
    pub(super) const fn none() -> Self {
        Self { last: None }
    }

    /// One more reading was rejected, `elapsed` after the one before. For how long, in seconds,
    /// they have differed by the same from what was expected, give or take `agreement`.
    pub(super) fn grow(&mut self, innovation: [f32; 2], elapsed: f32, agreement: f32) -> f32 {
        let [x, y] = innovation;
        let lasted = match self.last {
            Some(Contradiction { innovation: [was_x, was_y], lasted })
                if (x - was_x).abs() <= agreement && (y - was_y).abs() <= agreement =>
            {
                lasted + elapsed
            }
            _ => 0.0,
        };
        self.last = Some(Contradiction { innovation, lasted });
        lasted
    }
}
