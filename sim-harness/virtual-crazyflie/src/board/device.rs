//! A device model that is advanced only when it is accessed.

use sensors::models::I2cModel;

use crate::soc::Nanos;

const MICRO: Nanos = 1_000;

/// A model and the moment up to which it has been advanced, which is a whole number of µs: what is
/// left of one is made good later, so that nothing drifts.
#[derive(Debug)]
pub(super) struct Timed<M> {
    model: M,
    advanced_until: Nanos,
}

impl<M: I2cModel> Timed<M> {
    pub(super) const fn new(model: M) -> Self {
        Self { model, advanced_until: 0 }
    }

    /// The model as it is now.
    pub(super) fn at(&mut self, now: Nanos) -> &mut M {
        let mut micros = now.saturating_sub(self.advanced_until) / MICRO;
        self.advanced_until += micros * MICRO;
        // Even no time at all lets a model see that its reset line has moved.
        loop {
            let step = u32::try_from(micros).unwrap_or(u32::MAX);
            self.model.advance(step);
            micros -= Nanos::from(step);
            if micros == 0 {
                return &mut self.model;
            }
        }
    }

    /// The model as it was when it was last looked at.
    pub(super) const fn as_left(&self) -> &M {
        &self.model
    }

    /// The moment that many µs after the model's own.
    pub(super) fn moment_in(&self, micros: u32) -> Nanos {
        self.advanced_until + Nanos::from(micros) * MICRO
    }
}
