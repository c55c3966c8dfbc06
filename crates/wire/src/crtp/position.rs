//! Positions from an external positioning system: motion capture, Lighthouse, Loco.

use core::f32::consts::FRAC_1_SQRT_2;

use units::{Metres, Radians};

use super::commander::numbers;
use super::{Error, MAX_DATA, Packet, Port};

/// The farthest from the origin that a position is taken for one: the vendor's estimator gives up
/// beyond it (crazyflie-firmware, `kalman_supervisor.c`).
const FARTHEST: Metres = Metres(100.0);
/// A unit quaternion may be this long by rounding, and as much shorter.
const LONGEST: f32 = 1.1;
/// The bytes of a position, and of a pose, in a packet for several drones.
const POSITION: usize = 7;
const POSE: usize = 11;
/// The commands of the two packets with poses.
const ONE_POSE: u8 = 8;
const SOME_POSES: u8 = 9;
/// The largest number for an element of a compressed quaternion, and its bits with its sign.
const ELEMENT: u32 = (1 << 9) - 1;
const ELEMENT_BITS: u32 = 10;

/// The position of one drone in the room.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fix {
    /// The coordinates along the room's x, y and z.
    pub at: [Metres; 3],
    /// The heading of the nose, counter-clockwise from the room's x, where the system measures it.
    pub yaw: Option<Radians>,
}

/// A packet with positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Positions<'a> {
    /// The position of the drone that receives the packet.
    Own(Fix),
    /// The positions of several drones.
    Packed(PackedPositions<'a>),
}

impl<'a> Positions<'a> {
    /// The position of the drone whose address ends in `number`.
    #[must_use]
    pub fn of(&self, number: u8) -> Option<Fix> {
        match self {
            Self::Own(fix) => Some(*fix),
            Self::Packed(packed) => packed.iter().find(|(of, _)| *of == number).map(|(_, fix)| fix),
        }
    }

    pub(super) fn parse(channel: u8, data: &'a [u8]) -> Result<Self, Error> {
        match (channel, data) {
            (0, data) => numbers(data).and_then(|at| fix(at, None)).map(Self::Own),
            (1, [ONE_POSE, data @ ..]) => {
                let [x, y, z, rotation @ ..] = numbers::<7>(data)?;
                fix([x, y, z], Some(yaw(rotation)?)).map(Self::Own)
            }
            (1, [SOME_POSES, data @ ..]) => PackedPositions::parse(data, true).map(Self::Packed),
            (2, data) => PackedPositions::parse(data, false).map(Self::Packed),
            (1, [command, ..]) => Err(Error::Command(*command)),
            (1, []) => Err(Error::Length(0)),
            (channel, _) => Err(Error::Channel(channel)),
        }
    }

    pub(super) fn packet(&self) -> Packet {
        let on = |channel| Packet::empty(Port::Localization, channel);
        match self {
            Self::Own(Fix { at, yaw }) => {
                let rotation = yaw.map(|yaw| (yaw / 2.0).sin_cos());
                let head = if rotation.is_some() { on(1).with(&[ONE_POSE]) } else { on(0) };
                let rotation = rotation.map(|(sin, cos)| [0.0, 0.0, sin, cos]);
                let numbers = at.iter().map(|one| one.0).chain(rotation.into_iter().flatten());
                numbers.fold(head, |packet, number| packet.with(&number.to_le_bytes()))
            }
            Self::Packed(PackedPositions { data, are_poses: false }) => on(2).with(data),
            Self::Packed(PackedPositions { data, are_poses: true }) => {
                on(1).with(&[SOME_POSES]).with(data)
            }
        }
    }
}

/// Positions of several drones, each by the last byte of its address, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PackedPositions<'a> {
    data: &'a [u8],
    are_poses: bool,
}

impl<'a> PackedPositions<'a> {
    /// The drones with their positions. A rotation that is none is left out with its position.
    pub fn iter(&self) -> impl Iterator<Item = (u8, Fix)> + use<'a> {
        let are_poses = self.are_poses;
        self.data.chunks_exact(self.size()).filter_map(move |item| item_of(item, are_poses))
    }

    fn parse(data: &'a [u8], are_poses: bool) -> Result<Self, Error> {
        let all = Self { data, are_poses };
        let whole = data.len() / all.size() * all.size();
        let data = data.get(..whole.min(MAX_DATA)).filter(|data| !data.is_empty());
        data.map(|data| Self { data, are_poses }).ok_or(Error::Length(whole))
    }

    const fn size(&self) -> usize {
        if self.are_poses { POSE } else { POSITION }
    }
}

fn item_of(item: &[u8], is_pose: bool) -> Option<(u8, Fix)> {
    let [number, x0, x1, y0, y1, z0, z1, rotation @ ..] = item else { return None };
    let metres = |bytes: [u8; 2]| f32::from(i16::from_le_bytes(bytes)) / 1000.0;
    let at = [[*x0, *x1], [*y0, *y1], [*z0, *z1]].map(metres);
    let yaw = match rotation.first_chunk() {
        Some(packed) if is_pose => Some(yaw(unpacked(u32::from_le_bytes(*packed))?).ok()?),
        _ => None,
    };
    fix(at, yaw).ok().map(|fix| (*number, fix))
}

fn fix(at: [f32; 3], yaw: Option<Radians>) -> Result<Fix, Error> {
    let is_near = at.iter().all(|one| (-FARTHEST.0..=FARTHEST.0).contains(one));
    if is_near { Ok(Fix { at: at.map(Metres), yaw }) } else { Err(Error::Value) }
}

/// The heading of the nose by a rotation, x, y, z and w.
fn yaw([x, y, z, w]: [f32; 4]) -> Result<Radians, Error> {
    let length = x * x + y * y + z * z + w * w;
    if !(1.0 / LONGEST..=LONGEST).contains(&length) {
        return Err(Error::Value);
    }
    let (sin, cos) = (2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    Ok(Radians(libm::atan2f(sin, cos)))
}

/// The quaternion of 32 bits (crazyflie-firmware, `quatcompress.h`): two bits say which element is
/// the largest, which is positive; the other three follow from x on, a sign and nine bits each, in
/// parts of √½. `None` where they are too long for a unit quaternion.
fn unpacked(packed: u32) -> Option<[f32; 4]> {
    let largest = (packed >> 30) as usize;
    let (mut rotation, mut bits, mut squares) = ([0.0; 4], packed, 0.0);
    for (_, element) in
        rotation.iter_mut().enumerate().rev().filter(|(number, _)| *number != largest)
    {
        let size = FRAC_1_SQRT_2 * (bits & ELEMENT) as f32 / ELEMENT as f32;
        *element = if bits >> 9 & 1 == 1 { -size } else { size };
        squares += size * size;
        bits >>= ELEMENT_BITS;
    }
    if squares > 1.0 {
        return None;
    }
    if let Some(element) = rotation.get_mut(largest) {
        *element = libm::sqrtf(1.0 - squares);
    }
    Some(rotation)
}
