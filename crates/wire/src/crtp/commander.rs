//! Set-points of every kind that clients send.

use core::f32::consts::PI;

use units::{Metres, MetresPerSecond, Radians, RadiansPerSecond};

use super::{Error, Packet, Port};

/// One degree in radians: clients send angles in degrees.
const DEGREE: f32 = PI / 180.0;

/// The largest number that is accepted, in m, m/s, degrees and degrees per second: a client that
/// sends a larger one has sent garbage.
const MOST: f32 = 1e6;

/// A set-point of port 7. Counter-clockwise is positive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Setpoint {
    /// The motors are to be switched off.
    Stop,
    /// The drone is to fly with these velocities in the room's axes.
    Velocity {
        /// The velocities along the room's x, y and z.
        axes: [MetresPerSecond; 3],
        /// The turn rate about the room's z.
        yaw_rate: RadiansPerSecond,
    },
    /// The drone is to hold a height and these angles.
    Height {
        /// The roll angle.
        roll: Radians,
        /// The pitch angle.
        pitch: Radians,
        /// The turn rate about z.
        yaw_rate: RadiansPerSecond,
        /// The height over ground.
        height: Metres,
    },
    /// The drone is to hold a height and fly with these velocities in its own axes.
    Hover {
        /// The velocity along x.
        forward: MetresPerSecond,
        /// The velocity along y, to the left.
        lateral: MetresPerSecond,
        /// The turn rate about z.
        yaw_rate: RadiansPerSecond,
        /// The height over ground.
        height: Metres,
    },
    /// The drone is to fly to a place in the room.
    Position {
        /// The coordinates along the room's x, y and z.
        axes: [Metres; 3],
        /// The heading at that place.
        yaw: Radians,
    },
    /// A set-point of this kind, whose numbers are not parsed.
    Other(u8),
}

impl Setpoint {
    pub(super) fn parse(data: &[u8]) -> Result<Self, Error> {
        let (kind, data) = data.split_first().ok_or(Error::Length(0))?;
        let four = || numbers::<4>(data);
        match kind {
            0 => Ok(Self::Stop),
            // Kinds 1, 2 and 5 are older than 8, 9 and 10, and count turns clockwise.
            1 => four().map(|n| Self::velocity(n, -1.0)),
            8 => four().map(|n| Self::velocity(n, 1.0)),
            2 => four().map(|n| Self::height(n, -1.0)),
            9 => four().map(|n| Self::height(n, 1.0)),
            5 => four().map(|n| Self::hover(n, -1.0)),
            10 => four().map(|n| Self::hover(n, 1.0)),
            7 => four().map(|[x, y, z, yaw]| Self::Position {
                axes: [Metres(x), Metres(y), Metres(z)],
                yaw: Radians(yaw * DEGREE),
            }),
            kind => Ok(Self::Other(*kind)),
        }
    }

    fn velocity([x, y, z, turn]: [f32; 4], sign: f32) -> Self {
        Self::Velocity {
            axes: [MetresPerSecond(x), MetresPerSecond(y), MetresPerSecond(z)],
            yaw_rate: RadiansPerSecond(sign * turn * DEGREE),
        }
    }

    fn height([roll, pitch, turn, height]: [f32; 4], sign: f32) -> Self {
        Self::Height {
            roll: Radians(roll * DEGREE),
            pitch: Radians(pitch * DEGREE),
            yaw_rate: RadiansPerSecond(sign * turn * DEGREE),
            height: Metres(height),
        }
    }

    fn hover([forward, lateral, turn, height]: [f32; 4], sign: f32) -> Self {
        Self::Hover {
            forward: MetresPerSecond(forward),
            lateral: MetresPerSecond(lateral),
            yaw_rate: RadiansPerSecond(sign * turn * DEGREE),
            height: Metres(height),
        }
    }

