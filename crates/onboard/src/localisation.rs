//! The position of a drone in the room, by a positioning system and by its own motion between two
//! fixes.
//!
//! A Kalman filter has three states: the position along the room's two axes, and the angle from the
//! gyroscope's heading to the room's. The optic flow moves the position on; a fix of the positioning
//! system corrects it, and by it the angle, which shows as soon as the drone flies. A fix far from
//! where the drone can be is refused. Where the system insists for a second on another place that
//! moves as the drone does, the filter begins anew there.

use core::f32::consts::TAU;

use agent::{BodyVelocity, Located};
use units::{Duration, Instant, Metres, Point2, Pose2, Radians};

use crate::mounting;

/// The position of a drone by a positioning system, at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// The place in the room.
    pub at: Point2,
    /// The heading of the nose from the room's x, where the system measures it.
    pub yaw: Option<Radians>,
    /// The standard deviation of the place along each axis.
    pub deviation: Metres,
}

impl Fix {
    /// The standard deviation of a position that a client sends (crazyflie-firmware,
    /// `crtp_localization_service.c`, `locSrv.extPosStdDev`).
    pub const BY_CLIENT: Metres = Metres(0.01);
}

/// The filter's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LocalisationConfig {
    /// The error of the flow's scale, as a part of the way. A simulation's 3 % and what a floor adds;
    /// our own number.
    of_way: f32,
    /// The standard deviation of the position after a second without motion, m. Our own number.
    at_rest: f32,
    /// The speed that a drone may have that measures none, m/s. Our own number.
    unmeasured: f32,
    /// The standard deviation of the angle after a second, rad: the gyroscope's drift of half a degree
    /// a second at most (BMI088 data sheet, 0.015 °/s/K, over a warming of 30 K).
    turn: f32,
    /// The standard deviation of the angle before the first fix, rad: drones are put down with the
    /// board's x along the room's, as the vendor's `kalman.initialYaw` of 0 has it.
    first_yaw: f32,
    /// The standard deviation of a heading by the system, rad: twice `locSrv.extQuatStdDev`, since a
    /// quaternion has half angles.
    yaw: f32,
    /// A fix is refused where the square of its distance in standard deviations is above this: one
    /// good fix of a thousand (χ² with two degrees of freedom).
    gate: f32,
    /// Refused fixes that all are displaced alike for so long are believed.
    insists: Duration,
    /// How far the displacement of such fixes may vary, m. Our own number.
    alike: f32,
    /// A fix that repeats the one before in every bit is none once the drone has flown so far, m: the
    /// system is frozen. Our own number.
    frozen: f32,
    /// A position with a larger standard deviation is none, m.
    most: f32,
}

const CONFIG: LocalisationConfig = LocalisationConfig {
    of_way: 0.05,
    at_rest: 0.01,
    unmeasured: 0.5,
    turn: 0.01,
    first_yaw: 0.2,
    yaw: 0.009,
    gate: 13.8,
    insists: Duration::from_secs(1),
    alike: 0.15,
    frozen: 0.1,
    most: 0.5,
};

/// Fixes that were refused one after the other, displaced alike.
#[derive(Clone, Copy, Debug)]
struct Refused {
    since: Instant,
    displacement: [f32; 2],
}

/// The last fix, and how far the drone had flown when it first came.
#[derive(Clone, Copy, Debug)]
struct Latest {
    fix: Fix,
    flown: f32,
}

/// The state of the filter.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    at: [f32; 2],
    /// The angle from the gyroscope's heading to the room's.
    offset: f32,
    /// The covariance of the position's two coordinates and the angle.
    covariance: [[f32; 3]; 3],
}

/// Keeps a drone's position in the room.
#[derive(Clone, Debug)]
pub(crate) struct Localisation {
    estimate: Option<Estimate>,
    waiting: Option<(Instant, Fix)>,
    latest: Option<Latest>,
    refused: Option<Refused>,
    stepped: Option<Instant>,
    heading: f32,
    flown: f32,
}

impl Localisation {
    pub(crate) const fn new() -> Self {
        Self {
            estimate: None,
            waiting: None,
            latest: None,
            refused: None,
            stepped: None,
            heading: 0.0,
            flown: 0.0,
        }
    }

