//! The plan of a swarm's mission in the record of the settings: where the area lies that is surveyed,
//! and where the passage behind it.
//!
//! A plan takes 19 bytes; zeros are none:
//!
//! | byte | type | field | unit |
//! |---|---|---|---|
//! | 0 | `u8` | number of drones, 1 to 15; and 128 where both areas are surveyed | |
//! | 1 | 2 × `i16` | south-western corner of the area | cm |
//! | 5 | 2 × `u16` | extent of the area to the east and to the north, 1 to 100 m | cm |
//! | 9 | 2 × `i16` | middle of the passage's entrance | cm |
//! | 13 | `u16` | width of the entrance, 0.5 to 20 m | cm |
//! | 15 | `i16` | direction of the passage, counter-clockwise from east, up to 180 | 0.01° |
//! | 17 | `u16` | length of the passage, up to 100 m | cm |

use core::ops::RangeInclusive;

use units::{Metres, NODES, Point2, Radians};

use crate::Error;
use crate::bytes::Reader;

/// Bytes of a plan.
pub(crate) const LENGTH: usize = 1 + 2 * NUMBERS;
/// The numbers of a plan behind the number of drones.
const NUMBERS: usize = 9;

/// The bit of the number of drones that says that both areas are surveyed.
const BOTH: u8 = 0x80;

const DRONES: RangeInclusive<u8> = 1..=NODES as u8 - 1;
/// The extent of the area, cm.
const AREA: RangeInclusive<u16> = 100..=10_000;
/// The width of the entrance, cm.
const WIDTH: RangeInclusive<u16> = 50..=2_000;
/// The length of the passage, cm.
const PASSAGE: RangeInclusive<u16> = 0..=10_000;
/// The direction of the passage, 0.01°.
const DIRECTION: RangeInclusive<i16> = -18_000..=18_000;

/// The plan of a swarm's mission. All drones of a swarm must have the same. It is kept to the
/// centimetre and the hundredth of a degree.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SwarmPlan {
    /// The number of drones, which are those from number 0 on.
    pub drones: u8,
    /// The south-western corner of the area that is surveyed.
    pub corner: Point2,
    /// The area's extent to the east and to the north.
    pub area: (Metres, Metres),
    /// The middle of the passage's entrance.
    pub entrance: Point2,
    /// The width of the entrance.
    pub width: Metres,
    /// The direction of the second area from the entrance, counter-clockwise from east.
    pub direction: Radians,
    /// The distance from the entrance to the second area.
    pub length: Metres,
    /// Whether the second area is surveyed, too; it is as large as the first one.
    pub both: bool,
}

impl SwarmPlan {
    /// The bytes of a plan, or of none.
    pub(crate) fn encode(plan: Option<&Self>) -> Result<[u8; LENGTH], Error> {
        let mut bytes = [0; LENGTH];
        let Some(plan) = plan else { return Ok(bytes) };
        if !DRONES.contains(&plan.drones) {
            return Err(Error::Value);
        }
        let numbers = [
            signed(plan.corner.x)?,
            signed(plan.corner.y)?,
            unsigned(plan.area.0, &AREA)?,
            unsigned(plan.area.1, &AREA)?,
            signed(plan.entrance.x)?,
            signed(plan.entrance.y)?,
            unsigned(plan.width, &WIDTH)?,
            direction(plan.direction)?,
            unsigned(plan.length, &PASSAGE)?,
        ];
        let drones = plan.drones | if plan.both { BOTH } else { 0 };
        let fields = [drones].into_iter().chain(numbers.into_iter().flatten());
        for (place, byte) in bytes.iter_mut().zip(fields) {
            *place = byte;
        }
        Ok(bytes)
    }

    /// The plan in a record, if there is one.
    pub(crate) fn decode(fields: &mut Reader<'_>) -> Result<Option<Self>, Error> {
        let first = fields.u8()?;
        let mut numbers = [[0; 2]; NUMBERS];
        for number in &mut numbers {
            *number = fields.array()?;
        }
        let (drones, both) = (first & !BOTH, first & BOTH != 0);
        if first == 0 && numbers == [[0; 2]; NUMBERS] {
            return Ok(None);
        }
        let [corner_x, corner_y, east, north, x, y, width, direction, length] = numbers;
        let number = |bytes| f32::from(i16::from_le_bytes(bytes)) / 100.0;
        let way = i16::from_le_bytes(direction);
        if !DRONES.contains(&drones) || !DIRECTION.contains(&way) {
            return Err(Error::Value);
        }
        Ok(Some(Self {
            drones,
            corner: Point2::new(number(corner_x), number(corner_y)),
            area: (metres(east, &AREA)?, metres(north, &AREA)?),
            entrance: Point2::new(number(x), number(y)),
            width: metres(width, &WIDTH)?,
            direction: Radians(number(direction).to_radians()),
            length: metres(length, &PASSAGE)?,
            both,
        }))
    }
}

/// A length of the record.
fn metres(bytes: [u8; 2], range: &RangeInclusive<u16>) -> Result<Metres, Error> {
    let number = u16::from_le_bytes(bytes);
    if range.contains(&number) { Ok(Metres(f32::from(number) / 100.0)) } else { Err(Error::Value) }
}

/// The nearest hundredth.
fn hundredths(number: f32) -> f32 {
    libm::roundf(100.0 * number)
}

/// A coordinate, or a direction in degrees.
fn signed(number: f32) -> Result<[u8; 2], Error> {
    let rounded = hundredths(number);
    let is_kept = rounded.abs() <= f32::from(i16::MAX);
    if is_kept { Ok((rounded as i16).to_le_bytes()) } else { Err(Error::Value) }
}

/// A direction.
fn direction(angle: Radians) -> Result<[u8; 2], Error> {
    let bytes = signed(angle.0.to_degrees())?;
    let is_kept = DIRECTION.contains(&i16::from_le_bytes(bytes));
    if is_kept { Ok(bytes) } else { Err(Error::Value) }
}

/// A length.
fn unsigned(length: Metres, range: &RangeInclusive<u16>) -> Result<[u8; 2], Error> {
    let rounded = hundredths(length.0);
    let is_kept = (f32::from(*range.start())..=f32::from(*range.end())).contains(&rounded);
    if is_kept { Ok((rounded as u16).to_le_bytes()) } else { Err(Error::Value) }
}