    pub(super) fn packet(&self) -> Packet {
        let of = |kind: u8, numbers: [f32; 4]| {
            let head = Packet::empty(Port::Setpoint, 0).with(&[kind]);
            numbers.iter().fold(head, |packet, n| packet.with(&n.to_le_bytes()))
        };
        match *self {
            Self::Stop => Packet::empty(Port::Setpoint, 0).with(&[0]),
            Self::Velocity { axes: [x, y, z], yaw_rate } => {
                of(8, [x.0, y.0, z.0, yaw_rate.0 / DEGREE])
            }
            Self::Height { roll, pitch, yaw_rate, height } => {
                of(9, [roll.0 / DEGREE, pitch.0 / DEGREE, yaw_rate.0 / DEGREE, height.0])
            }
            Self::Hover { forward, lateral, yaw_rate, height } => {
                of(10, [forward.0, lateral.0, yaw_rate.0 / DEGREE, height.0])
            }
            Self::Position { axes: [x, y, z], yaw } => of(7, [x.0, y.0, z.0, yaw.0 / DEGREE]),
            Self::Other(kind) => Packet::empty(Port::Setpoint, 0).with(&[kind]),
        }
    }
}

/// A set-point of port 3, the oldest format: a gamepad without any assistance sends it, and a
/// client sends it with all numbers zero when it disconnects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rpyt {
    /// The roll angle.
    pub roll: Radians,
    /// The pitch angle, with the sign that the client gives it.
    pub pitch: Radians,
    /// The turn rate about z, with the sign that the client gives it.
    pub yaw_rate: RadiansPerSecond,
    /// The thrust, 0 to 65,535. Zero unlocks: set-points before the first zero are not followed.
    pub thrust: u16,
}

impl Rpyt {
    /// Whether the motors are to be off.
    #[must_use]
    pub const fn is_off(&self) -> bool {
        self.thrust == 0
    }

    pub(super) fn parse(data: &[u8]) -> Result<Self, Error> {
        let [roll, pitch, yaw_rate] = numbers(data)?;
        let thrust =
            data.get(12..).and_then(<[u8]>::first_chunk).ok_or(Error::Length(data.len()))?;
        Ok(Self {
            roll: Radians(roll * DEGREE),
            pitch: Radians(pitch * DEGREE),
            yaw_rate: RadiansPerSecond(yaw_rate * DEGREE),
            thrust: u16::from_le_bytes(*thrust),
        })
    }

    pub(super) fn packet(&self) -> Packet {
        [self.roll.0, self.pitch.0, self.yaw_rate.0]
            .iter()
            .fold(Packet::empty(Port::Commander, 0), |packet, angle| {
                packet.with(&(angle / DEGREE).to_le_bytes())
            })
            .with(&self.thrust.to_le_bytes())
    }
}

/// A command to the high-level commander, for one group of drones; group 0 is all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HighLevel {
    /// The group is to take off.
    TakeOff {
        /// The group of drones.
        group: u8,
    },
    /// The group is to land.
    Land {
        /// The group of drones.
        group: u8,
    },
    /// The group is to switch its motors off.
    Stop {
        /// The group of drones.
        group: u8,
    },
    /// A command of this kind, whose arguments are not parsed.
    Other(u8),
}

impl HighLevel {
    pub(super) fn parse(data: &[u8]) -> Result<Self, Error> {
        match data {
            [] => Err(Error::Length(0)),
            // By time, without and with a heading, and by speed.
            [1 | 7 | 9, group, ..] => Ok(Self::TakeOff { group: *group }),
            [2 | 8 | 10, group, ..] => Ok(Self::Land { group: *group }),
            [3, group, ..] => Ok(Self::Stop { group: *group }),
            [1..=3 | 7..=10] => Err(Error::Length(1)),
            [kind, ..] => Ok(Self::Other(*kind)),
        }
    }

    pub(super) fn packet(&self) -> Packet {
        Packet::empty(Port::HighLevel, 0).with(&match *self {
            Self::TakeOff { group } => [7, group],
            Self::Land { group } => [8, group],
            Self::Stop { group } => [3, group],
            Self::Other(kind) => [kind, 0],
        })
    }
}

/// The first `N` numbers of `data`, if all of them are finite and within [`MOST`].
pub(super) fn numbers<const N: usize>(data: &[u8]) -> Result<[f32; N], Error> {
    let mut numbers = [0.0; N];
    let (words, _) = data.as_chunks::<4>();
    if words.len() < N {
        return Err(Error::Length(data.len()));
    }
    for (number, word) in numbers.iter_mut().zip(words) {
        *number = f32::from_le_bytes(*word);
        if !(-MOST..=MOST).contains(number) {
            return Err(Error::Value);
        }
    }
    Ok(numbers)
}