    /// Notes a fix for the next step, in the place of an earlier one.
    pub(crate) fn fix(&mut self, now: Instant, fix: Fix) {
        let is_number = fix.at.is_finite() && fix.yaw.is_none_or(|yaw| yaw.0.abs() <= TAU);
        if is_number && fix.deviation.0 > 0.0 && fix.deviation.0.is_finite() {
            self.waiting = Some((now, fix));
        }
    }

    /// Forgets the position: the next fix is the first one again.
    pub(crate) const fn forget(&mut self) {
        self.estimate = None;
        self.waiting = None;
        self.latest = None;
        self.refused = None;
    }

    /// The place and the variance of it along each axis, m², however large; `None` before the first
    /// fix.
    pub(crate) fn place(&self) -> Option<(Point2, f32)> {
        let Estimate { at: [x, y], covariance: [[xx, ..], [_, yy, _], _], .. } = self.estimate?;
        Some((Point2::new(x, y), xx.max(yy)))
    }

    /// Moves the position on to `now` by the drone's own motion, and takes in the latest fix.
    pub(crate) fn step(
        &mut self,
        now: Instant,
        velocity: Option<BodyVelocity>,
        heading: Option<Radians>,
    ) -> Option<Located> {
        let dt = self.stepped.map_or(0.0, |last| now.since(last).as_secs_f32()).min(1.0);
        self.stepped = Some(now);
        if let Some(heading) = heading.filter(|heading| heading.0.abs() <= TAU) {
            self.heading = heading.0;
        }
        let flow = velocity.map(|v| [v.forward.0, v.lateral.0]);
        let flow = flow.filter(|v| v.iter().all(|one| one.abs() < 10.0));
        let speed = flow.map_or(0.0, length);
        self.flown += speed * dt;
        if let Some(estimate) = &mut self.estimate {
            estimate.predict(self.heading, flow, dt);
        }
        if let Some((at, fix)) = self.waiting.take()
            && !self.is_frozen(fix)
        {
            self.take_in(now, at, flow.unwrap_or_default(), fix);
        }
        self.located()
    }

    fn located(&self) -> Option<Located> {
        let (at, variance) = self.place()?;
        let deviation = Metres(libm::sqrtf(variance));
        let yaw = Radians(self.heading + self.estimate?.offset).wrapped();
        let pose = Pose2 { at, yaw };
        (deviation.0 <= CONFIG.most).then_some(Located { pose, deviation })
    }

    fn is_frozen(&mut self, fix: Fix) -> bool {
        match self.latest {
            Some(latest) if latest.fix == fix => self.flown - latest.flown > CONFIG.frozen,
            _ => {
                self.latest = Some(Latest { fix, flown: self.flown });
                false
            }
        }
    }

    fn take_in(&mut self, now: Instant, at: Instant, [forward, left]: [f32; 2], fix: Fix) {
        let Some(estimate) = &mut self.estimate else {
            self.estimate = Some(Estimate::at(fix, self.heading));
            return;
        };
        // The drone has flown on since.
        let age = now.since(at).as_secs_f32();
        let (sin, cos) = Radians(self.heading + estimate.offset).sin_cos();
        let x = fix.at.x + age * (forward * cos - left * sin);
        let y = fix.at.y + age * (forward * sin + left * cos);
        let displacement = [x - estimate.at[0], y - estimate.at[1]];
        if estimate.correct_place(displacement, fix.deviation.0) {
            self.refused = None;
            if let Some(yaw) = fix.yaw {
                let off = Radians(yaw.0 - self.heading - estimate.offset).wrapped();
                estimate.correct_yaw(off.0);
            }
            return;
        }
        let is_alike = |refused: &Refused| {
            let [x, y] = refused.displacement;
            length([x - displacement[0], y - displacement[1]]) < CONFIG.alike
        };
        let refused = self.refused.filter(is_alike).unwrap_or(Refused { since: now, displacement });
        self.refused = Some(refused);
        if now.since(refused.since) >= CONFIG.insists {
            let moved = Fix { at: Point2::new(x, y), ..fix };
            let known = *estimate;
            self.refused = None;
            self.estimate = Some(match fix.yaw {
                Some(_) => Estimate::at(moved, self.heading),
                None => Estimate { at: [x, y], ..known }.with_place(fix.deviation.0),
            });
        }
    }
}

