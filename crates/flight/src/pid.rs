//! One controller: proportional, integral and derivative, with a limit on what the integral holds
//! and none of it gathered while the actuator is at its end.

/// A controller's constants, in units of its output per unit of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// On the error.
    pub kp: f32,
    /// On the error's integral, per second.
    pub ki: f32,
    /// Against the measurement's rate of change: a set-point that jumps gives no kick. Seconds.
    pub kd: f32,
    /// The most that the integral part adds to the output, either way.
    pub integral_limit: f32,
}

impl Gains {
    /// Nothing but a proportional part.
    #[must_use]
    pub const fn proportional(kp: f32) -> Self {
        Self { kp, ki: 0.0, kd: 0.0, integral_limit: 0.0 }
    }
}

/// Whether what a controller asked for last time could be done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Actuator {
    /// All of it.
    #[default]
    Free,
    /// No more in either direction: nothing is added to an integral, only taken away.
    AtLimit,
}

/// A controller's memory.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pid {
    /// The integral part of the output.
    integral: f32,
    last: Option<f32>,
}

impl Pid {
    pub(crate) const fn new() -> Self {
        Self { integral: 0.0, last: None }
    }

    /// One step of `dt` seconds.
    pub(crate) fn step(
        &mut self,
        gains: &Gains,
        error: f32,
        measured: f32,
        dt: f32,
        actuator: Actuator,
    ) -> f32 {
        let gathered = self.integral + gains.ki * error * dt;
        let grows = gathered.abs() > self.integral.abs();
        if !(grows && actuator == Actuator::AtLimit) {
            self.integral = gathered.max(-gains.integral_limit).min(gains.integral_limit);
        }
        let rate = match self.last.replace(measured) {
            Some(last) if dt > 0.0 => (measured - last) / dt,
            _ => 0.0,
        };
        gains.kp * error + self.integral - gains.kd * rate
    }

    /// The part of the integral's limit that is used up, 0 to 1.
    pub(crate) fn integral_use(&self, gains: &Gains) -> f32 {
        if gains.integral_limit > 0.0 { self.integral.abs() / gains.integral_limit } else { 0.0 }
    }
}
