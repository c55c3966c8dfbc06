//! A PID controller whose integral is limited, and does not wind up while the actuator is at its
//! limit.

/// The gains of a controller, in units of its output per unit of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// The gain of the error.
    pub kp: f32,
    /// The gain of the error's integral, per second.
    pub ki: f32,
    /// The gain of the measurement's rate of change, seconds. It acts on the measurement, so the
    /// output does not jump when the set-point does.
    pub kd: f32,
    /// The limit of the integral part of the output, in either direction.
    pub integral_limit: f32,
}

impl Gains {
    /// Gains of a purely proportional controller.
    #[must_use]
    pub const fn proportional(kp: f32) -> Self {
        Self { kp, ki: 0.0, kd: 0.0, integral_limit: 0.0 }
    }
}

/// Whether the controller's last output could be carried out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Actuator {
    /// All of it was carried out.
    #[default]
    Free,
    /// The actuator is at its limit: the integral may shrink, but not grow.
    AtLimit,
}

/// The state of a controller between steps.
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

    /// This controller before its first step, with the integral that it has now.
    pub(crate) const fn resumed(&self) -> Self {
        Self { integral: self.integral, last: None }
    }

    /// Advances by `dt` seconds and returns the output.
    pub(crate) fn step(
        &mut self,
        gains: &Gains,
        error: f32,
        measured: f32,
        dt: f32,
        actuator: Actuator,
    ) -> f32 {
        let candidate = self.integral + gains.ki * error * dt;
        let grows = candidate.abs() > self.integral.abs();
        if !(grows && actuator == Actuator::AtLimit) {
            self.integral = candidate.max(-gains.integral_limit).min(gains.integral_limit);
        }
        let rate = match self.last.replace(measured) {
            Some(last) if dt > 0.0 => (measured - last) / dt,
            _ => 0.0,
        };
        gains.kp * error + self.integral - gains.kd * rate
    }

    /// Moves the integral by `by` where that brings it nearer to zero, and no farther than zero.
    pub(crate) fn relieve(&mut self, by: f32) {
        if self.integral * by < 0.0 {
            let left = self.integral + by;
            self.integral = if left * self.integral > 0.0 { left } else { 0.0 };
        }
    }

    /// The integral part of the output.
    pub(crate) const fn integral(&self) -> f32 {
        self.integral
    }

    /// The used fraction of the integral's limit, 0 to 1.
    pub(crate) fn integral_use(&self, gains: &Gains) -> f32 {
        if gains.integral_limit > 0.0 { self.integral.abs() / gains.integral_limit } else { 0.0 }
    }
}