impl Estimate {
    /// The estimate by a first fix.
    fn at(fix: Fix, heading: f32) -> Self {
        let (offset, deviation) = match fix.yaw {
            Some(yaw) => (yaw.0 - heading, CONFIG.yaw),
            None => (mounting::heading(Radians::ZERO).0 - heading, CONFIG.first_yaw),
        };
        let mut covariance = [[0.0; 3]; 3];
        covariance[2][2] = deviation * deviation;
        Self { at: [fix.at.x, fix.at.y], offset, covariance }.with_place(fix.deviation.0)
    }

    /// The same at a place that is known as well as this, whatever was known of it.
    const fn with_place(mut self, deviation: f32) -> Self {
        let of_angle = self.covariance[2][2];
        self.covariance = [[0.0; 3]; 3];
        self.covariance[0][0] = deviation * deviation;
        self.covariance[1][1] = deviation * deviation;
        self.covariance[2][2] = of_angle;
        self
    }

    fn predict(&mut self, heading: f32, flow: Option<[f32; 2]>, dt: f32) {
        let [forward, left] = flow.unwrap_or_default();
        let (sin, cos) = Radians(heading + self.offset).sin_cos();
        let moved = [dt * (forward * cos - left * sin), dt * (forward * sin + left * cos)];
        self.at = [self.at[0] + moved[0], self.at[1] + moved[1]];
        // ∂x/∂angle = −Δy, ∂y/∂angle = Δx.
        let by_angle = [-moved[1], moved[0]];
        let [[xx, xy, xa], [_, yy, ya], [.., aa]] = self.covariance;
        let [x, y] = by_angle;
        let way = length(moved);
        let unmeasured = if flow.is_none() { CONFIG.unmeasured * dt } else { 0.0 };
        let noise = (CONFIG.of_way * way) * (CONFIG.of_way * way)
            + CONFIG.at_rest * CONFIG.at_rest * dt
            + unmeasured * unmeasured;
        let (new_xa, new_ya) = (xa + x * aa, ya + y * aa);
        let new_xx = xx + 2.0 * x * xa + x * x * aa + noise;
        let new_xy = xy + x * ya + y * xa + x * y * aa;
        let new_yy = yy + 2.0 * y * ya + y * y * aa + noise;
        let new_aa = aa + CONFIG.turn * CONFIG.turn * dt;
        self.covariance =
            [[new_xx, new_xy, new_xa], [new_xy, new_yy, new_ya], [new_xa, new_ya, new_aa]];
    }

    /// Takes in the displacement of a fix; returns whether the fix was believed.
    fn correct_place(&mut self, [x, y]: [f32; 2], deviation: f32) -> bool {
        let [[xx, xy, xa], [_, yy, ya], _] = self.covariance;
        let variance = deviation * deviation;
        let (a, b, c) = (xx + variance, xy, yy + variance);
        let determinant = a * c - b * b;
        let squared = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant;
        // Written so that no number is refused, too.
        if !(squared <= CONFIG.gate && determinant > 0.0) {
            return false;
        }
        let gain = [[xx, xy], [xy, yy], [xa, ya]]
            .map(|[p, q]| [(p * c - q * b) / determinant, (q * a - p * b) / determinant]);
        let change = gain.map(|[p, q]| p * x + q * y);
        self.at = [self.at[0] + change[0], self.at[1] + change[1]];
        self.offset += change[2];
        let rows = [self.covariance[0], self.covariance[1]];
        for (row, [p, q]) in self.covariance.iter_mut().zip(gain) {
            for (column, one) in row.iter_mut().enumerate() {
                let [of_x, of_y] = rows.map(|row| row.get(column).copied().unwrap_or_default());
                *one -= p * of_x + q * of_y;
            }
        }
        true
    }

    /// Takes in how far the heading of a fix is off.
    fn correct_yaw(&mut self, off: f32) {
        let row = self.covariance[2];
        let sum = row[2] + CONFIG.yaw * CONFIG.yaw;
        let gain = row.map(|one| one / sum);
        let [x, y, angle] = gain.map(|one| one * off);
        self.at = [self.at[0] + x, self.at[1] + y];
        self.offset += angle;
        for (of, gain) in self.covariance.iter_mut().zip(gain) {
            for (one, own) in of.iter_mut().zip(row) {
                *one -= gain * own;
            }
        }
    }
}

/// The length of a vector. `libm::hypotf` computes in double precision, which the chip has not.
fn length([x, y]: [f32; 2]) -> f32 {
    libm::sqrtf(x * x + y * y)
}

#[cfg(test)]
#[path = "localisation_tests.rs"]
mod tests;
