//! The other drones of a mission, as the rangers of one of them see them.
//!
//! A Crazyflie is 92 mm wide and 29 mm high (Bitcraze's data sheet), and the beam of a VL53L1x a cone
//! of 27° (UM2555). Of that cone at a distance d the drone covers 0.015 m²/d², so that its light comes
//! to 0.0074/d⁴ of that of a white wall at 1 m, if it is as grey as the walls: less than the sensor
//! needs, 0.11, beyond half a metre.

use units::Point2;

/// Half the width of a drone without guards, m.
const RADIUS: f32 = 0.046;
/// Half its height, m.
const HALF_HEIGHT: f32 = 0.0145;
/// Sine and cosine of half the angle of a beam's cone: 13.5°.
const HALF_CONE: [f32; 2] = [0.233_45, 0.972_37];
/// The largest distance at which a drone is seen, m.
const FARTHEST: f32 = 0.5;

/// Where a drone is, as an obstacle.
#[derive(Clone, Copy, Debug)]
pub struct Obstacle {
    /// The place of its middle on the floor plan.
    pub at: Point2,
    /// Its height over the floor, m.
    pub height: f32,
}

/// All drones of a mission but one.
#[derive(Clone, Copy, Debug)]
pub struct Others<'a> {
    drones: &'a [Obstacle],
    own: usize,
}

impl<'a> Others<'a> {
    /// No other drones.
    pub const NONE: Self = Others { drones: &[], own: 0 };

    /// These drones without that of this number.
    #[must_use]
    pub const fn of(drones: &'a [Obstacle], own: usize) -> Self {
        Self { drones, own }
    }

    /// The distance to the nearest drone in the cone of a level beam, m: from `at`, at this height, along
    /// the unit vector `beam`. `None` where there is none near enough to be seen.
    #[must_use]
    pub fn seen(self, at: Point2, height: f32, beam: [f32; 2]) -> Option<f32> {
        let others = self.drones.iter().enumerate().filter(|(n, _)| *n != self.own);
        let distances = others.filter_map(|(_, other)| in_cone(other, at, height, beam));
        distances.reduce(f32::min)
    }
}

fn in_cone(drone: &Obstacle, at: Point2, height: f32, beam: [f32; 2]) -> Option<f32> {
    let (dx, dy) = (drone.at.x - at.x, drone.at.y - at.y);
    let square = dx * dx + dy * dy;
    if square > (FARTHEST + RADIUS) * (FARTHEST + RADIUS) {
        return None;
    }
    let ahead = dx * beam[0] + dy * beam[1];
    let beside = (dy * beam[0] - dx * beam[1]).abs();
    let [sin, cos] = HALF_CONE;
    // How far the middle of the drone is outside the edge of the cone.
    let is_beside = beside * cos - ahead * sin > RADIUS;
    let is_above = (drone.height - height).abs() * cos - ahead * sin > HALF_HEIGHT;
    let is_seen = ahead > 0.0 && !is_beside && !is_above;
    is_seen.then(|| (square.sqrt() - RADIUS).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(x: f32, y: f32, height: f32) -> Option<f32> {
        let drones = [0.0, x].map(|x| Obstacle { at: Point2::new(x, 0.0), height: 0.4 });
        let other = Obstacle { at: Point2::new(x, y), height };
        Others::of(&[drones[0], other], 0).seen(drones[0].at, 0.4, [1.0, 0.0])
    }

    #[test]
    fn a_drone_in_the_cone_of_a_beam_is_seen_within_half_a_metre() {
        assert!(seen(0.4, 0.0, 0.4).is_some_and(|d| (d - 0.354).abs() < 1e-4));
        assert!(seen(0.4, 0.12, 0.4).is_some() && seen(0.4, 0.2, 0.4).is_none());
        assert!(seen(0.7, 0.0, 0.4).is_none() && seen(-0.4, 0.0, 0.4).is_none());
    }

    #[test]
    fn a_drone_on_the_ground_or_far_above_is_not_seen() {
        assert!(seen(0.4, 0.0, 0.0).is_none() && seen(0.4, 0.0, 0.6).is_none());
        assert!(seen(0.4, 0.0, 0.48).is_some());
    }

    #[test]
    fn no_drone_sees_itself() {
        let drones = [Obstacle { at: Point2::new(0.0, 0.0), height: 0.4 }];
        assert_eq!(Others::of(&drones, 0).seen(drones[0].at, 0.4, [1.0, 0.0]), None);
    }
}
