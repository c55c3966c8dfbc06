//! What must be true of a drone's position in the room.

use core::f32::consts::{FRAC_PI_4, TAU};

use proptest::prelude::*;
use units::MetresPerSecond;

use super::*;

const ROUND_MS: u64 = 200;
/// The drone flies circles of this radius at this speed, nose ahead: m and m/s.
const RADIUS: f32 = 2.0;
const SPEED: f32 = 0.4;

/// A flight along a circle, from a place where the board's x is along the room's, with a gyroscope whose heading is off by a constant.
struct Flight {
    localisation: Localisation,
    round: u64,
    gyro_off: f32,
    seed: u32,
}

impl Flight {
    fn new(gyro_off: f32, seed: u32) -> Self {
        Self { localisation: Localisation::new(), round: 0, gyro_off, seed }
    }

    fn now(&self) -> Instant {
        Instant::from_millis(self.round * ROUND_MS)
    }

    fn truth(&self) -> Pose2 {
        let angle = (SPEED / RADIUS * self.round as f32 * 0.2).rem_euclid(TAU) - FRAC_PI_4;
        let (sin, cos) = angle.sin_cos();
        Pose2 { at: Point2::new(RADIUS * sin, -RADIUS * cos), yaw: Radians(angle).wrapped() }
    }

    /// A number that is normally distributed, nearly: the sum of twelve.
    fn normal(&mut self) -> f32 {
        let mut draw = || {
            self.seed = self.seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.seed >> 8) as f32 / 16_777_216.0
        };
        (0..12).map(|_| draw()).sum::<f32>() - 6.0
    }

    fn fix(&mut self, noise: f32) -> Fix {
        let at = self.truth().at;
        let at = Point2::new(at.x + noise * self.normal(), at.y + noise * self.normal());
        Fix { at, yaw: None, deviation: Metres(noise) }
    }

    /// Flies a round, at the end of which this fix has come.
    fn fly(&mut self, fix: impl FnOnce(&mut Self) -> Option<Fix>) -> Option<Located> {
        self.round += 1;
        let fix = fix(self);
        let now = self.now();
        if let Some(fix) = fix {
            self.localisation.fix(now, fix);
        }
        // The middle of the round's heading leads to the chord's end.
        let yaw = self.truth().yaw.0 - SPEED / RADIUS * 0.1;
        let velocity =
            BodyVelocity { forward: MetresPerSecond(SPEED), lateral: MetresPerSecond(0.0) };
        let heading = Radians(yaw - self.gyro_off).wrapped();
        self.localisation.step(now, Some(velocity), Some(heading))
    }

    /// Flies ten seconds with good fixes.
    fn fly_with_fixes(&mut self) {
        for _ in 0..50 {
            self.fly(|flight| Some(flight.fix(0.01)));
        }
    }

    fn error(&self, located: Option<Located>) -> f32 {
        located.map_or(f32::INFINITY, |located| located.pose.at.distance(self.truth().at).0)
    }
}

proptest! {
    #[test]
    fn the_position_is_as_good_as_the_fixes_though_a_third_of_them_is_lost(
        noise in 0.01_f32..0.1, seed in any::<u32>(), gyro_off in -3.0_f32..3.0,
    ) {
        let mut flight = Flight::new(gyro_off, seed);
        for round in 0..200_u32 {
            let located = flight.fly(|flight| {
                let is_lost = round > 0 && flight.normal() > 0.5;
                (!is_lost).then(|| flight.fix(noise))
            });
            let error = flight.error(located);
            prop_assert!(error < 4.5 * noise + 0.02, "round {round}: {error} m of {noise}");
        }
    }

    #[test]
    fn one_fix_far_off_moves_nothing(x in -50.0_f32..50.0, y in -50.0_f32..50.0, seed in any::<u32>()) {
        let mut flight = Flight::new(0.0, seed);
        for round in 0..60 {
            let located = flight.fly(|flight| {
                let fix = flight.fix(0.01);
                let off = Point2::new(fix.at.x + x, fix.at.y + y);
                let is_outlier = round == 40 && x.hypot(y) > 0.5;
                Some(if is_outlier { Fix { at: off, ..fix } } else { fix })
            });
            prop_assert!(flight.error(located) < 0.08);
        }
    }

    #[test]
    fn no_fix_and_no_motion_makes_a_number_that_is_none(
        x in any::<f32>(), y in any::<f32>(), yaw in any::<f32>(), deviation in any::<f32>(),
        forward in any::<f32>(), heading in any::<f32>(),
    ) {
        let mut localisation = Localisation::new();
        for round in 0..5_u64 {
            let now = Instant::from_millis(round * ROUND_MS);
            let fix = Fix { at: Point2::new(x, y), yaw: Some(Radians(yaw)), deviation: Metres(deviation) };
            localisation.fix(now, fix);
            let velocity = BodyVelocity { forward: MetresPerSecond(forward), lateral: MetresPerSecond(0.1) };
            let located = localisation.step(now, Some(velocity), Some(Radians(heading)));
            if let Some(Located { pose, deviation }) = located {
                prop_assert!(pose.at.is_finite() && pose.yaw.0.is_finite() && deviation.0 >= 0.0);
            }
        }
    }
}

#[test]
fn without_fixes_the_flow_leads_on_until_the_position_is_none() {
    let mut flight = Flight::new(1.0, 7);
    flight.fly_with_fixes();
    let (mut error, mut rounds) = (0.0_f32, 0);
    while let Some(located) = flight.fly(|_| None) {
        error = error.max(flight.error(Some(located)));
        rounds += 1;
        assert!(rounds < 10_000, "the position is never lost");
    }
    assert!(rounds > 5 * 10, "ten seconds of flow are a position: {rounds} rounds");
    assert!(error < 0.5, "{error} m");
}

#[test]
fn a_frozen_system_does_not_hold_the_drone() {
    let mut flight = Flight::new(0.0, 3);
    flight.fly_with_fixes();
    let frozen = flight.fix(0.01);
    for _ in 0..50 {
        let located = flight.fly(|_| Some(frozen));
        assert!(flight.error(located) < 0.25, "{}", flight.error(located));
    }
}

#[test]
fn a_system_that_insists_on_another_place_is_believed_after_a_second() {
    let mut flight = Flight::new(0.0, 5);
    flight.fly_with_fixes();
    let moved = |flight: &mut Flight| {
        let fix = flight.fix(0.01);
        Some(Fix { at: Point2::new(fix.at.x + 3.0, fix.at.y), ..fix })
    };
    let errors: std::vec::Vec<f32> = (0..10)
        .map(|_| {
            let located = flight.fly(moved);
            flight.error(located)
        })
        .collect();
    assert!(errors[..4].iter().all(|error| *error < 0.2), "{errors:?}");
    assert!(errors[8..].iter().all(|error| (2.8..3.2).contains(error)), "{errors:?}");
}
