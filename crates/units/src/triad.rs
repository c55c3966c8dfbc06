//! The readings of inertial sensors: three numbers along the board's axes.

/// The angular velocity about the board's axes x (forward), y (left) and z (up), in rad/s, each
/// positive counter-clockwise seen from the axis's tip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AngularVelocity(pub [f32; 3]);

/// The specific force along the board's axes x (forward), y (left) and z (up), in m/s²: what an
/// accelerometer measures, +9.81 on z at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Acceleration(pub [f32; 3]);
